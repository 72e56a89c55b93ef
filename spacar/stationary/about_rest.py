"""What the linearized equations about a small equilibrium at rest consist of, in one call of C (compiled/linearized.c).

The counterpart of `spacar.linearization.coefficients`, of the velocity transfer and of the bound of the condition
number, for what `Equilibrium` takes; `spacar.linearization.matrices` makes the reduced equations of it. Dense, up to
the size to which all matrices of a linearization are; zeros in the factors are passed over.
"""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from functools import partial

import numpy as np

from spacar.arrays import Array
from spacar.dynamics.array_evaluator import Dynamics
from spacar.kinematics.constraint_condition import Conditioning, of_entries
from spacar.linear_systems.matrix import DENSE_LIMIT, matrix, zero_matrix
from spacar.linearization.coefficients import Coefficients
from spacar.linearization.contractions import mass_matrix
from spacar.linearization.matrices import Linearization, reduced
from spacar.stationary.equilibrium import DOUBLES, NUMBER, WHOLE, Equilibrium


class CLinearized(ctypes.Structure):
    """`Linearized` of linearized.c."""

    _fields_ = [
        *((name, DOUBLES) for name in ("row", "column", "W", "We", "V", "geometric", "gravity", "sigma")),
        *((name, WHOLE) for name in ("n", "first", "q_x", "n_q_x", "q_e", "n_q_e")),
        ("bound", NUMBER), ("terms", NUMBER),
    ]  # fmt: skip


@dataclass(frozen=True)
class AboutRest:
    """W (nx, ndof), We (ne, ndof), V (ne, nx), the geometric stiffness and the gradient of gravity (nx, nx) and the
    stresses (ne,) of a state at rest; `bound` of the condition number; `terms` of the geometric stiffness."""

    dynamics: Dynamics
    W: Array
    We: Array
    V: Array
    geometric: Array
    gravity: Array
    sigma: Array
    bound: float
    terms: float

    @classmethod
    def of(cls, equations: Equilibrium, d: Dynamics, x: Array, sigma: Array) -> AboutRest | None:
        """At x (nx,) with the stresses sigma (ne,), at the loads of the equations. None: for NumPy."""
        from spacar.compiled.library import address_of

        n, m = d.numbering, d.mechanism
        U = n.velocity_unknowns
        if n.nk or max(n.nx, n.ne) > DENSE_LIMIT:
            return None
        xs, es = n.x_class, n.e_class
        W, We, V = np.zeros((n.nx, n.ndof)), np.zeros((n.ne, n.ndof)), np.zeros((n.ne, n.nx))
        geometric, stresses, column = np.zeros((n.nx, n.nx)), sigma.copy(), m.scale[U]
        gravity = np.zeros((n.nx, n.nx)) if equations.heavy else None
        c = CLinearized(
            *map(address_of, (m.deformation_scale, column, W, We, V, geometric)),
            None if gravity is None else address_of(gravity), address_of(stresses),
        )  # fmt: skip
        c.n, c.first = len(U), xs["calculable"].start
        c.q_x, c.n_q_x, c.q_e, c.n_q_e = xs["input"].start, len(n.q_x), es["input"].start, len(n.q_e)
        if not equations.linearize(x, sigma, c):
            return None
        gravity = zero_matrix((n.nx, n.nx)) if gravity is None else gravity
        return cls(d, W, We, V, geometric, gravity, stresses, c.bound, c.terms)

    @property
    def condition(self) -> Conditioning:
        """Of the choice of the degrees of freedom."""
        s = self.dynamics.sweep
        entries = s.v_rows, s.v_columns, s.v_entries.copy()
        return Conditioning(self.bound, partial(of_entries, self.dynamics.mechanism, *entries))

    def linearization(self) -> Linearization:
        """The linearized equations, while the sweep of `dynamics` is at this state, with its mass matrices."""
        d = self.dynamics
        n, sweep, law = d.numbering, d.sweep, d.law
        by_rates, by_x = zero_matrix((n.ne, n.nx)), zero_matrix((n.nx, n.nx))
        S, Sd, Me = (matrix(*entries, (n.ne, n.ne))
                     for entries in (law.stiffness, law.damping, d.mechanism.deformation_inertia))  # fmt: skip
        c = Coefficients(
            V=self.V, M=mass_matrix(sweep), rate_x=by_rates, second_v=by_rates, second_x=by_rates, inertia_x=by_x,
            inertia_v=by_x, geometric=self.geometric, gravity_x=self.gravity, user_x=by_x, user_v=by_x, S=S, Sd=Sd,
            deformation_inertia=Me, sigma=self.sigma, moving=False,
        )  # fmt: skip
        return reduced(d, c, self.W, self.We, self.W, self.terms)
