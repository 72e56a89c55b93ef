"""The equations of a stationary state with all coordinates and all stresses as unknowns (theory-system.md 6.1).

Unknown are the coordinates x_F that are not prescribed and all stresses sigma; nothing depends on which deformations
the user calls degrees of freedom (DYNE, DYNX) or releases (RLSE):

    V^T sigma + M a + h(x, v) - f(x)          = 0    on F                           (equilibrium)
    D(x) - e_given                            = 0    fixed and prescribed rows      (constraints)
    D(x) - C (sigma - sigma_1)                = 0    rows with stiffness, C = S^-1  (compatibility)
    sigma - sigma_1                           = 0    rows without
    sigma_1 = sigma_0 + S_d ed + M_e edd + stresses of the user function

sigma is not computed from the deformations of an iterate: a leaf spring that a correction leaves a micrometre too
long carries the force of the last solution, not the thousands of newtons of this elongation, which would enter the
geometric stiffness and spoil the next correction (Magisano, Leonetti, Garcea, CMAME 313 (2017) 986-1005).

In steady motion v and a are those of the configuration: V v = ed, V a = -H(v, v) on the fixed, prescribed and dynamic
rows, with the prescribed rates and, for holonomic systems, no rates of the dynamic degrees of freedom.
In non-holonomic systems kinematic coordinates and deformations are given too; their equations take the place of those
that slips do not have, and the stress of a slip that is a degree of freedom is free (`Iterate.slip` is its difference
from the law).
"""

from __future__ import annotations

from collections.abc import Callable
from math import isfinite
from typing import NamedTuple, Protocol

import numpy as np

from spacar.arrays import EPS, Array
from spacar.dynamics.array_evaluator import Dynamics
from spacar.dynamics.saddle_point import free_coordinates
from spacar.kinematics.kinematics import largest
from spacar.linear_systems import LinearSystem, SingularMatrixError
from spacar.linear_systems.reciprocal_condition import lost
from spacar.linearization.user_derivatives import UserDerivatives, user_derivatives
from spacar.mechanism.mechanism import UserForces
from spacar.stationary.flexibility import Flexibility
from spacar.stationary.loading import is_tube

FLOOR = 8.0 * EPS  # of the sum of the sizes of all terms: a residual below it is rounding


class Motion(NamedTuple):
    """v, a (nx,) of steady motion; ed, edd, convective H(v, v) (ne,)."""

    v: Array
    a: Array
    ed: Array
    edd: Array
    convective: Array


class Prescribed(NamedTuple):
    """Prescribed values of a load level: x (nx,) at the prescribed coordinates, e (ne,) at prescribed deformations."""

    x: Array
    e: Array


class Iterate(NamedTuple):
    """A state and how far it is from a solution.

    right (nf + ne,) the right-hand side of the correction, rounding the size of its rounding errors;
    force  largest out-of-balance force [N, N m]; work, work_size  that force, and all forces, times the size of their
    coordinates; gap  largest incompatibility / size of its deformation; quiet  is all of `right` rounding?;
    slip  stress that the law lacks at slips that are degrees of freedom, relative to work_size.
    """

    x: Array
    sigma: Array
    right: Array
    rounding: Array
    force: float
    work: float
    work_size: float
    gap: float
    quiet: bool
    slip: float
    motion: Motion | None
    user: UserForces | None

    @property
    def finite(self) -> bool:
        return isfinite(self.force + self.gap)


class StationaryEquations:
    """Residual of one evaluator under its present loads. `rates` (nddof,): those that non-holonomic systems keep.

    `held` (nx + ne,): forces, and misfits of deformations, that hold a start that is no equilibrium, if there are any.
    """

    def __init__(self, dynamics: Dynamics, flexibility: Flexibility, moving: bool, rates: Array) -> None:
        self.d, self.moving, self.rates = dynamics, moving, rates
        self.holonomic = dynamics.numbering.holonomic
        self.plain = self.holonomic and not moving
        n, m = dynamics.numbering, dynamics.mechanism
        self.F = free_coordinates(n)
        self.P = np.arange(n.x_class["input"].start, n.x_class["input"].stop)
        self.nf, self.ne = len(self.F), n.ne
        self.flexibility = flexibility
        self.scale, self.e_scale = m.scale, m.deformation_scale
        # An angle enters by directions, whose components are of size one: also at phi = 0 l (phi - beta) is known to
        # eps l only.
        self.least = np.ones(n.nx)
        self.least[n.positions] = 0.0
        self.rest = np.zeros(n.nx)
        self.held: Array | None = None
        self.user_part = 1.0  # of the stresses and forces of the user function
        first = dynamics.law.first
        self.active = np.arange(n.ne) >= first
        self.passive = self.active & (self.flexibility.coupled == 0.0)
        self.constrained = np.arange(n.ne) < n.e_class["input"].stop
        self._has_passive = bool(self.passive.any())
        self.loose = np.where(self.constrained, 0.0, 1.0)
        self.free_scale = self.scale[self.F]
        self._fluid = any(map(is_tube, m.layout.moving))
        size, rows = flexibility.size, np.arange(self.nf)
        self._length_rounding = FLOOR * size * (flexibility.coupled != 0.0)
        self._weights = np.concatenate((self.free_scale, 1.0 / (size * self.e_scale)))
        # two more right-hand sides of every correction: signs of rounding errors, a load of the size of the stiffness
        self.signs = np.where(np.arange(self.nf + self.ne) % 2, -1.0, 1.0)
        self.probe = np.concatenate((size * (1.0 + rows / max(self.nf, 1)), np.zeros(self.ne)))
        given = np.arange(n.e_class["dynamic"].stop)
        self.slips = given[n.slips[given]]
        self.x_kinematic, self.e_kinematic = np.r_[n.x_class["kinematic"]], np.r_[n.e_class["kinematic"]]

    def motion(self, x: Array) -> Motion | None:
        """v and a at the configuration of the sweep. Raises SingularMatrixError where they are not determined."""
        if not self.moving:
            return None
        d, n, k = self.d, self.d.numbering, self.d.kinematics
        k.x = x
        k.refactor()
        drive, n_xm = d.drive.at(0.0), d.n_xm
        xd, ed = np.zeros(n.nx), np.zeros(n.ne)
        xd[n.x_class["input"]], ed[n.e_class["input"]] = drive.xd, drive.ed
        xd[n.x_class["dynamic"]], ed[n.e_class["dynamic"]] = self.rates[:n_xm], self.rates[n_xm:]
        v = k.dependent(xd, ed)
        convective = d.sweep.convective(v)
        a = k.dependent(np.zeros(n.nx), -convective)
        return Motion(v, a, d.sweep.rate(v), d.sweep.rate(a) + convective, convective)

    def law_offset(self, motion: Motion | None, user: UserForces | None) -> Array:
        """sigma_1 on the active rows, M_e edd on all of them, (ne,)."""
        d = self.d
        if motion is None and user is None:
            return d.law.preload
        offset = d.law.preload.copy()
        if motion is not None:
            offset += d.law(np.zeros(self.ne), motion.ed) - d.law.preload
            offset += d.coupling.stress(motion.edd)
        if user is not None:
            offset += np.where(self.active, user.sigma, 0.0)
        return offset

    def point(self, x: Array, sigma: Array, given: Prescribed) -> Iterate:
        """Evaluate at x (nx,), sigma (ne,); leaves the sweep there. Raises SingularMatrixError as `motion`."""
        d, sweep, C, nf = self.d, self.d.sweep, self.flexibility, self.nf
        sweep.strain(x)
        motion = self.motion(x)
        user = None
        if d.forces.user is not None:
            ed, v = (np.zeros(self.ne), self.rest) if motion is None else (motion.ed, motion.v)
            user = d.forces.user(0.0, sweep.e, ed, x, v).scaled(self.user_part)
        offset = self.law_offset(motion, user)
        if user is None and self._has_passive:
            sigma = np.where(self.passive, offset, sigma)
        applied = d.forces(x, user)
        rows, columns, entries = sweep.v_rows, sweep.v_columns, sweep.v_entries
        parts = entries * sigma.take(rows)
        force = applied - np.bincount(columns, parts, d.numbering.nx)
        sizes = np.bincount(columns, np.abs(parts), d.numbering.nx) + np.abs(applied)
        if motion is not None or self._fluid or d.forces.heavy:  # nothing else has inertia forces at rest
            inertia = d.forces.inertia(sweep, self.rest if motion is None else motion.v)
            if motion is not None:
                sweep.mass()
                inertia += sweep.mass_times(motion.a)
            force -= inertia
            sizes += np.abs(inertia)
        if self.held is not None:
            force -= self.held[: len(x)]
        gap = C.coupled * (sweep.e - given.e) - C.times((sigma - offset) * self.loose)
        if self.held is not None:
            gap -= self.held[len(x) :]
        slip = 0.0
        work_size = max(largest(sigma * self.e_scale), largest(applied * self.scale))
        if len(self.slips):
            lacking = (offset - sigma)[self.slips] * self.loose[self.slips]
            slip = largest(lacking * self.e_scale[self.slips])
            k = self.x_kinematic
            gap[self.slips] = np.concatenate((x[k] - given.x[k], sweep.e[self.e_kinematic] - given.e[self.e_kinematic]))
        lengths = np.bincount(rows, np.abs(entries * np.maximum(np.abs(x), self.least).take(columns)), self.ne)
        right, rounding = np.empty((2, nf + self.ne))
        right[:nf], rounding[:nf] = force.take(self.F), sizes.take(self.F)
        np.multiply(gap, -C.size, out=right[nf:])
        np.multiply(lengths, self._length_rounding, out=rounding[nf:])
        rounding[:nf] *= FLOOR
        size = np.abs(right)
        scaled = size * self._weights
        return Iterate(
            x, sigma, right, rounding, largest(size[:nf]), largest(scaled[:nf]), work_size, largest(scaled[nf:]),
            bool((size <= rounding).all()), slip, motion, user,
        )  # fmt: skip

    def user_derivatives(self, p: Iterate) -> UserDerivatives:
        """Of the user function at the point where the sweep is, as far as it acts."""
        d, m = self.d, p.motion
        ed, v = (np.zeros(self.ne), self.rest) if m is None else (m.ed, m.v)
        found = user_derivatives(d.mechanism, 0.0, d.sweep.e, ed, p.x, v, self.active)
        return found if self.user_part == 1.0 else found.scaled(self.user_part)

    def balanced(self, p: Iterate) -> Array:
        """sigma (ne,) of the point where the sweep is, with those of the rows fixed, prescribed and dynamic from the
        equilibrium of the other coordinates. Raises SingularMatrixError where the degrees of freedom do not determine
        the configuration.
        """
        d = self.d
        d.kinematics.x = p.x
        d.kinematics.refactor()
        force = -d.sweep.rate_transposed(p.sigma)
        force[self.F] -= p.right[: self.nf]
        sigma = p.sigma.copy()
        d.kinematics.reactions(force, sigma)
        return sigma


# Displacement under forces of the size of the stiffness, 1/(50 eps), from which it is asked whether digits are left.
# From its square on there are none: entries of V, directions of size one, are known to eps, and V^T S V to eps^2 S.
SINGULAR = 1e14
# Part of such a displacement, or size of a correction [model lengths or rad], that is rounding: the matrix is singular.
NO_DIGITS = 1e-4
SPREAD = 10.0  # largest effect of rounding errors over that of one sample of their signs, which are not known


def require_digits(solve: Callable[[Array], Array], rounding: Callable[[Array], Array], z: Array, nf: int) -> None:
    """Raises SingularMatrixError where z (n,), the solution under forces of the size of the stiffness, is rounding.

    Displacements of soft, finely divided models are large without being wrong: above SINGULAR it is asked whether
    `rounding` of the entries, eps |matrix| |z|, changes the first nf unknowns by NO_DIGITS; above SINGULAR^2 they are.
    """
    growth = largest(z[:nf])
    finite = np.isfinite(z).all() and growth < SINGULAR**2
    if not growth < SINGULAR and not (finite and lost(solve, rounding(z), z, nf) < NO_DIGITS):
        raise SingularMatrixError(f"the stiffness is singular to working precision (growth {growth:.2g})")


class Tangent(Protocol):
    """The matrix of the corrections; unknowns x_F, then sigma / size."""

    @property
    def system(self) -> LinearSystem:
        """Its factors, of a large model."""

    @property
    def exact(self) -> bool: ...
    @property
    def symmetric(self) -> bool: ...
    def factor(self, point: Iterate) -> None: ...
    def solve(self, right: Array) -> Array: ...
    def along(self, dx: Array) -> Array: ...
    def dense(self) -> Array: ...
    def rounding(self, z: Array) -> Array:
        """eps |matrix| |z| of z (n,): by what rounding of the entries changes the product."""
    def sign(self) -> float:
        """Of the determinant of the tangent stiffness: -1 where the number of its negative eigenvalues is odd."""


class Astray(Exception):
    """The iteration does not converge, or not to a neighbouring state; the code of an error that says so, and what
    helps then."""

    def __init__(self, text: str, code: str = "statics.no-convergence", remedy: str = "a smaller load") -> None:
        super().__init__(text)
        self.code, self.remedy = code, remedy
