"""The equations of motion: from the state at a time to accelerations, stresses, and the derivative of the state.

State y: dynamic coordinates, dynamic deformations, kinematic coordinates, kinematic deformations, then the rates of
the dynamic ones (theory-system.md section 3). One right-hand side, in this order:

    prescribed   x, xd, xdd and e, ed, edd of the input rows at t, those of the dynamic rows from y
    position     D(x) = e                        Newton's method from the expansion of the last states
    velocity     V xd = ed                       with the same factors
    stresses     sigma = S e + S_d ed + sigma0 + what a user function adds, on the active rows
    forces       f - h - V^T sigma               h: convective inertia of the elements
    motion       [ M  V^T ] [ xdd   ]   [ f - h - V^T sigma ]
                 [ V   0  ] [ sigma ] = [ edd - H(xd, xd)   ]        of what is not prescribed (theory-system.md (9))
    derivative   the rates in y, the kinematic ones of xd, ed, and the dynamic ones of xdd, edd

Without degrees of freedom the accelerations follow from the second row alone, and the reactions from the first.

The next position of a motion, as a start value for Newton's method: Hermite's polynomial through two states.

With h = t1 - t0, s = (t - t1)/h and the differences D, V, A of the earlier state from the Taylor polynomial of the
later one (positions, h times rates, h^2 times accelerations):

    x(s) = x1 + s h v1 + s^2 h^2 a1/2 + s^3 (c3 + c4 s + c5 s^2),
    c3 = -A/2 - 4V - 10D,   c4 = -A - 7V - 15D,   c5 = -A/2 - 3V - 6D.

For equal steps the error is h^6/90 times the sixth derivative, against h^3/6 times the third of Taylor's polynomial.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import NamedTuple

import numpy as np

from spacar.arrays import Array
from spacar.dynamics.loaded_mechanism import AppliedForces, DeformationInertia, LoadedMechanism, StressLaw
from spacar.dynamics.saddle_point import SaddlePoint
from spacar.errors import AnalysisError
from spacar.kinematics import Kinematics
from spacar.kinematics.element_sweep import ElementSweep, SweepArrays
from spacar.kinematics.kinematics import CONVERGED
from spacar.linear_systems import SingularMatrixError
from spacar.mechanism.mechanism import DriveState, UserForces

State = tuple[float, Array, Array, Array]  # t, x, xd, xdd
FARTHEST = 1.5  # steps h ahead
# Bounds of the difference between both polynomials. Below SMALL times the scale of the coordinates Newton's method
# takes two iterations from Taylor's polynomial already; above ROUGH times the motion of a step it is not smooth.
SMALL, ROUGH = 1e-6, 0.1


class Accelerations(NamedTuple):
    """xdd (nx,); sigma (ne,) with multipliers; convective (ne,): H(xd, xd), so that edd = V xdd + convective."""

    xdd: Array
    sigma: Array
    convective: Array


class EquationsOfMotion:
    """The equations of one loaded mechanism, in the configuration of `kinematics` with the velocity `xd`.

    `kind` forces the storage of the linear systems. `place` must come before `accelerate`. The elements and their
    matrices are made when something is evaluated.

    Raises AnalysisError 'mechanism.count' when the numbers of unknowns and equations differ.
    """

    def __init__(self, model: LoadedMechanism, kind: str | None = None) -> None:
        self.kind = kind
        self.saddle: SaddlePoint | None = None
        self.use(model)
        self.numbering = n = model.mechanism.numbering
        if not n.is_square:
            Kinematics(model.mechanism, kind)  # says what is wrong
        self.xs, self.es = n.x_class, n.e_class
        self.n_positions = n.nkddof
        places = self.xs["dynamic"], self.es["dynamic"], self.xs["kinematic"]
        self.n_xm, self.n_em, self.n_xk = (part.stop - part.start for part in places)
        self.xd, self.ed = np.zeros(n.nx), np.zeros(n.ne)
        self.convected = np.zeros(n.nx)  # h minus gravity on moving families, of the last accelerations
        self.last: State | None = None  # t, x, xd, xdd of the last accelerated state: the next guess starts there
        self.after_rhs: Callable[[], None] | None = None  # looks at every evaluated state
        self.before: State | None = None  # the state before `last`; only without degrees of freedom

    def use(self, model: LoadedMechanism) -> None:
        """Put other loads, another prescribed motion or another stress law on the same mechanism."""
        self.model = model
        self.mechanism, self.loads, self.drive = model.mechanism, model.loads, model.drive
        vars(self).pop("forces", None)  # of other loads

    @cached_property
    def kinematics(self) -> Kinematics:
        return self._made()

    @cached_property
    def sweep(self) -> ElementSweep:
        return self.kinematics.sweep

    @cached_property
    def coupling(self) -> DeformationInertia:
        return DeformationInertia(self.mechanism, self.sweep)

    @cached_property
    def forces(self) -> AppliedForces:
        return AppliedForces(self.mechanism, self.loads, self.sweep)

    def _made(self, arrays: SweepArrays | None = None) -> Kinematics:
        """New kinematics; `arrays` that its elements share."""
        sweep = ElementSweep(self.mechanism, arrays)
        sweep.constant_mass()
        return Kinematics(self.mechanism, self.kind, sweep)

    @property
    def law(self) -> StressLaw:
        return self.model.law

    # -- prescribed, position, velocity -------------------------------------------------------------------------
    def given(self, drive: DriveState, y: Array) -> tuple[Array, Array]:
        """x (nx,) and e (ne,) with the given values; the others are those of the reference configuration and zero."""
        xs, es = self.xs, self.es
        x = self.mechanism.x0.copy()
        e = np.zeros(self.numbering.ne)
        x[xs["input"]] = drive.x
        e[es["input"]] = drive.e
        a, b, c = self.n_xm, self.n_xm + self.n_em, self.n_xm + self.n_em + self.n_xk
        x[xs["dynamic"]], e[es["dynamic"]] = y[:a], y[a:b]
        x[xs["kinematic"]], e[es["kinematic"]] = y[b:c], y[c : self.n_positions]
        return x, e

    def place(self, t: float, y: Array, within: float = CONVERGED) -> DriveState:
        """Position and velocity of the state: leaves x in the kinematics and xd here.

        `within`: largest scaled correction that ends Newton's iteration. The guess of the position is the expansion of
        the last accelerated states, when the time has moved on.
        """
        n, xs, es = self.numbering, self.xs, self.es
        drive = self.drive.at(t)
        rates = y[self.n_positions :]
        xd, ed = np.zeros(n.nx), np.zeros(n.ne)
        xd[xs["input"]], xd[xs["dynamic"]] = drive.xd, rates[: self.n_xm]
        ed[es["input"]], ed[es["dynamic"]] = drive.ed, rates[self.n_xm :]
        guess = None
        if self.last is not None and t != self.last[0]:
            guess = extrapolated(t, self.last, self.before, self.kinematics.scale)
        self.before = None if n.nddof else self.last
        self.last = None
        self.xd = self.kinematics.place(*self.given(drive, y), xd, ed, guess, within)
        return drive

    # -- stresses, forces, motion -------------------------------------------------------------------------------
    def accelerate(self, t: float, drive: DriveState) -> Accelerations:
        """Accelerations, stresses and multipliers at the placed state. Raises AnalysisError where they do not exist."""
        n, sweep = self.numbering, self.sweep
        convective = sweep.convective(self.xd)
        sigma, user = self.constitutive(t)
        sweep.mass()
        self.convected = self.forces.inertia(sweep, self.xd)
        force = self.forces(self.kinematics.x, user) - self.convected
        xdd, edd = np.zeros(n.nx), np.zeros(n.ne)
        xdd[self.xs["input"]], edd[self.es["input"]] = drive.xdd, drive.edd
        if n.nddof:
            self._solve(t, xdd, sigma, force, edd - convective, convective)
        else:
            xdd = self.kinematics.dependent(xdd, edd - convective)
            inertia = sweep.mass_times(xdd) + self._coupling_force(xdd, convective)
            self.kinematics.reactions(inertia - force, sigma)
        self.last = (t, self.kinematics.x, self.xd, xdd)
        return Accelerations(xdd, sigma, convective)

    def _solve(self, t: float, xdd: Array, sigma: Array, force: Array, strain: Array, convective: Array) -> None:
        """The saddle-point form: writes the free rows of xdd, whose others are given, and the multipliers in sigma."""
        sweep = self.sweep
        force -= sweep.rate_transposed(sigma) + self._coupling_force(xdd, convective)
        if self.xs["input"].stop > self.xs["input"].start:
            force -= sweep.mass_times(xdd)
            strain -= sweep.rate(xdd)
        if self.saddle is None:
            self.saddle = SaddlePoint(self.mechanism, sweep, self.kind)
        try:
            self.saddle.factor()
            free, multipliers = self.saddle.solve(force, strain)
        except SingularMatrixError as error:
            raise singular_motion(t, str(error)) from None
        if not np.isfinite(free).all():
            raise singular_motion(t, "the accelerations are not finite")
        xdd[self.saddle.F] = free
        sigma[: len(multipliers)] = multipliers

    def constitutive(self, t: float) -> tuple[Array, UserForces | None]:
        """Stresses of the active rows (the others zero), and what the user function returned."""
        sweep, law = self.sweep, self.law
        if not law.passive or self.forces.user is not None:
            self.ed = sweep.rate(self.xd)
        sigma = law(sweep.e, self.ed)
        user = None
        if self.forces.user is not None:
            user = self.forces.user(float(t), sweep.e, self.ed, self.kinematics.x, self.xd)
            sigma[law.first :] += user.sigma[law.first :]
        return sigma, user

    def _coupling_force(self, xdd: Array, convective: Array) -> Array:
        if not self.coupling.present:
            return np.zeros(self.numbering.nx)
        return self.sweep.rate_transposed(self.coupling.stress(self.sweep.rate(xdd) + convective))

    # -- derivative ---------------------------------------------------------------------------------------------
    def rhs(self, t: float, y: Array, within: float = CONVERGED) -> Array:
        """Time derivative of the state; `within` as for `place`."""
        xdd, _, convective = self.accelerate(t, self.place(t, y, within))
        xs, es = self.xs, self.es
        a, b, m = self.n_xm + self.n_em, self.n_xm + self.n_em + self.n_xk, self.n_positions
        out = np.empty(len(y))
        out[:a] = y[m:]
        if self.numbering.nk:
            out[a:b] = self.xd[xs["kinematic"]]
            out[b:m] = self.sweep.rate(self.xd)[es["kinematic"]]
        out[m : m + self.n_xm] = xdd[xs["dynamic"]]
        if self.n_em:
            out[m + self.n_xm :] = (self.sweep.rate(xdd) + convective)[es["dynamic"]]
        if self.after_rhs is not None:
            self.after_rhs()
        return out


def singular_motion(t: float, reason: str) -> AnalysisError:
    """The saddle-point matrix is singular: no mass on a motion, or dependent constraints."""
    text = (
        f"the equations of motion cannot be solved at t = {t:.9g}: {reason}; a degree of freedom carries no mass"
        " (add XM or EM) or constraints depend on each other in this position (`spacar 0`)"
    )
    return AnalysisError(text, "dynamics.singular-mass", t=t)


def extrapolated(t: float, last: State, before: State | None, scale: Array) -> Array:
    """x (nx,) at t; Taylor's polynomial where there is no earlier state, or the motion between both is not smooth."""
    t1, x1, v1, a1 = last
    step = t - t1
    taylor: Array = x1 + step * (v1 + (0.5 * step) * a1)
    if before is None:
        return taylor
    t0, x0, v0, a0 = before
    h = t1 - t0
    if h == 0.0 or not 0.0 < step / h <= FARTHEST:
        return taylor
    s = step / h
    half = (0.5 * h * h) * a1
    D = x0 - x1 + h * v1 - half
    V = h * (v0 - v1) + 2.0 * half
    A = (h * h) * a0 - 2.0 * half
    c5 = -0.5 * A - 3.0 * V - 6.0 * D
    c4 = 2.0 * c5 - V - 3.0 * D
    correction: Array = s**3 * (c4 - c5 - D + s * (c4 + s * c5))
    size = np.abs(correction / scale).max()
    if not SMALL < size < ROUGH * np.abs((taylor - x1) / scale).max():
        return taylor
    return taylor + correction
