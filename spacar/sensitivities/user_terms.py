"""Forces and stresses of the user (USERSIG) in the derivatives of the linearized equations.

With the state s = (e, x, ed, xd), the stresses a_e(s) and the forces a_x(s) that the function returns, the equations
hold l^T a'(s) r between vectors l = (w_e, -w), r = (u_e, u, z_e, z). Along a direction that moves the state by ds

    d(l^T a' r) = dl^T a' r + l^T a' dr + l^T a''(s)[ds, r]

The last term is the mixed difference of the function over steps of eps^(1/6) in both directions, extrapolated from two
sizes: truncation and rounding are both about eps^(2/3) = 4e-11 of the function, where it is smooth. The stiffness k
that a function states for its forces counts in the load multipliers as a spring, not as a load; its change is a
difference of fourth order.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from spacar.arrays import EPS, Array
from spacar.deck.directed import STEP
from spacar.dynamics.array_evaluator import Dynamics
from spacar.linearization.user_derivatives import UserDerivatives
from spacar.mechanism.mechanism import UserForces
from spacar.sensitivities.state_derivatives import StateDerivative

SHARE = EPS ** (1.0 / 6.0)  # of the size of the state: steps of mixed differences
SLOPE_SHARE = EPS**0.2  # the same of a difference of fourth order


@dataclass(frozen=True)
class UserTerms:
    """Of the state where the dynamics stand, along the derivative of this state; `known`: first derivatives there."""

    dynamics: Dynamics
    known: UserDerivatives
    state: StateDerivative

    def form(self, left: tuple[Array, Array], right: tuple[Array, Array, Array, Array]) -> Array:
        """l^T a' r (k, m) with its change as imaginary part: left (w_e, w), right (u_e, u, z_e, z), complex steps."""
        we, w = left
        by = dict(zip(("e", "x", "ed", "xd"), right, strict=True))
        found = we.T @ self.known.along("sigma", **by) - w.T @ self.known.along("f", **by)
        return found + 1j * STEP * self._second(np.vstack((we, -w)).real, np.vstack(right).real)

    def springs(self, w: Array, u: Array) -> Array:
        """w^T k u (k, m), with k the stiffness that the function states for its forces."""
        ds, h = self._along, self._step(self._along, SLOPE_SHARE)
        change = sum(c * self._at(n * h * ds).force_k for n, c in ((-2, 1.0), (-1, -8.0), (1, 8.0), (2, -1.0)))
        k = self._at(0.0 * ds).force_k + 1j * STEP * change / (12.0 * (h or 1.0))
        return (w.T * k) @ u

    @property
    def _along(self) -> Array:
        """ds."""
        s, e = self.state, self.state.elements
        return np.concatenate((s.de, s.dx, e.strain_rate(s.v).imag / STEP, s.v.imag / STEP))

    def _second(self, left: Array, right: Array) -> Array:
        """l^T a''[ds, r] (k, m), real."""
        out, ds = np.zeros((left.shape[1], right.shape[1])), self._along
        for column, r in zip(out.T, right.T, strict=True):
            fine, coarse = (left.T @ self._mixed(ds, r, share) for share in (SHARE, 2.0 * SHARE))
            column[:] = (4.0 * fine - coarse) / 3.0
        return out

    def _mixed(self, p: Array, q: Array, share: float) -> Array:
        """a''[p, q] (ne + nx,), second order in the share of the size that both steps have."""
        h, k = self._step(p, share), self._step(q, share)
        found = np.zeros(len(p) // 2)
        active = np.arange(self.dynamics.numbering.ne) >= self.dynamics.law.first
        if h and k:
            for i, j in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
                at = self._at(i * h * p + j * k * q)
                found += i * j * np.concatenate((at.sigma * active, at.force)) / (4.0 * h * k)
        return found

    def _step(self, along: Array, share: float) -> float:
        """The step along a vector that moves the state by a share of its size; 0: it does not move."""
        m = self.dynamics.mechanism
        largest = np.abs(along / np.tile(np.concatenate((m.deformation_scale, m.scale)), 2)).max(initial=0.0)
        return float(share / largest) if largest else 0.0

    def _at(self, moved: Array) -> UserForces:
        d, ne, nx = self.dynamics, self.dynamics.numbering.ne, self.dynamics.numbering.nx
        e, x, ed, xd = np.split(moved, np.cumsum([ne, nx, ne]))
        law: Callable[..., UserForces] | None = d.forces.user
        assert law is not None
        return law(0.0, d.sweep.e + e, d.sweep.rate(d.xd) + ed, d.kinematics.x + x, d.xd + xd)
