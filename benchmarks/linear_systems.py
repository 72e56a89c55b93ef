"""Break-even of dense, banded and sparse storage: one factorization and one solve of the saddle-point matrix of chains.

    python benchmarks/linear_systems.py

Microseconds, best of the repeats. DENSE_LIMIT and BAND_LIMIT of spacar/linear_systems follow from the table.
"""

from __future__ import annotations

import os
from time import perf_counter

os.environ.setdefault("OMP_NUM_THREADS", "1")

import cases

from spacar.dynamics import Dynamics
from spacar.mechanism import build

SIZES = {"planar flexible": (2, 4, 6, 8, 12, 20, 50, 200, 1000), "spatial flexible": (1, 2, 3, 4, 6, 10, 30, 100, 500)}
SIZES["planar rigid"] = (4, 8, 12, 16, 24, 50, 200, 1000)
SIZES["spatial rigid"] = (1, 2, 3, 4, 6, 10, 30, 100, 500)
KINDS = ("dense", "banded", "sparse")
LARGEST_DENSE = 700


def microseconds(kind: str, text: str) -> tuple[int, int, float]:
    """Unknowns, height of the band, best time of factor and solve."""
    dynamics = Dynamics(build(cases.parsed(text, 1), 1), kind=kind)
    y = dynamics.start()
    dynamics.rhs(0.0, y)
    saddle = dynamics.saddle
    assert saddle is not None
    best = float("inf")
    for _ in range(30):
        begin = perf_counter()
        saddle.factor()
        saddle.system.solve(saddle.rhs)
        best = min(best, perf_counter() - begin)
    return saddle.system.n, getattr(saddle.system, "height", 0), 1e6 * best


def main() -> None:
    print(f"{'chain':17s} {'n':>5s} {'unknowns':>9s} {'band':>5s}" + "".join(f"{kind:>10s}" for kind in KINDS))
    for name, sizes in SIZES.items():
        for n in sizes:
            text = cases.CHAINS[name](n)
            unknowns, height, banded = microseconds("banded", text)
            dense = microseconds("dense", text)[2] if unknowns <= LARGEST_DENSE else float("nan")
            sparse = microseconds("sparse", text)[2]
            print(f"{name:17s} {n:5d} {unknowns:9d} {height:5d}{dense:10.0f}{banded:10.0f}{sparse:10.0f}", flush=True)


if __name__ == "__main__":
    main()
