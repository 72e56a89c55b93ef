"""`spacar.flexure`: stiffness, errors, frequencies, buckling, force, energy and stress over a range of motion.

The stationary solutions are those of modes 7, 8 and 10 (theory-system.md section 6) on the model of `driven_deck`, from
the undeflected state outwards, to both sides one after the other. Definitions: docs/flexures.md.

Work of the drive and of the other loads along the stroke (docs/flexures.md section 4).

    drive   integral of F ds by Hermite's rule, h (F_0 + F_1)/2 + h^2 (k_0 - k_1)/12 in a step of length h, k = dF/ds;
            its error is of fourth order in the step
    others  sum of (f_0 + f_1).(x_1 - x_0)/2: exact for constant forces, second order for gravity on beams
    moments sum of M.theta, theta the rotation vector from one state to the next: exact for turns about one axis

Both are counted from the undeflected state. Their sum is the strain energy that the mechanism has gained; what is
missing is the error of the integrals.
"""

from collections.abc import Sequence
from dataclasses import replace
from numbers import Integral
from typing import Any, NamedTuple

import numpy as np

from spacar.arrays import Array
from spacar.calls import Source, checked_options, deck_of, frames, texts
from spacar.deck import Deck
from spacar.deck.length_unit import shown_in
from spacar.errors import AnalysisError, Report, UsageError
from spacar.linear.linear_modes import stationary
from spacar.mechanism import build
from spacar.mechanism.inputs import applied
from spacar.mechanism.mechanism import Loads, Mechanism
from spacar.result import Result
from spacar.stroke.drive_equations import DriveEquations, DrivePlace, MixedDrive, ReducedDrive
from spacar.stroke.driven_deck import Row, driven, load_row, own_move
from spacar.stroke.error_motions import error_motions, relative_rotations
from spacar.stroke.flexure_results import Flexure
from spacar.stroke.observed_node import ObservedNode
from spacar.stroke.station import Station, node_compliance, station
from spacar.stroke.stroke_move import StrokeMove, parse_move

OURS = {"load_steps", "store_every", "stationary_type"}
WITH_INITIAL = 2  # ITERSTEP type: the initial loading first, then the additional one


def flexure(
    source: Source, *, move: str | None = None, force: str | None = None, node: int | None = None,
    orientation: int = 0, steps: int = 10, loads: str | Sequence[str] = (), extra: str | Sequence[str] = (),
    pivot: Sequence[float] | None = None, modes: int = 6, **options: Any,
) -> Flexure:  # fmt: skip
    """What a designer of a flexure asks over its range of motion.

    source       path of the input file, a Deck or a Model; lengths below are in its unit of length (UNITS)
    move         coordinate and range, "7x=0.02", "8rz=-0.3:0.3", "e[3,1]=+-0.1"; default: what the file moves (DELINPX)
    force        the same with a force or moment instead, "7x=27"; the drive is then free and loaded
    node         whose stiffness and motion are asked for, default that of the drive;  orientation: its other node
    steps        to the farther end of the range
    loads        further forces that act all the time, "7y=-10"
    extra        forces that do not act, together one load case: its own multiplier is asked for, "7y=-1"
    pivot        ideal pivot, x y (z), instead of the pole of the undeflected state
    modes        how many frequencies are kept
    options      override the deck, as in `spacar.run` (beams, max_iterations ...)

    Raises UsageError and InputError for what is asked wrongly, AnalysisError where a state cannot be computed.

    >>> import spacar
    >>> study = spacar.flexure("data/leafguide.dat", move="7x=5", steps=1)
    >>> len(study.result.frames)
    2
    """
    options = checked_options(options)[0]
    if taken := OURS & options.keys():
        raise UsageError(f"{', '.join(sorted(taken))}: the steps of the stroke are set by `steps`", "flexure.steps")
    if not (isinstance(steps, Integral) and isinstance(modes, Integral) and steps >= 1 and modes >= 1):
        raise UsageError(f"steps = {steps!r} and modes = {modes!r} must be whole numbers from 1", "flexure.steps")
    texts("a move or a force", [text for text in (move, force) if text is not None])
    loads, extra = texts("loads", loads), texts("extra", extra)
    deck = deck_of(source, 10)
    mechanism = build(deck, 10, **options)
    n = mechanism.numbering
    if not n.holonomic or n.nk:
        raise UsageError(f"{deck.source} has wheels: there is no stroke of a flexure", "flexure.wheels")
    centre = _pivot(pivot, deck.metre, n.planar)
    if move is not None and force is not None:
        raise UsageError("give either a move or a force, not both", "flexure.move")
    given = force if move is None else move
    asked = own_move(deck, mechanism) if given is None else parse_move(given, n, deck.metre, pushed=force is not None)
    whole = asked.within(min(asked.low, 0.0), max(asked.high, 0.0))
    acting = [load_row(text, mechanism, deck.metre) for text in loads]
    beside = [load_row(text, mechanism, deck.metre, "--extra") for text in extra]
    ends = [end for end in (whole.low, whole.high) if end]
    farthest = max(map(abs, ends))
    doubt = beyond(whole, mechanism.length, deck.metre)
    sides = []
    try:
        for end in ends:
            count = max(1, int(np.ceil(steps * abs(end) / farthest - 1e-9)))
            sides.append(_side(deck, mechanism, whole, end, count, acting, beside, node, orientation, modes, options))
    except AnalysisError as error:
        raise AnalysisError("; ".join(filter(None, (str(error), doubt))), error.code, **error.data) from error
    return replace(_joined(deck, whole, sides, centre, doubt), extra=extra)


def beyond(move: StrokeMove, length: float, metre: float) -> str:
    """What to doubt in a range that is longer than the model, `length` [m]: usually its unit; "" for another one."""
    farthest = max(-move.low, move.high)
    if move.pushed or move.unit != "m" or farthest <= length:
        return ""
    unit = shown_in("m", metre)[1]
    sizes = f"the range of {move.text}, {farthest / metre:.4g} {unit}, exceeds the size of the model, "
    return f"{sizes}{length / metre:.4g} {unit}; lengths are in {unit}, the unit of the input file (UNITS)"


class _Side(NamedTuple):
    """The states from the undeflected one to one end: station, stroke, actuator force, its slope, and all other forces
    (nx,) but constant moments."""

    mechanism: Mechanism
    node: ObservedNode
    report: Report
    states: list[tuple[Station, float, float, float, Array]]


def _side(
    deck: Deck, mechanism: Mechanism, move: StrokeMove, end: float, count: int, acting: Sequence[Row],
    beside: Sequence[Row], node: int | None, orientation: int, modes: int, options: dict[str, Any],
) -> _Side:  # fmt: skip
    made = driven(deck, mechanism, move, end, acting)
    settings = {"load_steps": count, "store_every": 1, "stationary_type": WITH_INITIAL}
    run = frames(10, made, **(options | settings))
    n = run.mechanism.numbering
    row = (n.e_index if move.deformation else n.x_index)(move.number, move.place)
    drive = DrivePlace.of(n, row, move.deformation)
    side = _Side(run.mechanism, _observed(run.mechanism, move, node, orientation), run.report, [])
    extra: Loads | None = None
    if beside:
        extra = Loads(*applied((row[1:] for row in beside), n), np.zeros(2 if n.planar else 3), np.zeros(n.ne))
    turned = ObservedNode.of(n, move.number) if move.pushed and move.rotation else None
    mixed: MixedDrive | None = None
    with np.errstate(all="ignore"):
        for k, solution in enumerate(stationary(run, sparse_in_motion=False)):
            d, frame = solution.dynamics, solution.frame
            equations: DriveEquations
            if solution.tangent is not None:
                if mixed is None or mixed.dynamics is not d:
                    mixed = MixedDrive(d, drive)
                equations = mixed.at(solution.tangent.sigma)
            else:
                assert solution.L is not None
                equations = ReducedDrive(d, solution.L, drive)
            found = station(frame, equations, not move.pushed, side.node, modes, extra, run.report)
            change = float(frame.e[row] if move.deformation else frame.x[row] - run.mechanism.x0[row])
            stroke, force, slope = float(move.stroke(change)), end * k / count, found.slope
            if turned is not None:  # rotation of its node by a unit of the moment
                axis = turned.names.index(f"phi{move.text[-1]}")
                turning = float(node_compliance(equations, turned, True, run.report)[axis, axis])
                slope = 1.0 / turning if turning else slope
            elif not move.pushed:
                dual = -frame.sig[row] if move.deformation else (frame.fxtot - (frame.fx + frame.fxgrav))[row]
                force = float(move.force(np.array(stroke), dual))
                slope = float(move.stiffness(np.array(stroke), dual, np.array(slope)))
            side.states.append((found, stroke, force, slope, run.mechanism.loads.force + frame.fxgrav))
    return side


def _observed(mechanism: Mechanism, move: StrokeMove, node: int | None, orientation: int) -> ObservedNode:
    """The node that was asked for, else that of the drive; for a deformation the second one of its element."""
    n = mechanism.numbering
    if node is None and move.deformation:
        nodes = next(nodes for number, _, nodes in n.elements if number == move.number)
        node = next((m for m in reversed(nodes) if n.kind[m] == "position"), nodes[-1])
    return ObservedNode.of(n, move.number if node is None else node, orientation)


def _joined(deck: Deck, move: StrokeMove, sides: Sequence[_Side], pivot: Array | None, doubt: str) -> Flexure:
    """Both sides as one stroke with increasing values, which contains the undeflected state once."""
    first, states, zero = sides[0], sides[-1].states, 0
    if move.low < 0.0:
        zero = len(first.states) - 1
        states = first.states[:0:-1] + (states if len(sides) == 2 else first.states[:1])
    stations, *numbers = zip(*states, strict=True)
    stroke, force, slope, others = map(np.array, numbers)
    if not np.all(np.diff(stroke) > 0.0) and not move.pushed:
        raise AnalysisError("the stroke does not grow from state to state", "flexure.stroke")
    shots = tuple(replace(s.frame, t=float(i)) for i, s in enumerate(stations))
    lines = [f"warning: {doubt}"] if doubt else []
    lines = list(dict.fromkeys(lines + [line for side in sides for line in side.report.lines]))
    result = Result(first.mechanism, 10, shots, tuple(lines), {})
    node = first.node
    h = np.diff(stroke)
    correction = h**2 * (slope[:-1] - slope[1:]) / 12.0  # none without a finite slope: the trapezoidal rule
    parts = 0.5 * h * (force[:-1] + force[1:]) + np.where(np.isfinite(correction), correction, 0.0)
    x, loads = np.array([s.frame.x for s in stations]), first.mechanism.loads
    # d(coordinate)/d(stroke)
    by_stroke = (0.5 * np.cos(0.5 * stroke) if move.rotation else np.ones(len(stroke))).tolist()
    moving = [node.spatial(s.velocity * rate) for s, rate in zip(stations, by_stroke, strict=True)]
    errors = error_motions(
        np.array([node.place(s.frame.x) for s in stations]), np.array([node.turn(s.frame.x) for s in stations]),
        np.array([m for m, _ in moving]), np.array([w for _, w in moving]), zero, first.mechanism.length,
        pivot, move.unit == "rad" and move.number == node.orientation,
    )  # fmt: skip
    return Flexure(
        deck.source, move, node, deck.metre, zero, stroke, force, slope,
        _from_zero(parts, zero),
        load_work(others, x, loads.moment, x[:, loads.moment_rows.T], zero),
        stations, errors, result,
    )  # fmt: skip


def _pivot(given: Sequence[float] | None, metre: float, planar: bool) -> Array | None:
    if given is None:
        return None
    size = 2 if planar else 3
    if len(given) not in (2, size):
        raise UsageError(f"the pivot has {size} coordinates, not {len(given)}", "flexure.pivot")
    return np.pad(np.asarray(given, float) * metre, (0, 3 - len(given)))


def load_work(forces: Array, x: Array, moments: Array, turns: Array, zero: int) -> Array:
    """(k,) work [J] of the forces (k, nx) on the coordinates x (k, nx), and of constant global moments (n, 3) on nodes
    with the Euler parameters turns (k, n, 4)."""
    parts = 0.5 * np.sum((forces[:-1] + forces[1:]) * np.diff(x, axis=0), axis=1)
    for k, moment in enumerate(moments):
        parts += relative_rotations(turns[1:, k], turns[:-1, k]).as_rotvec() @ moment
    return _from_zero(parts, zero)


def _from_zero(parts: Array, zero: int) -> Array:
    total = np.concatenate(([0.0], np.cumsum(parts)))
    return total - total[zero]
