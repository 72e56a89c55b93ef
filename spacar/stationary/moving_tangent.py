"""The tangent of the mixed equations with everything in it: motion, slips, user functions.

With the changes dv, da of the rates and accelerations of steady motion that follow a change dx,

    V_E dv + H1(v) dx = 0,    V_E da + (H1(v) + H2(v)) dv + [H1(a) + T(v)] dx = 0      (1)

(rows E fixed, prescribed and dynamic, unknowns of U) the rows of the matrix are

    [d(M a + h - f)/dx + Hs(sigma)] dx + h_v dv + M da + V^T dsigma          rows of the coordinates F
    V dx + C dsigma_1 - C dsigma                                             rows with stiffness, C dsigma_1 without

with dsigma_1 = S_d d(ed) + M_e d(edd) and what the user function adds. Of a small model dv and da are eliminated, of a
larger one (1) stands beside the rows, with dv/w, da/w^2 as unknowns and w the typical rate, in sparse storage. The
determinant of (1) by dv, da is that of V_E squared, so that both forms have the same sign.

ITERSTEP types 1 and 3 leave out what comes from motion (N0): the iteration then converges linearly.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from spacar.arrays import EPS, Array
from spacar.kinematics.kinematics import largest
from spacar.linear_systems import LinearSystem, assemble
from spacar.linear_systems.linear_system import (
    DENSE_LIMIT,
    DenseSystem,
    Matrix,
    dense,
    diagonal_matrix,
    matrix,
    zero_matrix,
)
from spacar.linearization.coefficients import (
    geometric_stiffness,
    gradient_matrix,
    inertia_blocks,
    load_gradient,
    mass_matrix,
    rate_gradients,
    scatter,
)
from spacar.linearization.user_derivatives import UserDerivatives
from spacar.stationary.stationary_equations import Iterate, StationaryEquations


class MovingTangent:
    """Tangent of one evaluator; `factor` at the point where the sweep is, then `solve`."""

    symmetric = False

    def __init__(self, equations: StationaryEquations, without_n0: bool) -> None:
        self.q, self.exact = equations, not without_n0
        n = equations.d.numbering
        self._small = max(n.nx, n.ne) <= DENSE_LIMIT
        self.user: UserDerivatives | None = None  # at the point where it was factored
        self._square = np.zeros((0, 0))  # of a small model
        self._extended: Any = None  # of a larger one
        self._system: LinearSystem | None = None
        self._places: tuple[Any, Any] = np.zeros(0), np.zeros(0)

    @property
    def system(self) -> LinearSystem:
        """The factors: x_F first."""
        assert self._system is not None
        return self._system

    def factor(self, point: Iterate) -> None:
        """Form and factor the matrix. Raises SingularMatrixError when the velocities are not determined."""
        self._form(point)
        if self._small:
            self._square = A = self.dense()
            self._system = self._system or DenseSystem(len(A), *np.indices(A.shape).reshape(2, -1))
            self._system.factor(A.ravel())
            return
        self._extended = A = self._assembled().tocoo()
        if self._system is None or not all(map(np.array_equal, self._places, (A.row, A.col))):
            self._places = A.row, A.col
            self._system = assemble(A.shape[0], A.row.astype(np.int64), A.col.astype(np.int64))
        self._system.factor(A.data)

    def _form(self, point: Iterate) -> None:
        """Factors of dx, dv, da: in the equilibrium, in the law; in the rates of the deformations."""
        q = self.q
        d, sweep, C = q.d, q.d.sweep, q.flexibility
        nx, ne, motion = d.numbering.nx, q.ne, point.motion if self.exact else None
        nothing, none = zero_matrix((nx, nx)), zero_matrix((ne, nx))
        self.V, self.H1, self.second_v, self.second_x = gradient_matrix(sweep), none, none, none
        self.K, self.K_v, self.K_a = geometric_stiffness(sweep, point.sigma) + load_gradient(d), nothing, nothing
        law_x, law_v, law_a = none, none, none
        self.user = None if point.user is None else q.user_derivatives(point)
        self.w, self._moves = 1.0, motion is not None
        if self.exact:
            v, a = (q.rest, q.rest) if motion is None else (motion.v, motion.a)
            by_x, by_v = inertia_blocks(sweep, v, a)
            self.K = self.K + scatter(nx, by_x)
        if motion is not None:
            self.w = max(largest(motion.v / q.scale), 1e-100)
            self.H1, self.second_v, self.second_x = rate_gradients(sweep, motion.v, motion.a)
            self.K_v, self.K_a = scatter(nx, by_v), mass_matrix(sweep)
            Sd, Me = (matrix(*entries, (ne, ne)) for entries in (d.law.damping, d.mechanism.deformation_inertia))
            law_x, law_v = Sd @ self.H1 + Me @ self.second_x, Sd @ self.V + Me @ self.second_v
            law_a = Me @ self.V
        if self.user is not None:
            of = self.user.of
            self.K = self.K - of("f", "x") - of("f", "e") @ self.V - of("f", "ed") @ self.H1
            law_x = law_x + of("sigma", "x") + of("sigma", "e") @ self.V + of("sigma", "ed") @ self.H1
            if motion is not None:
                self.K_v = self.K_v - of("f", "xd") - of("f", "ed") @ self.V
                law_v = law_v + of("sigma", "xd") + of("sigma", "ed") @ self.V
        kept = np.ones(ne)
        kept[q.slips] = 0.0
        self.C = diagonal_matrix(kept) @ matrix(*C.entries, (ne, ne))
        loose = self.C @ diagonal_matrix(q.loose / C.size)
        self.R = diagonal_matrix(kept * C.coupled) @ self.V + loose @ law_x
        self.R_v, self.R_a = loose @ law_v, loose @ law_a
        nk, one = len(q.x_kinematic), np.ones(len(q.slips))
        if len(one):
            self.R = self.R + matrix(q.slips[:nk], q.x_kinematic, one[:nk], (ne, nx))
            self.R = self.R + matrix(q.slips[nk:], q.e_kinematic, one[nk:], (ne, ne)) @ self.V

    def _assembled(self) -> Any:
        """The extended matrix."""
        from scipy.sparse import bmat, csr_array

        q, w = self.q, self.w
        k, size, F = q.d.kinematics, q.flexibility.size, q.F
        E, U = k.E, k.U

        def part(A: Matrix, factor: float, rows: Any, columns: Any) -> Any:
            return csr_array(factor * A)[rows][:, columns]

        every = np.arange(q.ne)
        blocks = [
            [part(self.K, 1.0, F, F), size * csr_array(self.V.T)[F]],
            [part(self.R, size, every, F), -size * csr_array(self.C)],
        ]
        if not self._moves:
            return bmat(blocks)
        blocks[0] += [part(self.K_v, w, F, U), part(self.K_a, w * w, F, U)]
        blocks[1] += [part(self.R_v, size * w, every, U), part(self.R_a, size * w * w, every, U)]
        V = part(self.V, size, E, U)
        blocks.append([part(self.H1, size / w, E, F), None, V, None])
        blocks.append([part(self.second_x, size / w**2, E, F), None, part(self.second_v, size / w, E, U), V])
        return bmat(blocks)

    def solve(self, right: Array) -> Array:
        """Solution for right-hand sides (n,) or (n, k). Raises SingularMatrixError."""
        n, system = len(right), self.system
        b = np.zeros((system.n, *right.shape[1:]))
        b[:n] = right
        return system.solve(b)[:n]

    def along(self, dx: Array) -> Array:
        """The matrix times a change dx (nx,) or (nx, k) of coordinates, (n,) or (n, k)."""
        q = self.q
        dv, da = self._following(dx)
        force = self.K @ dx + self.K_v @ dv + self.K_a @ da
        gap = self.R @ dx + self.R_v @ dv + self.R_a @ da
        return np.concatenate((force[q.F], q.flexibility.size * gap))

    def _following(self, dx: Array) -> tuple[Array, Array]:
        """dv, da of (1) for dx (nx,) or (nx, k)."""
        dependent, still = self.q.d.kinematics.dependent, np.zeros_like(dx)
        if not self._moves:
            return still, still
        dv = dependent(still, -(self.H1 @ dx))
        return dv, dependent(still, -(self.second_x @ dx + self.second_v @ dv))

    def dense(self) -> Array:
        """The matrix, (n, n)."""
        q = self.q
        unit = np.zeros((q.d.numbering.nx, q.nf))
        unit[q.F, np.arange(q.nf)] = 1.0
        stresses = np.concatenate((dense(self.V).T[q.F], -dense(self.C)))
        return np.hstack((self.along(unit), q.flexibility.size * stresses))

    def rounding(self, z: Array) -> Array:
        """eps |matrix| |z|, (n,)."""
        if self._small:
            return np.asarray(EPS * (np.abs(self._square) @ np.abs(z)))
        dx, U = np.zeros(self.q.d.numbering.nx), self.q.d.kinematics.U
        dx[self.q.F] = z[: self.q.nf]
        dv, da = self._following(dx)
        every = np.concatenate((z, dv[U] / self.w, da[U] / self.w**2))[: self.system.n]
        return np.asarray(EPS * (abs(self._extended) @ np.abs(every))[: len(z)])

    def sign(self) -> float:
        """Sign of the determinant of the tangent stiffness."""
        # The mixed matrix has one negative eigenvalue more for every stress.
        return self.system.determinant_sign() * (-1.0) ** self.q.ne
