"""The residual of a stationary state and its convergence test (theory-system.md 6.1).

With the multipliers sigma_E of the equilibrium of the calculable coordinates (10), the residual (17) on the dynamic
rows needs no transfer functions: it is the out-of-balance force at dynamic coordinates, and the difference between
constitutive and equilibrium stress at dynamic deformations.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from spacar.dynamics.dynamics import Dynamics
from spacar.linear.matrices import equilibrium_stresses
from spacar.mechanism.mechanism import Array, DriveState

ROUNDING = 100.0 * np.finfo(float).eps


@dataclass(frozen=True)
class Equilibrium:
    """A state with qdd = 0 (not necessarily in equilibrium).

    xdd (nx,) accelerations of steady motion; convective (ne,) H(xd, xd); sigma (ne,) constitutive stresses, zero on
    fixed and input rows; full (ne,) all stresses with those of rows E from the equilibrium; residual (nddof,);
    size: magnitude of the forces in it, and of the stiffness of released deformations times the rounding of lengths.
    """

    xdd: Array
    convective: Array
    sigma: Array
    full: Array
    residual: Array
    size: float

    @property
    def norm(self) -> float:
        return float(np.max(np.abs(self.residual), initial=0.0))

    def reached(self, tolerance: float) -> bool:
        """max |R| <= tolerance, or below the rounding of the forces, which no iteration can undercut."""
        return self.norm <= max(tolerance, ROUNDING * self.size)


def equilibrium(dynamics: Dynamics, drive: DriveState) -> Equilibrium:
    """Residual at the placed state."""
    d = dynamics
    n, sweep, k = d.numbering, d.sweep, d.kinematics
    sweep.e[k.h] = k.e_given[k.h]  # the position has converged: exact, while S times the rounding of e is not small
    convective = sweep.convective(d.xd)
    xdd, edd = np.zeros(n.nx), np.zeros(n.ne)
    xdd[n.x_class["input"]], edd[n.e_class["input"]] = drive.xdd, drive.edd
    if convective.any() or xdd.any() or edd.any():
        xdd = k.dependent(xdd, edd - convective)
        edd = sweep.rate(xdd) + convective
    sigma, user = d.constitutive(0.0)
    sweep.mass()
    full = equilibrium_stresses(d, xdd, edd, sigma, user)
    applied = d.forces(k.x, user)
    balance = sweep.mass_times(xdd) + d.forces.inertia(sweep, d.xd) - applied
    balance += sweep.rate_transposed(full + d.coupling.stress(edd))
    xm, em = n.x_class["dynamic"], n.e_class["dynamic"]
    rows, _, S = d.law.stiffness
    released = np.max(np.abs(S[rows >= n.e_class["calculable"].start]), initial=0.0)
    largest = float(np.max(np.abs(full), initial=0.0)) * float(np.max(np.abs(sweep.v_entries), initial=0.0))
    return Equilibrium(
        xdd=xdd,
        convective=convective,
        sigma=sigma,
        full=full,
        residual=np.concatenate((balance[xm], sigma[em] - full[em])),
        size=max(largest, float(np.max(np.abs(applied), initial=0.0)), 0.1 * float(released) * d.mechanism.length),
    )
