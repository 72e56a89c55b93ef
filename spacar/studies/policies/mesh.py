"""The error of the mesh: flexible beams replaced by 1, 2, 4 ... equal ones until the result is as accurate as asked.

1. All beams are divided by 1, 2, 4 ... The difference of two meshes is an estimate of the error of the finer one. With
   three meshes every variable is extrapolated with the order that it shows
   (`spacar.studies.runs.mesh_ladder`); where it shows none, the last difference is its error.
2. When FEW beams in the place of each are not enough, and the next mesh will hardly be, one beam after the other (or
   group of neighbours, at most GROUPS) is divided in two in the mesh of the user. The differences d_g tell where the
   mesh matters: with errors of order 2 a group contributes 4/3 d_g. The groups that together stay below LEFT of the
   target are left as they are, the others are divided by 8, 16 ...
3. Results are given at the user's nodes (`spacar.studies.runs.user_nodes`). In modes 4 and 9, whose matrices belong to
   the degrees of freedom of the user, they are those of the user's mesh, and its error is only measured.

With a target the beams have the angle measure, of order 4, unless the run says `beams="sine"`: both measures tend to
the same rod. In motions the mesh of the user is integrated to a part of the target, finer ones as that one.
"""

import time
from collections.abc import Iterable
from dataclasses import dataclass, field, replace

import numpy as np

from spacar.deck.rewrite.refine import divisible_beams, with_pieces
from spacar.errors import AnalysisError
from spacar.integrators.methods import AUTOMATIC
from spacar.mechanism import Mechanism, build
from spacar.stream import Run
from spacar.studies.runs.mesh_ladder import Found, extrapolated, stalled
from spacar.studies.runs.quantities import Quantity
from spacar.studies.runs.result_quantities import distance
from spacar.studies.runs.tolerance_ladder import TIGHTEST, Attempt, Computed, ToleranceLadder, compute
from spacar.studies.runs.user_nodes import UserNodes

GROUPS = {True: 12, False: 4}  # most groups that are divided one by one: stationary solutions, motions
REST = 4.0 / 3.0  # sum of a series of differences, each a quarter of the one before, over the first one
FEW = 4  # beams in the place of one, up to which all beams are divided alike
FALL = 16.0  # of the error from one mesh to the next, with order 4
LEFT = 0.1  # part of the target that groups which are not refined may take
MOST = {True: 64, False: 16}  # beams in the place of one, at most
RESOLVED = 0.3  # error of the refined result over its difference from the mesh of the user, to measure that one
IN_TIME = 0.15  # part of the target that the integration of each mesh may take
OWN = 0.125  # part of the time that the mesh of the user may take: two finer ones cost 2 and 4 times its last run
UNMEASURED = 1e-5  # relative tolerance of refined meshes, at most, when the run of the file is only measured


def divisible(run: Run) -> tuple[tuple[int, ...], dict[int, str]]:
    """Beams of the model that can be divided, and why others cannot: user functions may count on the elements."""
    beams, reasons = divisible_beams(run.mechanism.deck)
    if run.mechanism.user_signal is not None:
        return (), dict.fromkeys((*beams, *reasons), "a user function may count on the elements of the model")
    return beams, reasons


def measured(run: Run) -> str:
    """The measure of the beams whose meshes are compared: that of the run, else "angle"."""
    return run.mechanism.settings.beams or "angle"


def undivided(reasons: dict[int, str]) -> str:
    return "; ".join(f"beam {b} cannot be divided: {text}" for b, text in reasons.items())


@dataclass
class MeshSearch:
    """Meshes of one model, in the order in which they were computed; the first one is the user's."""

    run: Run
    beams: tuple[int, ...]
    variables: tuple[Quantity, ...] = ()
    meshes: list[Computed] = field(default_factory=list)
    attempts: list[Attempt] = field(default_factory=list)
    end: float = np.inf  # as in `ToleranceLadder`
    in_time: float | None = None  # error that the integration may have; None: the settings of the file

    def __post_init__(self) -> None:
        self.measure = measured(self.run)
        self.ones = dict.fromkeys(self.beams, 1)

    def compute(self, pieces: dict[int, int], measure: str) -> Computed:
        """One mesh; the first one must be that of the user. Raises AnalysisError."""
        mechanism, parts = self._mechanism(pieces, measure)
        own = self.meshes[0] if self.meshes else None
        given = mechanism if own is None else own.run.mechanism
        view = None if own is None else UserNodes(given, mechanism, parts, own.frames or ()).frame
        run = Run(self.run.mode, mechanism)
        if self.run.mode.stationary:
            found = compute(run, Attempt(0, None), self.variables, view=view, shown=given, end=self.end)
        else:
            ladder = ToleranceLadder(run, self.variables, self.attempts, view, given, hold=True, end=self.end)
            found = self._integrated(ladder, own)
        found.pieces = pieces
        self.meshes.append(found)
        return found

    def _integrated(self, ladder: ToleranceLadder, own: Computed | None) -> Computed:
        """The motion of one mesh, with the error of its integration: measured in the mesh of the user; finer ones
        get the tolerance that was enough there, so that most of this error is common to all."""
        if own is None:
            return ladder.measured()[0] if self.in_time is None else ladder.climb(self.in_time)[0]
        tolerance = own.attempt.tolerance
        if tolerance is None:  # that of the file; its fixed steps say nothing about finer meshes
            tolerance = max(min(own.error, UNMEASURED), TIGHTEST)
        found = ladder.compute(AUTOMATIC, tolerance)
        found.error = own.error
        return found

    def _mechanism(self, pieces: dict[int, int], measure: str) -> tuple[Mechanism, dict[int, list[int]]]:
        """The divided model with the settings of the run, and the parts of each beam."""
        given = self.run.mechanism
        deck, parts = given.deck, dict[int, list[int]]()
        if any(n > 1 for n in pieces.values()):
            deck, parts = with_pieces(deck, pieces)
        elif measure == given.settings.beams:
            return given, {}
        settings = replace(given.settings, beams=measure)
        return replace(build(deck, self.run.mode.number, beams=measure), settings=settings), parts

    def refined(self, target: float) -> Found:
        """Meshes until the estimate is within the target."""
        self.in_time = IN_TIME * target
        own = self._own()
        chain, active, left, n = [own], self.beams, 0.0, 1
        found: Found | None = None
        try:
            while True:
                n *= 2
                far = found is not None and found.estimate > FALL * target
                if n >= 2 * FEW and far and len(active) == len(self.beams) > 1 and not left:
                    active, left = self._active(target)
                    if len(active) < len(self.beams):
                        coarser = [2**k for k in range(1, n.bit_length() - 1)][-2:]
                        chain = [own, *(self._divided(active, k) for k in coarser)]
                chain.append(self._divided(active, n))
                found = extrapolated(own.run.mechanism, chain, left, active, n)
                ends = len(chain) > 2 and stalled(chain)
                if found.estimate <= target or ends or 2 * n > MOST[self.run.mode.stationary]:
                    if found.estimate > target:
                        why = "differences of the meshes are rounding" if ends else "the finest mesh that is tried"
                        found.way += f"; {why}"
                    return found
        except AnalysisError as error:
            why = f"the mesh could not be refined further: {error}"
            if found is None:
                return Found(own.frames or (), np.full_like(own.x, np.nan), np.nan, why, own)
            return replace(found, way=f"{found.way}; {why}")

    def _own(self) -> Computed:
        """The mesh of the user, in its part of the time, or in all of it where that is too short."""
        end, now = self.end, time.process_time()
        if end < np.inf and not self.run.mode.stationary:
            self.end = now + OWN * (end - now)
            try:
                return self.compute(self.ones, self.measure)
            except AnalysisError as error:
                if error.code != "study.stopped":
                    raise
            finally:
                self.end = end
        return self.compute(self.ones, self.measure)

    def _divided(self, beams: Iterable[int], n: int) -> Computed:
        return self.compute(self.ones | dict.fromkeys(beams, n), self.measure)

    def _active(self, target: float) -> tuple[tuple[int, ...], float]:
        """The beams that must be refined further, and the error that the mesh of the others leaves."""
        parts = np.array_split(np.array(self.beams), min(GROUPS[self.run.mode.stationary], len(self.beams)))
        groups = [tuple(part.tolist()) for part in parts]
        errors = np.array([self._divided(group, 2).distance(self.meshes[0]) for group in groups])
        order = np.argsort(errors)
        still = order[REST * np.cumsum(errors[order]) <= LEFT * target]
        active = tuple(b for i, group in enumerate(groups) if i not in still for b in group)
        return active or self.beams, float(REST * errors[still].sum())

    def measured(self) -> Found:
        """The mesh of the user as it is, and its difference from refined ones."""
        own = self.compute(self.ones, self.run.mechanism.settings.beams)
        chain: list[Computed] = []
        try:
            for n in (2**k for k in range(MOST[self.run.mode.stationary].bit_length())):
                chain.append(self._divided(self.beams, n))
                if len(chain) > 2:
                    found = extrapolated(own.run.mechanism, chain, 0.0, self.beams, n)
                    assert found.rows is not None
                    away = distance(own.found.values, found.rows.values, chain[-1].found.amplitude)
                    if found.estimate <= RESOLVED * away or stalled(chain):
                        break
        except AnalysisError as error:
            way = f"the mesh could not be refined: {error}"
            return Found(own.frames or (), np.full_like(own.x, np.nan), np.nan, way, self.meshes[-1])
        bars = np.abs(own.x - np.array([f.x for f in found.frames]))
        way = f"the mesh of the model against {found.way}"
        return Found(own.frames or (), bars, float(away + found.estimate), way, self.meshes[-1])
