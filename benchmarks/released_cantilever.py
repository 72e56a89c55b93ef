"""Cost and error of codes 553 and 595 on a released cantilever, against what its vibrations ask for.

    python benchmarks/released_cantilever.py [N ...]

Unit cantilever (L = EI = m = 1) of n beams, released under its weight 1; 0.9 s of it, half its first period. Counted
are right-hand sides; the error is the largest of all coordinates at six outputs, against code 853 with ERROR 1e-9,
whose steps the highest frequency of the mesh limits, 60 n^2 rad/s (n = 64: some minutes).

What the vibrations ask for: the least fixed steps of the same method, two iterations each, that keep the tip of the
continuous beam to ERROR. With the roots of cos(beta) cosh(beta) = -1 its modes have the frequencies beta^2, and at the
tip 4 s/beta^5, s = (sinh(beta) - sin(beta))/(cosh(beta) + cos(beta)); a method with the stability function R errs by
|R(i omega h)^k - exp(i omega k h)| of each. The table also says how many modes have an amplitude above ERROR.
"""

from __future__ import annotations

import sys
import time

import models
import numpy as np
from scipy.optimize import brentq

import spacar
from spacar.arrays import Array
from spacar.deck import Deck, parse_deck
from spacar.integrators.radau import radau

ERRORS = tuple(10.0**-k for k in range(2, 8))
STAGES = {553: 3, 595: 5}
DURATION, MODES = 0.9, 40


def released(n: int) -> Deck:
    end = f"TIMESTEP {DURATION} 6"
    return parse_deck(models.cantilever(n, EI=1.0, length=1.0, dynamics=("GRAVITY 0. -1.", end)), mode=1)


def run(n: int, code: int, error: float) -> tuple[Array, int, float]:
    """Coordinates at the outputs, right-hand sides, processor time in s."""
    begin = time.process_time()
    r = spacar.run(1, released(n), integrator=code, atol=error, rtol=error)
    return r["x"], sum(f.statistics.get("rhs", 0) for f in r.frames), time.process_time() - begin


def vibrations() -> tuple[Array, Array]:
    """Frequencies [rad/s] and amplitudes at the tip of the released continuous beam."""
    middles = (np.arange(MODES) + 0.5) * np.pi
    beta = np.array([brentq(lambda b: np.cos(b) + 1.0 / np.cosh(b), m - 0.4, m + 0.4) for m in middles])
    ratio = (np.sinh(beta) - np.sin(beta)) / (np.cosh(beta) + np.cos(beta))
    return beta**2, 4.0 * ratio / beta**5


def least(stages: int, error: float) -> int:
    """Right-hand sides of fixed steps that keep the tip to this error."""
    omega, amplitude = vibrations()
    a = radau(stages).a
    n = 1
    while True:
        h = DURATION / n
        R = np.array([np.linalg.solve(np.eye(stages) - 1j * h * w * a, np.ones(stages))[-1] for w in omega])
        steps = np.unique(np.linspace(1, n, min(n, 60)).astype(int))[:, None]
        if (amplitude * np.abs((R**steps - np.exp(1j * h * omega * steps)).real)).sum(axis=1).max() <= error:
            return n * (2 * stages + 1)
        n = int(np.ceil(1.05 * n))


def main(numbers: list[int]) -> None:
    amplitude = vibrations()[1]
    print("ERROR, vibrations above it, least right-hand sides 553, 595")
    for error in ERRORS:
        above = int((amplitude > error).sum())
        print(f"  {error:.0e}  {above:3d}  {least(3, error):7d}  {least(5, error):7d}", flush=True)
    for n in numbers:
        exact, of_853, seconds = run(n, 853, 1e-9)
        print(f"{n} beams; 853: {of_853} right-hand sides, {seconds:.1f} s")
        print("  ERROR  code, right-hand sides, error/ERROR, s")
        for error in ERRORS:
            cells = [f"  {error:.0e}"]
            for code in STAGES:
                x, rhs, seconds = run(n, code, error)
                cells.append(f"{code} {rhs:7d} {np.abs(x - exact).max() / error:8.1e} {seconds:6.2f}")
            print("  |  ".join(cells), flush=True)


if __name__ == "__main__":
    main([int(a) for a in sys.argv[1:]] or [8, 16, 32, 64])
