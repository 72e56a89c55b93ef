"""Overhead of one integration step per code: time beside the evaluations of F and of the Jacobian.

    python benchmarks/integrators.py [--json]

Each code integrates n/2 uncoupled oscillators. The time of the evaluations of F is measured alone, in the same process,
and subtracted. Reported are the medians over the repetitions, in microseconds per accepted step, and the number of
evaluations of F per step. The last row is code 0 with 2000 outputs, per output instead of per step.
"""

from __future__ import annotations

import json
import sys
from statistics import median
from time import perf_counter

import numpy as np

from spacar.integrators import METHODS, Problem, integrate

SIZES = (2, 6, 20, 100)
REPETITIONS = 5


class Oscillators(Problem):
    """q'' = -w^2 q with w = 1 ... 2."""

    def __init__(self, n: int) -> None:
        self.n_positions = n // 2
        self.stiffness = -(np.linspace(1.0, 2.0, n // 2) ** 2)
        self.f = np.zeros(n)
        zero, one = np.zeros((n // 2, n // 2)), np.eye(n // 2)
        self.a = np.block([[zero, one], [np.diag(self.stiffness), zero]])
        self.f_t = np.zeros(n)

    def rhs(self, t: float, y: np.ndarray) -> np.ndarray:
        n = self.n_positions
        self.f[:n] = y[n:]
        np.multiply(self.stiffness, y[:n], out=self.f[n:])
        return self.f

    def jacobian(self, t: float, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return self.a, self.f_t


def seconds_per_call(problem: Oscillators, n: int, calls: int = 5000) -> float:
    y = np.ones(n)
    begin = perf_counter()
    for _ in range(calls):
        problem.rhs(0.0, y)
    return (perf_counter() - begin) / calls


def overhead(code: int, n: int, n_outputs: int) -> tuple[float, float]:
    """(microseconds per step beside F (per output if several), evaluations of F per step), medians."""
    times = np.linspace(0.0, 30.0, n_outputs + 1)
    tolerance = 1e-5 if code in (135, 225) else 1e-8
    step = 0.02 if not METHODS[code].variable_step else None
    samples = []
    for _ in range(REPETITIONS):
        problem = Oscillators(n)
        y0 = np.append(np.ones(n // 2), np.zeros(n // 2))
        cost = seconds_per_call(problem, n)
        begin = perf_counter()
        outputs = list(integrate(problem, y0, times, code, atol=tolerance, rtol=tolerance, step=step))
        elapsed = perf_counter() - begin
        steps, calls = sum(o.work.n_steps for o in outputs), sum(o.work.n_rhs for o in outputs)
        units = steps if n_outputs == 1 else n_outputs
        samples.append(((elapsed - calls * cost) / units * 1e6, calls / steps))
    return median(s[0] for s in samples), median(s[1] for s in samples)


def main() -> None:
    rows = [(str(code), code, 1) for code in METHODS] + [("0 output", 0, 2000)]
    table = {label: [overhead(code, n, outputs) for n in SIZES] for label, code, outputs in rows}
    if "--json" in sys.argv[1:]:
        print(json.dumps({"n": SIZES, "microseconds_and_evaluations_per_step": table}))
        return
    print("code     F/step " + "".join(f"  n = {n:<5}" for n in SIZES) + "  microseconds per step beside F")
    for label, cells in table.items():
        print(f"{label:8} {cells[0][1]:6.2f} " + "".join(f"{time:11.1f}" for time, _ in cells))


if __name__ == "__main__":
    main()
