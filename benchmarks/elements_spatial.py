"""Cost of the spatial element families per call: D + V + H(v,v), and M and h, for 1 to 1000 elements.

Run: python benchmarks/elements_spatial.py. It prints microseconds per call and per element; nothing is asserted.
"""

from __future__ import annotations

import timeit
from collections.abc import Callable

import numpy as np

from spacar.elements.family import ElementGroup, Family
from spacar.elements.spatial.beam import SpatialBeam
from spacar.elements.spatial.hinge import SpatialHinge
from spacar.elements.spatial.pinbody import SpatialPinbody
from spacar.elements.spatial.screw import Screw
from spacar.elements.spatial.truss import SpatialTruss
from spacar.elements.spatial.tube import SpatialTube
from spacar.elements.spatial.wheel import DiskWheel

FAMILIES: dict[str, tuple[Callable[[ElementGroup], Family], str, tuple[float, ...]]] = {
    "BEAM": (SpatialBeam, "xlxl", (0.1, 1.0, 0.2)),
    "TRUSS": (SpatialTruss, "xx", ()),
    "HINGE": (SpatialHinge, "ll", (0.1, 1.0, 0.2)),
    "RBEAM": (SpatialPinbody, "xlx", ()),
    "SCREW": (Screw, "xlxl", (0.1, 1.0, 0.2, 0.01)),
    "TUBE": (SpatialTube, "xlxl", (0.1, 1.0, 0.2)),
    "WHEEL": (DiskWheel, "xlx", (0.0, 1.0, 0.0)),
}


def group(keyword: str, layout: str, geometry: tuple[float, ...], n: int) -> ElementGroup:
    """Random elements with mass."""
    rng = np.random.default_rng(0)
    unit = np.eye(4)[:, :1].repeat(n, 1)
    x0 = np.concatenate([rng.normal(size=(3, n)) if kind == "x" else unit for kind in layout])
    if keyword == "WHEEL":  # upright, on the ground
        x0[2], x0[7:9], x0[9] = 0.3, x0[:2], 0.0
    em = np.zeros((n, 9))
    em[:, :4] = (1.0, 0.5, 0.2, 1.0) if keyword == "TUBE" else (1.0, 0.0, 0.0, 0.0)
    zero = np.zeros((n, 6))
    none = (None,) * n
    return ElementGroup(
        keyword, np.arange(1, n + 1), x0, (geometry,) * n, np.ones(n, bool), none, none, em, zero, zero
    )


def seconds(call: Callable[[], object]) -> float:
    timer = timeit.Timer(call)
    count, _ = timer.autorange()
    return min(timer.repeat(3, max(1, count // 5))) / max(1, count // 5)


def measure(keyword: str, n: int) -> tuple[float, float]:
    """Seconds for the deformations and for the inertia of n elements."""
    family_class, layout, geometry = FAMILIES[keyword]
    g = group(keyword, layout, geometry, n)
    family = family_class(g)
    rng = np.random.default_rng(1)
    x = g.x0 + 0.1 * rng.normal(size=g.x0.shape)
    v = rng.normal(size=x.shape)
    ne, nx = family.n_deformations, family.n_coordinates
    e, near, c_out = np.zeros((ne, n)), np.zeros((ne, n)), np.zeros((ne, n))
    V, M = np.zeros((ne, nx, n)), np.zeros((nx, nx, n))

    def deformations() -> None:
        c = family.strain(x, near, e, V)
        family.convective_strain(c, v, c_out)

    state = family.strain(x, near, e, V)

    def inertia() -> None:
        family.mass(state, M)
        family.inertia_force(state, v, None)

    return seconds(deformations), seconds(inertia) if family.has_mass else 0.0


def main() -> None:
    print(
        f"{'':8}{'n':>6}{'D+V+H(v,v)':>14}{'per element':>13}{'M+h':>10}{'per element':>13}   [microseconds]"
    )
    for keyword in FAMILIES:
        for n in (1, 10, 100, 1000):
            d, m = measure(keyword, n)
            print(f"{keyword:8}{n:6}{d * 1e6:14.1f}{d / n * 1e6:13.2f}{m * 1e6:10.1f}{m / n * 1e6:13.2f}")


if __name__ == "__main__":
    main()
