"""Strongly bent cantilever: cost of the stationary solution for n = 5 ... 1000 planar beams, and its error.

Run: OMP_NUM_THREADS=1 python benchmarks/statics.py. l = EI = 1, transverse tip force 10 EI/l^2 (tip angle 82
degrees), four load steps, reading and numbering not included. The truth is the elastica, theta'' = -F cos theta by
shooting. Columns: elements, milliseconds for the first solution (with all load steps), per element, iterations, error
of the tip relative to l and its measured order.

Then small models, for which the work around the numbers counts: processor times [ms, smallest of REPEATS] of the whole
analysis and of its stationary solution alone, evaluations of the deformations, iterations. These two do not depend on
the load of the machine.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np

import spacar
from spacar.deck import parse_deck
from spacar.errors import Report
from spacar.mechanism import build
from spacar.stationary import LoadProgram, StationarySolver

FORCE = 10.0
SIZES = (5, 10, 20, 50, 100, 200, 500, 1000)
HERE = Path(__file__).resolve().parent
REPEATS = 25


def cantilever(n: int, force: float = FORCE, steps: int = 4, tolerance: float = 5e-7) -> str:
    """Input text of a clamped chain of n beams without mass, l = EI = 1."""
    lines = [f"PLBEAM {k} {2 * k - 1} {2 * k} {2 * k + 1} {2 * k + 2}" for k in range(1, n + 1)]
    lines += [f"X {2 * k + 1} {k / n!r} 0." for k in range(1, n + 1)]
    lines += ["FIX 1", "FIX 2", *(f"DYNE {k} 2 3" for k in range(1, n + 1)), "END", "HALT"]
    lines += [f"ESTIFF {k} 0. 1." for k in range(1, n + 1)]
    lines += [f"XF {2 * n + 1} 0. {force!r}", f"ITERSTEP 20 {steps} {tolerance!r}", "END", "END", ""]
    return "\n".join(lines)


def elastica(force: float = FORCE) -> tuple[float, float, float]:
    """x, y and angle of the tip: theta'' = -F cos theta, theta(0) = 0, theta'(1) = 0, by shooting for theta(1)."""
    from scipy.integrate import solve_ivp
    from scipy.optimize import brentq

    def shape(tip: float) -> np.ndarray:
        # from the tip backwards: s runs from the free end to the clamp
        def rhs(s: float, z: np.ndarray) -> list[float]:
            return [z[1], -force * np.cos(z[0]), -np.cos(z[0]), -np.sin(z[0])]

        return solve_ivp(rhs, (0, 1), [tip, 0, 0, 0], method="DOP853", rtol=1e-13, atol=1e-14).y[:, -1]

    tip = brentq(lambda a: shape(a)[0], 1e-3, np.pi / 2 - 1e-9, xtol=1e-14)
    end = shape(tip)
    return -float(end[2]), -float(end[3]), float(tip)


def solve(n: int, force: float = FORCE) -> tuple[float, int, np.ndarray]:
    """Seconds, iterations, tip position and angle."""
    m = build(parse_deck(cantilever(n, force), mode=7), 7)
    begun = time.perf_counter()
    solver = StationarySolver(m, Report())
    evaluations = 0
    for level in LoadProgram(m.settings):
        solver.solve(level)
        evaluations += solver.iterations
    seconds = time.perf_counter() - begun
    rows = [m.numbering.x_index(2 * n + 1, 1), m.numbering.x_index(2 * n + 1, 2), m.numbering.x_index(2 * n + 2, 1)]
    return seconds, evaluations, solver.dynamics.kinematics.x[rows]


def small_models() -> dict[str, tuple[int, Path]]:
    """Mode and file of the examples and of the scenarios S5, S8 of benchmarks/peers."""
    sys.path.insert(0, str(HERE / "peers"))
    from spacar_side import beam

    examples = {name: (7, HERE.parent / "data" / f"{name}.dat") for name in ("crankfl", "finger")}
    bent = {f"S5, {n} elements, ADEFORM": (8, beam(n, True, True)) for n in (10, 25)}
    straight = {f"S8, {n} elements": (7, beam(n, False)) for n in (13, 45, 130)}
    return {**examples, **bent, **straight}


def small(mode: int, path: Path) -> tuple[float, float, int, int]:
    """Milliseconds of everything and of the stationary solution, its evaluations and iterations."""
    whole, alone, evaluations, iterations = [], [], 0, 0
    for _ in range(REPEATS):
        begun = time.process_time()
        spacar.run(mode, path)
        whole.append(time.process_time() - begun)
        m = build(parse_deck(path.read_text(), mode=mode), mode)
        begun = time.process_time()
        solver, iterations = StationarySolver(m, Report()), 0
        for level in LoadProgram(m.settings):
            solver.solve(level)
            iterations += solver.iterations
        alone.append(time.process_time() - begun)
        evaluations = solver.dynamics.sweep.count
    return 1e3 * min(whole), 1e3 * min(alone), evaluations, iterations


def main() -> None:
    exact = np.array(elastica())
    print(f"elastica: tip {exact[0]:.12f} {exact[1]:.12f}, angle {exact[2]:.12f} rad")
    print(f"{'n':>6} {'ms':>9} {'ms/n':>8} {'iter':>5} {'error':>10} {'order':>6}")
    last = None
    for n in SIZES:
        seconds, evaluations, tip = min((solve(n) for _ in range(2)), key=lambda r: r[0])
        error = float(np.linalg.norm(tip[:2] - exact[:2]))
        order = "" if last is None else f"{np.log(last[1] / error) / np.log(n / last[0]):.2f}"
        print(f"{n:6d} {1e3 * seconds:9.2f} {1e3 * seconds / n:8.4f} {evaluations:5d} {error:10.2e} {order:>6}")
        last = n, error
    print(f"\n{'':26} {'whole':>8} {'statics':>8} {'evaluations':>12} {'iterations':>11}")
    for name, (mode, path) in small_models().items():
        whole, alone, evaluations, iterations = small(mode, path)
        print(f"{name:26} {whole:8.1f} {alone:8.1f} {evaluations:12d} {iterations:11d}")


if __name__ == "__main__":
    main()
