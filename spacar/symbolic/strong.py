"""The strong form of a field equation, for reading: what the assumed field solves approximately.

    EI u_xxxx + ρ a·b_i − f·b_i − 2γ u_xxt = 0,    u = u_x = 0 at x = 0,
    EI u_xx = E(s_slope),  −EI u_xxx + 2γ u_xt = E(s_u)  at x = L

E(s') is equation (A) for the pseudo-speed; partial integration of (B). Source: the paper, (13) to (20); `symbolic.md`,
section 3.3.
"""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from spacar.errors import UsageError
from spacar.symbolic.beam_shapes import X
from spacar.symbolic.derivation import DerivedEquations
from spacar.symbolic.derivatives import dvdt
from spacar.symbolic.system_parts import Beam
from spacar.symbolic.unit_vectors import TIME
from spacar.symbolic.vectors import dot


@dataclass(frozen=True)
class StrongForm:
    """`equation` = 0 along the beam; `essential` = 0 at x = 0; `natural` pairs (left, right), equal at x = L."""

    equation: sp.Expr
    essential: tuple[sp.Expr, ...]
    natural: tuple[tuple[sp.Expr, sp.Expr], ...]


def strong_form(eq: DerivedEquations, beam: Beam, name: str = "u") -> StrongForm:
    """Field equation of the bending field `name` in vector notation, with held boundary terms.

    Raises UsageError for recursive equations (they keep no vectors) and for fields that are not bending fields.
    """
    if not eq.held_by_speed:
        raise UsageError("the strong form needs equations in vector notation: derive(strategy='held')")
    found = next((f for f in beam.bending if f.name == name), None)
    if found is None:
        raise UsageError(f"beam {beam.name} has no bending field {name!r}")
    system, u, EI = eq.system, found.function, found.stiffness
    velocity = beam.root.velocity + dvdt(system.N, beam.offset).xreplace(system.rates)
    acceleration = dvdt(system.N, velocity).xreplace(system.rates)
    direction = beam.frame[found.direction]
    inertia = beam.mass * dot(acceleration - system.gravity, direction)
    damping = 2 * beam.damping
    equation = (EI * u.diff(X, 2)).diff(X, 2) + sp.expand(inertia) - damping * u.diff(X, 2, TIME)
    letters = f"{beam.name}_{name}"
    E = {str(s.func): e for s, e in eq.held_by_speed.items()}
    natural = (
        (EI * u.diff(X, 2), E[f"{letters}xt"]),
        (-(EI * u.diff(X, 2)).diff(X) + damping * u.diff(X, TIME), E[f"{letters}t"]),
    )
    return StrongForm(equation, (u, u.diff(X)), natural)
