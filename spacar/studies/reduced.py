"""Right-hand side of disjoint copies from the reduced equations of motion (theory-system.md 2.2).

With few degrees of freedom per copy the velocity transfer W is cheap: the map V[E,U] is already factored, and since the
copies do not touch, one solve with nd + 1 columns gives the W of all copies and the convective accelerations. The small
systems

    (W^T M W) qdd = W^T (f - h - V^T sigma - M xdd_c),      xdd = W qdd + xdd_c

are solved as one stack. The result is that of the saddle-point form up to rounding; no multipliers come out, so stored
steps use the general evaluator. Measured with 200 copies of the manipulator (3 of 51 unknowns): 1.5 times faster
(benchmarks/ensemble.py).
"""

from __future__ import annotations

import numpy as np

from spacar.arrays import Array, Index
from spacar.dynamics.array_evaluator import Dynamics
from spacar.dynamics.motion_equations import singular_motion
from spacar.kinematics.kinematics import CONVERGED
from spacar.mechanism.mechanism import Mechanism

MOST = 8  # degrees of freedom of a copy up to which this is faster than the band solver


class ReducedCopies:
    """Right-hand side of n copies, an `Integrable`; `x_of` (n, nx of one): where the coordinates of each copy are."""

    stages = None
    by_case = None

    def __init__(self, dynamics: Dynamics, x_of: Index) -> None:
        self.dynamics = d = dynamics
        self.n_positions, self.component_name = d.n_positions, d.component_name
        self.x_of = x_of
        self.n_copies = n = len(x_of)
        nx, ne = d.n_xm // n, d.n_em // n
        self.columns = nx + ne  # of W; one more for the convective accelerations
        self.units_x = np.zeros((d.numbering.nx, self.columns + 1))
        self.units_e = np.zeros((d.numbering.ne, self.columns + 1))
        x, e = d.xs["dynamic"].start, d.es["dynamic"].start
        self.units_x[x + np.arange(n * nx), np.tile(np.arange(nx), n)] = 1.0
        self.units_e[e + np.arange(n * ne), np.tile(nx + np.arange(ne), n)] = 1.0

        self.moved = [*range(nx), *([self.columns] if d.numbering.nxp[2] else [])]  # columns with given coordinates

    @classmethod
    def suits(cls, mechanism: Mechanism, n: int) -> bool:
        """Whether the copies have few degrees of freedom, and no MEE."""
        return mechanism.numbering.nddof <= MOST * n and not len(mechanism.deformation_inertia[0])

    def rhs(self, t: float, y: Array, within: float = CONVERGED) -> Array:
        """Time derivative of the state of all copies."""
        d = self.dynamics
        sweep, kinematics, xs, es = d.sweep, d.kinematics, d.xs, d.es
        drive = d.place(t, y, within)
        convective = sweep.convective(d.xd)
        sigma, _ = d.constitutive(t)
        sweep.mass()
        force = d.forces(kinematics.x, None) - d.forces.inertia(sweep, d.xd)
        if sigma.any():
            force -= sweep.rate_transposed(sigma)
        given, rate = self.units_x, self.units_e
        given[xs["input"], -1] = drive.xdd
        rate[:, -1] = -convective
        rate[es["input"], -1] += drive.edd
        right = rate[kinematics.E]
        for k in self.moved:
            right[:, k] -= sweep.rate(given[:, k])[kinematics.E]
        W = given.copy()
        W[kinematics.U] = kinematics.velocity_system.solve(right)
        xdd = W[:, -1].copy()
        force -= sweep.mass_times(xdd)
        of_copies = W[self.x_of, :-1]  # (n, nx, nd)
        MW = np.stack([sweep.mass_times(column) for column in W.T[:-1]], axis=1)[self.x_of]
        transposed = of_copies.transpose(0, 2, 1)
        try:
            qdd = np.linalg.solve(transposed @ MW, transposed @ force[self.x_of][:, :, None])
        except np.linalg.LinAlgError as error:
            raise singular_motion(t, str(error)) from None
        if not np.isfinite(qdd).all():
            raise singular_motion(t, "the accelerations are not finite")
        xdd[self.x_of] += (of_copies @ qdd)[:, :, 0]
        d.last = (t, kinematics.x, d.xd, xdd)
        out = np.empty(len(y))
        m = self.n_positions
        out[:m] = y[m:]
        n_x = d.n_xm // self.n_copies
        out[m : m + d.n_xm] = qdd[:, :n_x, 0].ravel()
        out[m + d.n_xm :] = qdd[:, n_x:, 0].ravel()
        return out
