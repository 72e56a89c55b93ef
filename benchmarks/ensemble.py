"""Sweep of the manipulator data/robotsim.dat: variants of the tip mass, 1.4 s, one by one and as one batch.

    python benchmarks/ensemble.py [number of variants] [tolerances ...]

Two motions: `falls` (no moments in the hinges: the arm tumbles) and `swings` (held by stiff joints, which start with 1
and 0.5 rad/s: a smooth motion like those of a controlled arm), and S4c of benchmarks/peers (constant torques), 29 to
31 kg. The heading of a motion gives the time of a variant to change the number and check the deck again, that of a
whole `spacar.sweep` with its rows on one core, and on all cores (the default; elapsed time too). Then follow, for each
method and tolerance: the processor time of a variant alone (median over a sample), in a batch of decks, and of the
latter how much is setting up; how many variants have to be run alone; the error of the tip position relative to the
size of the arm, against single runs of method 853 at 1e-11.
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
from spacar.studies.ensemble import motions
from spacar.studies.side_by_side import side_by_side

DATA = Path(__file__).resolve().parents[1] / "data"
SAMPLE = 5
ARM = 1.4  # two links of 0.7 m
HELD = "ESIG 2 -196.98\nESIG 3 -82.276\nESTIFF 2 1000.\nESTIFF 3 500.\nSTARTDE 1 1 0. 1.\nSTARTDE 2 1 0. 0.5\n"
MOTIONS = {"falls": "", "swings": HELD}
REPEATS = 3


def tip(result: Result) -> np.ndarray:
    """Path of the end of the arm, (steps, 3)."""
    return np.stack([result.node(8, k) for k in (1, 2, 3)], axis=1)


def ensemble(decks: list[Deck], times: np.ndarray | None = None, **options) -> list[Result | None]:
    """Results of decks that are followed together; None of one that has to be run alone."""
    cases = side_by_side(decks, **options)
    found = dict(pair for pairs in motions(cases, lambda m: list(m.results()), times, **options) for pair in pairs)
    return [found.get(k) for k in range(len(decks))]


def best(work, *arguments, clock=time.process_time, **options):
    """Least processor time of some calls and the last answer."""
    seconds, answer = [], None
    for _ in range(REPEATS):
        begun = clock()
        answer = work(*arguments, **options)
        seconds.append(clock() - begun)
    return min(seconds), answer


def main(n: int = 200, tolerances: tuple[float, ...] = (1e-4, 1e-6, 1e-8)) -> None:
    kinematics, dynamics, third = (DATA / "robotsim.dat").read_text().split("HALT")
    models = {
        name: ("HALT".join([kinematics, "\n" + more + dynamics.lstrip(), third]), 20.0, 40.0)
        for name, more in MOTIONS.items()
    }
    models["S4c"] = ((Path(__file__).parent / "peers" / "scenarios" / "S4c.dat").read_text(), 29.0, 31.0)
    for name, (text, low, high) in models.items():
        base = parse_deck(text, mode=1)
        masses = np.linspace(low, high, n)
        seconds, decks = best(lambda base=base, masses=masses: [change(base, [setting("XM.8")], [m]) for m in masses])
        change_ms = 1e3 * seconds / n
        options = {"duration": 1.4, "n_steps": 14, "rtol": 1e-6, "atol": 1e-6}
        asked = base, {"XM.8": masses}, "z: x[8,3]@end"
        whole, _ = best(spacar.sweep, *asked, jobs=1, **options)
        cores, _ = best(spacar.sweep, *asked, **options)
        elapsed, _ = best(spacar.sweep, *asked, clock=time.perf_counter, **options)
        print(
            f"{name}: {n} variants, a changed deck {change_ms:.2f} ms, a whole sweep {1e3 * whole / n:.2f} ms each,"
            f" on all cores {1e3 * cores / n:.2f} ms, elapsed {1e3 * elapsed / n:.2f} ms"
        )
        print("method  tolerance  single [ms]  batch  of it set-up  alone  error  rhs")
        measure(decks, tolerances)


def measure(decks: list[Deck], tolerances: tuple[float, ...]) -> None:
    n = len(decks)
    sample = range(0, n, max(1, n // SAMPLE))
    options = {"duration": 1.4, "n_steps": 14}
    exact = {"integrator": 853, "rtol": 1e-11, "atol": 1e-11, **options}
    truth = {k: tip(spacar.run(1, decks[k], **exact)) for k in sample}
    for code in (0, 155, 853):
        for tolerance in tolerances:
            chosen = {"integrator": code, "rtol": tolerance, "atol": tolerance, **options}
            alone = float(np.median([best(spacar.run, 1, decks[k], **chosen)[0] for k in sample]))
            lanes, results = best(ensemble, decks, **chosen)
            setup = best(ensemble, decks, np.array([0.0, 1e-9]), **chosen)[0] / n
            followed = [k for k in sample if results[k] is not None]
            error = max((np.abs(tip(results[k]) - truth[k]).max() / ARM for k in followed), default=np.nan)
            rhs = sum(f.statistics["rhs"] for f in results[followed[0]].frames) if followed else 0
            print(
                f"{code:6d}  {tolerance:9.0e}  {1e3 * alone:11.2f}  {1e3 * lanes / n:5.3f}  {1e3 * setup:12.3f}"
                f"  {sum(r is None for r in results):5d}  {error:.0e}  {rhs:3.0f}",
                flush=True,
            )


if __name__ == "__main__":
    words = sys.argv[1:]
    main(int(words[0]) if words else 200, tuple(map(float, words[1:])) or (1e-4, 1e-6, 1e-8))
