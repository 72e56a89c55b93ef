"""Python functions beside the input file: USERSIG (forces and stresses) and USERINP, USERTRAJ (prescribed motion).

Signatures (input-language.md notes d5 and d12; index arrays 0-based, -1 for "does not exist", which `placed_vectors`
refuses):

    time, sig, f = name(t, ne, le, e, ep, nx, lnp, x, xp)     rows: number, mode or coordinate, value[, k, d]
    t, e, x = name(t, step)                                   rows: number, mode or coordinate, value, rate, acc.

The returned rows use the numbers of the input file. A missing or wrong function raises InputError before the run; an
exception, a wrong shape or a non-finite value during the run raises AnalysisError with time and row. A stress on a
fixed or prescribed deformation cannot act, because equilibrium alone determines it there: a warning of the run.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from math import isfinite
from typing import Any, NamedTuple, TypeVar

import numpy as np

from spacar.arrays import Array, Index
from spacar.deck import Deck, Statement
from spacar.deck.rewrite.divide import split_motion
from spacar.errors import BY_USERS, AnalysisError, type_and_text
from spacar.mechanism.mechanism import DriveState, Polynomial, Rows, UserForces, UserSignal
from spacar.mechanism.numbering import Numbering
from spacar.mechanism.placed_vectors import PlacedVector, placed
from spacar.mechanism.user_files import Loaded, load_function
from spacar.modes import find_mode


def call(function: Callable[..., Any], name: str, t: float, *arguments: Any) -> tuple[Any, Any]:
    """Call a user function and return its second and third result. Raises AnalysisError."""
    try:
        _, first, second = function(t, *arguments)
    except BY_USERS as error:  # a user's function may fail in any way
        raise _failed(name, t, error) from error
    return first, second


def _failed(name: str, t: float, error: BaseException) -> AnalysisError:
    text = f"the user function {name} failed at t = {t:.9g}: {type_and_text(error)}"
    return AnalysisError(text, "user-function.failed", t=t)


def read_rows(name: str, what: str, rows: Any, widths: tuple[int, ...], t: float) -> Sequence[Sequence[float]]:
    """Rows as numbers, filled up with zeros. A few short lists, the usual answer, are read without arrays; whatever is
    not just that goes to `checked_rows`, which raises AnalysisError naming the time and the row that is wrong.
    """
    few = type(rows) is list and len(rows) <= FEW and all([_plain(row, widths) for row in rows])
    if few and len({len(row) for row in rows}) <= 1:
        return [(*row, *ZEROS[: max(widths) - len(row)]) for row in rows]
    array: list[list[float]] = checked_rows(name, what, rows, widths, t).tolist()
    return array


def _plain(row: Any, widths: tuple[int, ...]) -> bool:
    """Whether a row is a list of numbers whose sum is one; where not, `checked_rows` looks at each of them."""
    try:
        return type(row) in ROWS and len(row) in widths and NUMBERS.issuperset(map(type, row)) and isfinite(sum(row))
    except OverflowError:  # an integer beyond the floating-point numbers
        return False


def checked_rows(name: str, what: str, rows: Any, widths: tuple[int, ...], t: float) -> Array:
    """Rows as a 2-D float array; raises AnalysisError naming the time and the row that is wrong."""
    try:
        array = np.atleast_2d(np.asarray(rows if rows is not None else [], float))
    except (TypeError, ValueError, OverflowError) as error:
        raise AnalysisError(
            f"{name} at t = {t:.9g}: {what} is not an array of numbers ({error})", "user-function.shape", t=t
        ) from error
    if array.size == 0:
        return np.zeros((0, max(widths)))
    if array.ndim != 2 or array.shape[1] not in widths:
        expected = " or ".join(str(w) for w in widths)
        text = f"{name} at t = {t:.9g}: {what} has the shape {array.shape}; expected rows of {expected} numbers"
        raise AnalysisError(text, "user-function.shape", t=t)
    bad = np.flatnonzero(~np.isfinite(array).all(axis=1))
    if len(bad):
        text = f"{name} at t = {t:.9g}: row {bad[0] + 1} of {what} is not finite: {array[bad[0]].tolist()}"
        raise AnalysisError(text, "user-function.not-finite", t=t)
    return np.pad(array, ((0, 0), (0, max(widths) - array.shape[1])))


FEW = 20  # rows above which an array is read faster
NUMBERS = {int, float, np.float64}
ROWS = {list, tuple}
Form = list[Any]  # of rows: two numbers and a place each
ZEROS = (0.0,) * 5


def whole(row: Sequence[float]) -> tuple[int, int]:
    """The two leading numbers of a row; KeyError if they are not whole."""
    a, b = float(row[0]), float(row[1])
    if not (a.is_integer() and b.is_integer()):
        raise KeyError((a, b))
    return int(a), int(b)


def _unknown(name: str, what: str, k: int, row: Sequence[float], why: str, t: float) -> AnalysisError:
    text = f"{name} at t = {t:.9g}: row {k + 1} of {what} names {row[0]:g} {row[1]:g}, which {why}"
    return AnalysisError(text, "user-function.index", t=t)


def _taken(rows: Any, places: dict[tuple[Any, Any], int], values: Any) -> Form | None:
    """Add rows to values, when they are a short list of three numbers each whose places were looked up before, and give
    the numbers and the place of every row, one after the other. Else None: then `UserLaw._rows` reads them, and what
    was added is of no use."""
    if type(rows) is not list or len(rows) > FEW:
        return None
    form: Form = []
    total = 0.0
    try:
        for row in rows:
            a, b, value = row
            if type(value) not in NUMBERS or type(row) not in ROWS:
                return None
            i = places[a, b]
            values[i] += value
            total += value
            form += a, b, i
    except (KeyError, TypeError, ValueError, OverflowError):
        return None
    return form if isfinite(total) else None


def load_user_signal(deck: Deck, statement: Statement, numbering: Numbering) -> UserSignal:
    function, name = load_function(deck, statement), str(statement.values[0])
    le, lnp = numbering.e_places[1:].copy(), numbering.x_places[1:].copy()
    along = isinstance(deck.mode, int) and find_mode(deck.mode).takes_setpoints
    return UserLaw(function, name, numbering, le, lnp, along, function.breaks)


@dataclass(frozen=True)
class UserLaw:
    """USERSIG as a function (t, e, ed, x, xd) -> UserForces."""

    function: Callable[..., Any]
    name: str
    numbering: Numbering
    le: Index
    lnp: Index
    prescribed_act: bool  # along set-points the prescribed deformations are the degrees of freedom
    breaks: tuple[float, ...] = ()
    # places of the stresses that act and of the forces, by the two numbers of a row, as they were looked up
    stresses: dict[tuple[Any, Any], int] = field(default_factory=dict, repr=False, compare=False)
    forces: dict[tuple[Any, Any], int] = field(default_factory=dict, repr=False, compare=False)

    def __call__(self, t: float, e: Array, ed: Array, x: Array, xd: Array) -> UserForces:
        n = self.numbering
        given = self._given(placed(e, "e"), placed(ed, "ep"), placed(x, "x"), placed(xd, "xp"))
        sig, f = call(self._function, self.name, t, *given)
        (sigma, k_e, d_e), (force, k_x, d_x) = np.zeros((3, n.ne)), np.zeros((3, n.nx))
        _, found, lost = self.answer(t, sig, f, sigma, force)
        for rows, (k, d) in zip(found, ((k_e, d_e), (k_x, d_x)), strict=False):
            for i, row in rows:
                k[i] += row[3]
                d[i] += row[4]
        return UserForces(sigma, force, k_e, d_e, k_x, d_x, lost)

    def answer(
        self, t: float, sig: Any, f: Any, sigma: Array, force: Array
    ) -> tuple[tuple[Form, Form] | None, Sequence[Rows], dict[int, str]]:
        """Write sig and f into sigma and force, which are zero: `_taken` of both, or None and all their rows; the
        sentences of `UserForces.lost`."""
        found, lost = list[Rows](), dict[int, str]()
        for places_known in (False, True):
            of_sig = _taken(sig, self.stresses, sigma)
            of_f = None if of_sig is None else _taken(f, self.forces, force)
            if of_sig is not None and of_f is not None:
                return (of_sig, of_f), (), {}
            sigma[:] = force[:] = 0.0  # a part may have been written
            if not places_known:
                *found, lost = self._rows(t, sig, f)
        for rows, values in zip(found, (sigma, force), strict=True):
            for i, row in rows:
                values[i] += row[2]
        return None, found, lost

    def answering(self, arguments: tuple[PlacedVector, ...], sigma: Array, force: Array) -> "Answering":
        """What asks the function at the guarded vectors e, ed, x, xd and writes what it returns into sigma and force,
        which are zero then."""
        return Answering(self, arguments, sigma, force)

    def anew(self) -> "UserLaw":
        """The same for another case: a function that remembers something remembers it for each. Raises InputError."""
        return _anew(self)  # places that were looked up are those of all

    @property
    def _function(self) -> Callable[..., Any]:
        return self.function.function if isinstance(self.function, Loaded) else self.function

    def _given(self, e: PlacedVector, ed: PlacedVector, x: PlacedVector, xd: PlacedVector) -> tuple[Any, ...]:
        """What the function is called with, behind the time."""
        return self.numbering.ne, self.le, e, ed, self.numbering.nx, self.lnp, x, xd

    def _rows(self, t: float, sig: Any, f: Any) -> tuple[Rows, Rows, dict[int, str]]:
        """Rows of sig and f with their places in e and x, checked, and the sentences of `UserForces.lost`."""
        n = self.numbering
        stresses, forces = self._found("sig", sig, t), self._found("f", f, t)
        lost, fixed, inputs = {}, n.e_class["fixed"].stop, n.e_class["input"].stop
        first = fixed if self.prescribed_act else inputs  # row of e on which a stress can act
        for i, row in stresses:
            if i >= first:
                self.stresses[row[0], row[1]] = i
            elif any(row[2:]):
                lost[i] = (
                    f"warning: {self.name} at t = {t:.9g}: the stress of {n.e_name(i)} has no effect: the deformation"
                    f" is {'fixed' if i < fixed else 'prescribed'}, so that its stress follows from equilibrium alone;"
                    " a stress law needs DYNE or RLSE"
                )
        self.forces.update({(row[0], row[1]): i for i, row in forces})
        return stresses, forces, lost

    def _found(self, what: str, rows: Any, t: float) -> Rows:
        n, found = self.numbering, Rows()
        known, find = (self.stresses, n.e_index) if what == "sig" else (self.forces, n.x_index)
        for k, row in enumerate(read_rows(self.name, what, rows, (3, 5), t)):
            place = known.get((row[0], row[1]))
            try:
                found.append((find(*whole(row)) if place is None else place, row))
            except KeyError:
                raise _unknown(self.name, what, k, row, "does not exist", t) from None
        return found


class Answering:
    """The answers of a law for the engine, at vectors that change: written into sigma (ne,) and force (nx,).

    function, arguments   what is called with the time and with these
    forms            `_taken` of the last answer
    """

    def __init__(self, law: UserLaw, arguments: tuple[PlacedVector, ...], sigma: Array, force: Array) -> None:
        self.law, self.function, self.arguments = law, law._function, law._given(*arguments)
        self.values = sigma, force
        self.forms: tuple[Form, Form] | None = None

    def __call__(self, t: float) -> dict[int, str]:
        """Write the answer at a time where zeros are. Returns the sentences of `UserForces.lost`."""
        try:
            given = self.function(t, *self.arguments)
        except BY_USERS as error:  # a user's function may fail in any way
            raise self.failed(t, error) from error
        return self.read(t, given)

    def failed(self, t: float, error: BaseException) -> AnalysisError:
        """What is raised when the function raises something."""
        return _failed(self.law.name, t, error)

    def read(self, t: float, given: Any) -> dict[int, str]:
        """The same with what the function gave. Some values may have been written."""
        try:
            _, sig, f = given
        except BY_USERS as error:
            raise self.failed(t, error) from error
        if self.forms is None:
            for values in self.values:
                values[:] = 0.0
        for form, values in zip(self.forms or (), self.values, strict=False):
            for i in form[2::3]:
                values[i] = 0.0
        self.forms, _, lost = self.law.answer(t, sig, f, *self.values)
        return lost


Law = TypeVar("Law", UserLaw, "UserDrive")


def _anew(law: Law) -> Law:
    """The same with its function loaded once more, where it came from a file."""
    if not isinstance(law.function, Loaded):
        return law
    function = law.function.anew()
    return replace(law, function=function, breaks=function.breaks)


class DividedInputs(NamedTuple):
    """Prescribed deformations of a beam that is divided: the places of those of its first part (modes,), which has its
    number, and of all parts (k,); `shares` (k, modes): those of the parts for each one of the beam."""

    first: list[int]
    every: list[int]
    shares: Array

    def spread(self, e: Array, before: Array, named: set[int]) -> None:
        """e (3, inputs) has what is said of the beam at the places `named` of its first part: divide it among all, with
        the modes that are not named as they were `before`."""
        given = [i in named for i in self.first]
        if not any(given):
            return
        whole = np.linalg.lstsq(self.shares, before[:, self.every].T, rcond=None)[0]
        whole[given] = e[:, self.first].T[given]
        e[:, self.every] = (self.shares @ whole).T


def divided_inputs(deck: Deck, numbering: Numbering) -> tuple[DividedInputs, ...]:
    """Of all divided beams that are driven."""
    inputs, found = numbering.e_class["input"], []
    for beam, parts in deck.divided.items():
        at = numbering.e_places[list(parts)]
        modes = np.flatnonzero((at[0] >= inputs.start) & (at[0] < inputs.stop))
        if len(modes):
            n, numbers = len(parts), (modes + 1).tolist()
            units = [split_motion(numbering.keyword[beam], {m: (1.0,)}, 1, n) for m in numbers]
            shares = np.array([[u.get(m, [(0.0,)] * n)[i][0] for u in units] for m in numbers for i in range(n)])
            places = at[:, modes].T - inputs.start
            found.append(DividedInputs(places[:, 0].tolist(), places.ravel().tolist(), shares))
    return tuple(found)


@dataclass(frozen=True)
class UserDrive:
    """Prescribed motion from a user function; inputs that it does not mention follow `base`. What it says of a beam
    that is divided in the run is divided as INPUTE is."""

    function: Callable[..., Any]
    name: str
    numbering: Numbering
    base: Polynomial
    interval: float  # output step [s], turns the time into a step number
    breaks: tuple[float, ...] = ()
    divided: tuple[DividedInputs, ...] = ()

    @classmethod
    def load(
        cls, deck: Deck, statement: Statement, numbering: Numbering, base: Polynomial, interval: float
    ) -> "UserDrive":
        function = load_function(deck, statement)
        divided = divided_inputs(deck, numbering)
        return cls(function, str(statement.values[0]), numbering, base, interval, function.breaks, divided)

    def anew(self, base: Polynomial) -> "UserDrive":
        """The same for another case, see `UserLaw.anew`. Raises InputError."""
        return _anew(replace(self, base=base))

    def at(self, t: float) -> DriveState:
        e_rows, x_rows = call(self.function, self.name, t, round(t / self.interval))
        base = self.base.at(t)
        x, e = np.array(base[:3]), np.array(base[3:])
        self._fill(x, "x", x_rows, t)
        before = e.copy() if self.divided else e
        named = self._fill(e, "e", e_rows, t)
        for beam in self.divided:
            beam.spread(e, before, named)
        return DriveState(*x, *e)

    def _fill(self, target: Array, what: str, rows: Any, t: float) -> set[int]:
        """Write the rows into target (3, inputs); the places that they name."""
        n, named = self.numbering, set()
        find, of, noun = (n.x_index, n.x_class, "coordinate") if what == "x" else (n.e_index, n.e_class, "deformation")
        for k, row in enumerate(read_rows(self.name, what, rows, (5,), t)):
            try:
                i = find(*whole(row)) - of["input"].start
            except KeyError:
                i = -1
            if not 0 <= i < target.shape[1]:
                raise _unknown(self.name, what, k, row, f"is no input {noun}", t)
            target[:, i] = row[2:5]
            named.add(i)
        return named
