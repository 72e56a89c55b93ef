"""Frequencies of a cantilever of n = 5 ... 320 (1000) planar beams: cost and error.

Run: OMP_NUM_THREADS=1 python benchmarks/cantilever_eigen.py. l = EI = m = 1, rigid in elongation. A whole mode 7 run in
memory, reading and numbering not included; up to 300 beams all modes (dense), beyond that the lowest 20 (sparse).
Columns: elements, stored eigenvalues, seconds, microseconds per element, relative errors of the first and fifth
frequency against cos b cosh b = -1, measured order of the first.
"""

from __future__ import annotations

import time

import numpy as np

from spacar.deck import parse_deck
from spacar.mechanism import build
from spacar.modes import find_mode
from spacar.result import Result
from spacar.stream import Run

SIZES = (5, 10, 20, 40, 80, 160, 320, 1000)
ROOTS = (1.8751040687119611, 4.6940911329741746, 7.8547574382376126, 10.995540734875467, 14.13716839104647)


def cantilever(n: int, clamp: str = "FIX 1\nFIX 2", more: str = "") -> str:
    """Input text of a chain of n beams; `clamp` are the statements about its ends, `more` those about its loads."""
    lines = [f"PLBEAM {k} {2 * k - 1} {2 * k} {2 * k + 1} {2 * k + 2}" for k in range(1, n + 1)]
    lines += [f"X {2 * k + 1} {k / n!r} 0." for k in range(1, n + 1)]
    lines += [clamp, *(f"DYNE {k} 2 3" for k in range(1, n + 1)), "END", "HALT"]
    lines += [f"EM {k} 1." for k in range(1, n + 1)]
    lines += [f"ESTIFF {k} 0. 1." for k in range(1, n + 1)]
    return "\n".join([*lines, more, "END", "END", ""])


def measure(n: int) -> tuple[float, int, np.ndarray]:
    """Seconds, number of eigenvalues, relative errors of the five lowest frequencies."""
    m = build(parse_deck(cantilever(n), mode=7), 7)
    begun = time.perf_counter()
    values = Result.collect(Run(find_mode(7), m))["eigval"][0]
    seconds = time.perf_counter() - begun
    omega = np.sort(np.hypot(*values.T))[::2][:5]
    return seconds, len(values), omega / np.array(ROOTS) ** 2 - 1


def main() -> None:
    print(f"{'n':>5} {'values':>7} {'s':>9} {'us/n':>9} {'error 1':>10} {'error 5':>10} {'order':>6}")
    last: tuple[int, float] | None = None
    for n in SIZES:
        seconds, count, error = measure(n)
        first = abs(error[0])
        order = "" if last is None else f"{np.log(last[1] / first) / np.log(n / last[0]):.2f}"
        print(f"{n:5d} {count:7d} {seconds:9.3f} {1e6 * seconds / n:9.1f} {first:10.2e} {error[4]:10.2e} {order:>6}")
        last = n, first


if __name__ == "__main__":
    main()
