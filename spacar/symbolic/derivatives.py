"""Time derivatives seen from a frame, partial velocities.

    DvDt(A, Σ c k) = Σ ċ k + c DvDt(A, k),   DvDt(A, u of B) = ω(A,B) × u,   product rule for crosses and dyads

Source: the paper, tables 6, 7, 9, 10, 15; `symbolic.md`, section 2.
"""

from typing import Any, TypeVar

import sympy as sp

from spacar.symbolic.reference_frames import ReferenceFrame, unit_rate
from spacar.symbolic.unit_vectors import TIME, Key, Unit
from spacar.symbolic.vectors import ZERO, Dyad, Vector, cross, outer

Held = TypeVar("Held", sp.Expr, Vector, Dyad)


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


def _key_rate(frame: ReferenceFrame, key: Key) -> Vector:
    if isinstance(key, Unit):
        return unit_rate(frame, key)
    a, b = Vector({key.a: 1}), Vector({key.b: 1})
    return cross(unit_rate(frame, key.a), b) + cross(a, unit_rate(frame, key.b))


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
