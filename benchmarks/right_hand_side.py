"""Cost of one right-hand side and where it goes: `python benchmarks/right_hand_side.py [MODEL ...]`; with
`--links [N ...]` of rigid chains and binary trees, compiled, microseconds a link (default: 3 5 10 20 50 100).

For each model (default: some examples of data/): microseconds per evaluation of the general and of the compiled path,
then the parts of the general path: position and velocity, accelerations, element sweeps, linear solutions. Best of
several repetitions, because other processes only ever add time.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")

import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
from models import pendulum, spatial_pendulum

import spacar
from spacar.compiled import CompiledDynamics, why_general
from spacar.deck import parse_deck
from spacar.dynamics import Dynamics
from spacar.kinematics.kinematics import CONVERGED

DATA = Path(__file__).parents[1] / "data"
MODELS = ["crankfl", "fingersim", "trike2", "robotsim", "trike3v", "screw"]


def microseconds(call: Callable[[], object], number: int = 100, repeats: int = 7) -> float:
    """Best mean time of one call."""
    best = np.inf
    for _ in range(repeats):
        begun = time.perf_counter()
        for _ in range(number):
            call()
        best = min(best, (time.perf_counter() - begun) / number)
    return best * 1e6


def parts(path: Path) -> dict[str, float | str]:
    """One row of the table."""
    mechanism = spacar.frames(1, path).mechanism
    d = Dynamics(mechanism)
    y = d.start()
    d.rhs(0.0, y)
    moved = y.copy()
    moved[: d.n_positions] += 1e-5
    states = [y, moved]

    def alternate(call: Callable[[np.ndarray], object]) -> Callable[[], object]:
        return lambda: states.reverse() or call(states[0])

    row: dict[str, float | str] = {
        "model": path.stem,
        "unknowns": f"{d.kinematics.velocity_system.n}/{d.saddle.system.n if d.saddle else 0}",
        "general": microseconds(alternate(lambda s: d.rhs(0.0, s))),
    }
    row["compiled"] = "-"
    if why_general(mechanism) is None:
        c = CompiledDynamics(mechanism)
        c.start()
        row["compiled"] = microseconds(alternate(lambda s: c.rhs(0.0, s)))
    drive = d.place(0.0, y)
    row |= {
        "place": microseconds(alternate(lambda s: d.place(0.0, s))),
        "accelerate": microseconds(lambda: d.accelerate(0.0, drive)),
        "strain": microseconds(lambda: d.sweep.strain(d.kinematics.x)),
        "H(v,v)": microseconds(lambda: d.sweep.convective(d.xd)),
        "M": microseconds(d.sweep.mass),
        "h": microseconds(lambda: d.sweep.inertia_force(d.xd, None)),
    }
    if d.saddle is not None:
        saddle, force, strain = d.saddle, np.ones(d.numbering.nx), np.ones(d.numbering.ne)
        row["saddle"] = microseconds(lambda: (saddle.factor(), saddle.solve(force, strain)))
    return row


def per_link(text: str, links: int) -> float:
    """Microseconds of an evaluation in C over the number of links, at states that differ a little in turn."""
    c = CompiledDynamics(spacar.frames(1, parse_deck(text, mode=1)).mechanism)
    y, out = c.start(), np.zeros(2 * c.n_positions)
    states = [y + 1e-5 * k for k in (0, 1)]
    where = [state.ctypes.data for state in states]

    def evaluate() -> None:
        where.reverse()
        c.solver.rhs(c.state, 0.0, where[0], out.ctypes.data, CONVERGED)

    return microseconds(evaluate, 20, 50) / links


def trees(sizes: list[int]) -> None:
    """The table of `--links`."""
    made = {
        "planar chain": pendulum,
        "spatial chain": spatial_pendulum,
        "spatial tree": partial(spatial_pendulum, branches=2),
    }
    print("microseconds a link" + "".join(f"{n:>8}" for n in sizes))
    for name, make in made.items():
        print(f"{name:19}" + "".join(f"{per_link(make(n, 1.0, 10), n):8.2f}" for n in sizes), flush=True)


def main() -> None:
    if sys.argv[1:2] == ["--links"]:
        trees([int(word) for word in sys.argv[2:]] or [3, 5, 10, 20, 50, 100])
        return
    paths = [Path(word) for word in sys.argv[1:]] or [DATA / f"{name}.dat" for name in MODELS]
    rows = [parts(path) for path in paths]
    heads = list(max(rows, key=len))
    print("microseconds; unknowns of the position / of the saddle-point system")
    print("".join(f"{head:>12}" for head in heads))
    for row in rows:
        cells = [row.get(head, "-") for head in heads]
        print("".join(f"{cell:>12}" if isinstance(cell, str) else f"{cell:12.1f}" for cell in cells))


if __name__ == "__main__":
    main()
