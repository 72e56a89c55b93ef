"""The residual of a stationary state and its convergence test (theory-system.md 6.1).

With the multipliers sigma_E of the equilibrium of the calculable coordinates (10), the residual (17) on the dynamic
rows needs no transfer functions: it is the out-of-balance force at dynamic coordinates, and the difference between
constitutive and equilibrium stress at dynamic deformations.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from spacar.dynamics.dynamics import Dynamics
from spacar.kinematics.kinematics import largest
from spacar.linear.matrices import equilibrium_stresses
from spacar.mechanism.mechanism import Array, DriveState

ROUNDING = 100.0 * np.finfo(float).eps
RELATIVE = 1e-8  # of the loads: an absolute tolerance in newtons says nothing about a mechanism of micrometres


@dataclass(frozen=True)
class Equilibrium:
    """A state with qdd = 0 (not necessarily in equilibrium).

    xdd (nx,) accelerations of steady motion; convective (ne,) H(xd, xd); sigma (ne,) constitutive stresses, zero on
    fixed and input rows; full (ne,) all stresses with those of rows E from the equilibrium; residual (nddof,);
    size: magnitude of the forces in it, and of the stiffness of released deformations times the rounding of lengths.
    work, work_size: the largest residual and the size of the forces, each times the size of its coordinate or
    deformation (model length, 1 rad), so that forces and moments compare and units do not matter.
    """

    xdd: Array
    convective: Array
    sigma: Array
    full: Array
    residual: Array
    size: float
    work: float
    work_size: float

    @cached_property
    def norm(self) -> float:
        return largest(self.residual)

    def reached(self, tolerance: float, seen: float) -> bool:
        """max |R| <= tolerance and small against the loads, or below their rounding, which no iteration can undercut.

        `seen` is the largest `work` of the iteration so far: where the solution is free of forces, nothing else has a
        size.
        """
        small = self.norm <= tolerance and self.work <= RELATIVE * max(self.work_size, seen)
        return bool(small or self.norm <= ROUNDING * self.size or self.work <= ROUNDING * self.work_size)


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
    residual = np.concatenate((balance[xm], sigma[em] - full[em]))
    scale, e_scale = d.mechanism.scale, d.mechanism.deformation_scale
    work = residual * np.concatenate((scale[xm], e_scale[em]))
    of_released = rows >= n.e_class["calculable"].start
    released, stored = S[of_released], S[of_released] * e_scale[rows[of_released]] ** 2
    return Equilibrium(
        xdd=xdd,
        convective=convective,
        sigma=sigma,
        full=full,
        residual=residual,
        size=max(
            largest(full) * largest(sweep.v_entries), largest(applied), 0.1 * largest(released) * d.mechanism.length
        ),
        work=largest(work),
        work_size=max(largest(full * e_scale), largest(applied * scale), 0.1 * largest(stored)),
    )
