"""The trajectories of a deck as one prescribed motion (theory-system.md 7.2, input-language.md section 6).

Trajectories follow each other: each starts where the previous one ended, time accumulates, and coordinates without a
path rest. The set-point where two of them meet is the end of the earlier one: its accelerations and loads count there.
Extra masses (TRM) and forces (TRF) act during their own trajectory only.
"""

from bisect import bisect_left
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import islice
from operator import attrgetter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import Array, Index
from spacar.deck import Deck, Statement
from spacar.deck.table_io import NO_TRAJECTORY, PATHS, TRAJECTORIES
from spacar.elements.spatial.node_inertia import RigidBodyNode
from spacar.errors import InputError, Message, Report
from spacar.integrators import EvenTimes
from spacar.inverse.paths import BadPath, Path, arc, change, straight, turn
from spacar.inverse.profile import IllegalProfile, Profile, make_profile
from spacar.mechanism.layout import Batch
from spacar.mechanism.lumped_inertia import LumpedMass, symmetric
from spacar.mechanism.mechanism import Drive, DriveState, Mechanism, Polynomial

NAMES = {k.name for k in TRAJECTORIES}
UNMOVED = 1e-9  # of the size: a fixed coordinate that a path names with the digits of a file


class Leg(NamedTuple):
    """One trajectory: its statements, when it starts and how long it takes [s], its output steps, what moves in it."""

    statements: tuple[Statement, ...]
    start: float
    duration: float
    steps: int
    x: Array  # prescribed coordinates at its start
    e: Array  # prescribed deformations at its start
    moves: tuple[tuple[Profile, Path, bool], ...]  # whether along deformations

    def at(self, t: float) -> DriveState:
        x, e = np.zeros((3, len(self.x))), np.zeros((3, len(self.e)))
        x[0], e[0] = self.x, self.e
        for profile, path, of_elements in self.moves:
            target = e if of_elements else x
            target[:, path.rows] = path.at(*profile.at(t))
        return DriveState(*x, *e)


class TrajectoryDrive(NamedTuple):
    """All trajectories one after the other; before the first and after the last one everything rests."""

    legs: tuple[Leg, ...]
    breaks: tuple[float, ...] = ()  # nothing is integrated along them

    def at(self, t: float) -> DriveState:
        leg = self.legs[max(bisect_left(self.legs, t, key=attrgetter("start")) - 1, 0)]
        return leg.at(t - leg.start)


@dataclass(frozen=True)
class TrajectoryProgram:
    """What mode 2 runs through: the motion and its trajectories. Its length is the number of output times."""

    drive: Drive
    legs: tuple[Leg, ...]

    def __len__(self) -> int:
        return 1 + sum(leg.steps for leg in self.legs)

    def times(self) -> Iterator[tuple[float, int]]:
        """(output time [s], index of its trajectory), one after the other."""
        yield 0.0, 0
        for k, leg in enumerate(self.legs):
            for t in islice(EvenTimes(leg.start, leg.start + leg.duration, leg.steps), 1, None):
                yield t, k

    def rests(self, mechanism: Mechanism) -> NDArray[np.bool_]:
        """(ne,) which prescribed deformations have the same value at all output times."""
        place = mechanism.numbering.e_class["input"]
        rests = np.zeros(mechanism.numbering.ne, bool)
        values = np.array([self.drive.at(float(t)).e for t, _ in self.times()])
        rests[place] = np.ptp(values, axis=0) == 0.0
        return rests


def program(mechanism: Mechanism, report: Report) -> TrajectoryProgram:
    """The motion of all TRAJECT statements and its output times.

    Raises InputError for an illegal velocity profile or path, with the line of the statement, and when there is no
    TRAJECT.
    """
    deck = mechanism.deck
    if not groups(deck):
        raise InputError([Message("error", deck.source, None, "", NO_TRAJECTORY, "input.no-trajectory")])
    start = mechanism.drive.at(0.0)
    if any(v.any() for v in (start.xd, start.xdd, start.ed, start.edd)):
        report.add(
            "mode 2: rates and accelerations of INPUTX and INPUTE are not used; the trajectories prescribe the motion"
        )
    legs, x, e, begin = [], start.x, start.e, 0.0
    for number, statements in groups(deck):
        leg = _leg(mechanism, report, number, statements, begin, x, e)
        legs.append(leg)
        end = leg.at(leg.duration)
        x, e, begin = end.x, end.e, begin + leg.duration
    user = deck.last("USERTRAJ", block=3)
    drive: Drive = TrajectoryDrive(tuple(legs)) if user is None else _user_drive(mechanism, user, legs[0])
    return TrajectoryProgram(drive, tuple(legs))


def groups(deck: Deck) -> list[tuple[int, tuple[Statement, ...]]]:
    """(number, statements) of every TRAJECT in file order."""
    found: list[tuple[int, list[Statement]]] = []
    for s in deck.of(*NAMES, block=3):
        if s.keyword == "TRAJECT":
            found.append((s.integer(0), []))
        elif found:
            found[-1][1].append(s)
    return [(number, tuple(statements)) for number, statements in found]


def named(statements: tuple[Statement, ...], *keywords: str) -> list[Statement]:
    """Those of a trajectory with these keywords."""
    return [s for s in statements if s.keyword in keywords]


def _user_drive(mechanism: Mechanism, statement: Statement, leg: Leg) -> Drive:
    from spacar.mechanism.user_functions import UserDrive

    x, e = np.zeros((len(leg.x), 3)), np.zeros((len(leg.e), 3))
    x[:, 0], e[:, 0] = leg.x, leg.e
    interval = leg.duration / leg.steps
    return UserDrive.load(mechanism.deck, statement, mechanism.numbering, Polynomial(x, e), interval)


def _leg(
    mechanism: Mechanism, report: Report, number: int, statements: tuple[Statement, ...], begin: float, x: Array,
    e: Array,
) -> Leg:  # fmt: skip
    values = named(statements, "TRTIME")[0].values
    duration, steps = float(values[0]), int(np.prod([int(v) for v in values[1:]]))
    speeds = {(s.keyword, s.integer(0)): s for s in named(statements, "TRVMAX", "TREPMAX")}
    fronts = {s.integer(0): int(s.real(1)) for s in named(statements, "TRFRONT")}
    moves = []
    for s in named(statements, *PATHS):
        path = _path(mechanism, s, x, e)
        given = speeds.get(("TREPMAX" if s.keyword == "TRE" else "TRVMAX", s.integer(0)))
        if path.length == 0.0 and given is not None:
            report.add(f"trajectory {number}: {s.subject} does not move, so {given.subject} is not used")
        profile = _profile(mechanism.deck, path.length, duration, s, given, fronts.get(s.integer(0), 0))
        moves.append((profile, path, s.keyword == "TRE"))
    return Leg(statements, begin, duration, steps, x, e, tuple(moves))


def _profile(
    deck: Deck, length: float, duration: float, path: Statement, given: Statement | None, front: int
) -> Profile:
    rise = given.real(1) if given is not None and len(given.values) > 1 else None
    speed = given.real(2) if given is not None and len(given.values) > 2 else None
    try:
        return make_profile(length, duration, rise, speed, front)
    except IllegalProfile as error:
        raise _refused(deck, given or path, str(error), "input.velocity-profile") from None


def _path(mechanism: Mechanism, s: Statement, x: Array, e: Array) -> Path:
    n = mechanism.numbering
    number, numbers = s.integer(0), [s.real(i) for i in range(1, len(s.values))]
    try:
        if s.keyword == "TRE":
            row = n.e_index(number, 1) - n.e_class["input"].start
            if not 0 <= row < len(e):
                raise BadPath(f"mode 1 of element {number} is not prescribed; it needs INPUTE {number} 1")
            return change(np.array([row]), e[[row]], numbers[0])
        end = np.array(numbers)
        rows, components = _rows(mechanism, number, len(x), end if s.keyword == "TRANS" else None)
        if s.keyword == "TROT":
            if n.planar:
                return change(rows, x[rows], numbers[0])
            orientation = np.zeros(4)
            orientation[components] = x[rows]
            if 0 not in components:
                orientation[0] = np.sqrt(max(0.0, 1.0 - float(x[rows] @ x[rows])))
            return turn(rows, components, orientation, numbers[0], np.array(numbers[1:4]))
        size = len(rows)
        if s.keyword == "TRANS":
            return straight(rows, x[rows], end[components])
        return arc(rows, x[rows], np.array(numbers[:size]), np.array(numbers[size : 2 * size]))
    except BadPath as error:
        raise _refused(mechanism.deck, s, str(error), "input.path") from None


def _rows(mechanism: Mechanism, node: int, n_prescribed: int, end: Array | None) -> tuple[Index, Index]:
    """Prescribed coordinates of a node: their places among all prescribed ones, and their numbers from 0.

    Raises BadPath when one of the independent coordinates is not prescribed; of a straight path to `end` it may be
    fixed where the path does not change it.
    """
    n = mechanism.numbering
    size = int(np.count_nonzero(n.lnp[node - 1]))
    rows = n.lnp[node - 1, :size] - 1 - n.x_class["input"].start
    inside = (rows >= 0) & (rows < n_prescribed)
    needed = np.ones(size, bool)
    needed[0] = size != 4
    if end is not None:
        at = n.lnp[node - 1, :size] - 1
        held = at < n.x_class["fixed"].stop
        away = held & (np.abs(end - mechanism.x0[at]) > UNMOVED * mechanism.scale[at])
        for k in np.flatnonzero(away):
            raise BadPath(f"coordinate {k + 1} of node {node} is fixed at {mechanism.x0[at[k]]:.9g} m: not on the path")
        needed &= ~held
    if not inside[needed].all():
        coordinate = int(np.flatnonzero(needed & ~inside)[0]) + 1
        raise BadPath(f"coordinate {coordinate} of node {node} is not prescribed; the path needs INPUTX {node}")
    return rows[inside], np.flatnonzero(inside)


def _refused(deck: Deck, statement: Statement, text: str, code: str) -> InputError:
    return InputError([deck.message("error", statement, text, code=code)])


def loaded(mechanism: Mechanism, statements: tuple[Statement, ...]) -> Mechanism:
    """The mechanism with the extra masses and forces of a trajectory; the same object when there are none."""
    n = mechanism.numbering
    extra: list[Batch] = []
    for s in named(statements, "TRM"):
        node = s.integer(0)
        rows = n.lnp[node - 1, : int(np.count_nonzero(n.lnp[node - 1]))] - 1
        family: Any
        if n.kind[node] == "orientation" and not n.planar:
            family = RigidBodyNode(np.array([node]), symmetric(np.array(s.reals(1, len(s.values) - 1)))[None])
            extra.append(Batch(family, rows[:, None], np.zeros((0, 1), np.int64)))
        else:
            family = LumpedMass(np.full(len(rows), node), np.full(len(rows), s.real(1)))
            extra.append(Batch(family, rows[None, :], np.zeros((0, len(rows)), np.int64)))
    force = np.zeros(n.nx)
    for s in named(statements, "TRF"):
        for coordinate, value in enumerate(s.values[1:], 1):
            force[n.x_index(s.integer(0), coordinate)] += float(value)
    if not extra and not force.any():
        return mechanism
    loads = replace(mechanism.loads, force=mechanism.loads.force + force)
    return replace(mechanism, batches=(*mechanism.batches, *extra), loads=loads)
