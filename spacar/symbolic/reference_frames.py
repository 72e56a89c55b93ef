"""Frames: three unit vectors each, how they turn, their angular velocities; derivatives seen from them.

    ω(A,B) = −ω(B,A),   ω(A,C) = ω(A,B) + ω(B,C),   du/dt seen from A = ω(A,B) × u for u fixed in B
    DvDt(A, Σ c k) = Σ ċ k + c DvDt(A, k), product rule for crosses and dyads

Source: the paper, tables 4, 6, 7, 9, 10, 15; `symbolic.md`, section 2.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import count
from typing import Any, TypeVar

import sympy as sp
from sympy.core.function import AppliedUndef

from spacar.errors import UsageError
from spacar.symbolic.unit_vectors import TIME, Key, UnevaluatedCross, UnevaluatedDot, Unit
from spacar.symbolic.vectors import ZERO, Dyad, Vector, cross, dot, outer

Held = TypeVar("Held", sp.Expr, Vector, Dyad)
_serials: Iterator[int] = count()


@dataclass(frozen=True)
class Rotation:
    """A frame obtained by turning `parent` about its own axis `axis` (1, 2, 3) by `angle` [rad]."""

    parent: ReferenceFrame
    axis: int
    angle: sp.Expr


@dataclass(frozen=True)
class Attitude:
    """A frame whose direction cosines `matrix` (parent_i · frame_j) are given, not as a turn about an axis."""

    parent: ReferenceFrame
    matrix: sp.Matrix


class ReferenceFrame:
    """A set of three right-handed orthonormal unit vectors, `frame[1]`, `frame[2]`, `frame[3]`.

    `symbol` is the letter of the unit vectors in print; families of frames may use `b1`, `b2`, … as symbols.

    >>> N = ReferenceFrame("N", "n")
    >>> print(N[1] ^ N[2])
    n3
    """

    def __init__(self, name: str, symbol: str | None = None) -> None:
        self.name = name
        self.symbol = symbol or name.lower()
        self.serial = next(_serials)
        self.rotation: Rotation | None = None
        self.attitude: Attitude | None = None
        self.is_section = False  # the end section of a beam: turns on it are added to its own slope
        self.relative: dict[ReferenceFrame, Vector] = {}  # angular velocities of directly known neighbours
        self.directions = {i: (self.serial, i) for i in (1, 2, 3)}

    def __getitem__(self, i: int) -> Vector:
        return Vector({self.unit(i): sp.S.One})

    def unit(self, i: int) -> Unit:
        """The key of unit vector `i`; ValueError unless i is 1, 2 or 3."""
        if i not in (1, 2, 3):
            raise ValueError(f"frame {self.name} has unit vectors 1, 2 and 3, not {i!r}")
        return Unit(self, i)

    def turned(self, name: str, axis: int, angle: Any, symbol: str | None = None) -> ReferenceFrame:
        """A new frame turned about `self[axis]` by `angle`, with its angular velocity and the shared axis.

        >>> from sympy.physics.vector import dynamicsymbols
        >>> q = dynamicsymbols("q")
        >>> N = ReferenceFrame("N"); B = N.turned("B", 3, q)
        >>> print(N[3] & B[3], N[3] & B[1], N[1] & B[1])
        1 0 n1.b1
        """
        frame = ReferenceFrame(name, symbol)
        angle = sp.sympify(angle)
        frame.rotation = Rotation(self, axis, angle)
        frame.directions[axis] = self.directions[axis]
        set_omega(self, frame, frame[axis] * angle.diff(TIME))
        return frame

    @cached_property
    def chain(self) -> tuple[ReferenceFrame, ...]:
        """This frame and those that it was turned from."""
        turn = self.rotation or self.attitude
        return (self, *turn.parent.chain) if turn else (self,)

    @cached_property
    def turned_by(self) -> frozenset[sp.Expr]:
        """Coordinates and parameters of its turn."""
        turn = self.rotation.angle if self.rotation else self.attitude.matrix if self.attitude else sp.S.Zero
        found: set[sp.Expr] = turn.atoms(AppliedUndef, sp.Symbol)
        return frozenset(found - {TIME})

    def held_rate(self, atom: UnevaluatedDot) -> sp.Expr:
        """Time derivative of a held dot or triple product, seen from the frame of its last factor.

        d(a·b)/dt = (ω × a)·b with ω the angular velocity of a's frame relative to b's; every observer agrees.
        """
        first, *more, last = atom.units
        rate = _key_rate(last.frame, UnevaluatedCross(first, *more) if more else first)
        return dot(rate, Vector({last: 1}))

    def __repr__(self) -> str:
        return f"ReferenceFrame({self.name!r})"


def set_omega(base: ReferenceFrame, frame: ReferenceFrame, omega: Vector) -> Vector:
    """Define the angular velocity of `frame` relative to `base` (which may rotate itself); returns it.

    >>> s = sp.symbols("s1:4"); N, B = ReferenceFrame("N"), ReferenceFrame("B")
    >>> print(set_omega(N, B, s[0] * N[1] + s[1] * N[2] + s[2] * N[3]))
    s1 n1 + s2 n2 + s3 n3
    """
    base.relative[frame] = omega
    frame.relative[base] = -omega
    return omega


def omega(base: ReferenceFrame, frame: ReferenceFrame) -> Vector:
    """Angular velocity of `frame` relative to `base`, summed along the shortest chain of known pairs.

    Raises UsageError when no chain connects the two frames.
    """
    reached: dict[ReferenceFrame, Vector] = {base: ZERO}
    waiting = deque([base])
    while waiting:
        here = waiting.popleft()
        if here is frame:
            return reached[here]
        for neighbour, step in here.relative.items():
            if neighbour not in reached:
                reached[neighbour] = reached[here] + step
                waiting.append(neighbour)
    raise UsageError(f"no angular velocity is known between frames {base.name} and {frame.name}")


class Recurrence(sp.Symbol):
    """The symbol of a Z variable: a memory read, which time derivatives must not see (see `rate`)."""

    __slots__ = ()


def rate(expression: Any) -> sp.Expr:
    """Time derivative of a scalar, held dots included. TypeError for a Z variable: differentiate its definition."""
    expression = sp.sympify(expression)
    memory = expression.atoms(Recurrence)
    if memory:
        name = min(z.name for z in memory)
        raise TypeError(f"{name} is a memory read without time derivative: differentiate its definition")
    return expression.diff(TIME)


def dvdt(frame: ReferenceFrame, value: Held) -> Held:
    """Time derivative of a scalar, vector or dyad as seen from `frame` (DvDt of the paper, table 6).

    >>> from sympy.physics.vector import dynamicsymbols
    >>> q, L = dynamicsymbols("q"), sp.Symbol("L")
    >>> N = ReferenceFrame("N"); B = N.turned("B", 3, q)
    >>> print(dvdt(N, L * B[1]))
    L*q_dot b2
    """
    if isinstance(value, Vector):
        return sum((Vector({key: rate(c)}) + _key_rate(frame, key) * c for key, c in value.terms.items()), ZERO)
    if isinstance(value, Dyad):
        result = Dyad()
        for (p, q), c in value.terms.items():
            left, right = Vector({p: 1}), Vector({q: 1})
            result += outer(left, right) * rate(c)
            result += (outer(_key_rate(frame, p), right) + outer(left, _key_rate(frame, q))) * c
        return result
    return rate(value)


def _key_rate(frame: ReferenceFrame, key: Key) -> Vector:
    if isinstance(key, Unit):
        return ZERO if key.frame is frame else cross(omega(frame, key.frame), Vector({key: 1}))
    a, b = Vector({key.a: 1}), Vector({key.b: 1})
    return cross(_key_rate(frame, key.a), b) + cross(a, _key_rate(frame, key.b))


def partial_velocity(velocity: Held, speed: Any) -> Held:
    """Partial derivative of a velocity or angular velocity to a generalized speed (Pvel, table 15).

    >>> from sympy.physics.vector import dynamicsymbols
    >>> s = dynamicsymbols("s"); L = sp.Symbol("L"); N = ReferenceFrame("N")
    >>> print(partial_velocity(L * s * N[1] + s**2 * N[2], s))
    L n1 + 2*s n2
    """
    if isinstance(velocity, (Vector, Dyad)):
        return velocity.map(lambda c: c.diff(speed))
    return sp.sympify(velocity).diff(speed)
