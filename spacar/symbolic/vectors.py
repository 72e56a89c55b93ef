"""Vectors and dyads as linear combinations of keys; dot, cross and outer product are bilinear.

Operators as in `sympy.physics.vector`: `a & b` dot, `a ^ b` cross, `a | b` outer (dyad), order respected:

    (ab)·c = a (b·c),   c·(ab) = (c·a) b,   (ab)×c = a (b×c),   c×(ab) = (c×a) b,   (ab)·(cd) = (b·c) ad

Source: the paper, tables 1 to 5; `symbolic.md`, section 2.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import sympy as sp

from spacar.symbolic.printing import latex, text
from spacar.symbolic.unit_vectors import Key, Unit, cross_keys, dot_keys


def _scalar(value: Any) -> sp.Expr:
    if isinstance(value, (Vector, Dyad)):
        raise TypeError("product of vectors: use dot (&), cross (^) or outer (|), not *")
    return sp.sympify(value)


def _order(key: Key | tuple[Key, Key]) -> Any:
    return tuple(k.sort_key for k in key) if isinstance(key, tuple) else key.sort_key


class _Combination:
    """What vectors and dyads share: an ordered mapping from keys to SymPy scalars without zeros."""

    terms: dict[Any, sp.Expr]

    def __init__(self, terms: Mapping[Any, Any] | None = None) -> None:
        pairs = sorted((terms or {}).items(), key=lambda item: _order(item[0]))
        self.terms = {key: c for key, value in pairs if (c := _scalar(value)) != 0}

    @classmethod
    def collect(cls, pairs: Iterable[tuple[Any, Any]]) -> Any:
        """The sum of (key, scalar) pairs; equal keys are added."""
        parts: dict[Any, list[sp.Expr]] = {}
        for key, value in pairs:
            parts.setdefault(key, []).append(value)
        return cls({key: sp.Add(*values) for key, values in parts.items()})

    def map(self, function: Callable[[sp.Expr], sp.Expr]) -> Any:
        """The same keys with `function` applied to every scalar."""
        return type(self)({key: function(c) for key, c in self.terms.items()})

    def xreplace(self, rule: Mapping[Any, Any]) -> Any:
        return self.map(lambda c: c.xreplace(rule))

    def __add__(self, other: Any) -> Any:
        if other == 0 and not isinstance(other, _Combination):
            return self
        if type(other) is not type(self):
            raise TypeError(f"cannot add a {type(self).__name__.lower()} and {other!r}")
        return self.collect([*self.terms.items(), *other.terms.items()])

    __radd__ = __add__

    def __neg__(self) -> Any:
        return self.map(lambda c: -c)

    def __sub__(self, other: Any) -> Any:
        return self + (-other)

    def __rsub__(self, other: Any) -> Any:
        return -self + other

    def __mul__(self, factor: Any) -> Any:
        factor = _scalar(factor)
        return self.map(lambda c: factor * c)

    __rmul__ = __mul__

    def __truediv__(self, divisor: Any) -> Any:
        return self * (1 / _scalar(divisor))

    def __eq__(self, other: object) -> bool:
        if isinstance(other, _Combination):
            return type(self) is type(other) and self.terms == other.terms
        return other == 0 and not self.terms

    def __hash__(self) -> int:
        return hash(tuple(self.terms.items()))

    def __bool__(self) -> bool:
        return bool(self.terms)

    def __and__(self, other: Any) -> Any:
        return dot(self, other)

    def __xor__(self, other: Any) -> Any:
        return cross(self, other)

    def count_ops(self) -> int:
        return sum(int(sp.count_ops(c)) for c in self.terms.values())

    def atoms(self, *types: type) -> set[sp.Basic]:
        return set().union(*(c.atoms(*types) for c in self.terms.values()))

    def __str__(self) -> str:
        return text(self)

    __repr__ = __str__

    def _repr_latex_(self) -> str:
        return f"${latex(self)}$"


class Vector(_Combination):
    """A vector: unit vectors and held cross products of any frames with scalar coefficients.

    >>> x, y = sp.symbols("x y")
    >>> from spacar.symbolic.reference_frames import ReferenceFrame
    >>> N, B = ReferenceFrame("N"), ReferenceFrame("B")
    >>> v = x * N[1] + y * B[2]
    >>> print(v)
    x n1 + y b2
    >>> print(v ^ N[2], "|", v & B[2])
    x n3 - y n2 >< b2 | x*n1.b2 + y
    """

    terms: dict[Key, sp.Expr]

    def __or__(self, other: Vector) -> Dyad:
        return outer(self, other)

    def coefficient(self, unit: Vector) -> sp.Expr:
        """The measure number of a unit vector or held cross product given as a vector (`v.coefficient(B[1])`)."""
        ((key, sign),) = unit.terms.items()
        return self.terms.get(key, sp.S.Zero) / sign

    def frames(self) -> set[Any]:
        return {u.frame for key in self.terms for u in ((key,) if isinstance(key, Unit) else (key.a, key.b))}


class Dyad(_Combination):
    """A sum of ordered pairs of keys.

    >>> from spacar.symbolic.reference_frames import ReferenceFrame
    >>> N, B = ReferenceFrame("N", "n"), ReferenceFrame("B", "b")
    >>> print((B[1] | N[1]) ^ B[1])
    b1 (n1 >< b1)
    """

    terms: dict[tuple[Key, Key], sp.Expr]


def outer(a: Vector, b: Vector) -> Dyad:
    """The dyad ab. TypeError unless both are vectors."""
    if not (isinstance(a, Vector) and isinstance(b, Vector)):
        raise TypeError("outer product needs two vectors")
    return Dyad.collect(((p, q), c * d) for p, c in a.terms.items() for q, d in b.terms.items())


def dot(a: Any, b: Any) -> Any:
    """a·b of vectors and dyads in this order: a scalar, a vector (one dyad) or a dyad (two)."""
    if isinstance(a, Vector) and isinstance(b, Vector):
        return sp.Add(*(c * d * dot_keys(p, q) for p, c in a.terms.items() for q, d in b.terms.items()))
    if isinstance(a, Dyad) and isinstance(b, Vector):
        return Vector.collect((p, c * (Vector({q: 1}) & b)) for (p, q), c in a.terms.items())
    if isinstance(a, Vector) and isinstance(b, Dyad):
        return Vector.collect((q, c * (a & Vector({p: 1}))) for (p, q), c in b.terms.items())
    if isinstance(a, Dyad) and isinstance(b, Dyad):
        return Dyad.collect(
            ((p, s), c * d * dot_keys(q, r)) for (p, q), c in a.terms.items() for (r, s), d in b.terms.items()
        )
    raise TypeError(f"dot product of {a!r} and {b!r}: both must be vectors or dyads")


def cross(a: Any, b: Any) -> Any:
    """a×b of two vectors (a vector), or of a vector and a dyad in either order (a dyad)."""
    if isinstance(a, Vector) and isinstance(b, Vector):
        return Vector.collect(
            (key, c * d * e) for p, c in a.terms.items() for q, d in b.terms.items() for e, key in cross_keys(p, q)
        )
    if isinstance(a, Dyad) and isinstance(b, Vector):
        return Dyad.collect(
            ((p, key), c * d) for (p, q), c in a.terms.items() for key, d in cross(Vector({q: 1}), b).terms.items()
        )
    if isinstance(a, Vector) and isinstance(b, Dyad):
        return Dyad.collect(
            ((key, q), c * d) for (p, q), c in b.terms.items() for key, d in cross(a, Vector({p: 1})).terms.items()
        )
    raise TypeError(f"cross product of {a!r} and {b!r}: two vectors, or a vector and a dyad")


ZERO = Vector()
