"""The tangent of the mixed equations with everything in it: motion, slips, user functions, as a dense matrix.

With v(x), a(x) of steady motion and their derivatives Z = dv/dx, Y = da/dx, for any change of x,

    V_E Z = -H1(v),    V_E Y = -[H1(a) + T(v) + (H1(v) + H2(v)) Z]     (rows E fixed, prescribed and dynamic)

the rows of the matrix are

    d(M a + h - f)/dx + Hs(sigma) + h_v Z + M Y    V^T          rows of the coordinates F
    V + C d(sigma_1)/dx                            -C           rows with stiffness, C d(sigma_1)/dx those without

ITERSTEP types 1 and 3 leave out what comes from motion (N0): the iteration then converges linearly.
"""

from __future__ import annotations

import numpy as np

from spacar.arrays import Array
from spacar.linear_systems import SingularMatrixError
from spacar.linear_systems.lost_digits import EPS
from spacar.linear_systems.matrix import dense
from spacar.linearization.coefficients import load_gradient
from spacar.linearization.contractions import (
    geometric_blocks,
    inertia_blocks,
    mass_matrix,
)
from spacar.linearization.user_derivatives import UserDerivatives
from spacar.stationary.rate_matrices import RateMatrices, SquareSum
from spacar.stationary.stationary_equations import Iterate, StationaryEquations


class MovingTangent:
    """Dense tangent of one evaluator; `factor` at the point where the sweep is, then `solve`."""

    symmetric = False

    def __init__(self, equations: StationaryEquations, without_n0: bool) -> None:
        self.q, self.exact = equations, not without_n0
        self.full = np.zeros((0, 0))  # all columns x, then sigma / size
        self.user: UserDerivatives | None = None  # at the point where it was factored
        self.rates = RateMatrices(equations.d.sweep)
        self.squares = SquareSum(equations.d.numbering.nx)

    def factor(self, point: Iterate) -> None:
        """Form the matrix. Raises SingularMatrixError when the velocities are not determined."""
        q = self.q
        d, sweep, C = q.d, q.d.sweep, q.flexibility
        nx, motion = d.numbering.nx, point.motion
        V, flexible = sweep.gradient(), C.dense()
        K = self.squares(geometric_blocks(sweep, point.sigma)) + dense(load_gradient(d))
        offset = np.zeros((q.ne, nx))
        self.user = None if point.user is None else q.user_derivatives(point)
        x_changes: dict[str, Array] = {"e": V, "x": np.eye(nx)}
        if self.exact:
            v, a = (q.rest, q.rest) if motion is None else (motion.v, motion.a)
            by_x, by_v = inertia_blocks(sweep, v, a)
            K += self.squares(by_x)
            if motion is not None:
                Z, ed, Y, edd = self._rates(V, point)
                K += self.squares(by_v) @ Z + mass_matrix(sweep) @ Y
                i, j, value = d.law.damping
                np.add.at(offset, i, value[:, None] * ed[j])
                i, j, value = d.mechanism.deformation_inertia
                np.add.at(offset, i, value[:, None] * edd[j])
                x_changes.update(ed=ed, xd=Z)
        if self.user is not None:
            K -= self.user.along("f", **x_changes)
            offset += self.user.along("sigma", **x_changes)
        rows = C.coupled[:, None] * V + flexible @ (offset * ~q.constrained[:, None]) / C.size
        flexible[q.slips] = 0.0
        rows[q.slips] = 0.0
        nk = len(q.x_kinematic)
        rows[q.slips[:nk], q.x_kinematic] = 1.0
        rows[q.slips[nk:]] = V[q.e_kinematic]
        n = q.nf + q.ne
        self.full = np.empty((n, nx + q.ne))
        self.full[: q.nf, :nx], self.full[: q.nf, nx:] = K[q.F], C.size * V.T[q.F]
        self.full[q.nf :, :nx], self.full[q.nf :, nx:] = C.size * rows, -C.size * flexible
        self._square = self.full[:, np.concatenate((q.F, nx + np.arange(q.ne)))]

    def solve(self, right: Array) -> Array:
        """Solution for right-hand sides (n,) or (n, k). Raises SingularMatrixError."""
        try:
            return np.linalg.solve(self._square, right)
        except np.linalg.LinAlgError:
            raise SingularMatrixError(f"matrix of order {len(self._square)} is singular") from None

    def along(self, dx: Array) -> Array:
        """The matrix times a change dx (nx,) of prescribed coordinates, (n,)."""
        return np.asarray(self.full[:, : len(dx)] @ dx)

    def dense(self) -> Array:
        """The matrix, (n, n)."""
        return self._square

    def rounding(self, z: Array) -> Array:
        """eps |matrix| |z|, (n,)."""
        return np.asarray(EPS * (np.abs(self._square) @ np.abs(z)))

    def sign(self) -> float:
        """Sign of the determinant of the tangent stiffness."""
        # The mixed matrix has one negative eigenvalue more for every stress.
        return float(np.linalg.slogdet(self._square)[0]) * (-1.0) ** self.q.ne

    def _rates(self, V: Array, point: Iterate) -> tuple[Array, Array, Array, Array]:
        """Z (nx, nx), d(ed)/dx (ne, nx), Y, d(edd)/dx."""
        k, motion = self.q.d.kinematics, point.motion
        assert motion is not None
        nothing = np.zeros((self.q.d.numbering.nx,) * 2)
        by_v, second, swept = self.rates(motion.v, motion.a)
        Z = k.dependent(nothing, -by_v)
        swept += second @ Z
        Y = k.dependent(nothing, -swept)
        return Z, V @ Z + by_v, Y, V @ Y + swept
