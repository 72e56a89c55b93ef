"""Sweep of the manipulator data/robotsim.dat: variants of the tip mass, 1.4 s, one by one and as one batch.

    python benchmarks/ensemble.py [number of variants] [tolerances ...]

Two motions: `falls` (no moments in the hinges: the arm tumbles) and `swings` (held by stiff joints, which start with 1
and 0.5 rad/s: a smooth motion like those of a controlled arm). Prints per tolerance the processor time of a variant:
alone (median over a sample), in a batch with NumPy, compiled in a batch, and of the latter how much is setting up; then
the error of the tip position relative to the size of the arm, against single runs of method 853 at 1e-11. Reading the
variants (changing a number and checking the deck again) comes on top and is said first.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np

import spacar
from spacar.deck import Deck, parse_deck
from spacar.result import Result
from spacar.studies.assignments import change, setting
from spacar.studies.ensemble import ensemble

DATA = Path(__file__).resolve().parents[1] / "data"
SAMPLE = 5
ARM = 1.4  # two links of 0.7 m
HELD = "ESIG 2 -196.98\nESIG 3 -82.276\nESTIFF 2 1000.\nESTIFF 3 500.\nSTARTDE 1 1 0. 1.\nSTARTDE 2 1 0. 0.5\n"
MOTIONS = {"falls": "", "swings": HELD}
REPEATS = 3


def tip(result: Result) -> np.ndarray:
    """Path of the end of the arm, (steps, 3)."""
    return np.stack([result.node(8, k) for k in (1, 2, 3)], axis=1)


def best(work, *arguments, **options):
    """Least processor time of some calls and the last answer."""
    seconds, answer = [], None
    for _ in range(REPEATS):
        begun = time.process_time()
        answer = work(*arguments, **options)
        seconds.append(time.process_time() - begun)
    return min(seconds), answer


def main(n: int = 200, tolerances: tuple[float, ...] = (1e-3, 1e-4, 1e-6, 1e-8), general: bool = True) -> None:
    """`general`: the NumPy paths too, which take minutes."""
    kinematics, dynamics, third = (DATA / "robotsim.dat").read_text().split("HALT")
    for name, more in MOTIONS.items():
        base = parse_deck("HALT".join([kinematics, "\n" + more + dynamics.lstrip(), third]), mode=1)
        begun = time.process_time()
        decks = [change(base, [setting("XM.8")], [mass]) for mass in np.linspace(20.0, 40.0, n)]
        print(f"{name}: {n} variants, reading {1e3 * (time.process_time() - begun) / n:.2f} ms each")
        print("method  tolerance  single [ms]  NumPy batch  compiled batch  of it set-up  error  rhs")
        measure(decks, tolerances, general)


def measure(decks: list[Deck], tolerances: tuple[float, ...], general: bool) -> None:
    n = len(decks)
    sample = range(0, n, max(1, n // SAMPLE))
    options = {"duration": 1.4, "n_steps": 20}
    exact = {"integrator": 853, "rtol": 1e-11, "atol": 1e-11, **options}
    truth = {k: tip(spacar.run(1, decks[k], compiled=True, **exact)) for k in sample}
    for code in (0, 155, 853):
        for tolerance in tolerances:
            chosen = {"integrator": code, "rtol": tolerance, "atol": tolerance, **options}
            alone = together = float("nan")
            if general:
                alone = float(np.median([best(spacar.run, 1, decks[k], **chosen)[0] for k in sample]))
                together = best(ensemble, decks, **chosen)[0] / n
            lanes, results = best(ensemble, decks, compiled=True, **chosen)
            setup = best(ensemble, decks, np.array([0.0, 1e-9]), compiled=True, **chosen)[0] / n
            error = max(np.abs(tip(results[k]) - truth[k]).max() / ARM for k in sample)
            rhs = sum(f.statistics["rhs"] for f in results[0].frames)
            print(
                f"{code:6d}  {tolerance:9.0e}  {1e3 * alone:11.2f}  {1e3 * together:11.2f}  {1e3 * lanes / n:14.3f}"
                f"  {1e3 * setup:12.3f}  {error:.0e}  {rhs:3.0f}",
                flush=True,
            )


if __name__ == "__main__":
    words = sys.argv[1:]
    main(int(words[0]) if words else 200, tuple(map(float, words[1:])) or (1e-4, 1e-6, 1e-8))
