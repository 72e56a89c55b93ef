"""The recommended line of `spacar.trade` against a grid of settings (docs/studies.md, trade).

python benchmarks/recommendations.py [--reduced] [MODEL ...]

Grid: codes x ERROR in six decades x 1, 2, 4, 8 beams in the place of each x both measures, and rigid beams; mode 7:
meshes and measures. Truth of a motion: 16 beams in the angle measure, of order 4, code 595, ERROR 1e-6; of a stationary
solution 32 beams. What counts: the free coordinates of the file, or those in POINTS: the end of the stiff arm moves by
6 micrometers, in vibrations that no mesh of the grid has. Cost: processor time of the run, the least of three; that of
the cheapest and of the recommended one are measured once more, in turn.
Regret: cost of the recommended line over the least of the grid within the target. `--reduced`: codes 0 and 595, three
tolerances, 1, 2, 4 beams.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import models
import numpy as np

import spacar
from spacar.arrays import Array
from spacar.deck import Deck, parse_deck
from spacar.deck.rewrite.refine import flexible_beams
from spacar.errors import AnalysisError, SpacarError
from spacar.integrators.methods import METHODS
from spacar.studies.runs.result_quantities import amplitudes, distance, free_coordinates

TARGET = 1e-3
CODES, DECADES, MESHES = (595, 553, 0, 155, 853), (2, 3, 4, 5, 6, 7), (1, 2, 4, 8)
REDUCED = (595, 0), (2, 4, 6), (1, 2, 4)
REPEATS, SHORT = 3, 0.5  # runs of a setting, while they take less than so many seconds together
TURNS = 5
LONGEST = 10.0  # seconds of a setting

RIGID = """
PLBEAM 1 1 2 3 4
X 3 1. 0.
FIX 1
DYNX 2 1
DYNE 1 2 3
END HALT
EM 1 1.
ESTIFF 1 0. 2e3
GRAVITY 0. -9.81
TIMESTEP 0.3 3
END END
"""
MODELS: dict[str, tuple[str, int, dict[str, Any]]] = {
    "crankfl": (models.example("crankfl"), 1, {"duration": 0.01, "n_steps": 10}),
    "robotflexsim": (models.example("robotflexsim"), 7, {}),
    "plbeam5": (models.example("plbeam5"), 7, {}),
    "screw": (models.example("screw"), 1, {"duration": 0.5, "n_steps": 10}),
    "stiff and soft arm": (models.STIFF_AND_SOFT_ARM, 1, {}),
    "rod that is rigid enough": (RIGID, 1, {}),
}
POINTS: dict[str, list[tuple[int, int]]] = {"stiff and soft arm": [(5, 1), (5, 2)]}  # node, coordinate: its end


@dataclass(frozen=True)
class Grid:
    """Codes, decades of ERROR and meshes."""

    codes: tuple[int, ...] = CODES
    decades: tuple[int, ...] = DECADES
    meshes: tuple[int, ...] = MESHES

    def settings(self, deck: Deck, mode: int) -> Iterator[dict[str, Any]]:
        """Options of `spacar.run`."""
        given: list[dict[str, Any]] = [{"elements": n, "beams": m} for n in self.meshes for m in ("sine", "angle")]
        given = [{"rigid_beams": True}, *given] if flexible_beams(deck) else given
        if mode == 7:
            yield from given
            return
        for model in given:
            for code in self.codes:
                for k in self.decades:
                    yield model | {"integrator": code, "rtol": 10.0**-k, "atol": 10.0**-k}


def run(deck: Deck, mode: int, points: Sequence[tuple[int, int]], most: float, **options: Any) -> tuple[Array, float]:
    """Coordinates (variables, times), and the processor time [s], the least of three while these are short. Raises
    SpacarError, also for what takes more than `most`."""
    seconds: list[float] = []
    while not seconds or (len(seconds) < REPEATS and sum(seconds) < SHORT and min(seconds) < most):
        begun, rows = time.process_time(), []
        made = spacar.frames(mode, deck, **options)
        at = [made.mechanism.numbering.x_index(*point) for point in points]
        for frame in made:
            rows.append(frame.x[at])
            if time.process_time() - begun > most:
                raise AnalysisError("too long", "study.stopped")
        seconds.append(time.process_time() - begun)
    return np.array(rows).T, min(seconds)


def truth(deck: Deck, mode: int, points: Sequence[tuple[int, int]], options: dict[str, Any]) -> Array:
    """On the finest mesh, of a model that cannot be divided on its own."""
    mesh = {"elements": 32 if mode == 7 else 16} if flexible_beams(deck) else {}
    tight = {} if mode == 7 else {"integrator": 595, "rtol": 1e-6, "atol": 1e-7}
    try:
        return run(deck, mode, points, np.inf, beams="angle", **mesh, **tight, **options)[0]
    except AnalysisError:
        return run(deck, mode, points, np.inf, beams="angle", **tight, **options)[0]


def main(words: list[str]) -> None:
    grid = Grid(*REDUCED) if "--reduced" in words else Grid()
    names = [word for word in words if not word.startswith("--")]
    print("| model | cheapest | cost | recommended | cost | error | regret |")
    print(f"|{'---|' * 7}")
    for name in names or MODELS:
        text, mode, interval = MODELS[name]
        deck = parse_deck(text, mode=mode)
        points = POINTS.get(name) or _free(deck, mode)
        exact = truth(deck, mode, points, interval)
        scale = amplitudes(exact, mode == 7)
        best: tuple[float, dict[str, Any]] = (np.inf, {})
        for setting in grid.settings(deck, mode):
            try:
                values, cost = run(deck, mode, points, min(2.0 * best[0], LONGEST), **setting, **interval)
            except SpacarError:
                continue
            if distance(values, exact, scale) <= TARGET:
                best = min(best, (cost, setting), key=lambda one: one[0])
        assert best[1], "no setting of the grid reaches the target"
        wanted = [f"x[{node},{c}]" for node, c in points]
        answer = spacar.trade(deck, TARGET, mode=mode, variables=wanted, budget=40.0, repeats=1, **interval)
        assert answer.deck is not None
        options = {k: v for k, v in answer.options.items() if k not in interval}
        least = cost = np.inf
        for _ in range(TURNS):
            least = min(least, run(deck, mode, points, np.inf, **best[1], **interval)[1])
            values, seconds = run(answer.deck, mode, points, np.inf, **options, **interval)
            cost = min(cost, seconds)
        error = distance(values, exact, scale)
        cells = (_short(best[1]), f"{least:.3g} s", _short(options), f"{cost:.3g} s", f"{error:.1e}")
        print(f"| {name} | {' | '.join(map(str, cells))} | {cost / least:.2f} |", flush=True)


def _free(deck: Deck, mode: int) -> list[tuple[int, int]]:
    mechanism = spacar.frames(mode, deck).mechanism
    return [mechanism.numbering.x_owner(int(i)) for i in free_coordinates(mechanism)]


def _short(options: dict[str, Any]) -> str:
    return ", ".join(f"{k} {v:.0e}" if k in ("rtol", "atol") else f"{k} {v}" for k, v in options.items() if k != "atol")


assert set(CODES) <= set(METHODS)

if __name__ == "__main__":
    main(sys.argv[1:])
