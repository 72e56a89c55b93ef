"""The model with the drive of a stroke: one coordinate prescribed, or free and loaded, as a degree of freedom.

The drive has to be a degree of freedom of its own, so that stiffness and mass are known with it free and with it
locked. What the file itself moves (DELINPX, DELINPE) is its drive, and becomes free when another coordinate is moved. A
coordinate that is calculable in the file takes the place of that drive, or of the dynamic deformation that moves it
most in the reference configuration; the deformation is released, which keeps its stiffness (theory-system.md 1.1, class
c). What the file says about additional loading (DEL...) and about the start of the drive is left out.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import zip_longest

import numpy as np

from spacar.arrays import Array
from spacar.deck import ELEMENT_TYPES, Deck
from spacar.deck.deck import rebuilt
from spacar.deck.statement import Statement, Value
from spacar.deck.table_types import ELEMENT_CLASSES, NODE_CLASSES, independent_of
from spacar.dynamics.array_evaluator import Dynamics
from spacar.errors import UsageError
from spacar.kinematics.transfer import moved_along
from spacar.mechanism.mechanism import Mechanism
from spacar.stroke.stroke_move import StrokeMove, move_of, parse_move

Row = tuple[Value, ...]
Place = tuple[str, int, int]  # "x" or "e", node or element, coordinate or mode
STORED = ("OUTLEVEL", "MODES")  # what is stored of the states: left out, as nothing is stored here, but MODES 0
LEFT_OUT = (*STORED, "DELXF", "DELGRAV", "DELESIG", "DELOMF", "DELINPX", "DELINPE")
STARTS = ("INPUTE", "STARTDE", "INPUTX", "STARTDX")
STEERED = ("STARTDE", "STARTDX", "MEE")  # statements that need the class of a degree of freedom
STILL = 1e-9  # of the size of the drive's coordinate: degrees of freedom that do not move it by more


def own_move(deck: Deck, mechanism: Mechanism) -> StrokeMove:
    """The stroke that the file itself describes: its only DELINPX, DELINPE, or DELXF. Raises UsageError."""
    n = mechanism.numbering
    prescribed = deck.of("DELINPX", "DELINPE", block=2)
    if len(prescribed) == 1:
        s = prescribed[0]
        move = move_of(n, s.keyword == "DELINPE", s.integer(0), s.integer(1))
        begin = float(_start(deck, mechanism, move))
        ends = [float(move.stroke(begin)), float(move.stroke(begin + s.real(2)))]
        return move.within(min(ends), max(ends))
    loads = [(s, k) for s in deck.of("DELXF", block=2) for k in range(1, len(s.values)) if s.real(k)]
    if not prescribed and len(loads) == 1:
        s, k = loads[0]
        node = s.integer(0)
        turned = not n.planar and n.kind[node] == "orientation"
        if not turned or len(s.values) == 4:
            move = move_of(n, False, node, k + turned)
            return replace(move, low=min(0.0, s.real(k)), high=max(0.0, s.real(k)), pushed=True)
    text = f"{deck.source} moves no single coordinate (DELINPX, DELINPE, DELXF): say which one is moved and how far"
    raise UsageError(f"{text}, for instance --move 7x=0.01", "flexure.move")


def driven(deck: Deck, mechanism: Mechanism, move: StrokeMove, end: float, loads: Sequence[Row] = ()) -> Deck:
    """The deck that goes from the reference position of the drive to `end` [unit of the move] as additional loading.

    loads   rows of the dynamics block (XF) that act from the beginning. Raises UsageError when the drive is fixed or
    no degree of freedom moves it.
    """
    wanted = "dynamic" if move.pushed else "prescribed"
    classes = ELEMENT_CLASSES if move.deformation else NODE_CLASSES
    names = {name: keyword for keyword, name in classes.items()}
    freed = _replaced(mechanism, move)
    about = [("e" if move.deformation else "x", move.number, move.place), *([freed[0]] if freed else [])]
    kinematics: list[Row] = []
    dynamics: list[Row] = []
    for s in deck.statements:
        if s.block == 1 and s.keyword not in STORED:
            kinematics += _without(s, mechanism, about)
        elif s.keyword == "MODES" and not s.integer(0):
            dynamics.append(("MODES", 0))  # all modes and multipliers, of dense matrices
        elif s.block == 2 and s.keyword not in LEFT_OUT and not (s.keyword in STARTS and _place_of(s) in about):
            dynamics.append((s.keyword, *s.values))
    kinematics.append((names[wanted], move.number, move.place))
    if freed is not None and freed[1]:
        kinematics.append((freed[1], *freed[0][1:]))
    return rebuilt(deck, kinematics, [*_with_loads(dynamics, loads), *_stroke_rows(mechanism, move, end)])


def _with_loads(rows: Sequence[Row], loads: Sequence[Row]) -> list[Row]:
    """The dynamics block with further XF; those of one node are added up, as it has one statement at most."""
    out, place = list(rows), {int(row[1]): k for k, row in enumerate(rows) if row[0] == "XF"}
    for load in loads:
        node = int(load[1])
        if node not in place:
            place[node] = len(out)
            out.append(load)
            continue
        before = out[place[node]][2:]
        both = zip_longest(before, load[2:], fillvalue=0.0)
        out[place[node]] = ("XF", node, *(float(a) + float(b) for a, b in both))
    return out


def _stroke_rows(mechanism: Mechanism, move: StrokeMove, end: float) -> list[Row]:
    if not move.pushed:
        keyword = "DELINPE" if move.deformation else "DELINPX"
        return [(keyword, move.number, move.place, float(move.coordinate(end)))]
    if move.deformation:
        raise UsageError(f"{move.text}: a force acts on a node; a deformation is moved (--move)", "flexure.move")
    size = 3 if not mechanism.numbering.planar else 2 if move.unit == "m" else 1
    values = [0.0] * size
    values[move.place - 1 - move.rotation] = end
    return [("DELXF", move.number, *values)]


def load_row(text: str, mechanism: Mechanism, metre: float, option: str = "--load") -> Row:
    """The XF statement of `7y=-10`, in SI; `option` is what errors call it. Raises UsageError."""
    found = parse_move(text, mechanism.numbering, metre, pushed=True, option=option)
    value = found.low or found.high
    if found.low and found.high:
        raise UsageError(f"{option} {text}: one force, not a range", "flexure.load")
    if found.deformation:
        raise UsageError(f"{option} {text}: a force acts on a node", "flexure.load")
    return ("XF", *_stroke_rows(mechanism, found, value)[0][1:])


def _start(deck: Deck, mechanism: Mechanism, move: StrokeMove) -> float:
    """The value that the initial loading of the file prescribes, counted from the reference configuration."""
    n = mechanism.numbering
    keyword = "INPUTE" if move.deformation else "INPUTX"
    reference = 0.0 if move.deformation else float(mechanism.x0[n.x_index(move.number, move.place)])
    for s in deck.of(keyword, block=2):
        if s.integer(0) == move.number and s.integer(1) == move.place:
            return s.real(2) - reference
    return 0.0


def _place_of(s: Statement) -> Place:
    """What INPUTX, STARTDX, DELINPX, and the same of E, give a value to."""
    return s.keyword[-1].lower(), s.integer(0), s.integer(1)


def _without(s: Statement, mechanism: Mechanism, dropped: Sequence[Place]) -> list[Row]:
    """A statement of the kinematics block as rows that give no class to the `dropped` places."""
    n = mechanism.numbering
    kind, given = "", s.integers(1)
    if s.keyword in NODE_CLASSES:
        kind, given = "x", given or independent_of(n.kind.get(s.integer(0), "orientation"), n.planar)
    elif s.keyword in ELEMENT_CLASSES:
        kind, given = "e", given or ELEMENT_TYPES[n.keyword[s.integer(0)]].classed
    kept = tuple(k for k in given if (kind, s.integer(0), k) not in dropped) if kind else given
    if kept == given:
        return [(s.keyword, *s.values)]
    return [(s.keyword, s.integer(0), *kept)] if kept else []


def _replaced(mechanism: Mechanism, move: StrokeMove) -> tuple[Place, str] | None:
    """What gives way to the drive, and the keyword of its new class ("": none is needed); None when nothing does.

    Raises UsageError when the drive is fixed or nothing moves it.
    """
    n = mechanism.numbering
    i = (n.e_index if move.deformation else n.x_index)(move.number, move.place)
    classes = n.e_class if move.deformation else n.x_class
    found = next(name for name, part in classes.items() if part.start <= i < part.stop)
    if found == "fixed":
        text = f"{move.text} is {'rigid' if move.deformation else 'fixed'}: it cannot be moved"
        raise UsageError(text, "flexure.move")
    if found == "kinematic":
        raise UsageError(f"{move.text} is a configuration coordinate of wheels", "flexure.move")
    here: Place = ("e" if move.deformation else "x", move.number, move.place)
    drives = [d for d in map(_place_of, mechanism.deck.of("DELINPX", "DELINPE", block=2)) if d != here]
    if found in ("input", "dynamic"):
        return (drives[0], "DYNE" if drives[0][0] == "e" else "DYNX") if len(drives) == 1 else None
    dynamics = Dynamics(mechanism)
    dynamics.kinematics.begin()
    dynamics.place(0.0, dynamics.start_values())
    unit = np.zeros(n.ne if move.deformation else n.nx)
    unit[i] = 1.0
    row = moved_along(dynamics.kinematics, dynamics.sweep.rate_transposed(unit) if move.deformation else unit)
    size = np.concatenate((mechanism.scale[n.q_x], mechanism.deformation_scale[n.q_e]))
    share = np.abs(row) * size
    own = (mechanism.deformation_scale if move.deformation else mechanism.scale)[i]
    if not share.max(initial=0.0) > STILL * own:
        text = f"{move.text} cannot be moved: no degree of freedom moves it in the reference configuration"
        raise UsageError(text, "flexure.move")
    place = _candidate(mechanism, share, drives)
    return place, "RLSE" if place[0] == "e" else ""


def _candidate(mechanism: Mechanism, share: Array, drives: Sequence[Place]) -> Place:
    """The drive of the file, else the dynamic degree of freedom with the largest share (ndof,), deformations before
    coordinates. Raises UsageError."""
    n = mechanism.numbering
    steered = {s.values[:2] for s in mechanism.deck.of(*STEERED, block=2)}
    places: list[Place] = [("x", *n.x_owner(int(i))) for i in n.q_x] + [("e", *n.e_owner(int(i))) for i in n.q_e]
    best: tuple[float, Place] = (0.0, ("", 0, 0))
    for k, here in enumerate(places):
        on_x, number = here[0] == "x", here[1]
        fitting = k in n.dynamic and here[1:] not in steered and not (on_x and n.kind[number] == "warping")
        if here in drives or fitting:
            weight = 1e6 if here in drives else 1e-3 if on_x else 1.0
            best = max(best, (weight * float(share[k]), here))
    if not best[0] > 0.0:
        text = "no dynamic degree of freedom (DYNE, DYNX) can give way to the drive; prescribe it in the file (INPUTX)"
        raise UsageError(text, "flexure.move")
    return best[1]
