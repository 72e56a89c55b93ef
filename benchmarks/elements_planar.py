"""Microseconds per element of the planar families for 1, 10, 100, 1000 elements at once.

Run: OMP_NUM_THREADS=1 python benchmarks/elements_planar.py. Columns per size: strain (D and V),
convective_strain, mass + inertia_force ('-' where a family has none). Best of five repetitions.
"""

from __future__ import annotations

import timeit
from collections.abc import Callable

import numpy as np

from spacar.elements.family import ElementGroup, Family
from spacar.elements.planar.plbeam import PlanarBeam
from spacar.elements.planar.plbelt import PlanarBelt
from spacar.elements.planar.plpinbod import PlanarPinbody
from spacar.elements.planar.pltor import PlanarHinge
from spacar.elements.planar.pltruss import PlanarTruss
from spacar.elements.planar.pltube import PlanarTube
from spacar.elements.planar.plwheel import PlanarWheel

SIZES = (1, 10, 100, 1000)
LINE = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0)  # x_p, phi_p, x_q, phi_q
FAMILIES: dict[str, tuple[type[Family], tuple[float, ...], tuple[float, ...], bool]] = {
    "PLBEAM": (PlanarBeam, LINE, (), True),
    "PLBEAM massless": (PlanarBeam, LINE, (), False),
    "PLTRUSS": (PlanarTruss, (0.0, 0.0, 1.0, 0.0), (), True),
    "PLTOR": (PlanarHinge, (0.0, 0.0), (), False),
    "PLRBEAM": (PlanarPinbody, LINE[:5], (), True),
    "PLWHEEL": (PlanarWheel, (0.0,) * 4, (0.3, 0.0, 1.0), False),
    "PLBELT": (PlanarBelt, LINE, (0.2, 0.1), True),
    "PLTUBE": (PlanarTube, LINE, (0.1, 0.1), True),
}


def elements(name: str, n: int) -> tuple[Family, np.ndarray]:
    """n equal elements of a family and a configuration close to their start."""
    kind, start, geometry, heavy = FAMILIES[name]
    x0 = np.repeat(np.array(start)[:, None], n, axis=1)
    em = np.zeros((n, 9))
    if heavy:
        em[:, 0:2] = 1.0, 0.01
    if name == "PLTUBE":
        em[:, 0:6] = 1.0, 0.5, 0.2, 1.0, 2.0, 0.0
    family = kind(
        ElementGroup(  # type: ignore[call-arg]
            keyword=name.split()[0],
            numbers=np.arange(n) + 1,
            x0=x0,
            geometry=(geometry,) * n,
            nonlinear=np.ones(n, bool),
            directions=(None,) * n,
            projections=(None,) * n,
            em=em,
            estiff=np.zeros((n, 6)),
            edamp=np.zeros((n, 6)),
        )
    )
    return family, x0 + 0.1 * np.random.default_rng(1).normal(size=x0.shape)


def microseconds(call: Callable[[], object], n: int) -> float:
    repeats = max(20, 5000 // (n + 20))
    return min(timeit.repeat(call, number=repeats, repeat=5)) / repeats / n * 1e6


def measure(name: str, n: int) -> str:
    family, x = elements(name, n)
    e, V = np.zeros((family.n_deformations, n)), np.zeros((family.n_deformations, *x.shape))
    near, v, M = e.copy(), np.ones_like(x), np.zeros((len(x), *x.shape))
    c = family.strain(x, near, e, V)
    columns = [microseconds(lambda: family.strain(x, near, e, V), n)]
    if not family.constant_gradient:
        columns.append(microseconds(lambda: family.convective_strain(c, v, e), n))
    if family.has_mass:

        def inertia() -> None:
            family.mass(c, M)
            family.inertia_force(c, v, None)

        columns += [0.0] * (2 - len(columns)) + [microseconds(inertia, n)]
    cells = [f"{value:6.2f}" if value else "     -" for value in columns]
    return " ".join((cells + ["     -"] * 3)[:3])


def main() -> None:
    print(f"{'n':>16s}" + "".join(f"{n:>23d}" for n in SIZES))
    for name in FAMILIES:
        print(f"{name:16s}" + "".join("  " + measure(name, n) + " " for n in SIZES))


if __name__ == "__main__":
    main()
