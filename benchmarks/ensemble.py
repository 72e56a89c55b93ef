"""Sweep of the manipulator data/robotsim.dat: variants of the tip mass, 1.4 s, one by one and as one batch.

    python benchmarks/ensemble.py [number of variants] [tolerances ...]

Prints per tolerance the processor time of a variant, alone (median over a sample) and in a batch, the ratio, and the
largest errors of the tip position relative to the size of the arm, against single runs of method 853 at 1e-11.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np

import spacar
from spacar.deck import read_deck
from spacar.studies.assignments import change, setting
from spacar.studies.ensemble import ensemble

DATA = Path(__file__).resolve().parents[1] / "data"
SAMPLE = 5
ARM = 1.4  # two links of 0.7 m


def tip(result):
    """Path of the end of the arm, (steps, 3)."""
    return np.stack([result.node(8, k) for k in (1, 2, 3)], axis=1)


def main(n: int = 200, tolerances: tuple[float, ...] = (1e-4, 1e-6, 1e-8)) -> None:
    base = read_deck(DATA / "robotsim.dat", 1)
    begun = time.process_time()
    decks = [change(base, [setting("XM.8")], [mass]) for mass in np.linspace(20.0, 40.0, n)]
    reading = (time.process_time() - begun) / n
    options = {"duration": 1.4, "n_steps": 20}
    sample = range(0, n, max(1, n // SAMPLE))
    truth = {k: tip(spacar.run(1, decks[k], integrator=853, rtol=1e-11, atol=1e-11, **options)) for k in sample}
    print(f"{n} variants, reading {1e3 * reading:.2f} ms each")
    print("method  tolerance  single [ms]  batch [ms]  ratio  single error  batch error  rhs")
    for code in (0, 853):
        for tolerance in tolerances:
            chosen = {"integrator": code, "rtol": tolerance, "atol": tolerance, **options}
            seconds, errors = [], []
            for k in sample:
                begun = time.process_time()
                result = spacar.run(1, decks[k], **chosen)
                seconds.append(time.process_time() - begun)
                errors.append(np.abs(tip(result) - truth[k]).max() / ARM)
            begun = time.process_time()
            results = ensemble(decks, **chosen)
            each = (time.process_time() - begun) / n
            error = max(np.abs(tip(results[k]) - truth[k]).max() / ARM for k in sample)
            rhs = sum(f.statistics["rhs"] for f in results[0].frames)
            alone = float(np.median(seconds))
            print(
                f"{code:6d}  {tolerance:9.0e}  {1e3 * alone:11.2f}  {1e3 * each:10.2f}  {alone / each:5.1f}"
                f"  {max(errors):12.1e}  {error:11.1e}  {rhs:3.0f}"
            )


if __name__ == "__main__":
    words = sys.argv[1:]
    main(int(words[0]) if words else 200, tuple(map(float, words[1:])) or (1e-4, 1e-6, 1e-8))
