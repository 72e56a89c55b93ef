"""The error of the mesh: flexible beams replaced by 1, 2, 4 ... equal ones until the result is as accurate as asked.

1. All beams are divided by 1, 2, 4. The difference of two meshes is an estimate of the error of the finer one. With
   three meshes every variable is extrapolated with the order that it shows
   (`spacar.studies.richardson.extrapolate_rows`); where it shows none, the last difference is its error.
2. When that is not enough, one beam after the other (or group of neighbours, at most GROUPS) is divided in two in the
   mesh of the user. The differences d_g tell where the mesh matters: with errors of order 2 a group contributes
   4/3 d_g. The groups that together stay below LEFT of the target are left as they are, the others are divided by 8,
   16 ...
3. Results are given at the user's nodes (`spacar.studies.user_nodes`). In modes 4 and 9, whose matrices belong to the
   degrees of freedom of the user, they are those of the user's mesh, and its error is only measured.

With a target the beams have the angle measure, of order 4, unless the run says `beams="sine"`: both measures tend to
the same rod. In motions the mesh of the user is integrated to a part of the target (`spacar.studies.accuracy`), finer
ones as that one.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from spacar.arrays import Array
from spacar.deck.rewrite.refine import divisible_beams, with_pieces
from spacar.errors import AnalysisError
from spacar.frame import Frame
from spacar.integrators.methods import METHODS
from spacar.kinematics.element_sweep import ElementSweep
from spacar.mechanism import Mechanism, build
from spacar.stream import AccuracyRequest, Run
from spacar.studies.accuracy import (
    EXPLICIT,
    SMALL,
    STALLED,
    STIFF,
    TIGHTEST,
    Accuracy,
    Attempt,
    Computed,
    Search,
    measured,
    stiff,
    tightened,
)
from spacar.studies.error_norm import distance
from spacar.studies.quantities import Quantity, quantity
from spacar.studies.result_quantities import Assessed, assessed
from spacar.studies.richardson import ROUNDING, extrapolate_rows
from spacar.studies.user_nodes import UserNodes, deform

GROUPS = {True: 12, False: 4}  # most groups that are divided one by one: stationary solutions, motions
REST = 4.0 / 3.0  # sum of a series of differences, each a quarter of the one before, over the first one
FEW = 4  # beams in the place of one, up to which all beams are divided alike
LEFT = 0.1  # part of the target that groups which are not refined may take
MOST = {True: 64, False: 16}  # beams in the place of one, at most
RESOLVED = 0.3  # error of the refined result over its difference from the mesh of the user, to measure that one
IN_TIME = 0.15  # part of the target that the integration of each mesh may take
UNMEASURED = 1e-5  # relative tolerance of refined meshes, at most, when the run of the file is only measured
FIELDS = ("x", "xd", "xdd", "sig", "fx", "fxtot", "xcompl")  # that are extrapolated
SPECTRA = ("eigval", "lmult")


@dataclass
class Mesh:
    """Results with `pieces[beam]` beams for each beam on the user's nodes; `time`: error of the integration."""

    pieces: dict[int, int]
    run: Run
    frames: list[Frame]
    found: Assessed
    seconds: float
    time: float = 0.0


@dataclass
class MeshSearch:
    """Meshes of one model. `in_time`: the error that the integration may have, None: the file's own settings."""

    run: Run
    beams: tuple[int, ...]
    measure: str
    variables: tuple[Quantity, ...] = ()
    in_time: float | None = None
    attempts: list[Attempt] = field(default_factory=list)
    own: Mesh | None = None  # of the user, the first one
    last: Attempt | None = None  # how that one is integrated

    @property
    def stationary(self) -> bool:
        return self.run.mode.stationary

    def compute(self, pieces: dict[int, int], measure: str) -> Mesh:
        """One mesh; the first one must be that of the user. Raises AnalysisError."""
        begun = time.process_time()
        mechanism, parts = self._mechanism(pieces, measure)
        given = mechanism if self.own is None else self.own.run.mechanism
        view = None if self.own is None else partial(_view, UserNodes(given, mechanism, parts), self.own.frames)
        run, error = Run(self.run.mode, mechanism), 0.0
        if self.stationary:
            frames = [f if view is None else view(f, i) for i, f in enumerate(run)]
        else:
            search = Search(run, self.variables, view=view, shown=given, hold=True)
            computed, error = self._integrated(search)
            run, frames = computed.run, computed.frames or []
            self.attempts += search.attempts
        found = assessed(given, self.run.mode.number, frames, self.variables, self.stationary)
        mesh = Mesh(pieces, run, frames, found, time.process_time() - begun, error)
        self.own = self.own or mesh
        return mesh

    def _integrated(self, search: Search) -> tuple[Computed, float]:
        """The motion of one mesh, and the error of its integration: measured in the mesh of the user; finer ones
        get the method and the tolerance that was enough there, so that most of this error is common to all."""
        methods = STIFF if stiff(search.run) else EXPLICIT
        if self.own is None:
            how = measured(search, methods) if self.in_time is None else tightened(search, methods, self.in_time)
            self.last = how[0].attempt
            return how[0], how[2]
        assert self.last is not None
        code, tolerance = self.last.integrator, self.last.tolerance
        if tolerance is None:  # that of the file; its fixed steps say nothing about finer meshes
            tolerance = max(min(self.own.time, UNMEASURED), TIGHTEST)
        if (code in STIFF) != (methods == STIFF) or not METHODS[code].variable_step:
            code = methods[1]
        return search.compute(code, tolerance), self.own.time

    def _mechanism(self, pieces: dict[int, int], measure: str) -> tuple[Mechanism, dict[int, list[int]]]:
        """The divided model with the settings of the run, and the parts of each beam."""
        given = self.run.mechanism
        deck = given.deck
        parts: dict[int, list[int]] = {}
        if any(n > 1 for n in pieces.values()):
            deck, parts = with_pieces(deck, pieces)
        elif measure == given.settings.beams:
            return given, {}
        settings = replace(given.settings, beams=measure)
        return replace(build(deck, self.run.mode.number, beams=measure), settings=settings), parts


def _view(nodes: UserNodes, own: Sequence[Frame], frame: Frame, i: int) -> Frame:
    return nodes.frame(frame, own[i])


def divisible(run: Run) -> tuple[tuple[int, ...], dict[int, str]]:
    """Beams of the model that can be divided, and why others cannot: user functions may count on the elements."""
    beams, reasons = divisible_beams(run.mechanism.deck)
    if run.mechanism.user_signal is not None:
        return (), dict.fromkeys((*beams, *reasons), "a user function may count on the elements of the model")
    return beams, reasons


@dataclass
class MeshResult:
    """What is shown: frames, the error of their coordinates (steps, nx), estimate and how it came about."""

    frames: Sequence[Frame]
    bars: Array
    estimate: float
    way: str
    meshes: list[Mesh]  # all that were computed; the last one is the finest


def stationary(run: Run) -> Iterator[Sequence[Frame]]:
    """Frames of modes 7 to 10 with the error of the mesh. Raises as these modes do."""
    request = run.accuracy or AccuracyRequest()
    beams, reasons = divisible(run)
    if not beams:
        estimate, way = (np.nan, _undivided(reasons)) if reasons else (0.0, "there are no flexible beams to refine")
        run.header["accuracy"] = found = Accuracy(request.target, estimate, 1.0, way, runs=1)
        for line in found.lines():
            run.report.add(line)
        yield from replace(run, accuracy=None, report=run.report, header=run.header).blocks()
        return
    search = MeshSearch(run, beams, _measure(run), variables=tuple(quantity(v) for v in request.variables))
    yield from _shown(run, search, _found(search, request.target), reasons)


def motion(run: Run) -> Iterator[Sequence[Frame]]:
    """Frames of modes 1 and 4 with the error of integration and mesh. Raises as these modes do."""
    request = run.accuracy or AccuracyRequest()
    beams, reasons = divisible(run)
    search = MeshSearch(run, beams, _measure(run), variables=tuple(quantity(v) for v in request.variables))
    search.in_time = None if request.target is None else IN_TIME * request.target
    yield from _shown(run, search, _found(search, request.target), reasons)


def _found(search: MeshSearch, target: float | None) -> MeshResult:
    return _measured(search) if target is None or search.run.mode.third else _refined(search, target)


def _measure(run: Run) -> str:
    """The measure of the deformations of the refined beams."""
    return run.mechanism.settings.beams or "angle"


def _undivided(reasons: dict[int, str]) -> str:
    return "; ".join(f"beam {b} cannot be divided: {text}" for b, text in reasons.items())


def _difference(a: Mesh, b: Mesh) -> float:
    return distance(a.found.values, b.found.values, a.found.amplitude)


def _groups(beams: Sequence[int], most: int) -> list[tuple[int, ...]]:
    """Beams that are neighbours in the numbering, in at most `most` groups."""
    parts = np.array_split(np.array(beams), min(most, len(beams)))
    return [tuple(int(b) for b in part) for part in parts]


def _refined(search: MeshSearch, target: float) -> MeshResult:
    """Meshes until the estimate is within the target."""
    ones = dict.fromkeys(search.beams, 1)
    own = search.compute(ones, search.measure)
    meshes, chain, active, left, n = [own], [own], search.beams, 0.0, 1
    found: MeshResult | None = None
    finest = own  # whose frames are found

    def mesh(pieces: dict[int, int]) -> Mesh:
        meshes.append(search.compute(pieces, search.measure))
        return meshes[-1]

    try:
        while True:
            n *= 2
            if n == 2 * FEW and len(search.beams) > 1:
                active, left = _active(search, own, mesh, target)
                if len(active) < len(search.beams):
                    chain = [own, *(mesh(ones | dict.fromkeys(active, k)) for k in (2, FEW))]
            chain.append(mesh(ones | dict.fromkeys(active, n)))
            found, finest = _extrapolated(own.run.mechanism, chain, left, active, n), chain[-1]
            stalled = len(chain) > 2 and _stalled(chain)
            if found.estimate <= target or stalled or 2 * n > MOST[search.stationary]:
                found.meshes = meshes
                if found.estimate > target:
                    why = "the differences of the meshes are rounding" if stalled else "the finest mesh that is tried"
                    found.way += f"; {why}"
                return found
    except AnalysisError as error:
        why = f"the mesh could not be refined further: {error}"
        if found is None:
            return MeshResult(own.frames, _bars(own, own, np.nan), np.nan, why, meshes)
        # `_shown` looks at the last mesh: the one whose frames these are, which need not have been computed last.
        meshes = [*(m for m in meshes if m is not finest), finest]
        return replace(found, way=f"{found.way}; {why}", meshes=meshes)


def _active(
    search: MeshSearch, own: Mesh, mesh: Callable[[dict[int, int]], Mesh], target: float
) -> tuple[tuple[int, ...], float]:
    """The beams that must be refined further, and the error that the mesh of the others leaves."""
    ones = dict.fromkeys(search.beams, 1)
    groups = _groups(search.beams, GROUPS[search.stationary])
    parts = np.array([_difference(mesh(ones | dict.fromkeys(group, 2)), own) for group in groups])
    order = np.argsort(parts)
    still = order[REST * np.cumsum(parts[order]) <= LEFT * target]
    active = tuple(b for i, group in enumerate(groups) if i not in still for b in group)
    return active or search.beams, float(REST * parts[still].sum())


def _stalled(chain: list[Mesh]) -> bool:
    """Do the differences not fall any more although they are small?"""
    now, before = _difference(chain[-1], chain[-2]), _difference(chain[-2], chain[-3])
    return now < SMALL and now > STALLED * before


def _extrapolated(given: Mechanism, chain: list[Mesh], left: float, active: Sequence[int], n: int) -> MeshResult:
    """The best of the last three meshes, with what they say of its error."""
    fine = chain[-1]
    in_time = 2.0 * max(m.time for m in chain[-3:])
    which = ", ".join(str(n // 2**k) for k in range(min(len(chain), 3) - 1, -1, -1))
    way = f"meshes of {which} beams in the place of {_list(active)}"
    if len(chain) == 2:
        error = _difference(fine, chain[0]) + left + in_time
        return MeshResult(fine.frames, _bars(fine, chain[0], error), error, f"{way}, not extrapolated", [])
    a, b, c = chain[-3:]
    amplitude = c.found.amplitude
    before = None
    if len(chain) > 3:
        coarser = chain[-4].found.values
        before = extrapolate_rows(coarser, a.found.values, b.found.values, amplitude)
    rows = extrapolate_rows(a.found.values, b.found.values, c.found.values, amplitude, before)
    error = float(rows.errors.max(initial=0.0)) + left + in_time
    counted = np.isfinite(amplitude) & (rows.errors > ROUNDING)
    seen = {p: int(np.sum(rows.order[counted] == p)) for p in (4, 2, 0)}
    words = [f"{k} with order {p}" if p else f"{k} not" for p, k in seen.items() if k]
    way += f", variables extrapolated: {', '.join(words)}"
    frames = _between(given, a.frames, b.frames, c.frames)
    bars = np.abs(np.array([f.x for f in frames]) - np.array([f.x for f in b.frames]))
    scale = _difference(c, b)
    bars *= min(1.0, error / scale) if scale > 0.0 else 1.0
    return MeshResult(frames, bars, error, way, [])


def _list(numbers: Sequence[int]) -> str:
    return f"beam {numbers[0]}" if len(numbers) == 1 else f"each of beams {', '.join(map(str, numbers))}"


def _bars(shown: Mesh, other: Mesh, estimate: float) -> Array:
    """Error of every coordinate: the difference of two meshes, as large as the estimate."""
    bars = np.abs(np.array([f.x for f in shown.frames]) - np.array([f.x for f in other.frames]))
    size = _difference(shown, other)
    return np.asarray(bars * (estimate / size if size > 0.0 else 1.0))


def _between(given: Mechanism, coarse: Sequence[Frame], middle: Sequence[Frame], fine: Sequence[Frame]) -> list[Frame]:
    """The frames of the finest mesh with the variables that show an order extrapolated."""
    found = [replace(f, matrices=dict(f.matrices)) for f in fine]

    def better(arrays: list[Array]) -> Array:
        shape = arrays[0].shape
        rows = [np.moveaxis(a, 0, -1).reshape(-1, shape[0]) for a in arrays]
        size = np.maximum(np.abs(rows[2]).max(axis=1, initial=0.0), np.finfo(float).tiny)
        values = extrapolate_rows(rows[0], rows[1], rows[2], size).values
        return np.moveaxis(values.reshape(*shape[1:], shape[0]), -1, 0)

    for name in FIELDS:
        if getattr(fine[0], name) is not None:
            every = better([np.array([getattr(f, name) for f in frames]) for frames in (coarse, middle, fine)])
            for frame, value in zip(found, every, strict=True):
                setattr(frame, name, value)
    for name in SPECTRA:
        if name in fine[0].matrices:  # what is nan has no order and stays so
            stacks = [[f.matrices[name] for f in frames] for frames in (coarse, middle, fine)]
            if len({a.shape for stack in stacks for a in stack}) == 1:
                for frame, value in zip(found, better([np.array(s) for s in stacks]), strict=True):
                    frame.matrices[name] = value
    sweep = ElementSweep(given)
    for frame in found:
        deform(given, sweep, frame, frame)
    return found


def _measured(search: MeshSearch) -> MeshResult:
    """The mesh of the user as it is, and its difference from refined ones."""
    ones = dict.fromkeys(search.beams, 1)
    own = search.compute(ones, search.run.mechanism.settings.beams)
    meshes, chain, n = [own], [], 1
    try:
        while True:
            chain.append(search.compute(dict.fromkeys(search.beams, n), search.measure))
            meshes.append(chain[-1])
            if len(chain) > 2:
                found = _extrapolated(own.run.mechanism, chain, 0.0, search.beams, n)
                a, b, c = (m.found.values for m in chain[-3:])
                rows = extrapolate_rows(a, b, c, chain[-1].found.amplitude)
                away = distance(own.found.values, rows.values, chain[-1].found.amplitude)
                if found.estimate <= RESOLVED * away or _stalled(chain) or 2 * n > MOST[search.stationary]:
                    break
            n *= 2
    except AnalysisError as error:
        unknown = np.full((len(own.frames), len(own.frames[0].x)), np.nan)
        return MeshResult(own.frames, unknown, np.nan, f"the mesh could not be refined: {error}", meshes)
    bars = np.abs(np.array([f.x for f in own.frames]) - np.array([f.x for f in found.frames]))
    way = f"the mesh of the model against {found.way}"
    return MeshResult(own.frames, bars, away + found.estimate, way, meshes)


def _shown(
    run: Run, search: MeshSearch, found: MeshResult, reasons: dict[int, str]
) -> Iterator[Sequence[Frame]]:
    """Report, header and frames of an outcome."""
    assert search.own is not None
    target = run.accuracy.target if run.accuracy else None
    own, last = search.own, found.meshes[-1]
    cost = sum(m.seconds for m in found.meshes) / max(last.seconds, 1e-9)
    shown = {} if found.frames is own.frames else {b: n for b, n in last.pieces.items() if n > 1}
    way = found.way + (f"; without {_undivided(reasons)}" if reasons else "")
    run.header["accuracy"] = record = Accuracy(
        target, float(found.estimate), float(cost), way, None, tuple(search.attempts), shown, len(found.meshes)
    )
    run.mechanism, run.n_frames = own.run.mechanism, len(found.frames)
    run.header |= own.run.header
    for line in own.run.report.lines:
        run.report.add(line)
    for line in record.lines():
        run.report.add(line)
    if shown and run.mode.linearized:
        run.report.add(
            "information: matrices of the linearized equations (m0, k0 ...) and transfer functions are those of the"
            " mesh of the model; coordinates, stresses, eigenvalues and load multipliers those of the refined one"
        )
    frames: Iterator[Frame] = iter(found.frames)
    if run.mode.integrated and run.mode.linearized:
        frames = iter(replace(run, accuracy=None, mechanism=own.run.mechanism))
    for frame, bars in zip(frames, found.bars, strict=True):
        frame.xerr = bars
        yield (frame,)
