"""Unit vectors of frames, and the scalars that appear when two frames meet.

A vector is a linear combination of *keys*. A key is a unit vector (`Unit`) or the held cross product of two
unit vectors of different frames (`UnevaluatedCross`). Products of keys follow from identities alone; no direction
cosine is ever needed (reference `symbolic.md`, section 2; a, b, c, d unit vectors of any frames):

    (a×b)·c = (c×a)·b = (b×c)·a          two factors of one frame: becomes a single dot
    (a×b)×c = b (a·c) − a (b·c)          so a held cross product is never nested
    (a×b)·(c×d) = (a·c)(b·d) − (a·d)(b·c)

What stays unevaluated is a scalar atom: `UnitDot` (two frames) or `UnitTriple` (three frames). Frames that turn
about a common axis share that unit vector, which is an identity and not a transformation.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import sympy as sp
from sympy.physics.vector import dynamicsymbols

from spacar.errors import UsageError

TIME = dynamicsymbols._t
"""The symbol of time, the one of `sympy.physics.vector`, so that coordinates q(t) may be shared with SymPy."""

Scalars = tuple[sp.Expr, ...]
ByExpression = dict[sp.Expr, sp.Expr]  # such as rates by coordinates, derivatives by speeds
Rule = dict[sp.Basic, sp.Expr]  # what replaces what
AccelerationSymbols = dict[sp.Expr, sp.Symbol]  # by speeds
Definitions = dict[sp.Symbol, sp.Expr]  # of Z variables and of steps of a program


@dataclass(frozen=True)
class Unit:
    """Unit vector `index` of `frame`: the first kind of key."""

    frame: Any  # a `ReferenceFrame`, which stands above; here only its serial, symbol and directions are read
    index: int

    @cached_property
    def order(self) -> tuple[int, int]:
        return self.frame.serial, self.index

    @property
    def sort_key(self) -> tuple[int, ...]:
        return (0, *self.order)

    def __str__(self) -> str:
        return f"{self.frame.symbol}{self.index}"


@dataclass(frozen=True)
class UnevaluatedCross:
    """a×b of unit vectors of two frames, the frame that was made first standing first: the second kind of key."""

    a: Unit
    b: Unit

    @property
    def sort_key(self) -> tuple[int, ...]:
        return (1, *self.a.order, *self.b.order)

    def __str__(self) -> str:
        return f"{self.a} >< {self.b}"


def unit_latex(u: Unit) -> str:
    head = re.fullmatch(r"(\D*)(.*)", u.frame.symbol)
    assert head is not None
    return rf"\hat{{{head[1]}}}_{{{head[2]}{u.index}}}"


Key = Unit | UnevaluatedCross
Terms = list[tuple[int, Key]]  # a few keys with signs: what a cross product of two units gives


CODE = ("code", "_glsl", "_julia", "_octave", "_maple", "_javascript")  # ends of the methods of SymPy's code printers


class UnevaluatedDot(sp.Expr):
    """A product of unit vectors of different frames, not evaluated; it knows its time derivative.

    Its arguments are what it depends on: the time, and the coordinates and parameters of the turns between its frames.
    SymPy may rebuild it from them. With others it would need its value, which only `transform` gives: such a
    substitution, a partial derivative and a pickle are refused with a UsageError. A copy is the product itself, as
    frames are compared by identity.
    """

    is_Atom = True
    is_commutative = True
    is_real = True
    is_number = False
    units: tuple[Unit, ...]
    form: str  # in text, with the units in the braces
    latex_form: str

    def __new__(cls, *units: Unit) -> UnevaluatedDot:
        atom = sp.Expr.__new__(cls, TIME, *_turned_by(units))
        atom.units = units
        return atom

    def func(self, *args: sp.Basic) -> UnevaluatedDot:
        """With these arguments, as SymPy asks for it."""
        if args == self.args:
            return self
        changed = ", ".join(str(old) for old, new in zip(self.args, args, strict=False) if old != new)
        raise self._without_value(f"be evaluated or differentiated for {changed}")

    def __copy__(self) -> UnevaluatedDot:
        return self

    def __deepcopy__(self, memo: dict[int, Any]) -> UnevaluatedDot:
        return self

    def __reduce_ex__(self, protocol: Any) -> Any:
        raise self._without_value("be pickled, as its frames belong to this process")

    def _without_value(self, what: str) -> UsageError:
        return UsageError(f"the product {self} of unit vectors of several frames cannot {what}: transform it first")

    def _hashable_content(self) -> tuple[Any, ...]:
        return tuple((u.frame.symbol, u.index, u.frame.serial) for u in self.units)

    def matches(self, expr: sp.Basic, repl_dict: Any = None, old: bool = False) -> Any:
        """SymPy compares arguments, which are the same for all products of two frames."""
        return (repl_dict or {}) if expr == self else None

    def __getattr__(self, name: str) -> Any:
        if name.endswith(CODE):
            raise self._without_value("become program text")
        raise AttributeError(name)

    def _eval_derivative(self, s: sp.Symbol) -> sp.Expr:
        if s == TIME:
            return self.units[-1].frame.held_rate(self)
        if s in self.args:
            raise self._without_value(f"be differentiated by {s}")
        return sp.S.Zero

    def _eval_derivative_n_times(self, s: sp.Symbol, n: Any) -> sp.Expr:
        result: sp.Expr = self
        for _ in range(int(n)):
            result = result.diff(s) if result is not self else self._eval_derivative(s)
        return result

    def _sympystr(self, printer: Any) -> str:
        return self.form.format(*self.units)

    def _latex(self, printer: Any, exp: str | None = None) -> str:
        return self.latex_form.format(*map(unit_latex, self.units)) + (f"^{{{exp}}}" if exp else "")


class UnitDot(UnevaluatedDot):
    """a·b of unit vectors of two frames."""

    form, latex_form = "{}.{}", r"({} \cdot {})"


class UnitTriple(UnevaluatedDot):
    """(a×b)·c of unit vectors of three frames."""

    form, latex_form = "[{} {} {}]", r"({} \times {} \cdot {})"


def _turned_by(units: tuple[Unit, ...]) -> list[sp.Expr]:
    """Coordinates and parameters of the turns between the frames of unit vectors."""
    chains = [u.frame.chain for u in units]
    apart = set().union(*chains).difference(set(chains[0]).intersection(*chains[1:]))
    found = set().union(*(frame.turned_by for frame in apart))
    return sorted(found, key=str)


def local_index(u: Unit, frame: Any) -> int | None:
    """The index under which `frame` knows the direction of `u` as one of its own, else None."""
    if u.frame is frame:
        return u.index
    direction = u.frame.directions[u.index]
    return next((i for i, d in frame.directions.items() if d == direction), None)


def dot_units(a: Unit, b: Unit) -> sp.Expr:
    """a·b: a number when one frame knows both directions, else the atom `UnitDot`."""
    for u, v in ((a, b), (b, a)):
        i = local_index(u, v.frame)
        if i is not None:
            return sp.Integer(int(i == v.index))
    return UnitDot(a, b) if a.order < b.order else UnitDot(b, a)


def cross_units(a: Unit, b: Unit) -> Terms:
    """a×b as signed keys: a unit vector when one frame knows both directions, else a held cross."""
    i = local_index(a, b.frame)
    if i is not None:
        return _cross_in_frame(b.frame, i, b.index)
    j = local_index(b, a.frame)
    if j is not None:
        return _cross_in_frame(a.frame, a.index, j)
    return [(1, UnevaluatedCross(a, b))] if a.order < b.order else [(-1, UnevaluatedCross(b, a))]


def _cross_in_frame(frame: Any, i: int, j: int) -> Terms:
    return [] if i == j else [((1 if (j - i) % 3 == 1 else -1), frame.unit(6 - i - j))]


def triple(a: Unit, b: Unit, c: Unit) -> sp.Expr:
    """(a×b)·c: a dot when two of the three directions belong to one frame, else the atom `UnitTriple`."""
    for u, v, w in ((a, b, c), (b, c, a), (c, a, b)):
        terms = cross_units(u, v)
        if all(isinstance(key, Unit) for _, key in terms):
            return sp.Add(*(sign * dot_units(key, w) for sign, key in terms if isinstance(key, Unit)))
    ordered = sorted((a, b, c), key=lambda u: u.order)
    swaps = sum(x.order > y.order for x, y in ((a, b), (a, c), (b, c)))
    return (-1) ** swaps * UnitTriple(*ordered)


def dot_keys(p: Key, q: Key) -> sp.Expr:
    """p·q of any two keys."""
    if isinstance(q, Unit):
        return dot_units(p, q) if isinstance(p, Unit) else triple(p.a, p.b, q)
    if isinstance(p, Unit):
        return triple(q.a, q.b, p)
    return dot_units(p.a, q.a) * dot_units(p.b, q.b) - dot_units(p.a, q.b) * dot_units(p.b, q.a)


def cross_keys(p: Key, q: Key) -> list[tuple[sp.Expr, Key]]:
    """p×q of any two keys as coefficients and keys, never nested."""
    if isinstance(p, UnevaluatedCross):
        return [(dot_keys(p.a, q), p.b), (-dot_keys(p.b, q), p.a)]
    if isinstance(q, UnevaluatedCross):
        return [(dot_keys(p, q.b), q.a), (-dot_keys(p, q.a), q.b)]
    return [(sp.Integer(sign), key) for sign, key in cross_units(p, q)]
