"""Angular velocities, time derivatives seen from a frame, partial velocities.

    DvDt(A, Σ c k) = Σ ċ k + c DvDt(A, k),   DvDt(A, u of B) = ω(A,B) × u,   product rule for crosses and dyads
    ω(A,B) = −ω(B,A),   ω(A,C) = ω(A,B) + ω(B,C)

Source: the paper, tables 4, 6, 7, 9, 10, 15; `symbolic.md`, section 2.
"""

from __future__ import annotations

from collections import deque
from typing import Any, TypeVar

import sympy as sp

from spacar.errors import UsageError
from spacar.symbolic.units import TIME, Frame, HeldScalar, Key, Unit, UnitDot
from spacar.symbolic.vectors import ZERO, Dyad, Vector, cross, dot, outer

Held = TypeVar("Held", sp.Expr, Vector, Dyad)


class Recurrence(sp.Symbol):
    """The symbol of a Z variable: a memory read, which time derivatives must not see (see `rate`)."""

    __slots__ = ()


def set_omega(base: Frame, frame: Frame, omega: Vector) -> Vector:
    """Define the angular velocity of `frame` relative to `base` (which may rotate itself); returns it.

    >>> s = sp.symbols("s1:4"); N, B = Frame("N"), Frame("B")
    >>> print(set_omega(N, B, s[0] * N[1] + s[1] * N[2] + s[2] * N[3]))
    s1 n1 + s2 n2 + s3 n3
    """
    base.relative[frame] = omega
    frame.relative[base] = -omega
    return omega


def omega(base: Frame, frame: Frame) -> Vector:
    """Angular velocity of `frame` relative to `base`, summed along the shortest chain of known pairs.

    Raises UsageError when no chain connects the two frames.
    """
    reached: dict[Frame, Vector] = {base: ZERO}
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


def rate(expression: Any) -> sp.Expr:
    """Time derivative of a scalar, held dots included. TypeError for a Z variable: differentiate its definition."""
    expression = sp.sympify(expression)
    memory = expression.atoms(Recurrence)
    if memory:
        name = min(z.name for z in memory)
        raise TypeError(f"{name} is a memory read without time derivative: differentiate its definition")
    return expression.diff(TIME)


def dvdt(frame: Frame, value: Held) -> Held:
    """Time derivative of a scalar, vector or dyad as seen from `frame` (DvDt of the paper, table 6).

    >>> from sympy.physics.vector import dynamicsymbols
    >>> q, L = dynamicsymbols("q"), sp.Symbol("L")
    >>> N = Frame("N"); B = N.turned("B", 3, q)
    >>> print(dvdt(N, L * B[1]))
    L*q_dot b2
    """
    if isinstance(value, Vector):
        parts = [Vector({key: rate(c)}) + _key_rate(frame, key) * c for key, c in value.terms.items()]
        return sum(parts, ZERO)
    if isinstance(value, Dyad):
        result = Dyad()
        for (p, q), c in value.terms.items():
            left, right = Vector({p: 1}), Vector({q: 1})
            result += outer(left, right) * rate(c)
            result += (outer(_key_rate(frame, p), right) + outer(left, _key_rate(frame, q))) * c
        return result
    return rate(value)


def _unit_rate(frame: Frame, u: Unit) -> Vector:
    return ZERO if u.frame is frame else cross(omega(frame, u.frame), Vector({u: 1}))


def _key_rate(frame: Frame, key: Key) -> Vector:
    if isinstance(key, Unit):
        return _unit_rate(frame, key)
    a, b = Vector({key.a: 1}), Vector({key.b: 1})
    return cross(_unit_rate(frame, key.a), b) + cross(a, _unit_rate(frame, key.b))


def held_rate(atom: HeldScalar) -> sp.Expr:
    """Time derivative of a held dot or triple product, seen from the frame of its last factor.

    d(a·b)/dt = (ω × a)·b with ω the angular velocity of a's frame relative to b's; every observer agrees.
    """
    *others, last = atom.units
    observer = last.frame
    vectors = [Vector({u: 1}) for u in others]
    rates = [_unit_rate(observer, u) for u in others]
    fixed = Vector({last: 1})
    if isinstance(atom, UnitDot):
        return dot(rates[0], fixed)
    return dot(cross(rates[0], vectors[1]) + cross(vectors[0], rates[1]), fixed)


def partial_velocity(velocity: Held, speed: Any) -> Held:
    """Partial derivative of a velocity or angular velocity to a generalized speed (Pvel, table 15).

    >>> from sympy.physics.vector import dynamicsymbols
    >>> s = dynamicsymbols("s"); L = sp.Symbol("L"); N = Frame("N")
    >>> print(partial_velocity(L * s * N[1] + s**2 * N[2], s))
    L n1 + 2*s n2
    """
    if isinstance(velocity, (Vector, Dyad)):
        return velocity.map(lambda c: c.diff(speed))
    return sp.sympify(velocity).diff(speed)
