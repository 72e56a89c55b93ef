"""From the state (q_d, k, qd_d) at a time to accelerations, stresses and reactions.

State y: dynamic coordinates, dynamic deformations, kinematic coordinates, kinematic deformations, then the rates of
the dynamic ones (theory-system.md section 3). One evaluation does, in this order: prescribed motion, position,
velocity, element sweeps for H(xd,xd), M, h and sigma, one solve of the saddle-point form.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from spacar.arrays import Array
from spacar.dynamics.forces import AppliedForces, StressLaw
from spacar.dynamics.mass_check import dynamic_mass, is_checked, require_regular_mass
from spacar.dynamics.saddle_point import DeformationInertia, SaddlePoint
from spacar.errors import AnalysisError
from spacar.frame import Frame
from spacar.kinematics import Kinematics
from spacar.kinematics.condition import condition_number
from spacar.kinematics.extrapolation import State, extrapolated
from spacar.kinematics.kinematics import CONVERGED
from spacar.kinematics.regularity import PositionMatrix
from spacar.linear_systems import SingularMatrixError
from spacar.mechanism.mechanism import Drive, DriveState, Loads, Mechanism, UserForces


class Dynamics:
    """Evaluator of one mechanism under one set of loads. The `Problem` of the integrators.

    `kind` forces the storage of the linear systems; `drive` and `loads` replace those of the mechanism.
    """

    def __init__(
        self, mechanism: Mechanism, *, loads: Loads | None = None, drive: Drive | None = None, kind: str | None = None
    ) -> None:
        self.mechanism = mechanism
        self.numbering = n = mechanism.numbering
        self.kinematics = Kinematics(mechanism, kind)
        self.sweep = self.kinematics.sweep
        self.sweep.constant_mass()
        self.reload(loads or mechanism.loads, drive or mechanism.drive)
        self.coupling = DeformationInertia(mechanism, self.sweep)
        self.xs, self.es = n.x_class, n.e_class
        self.n_positions = n.nddof + n.nk
        self.n_xm, self.n_em = int(n.nxp[3]), int(n.nep[3])
        self.n_xk = int(n.nxp[4])
        self.saddle: SaddlePoint | None = None
        self.kind = kind
        self.xd, self.ed = np.zeros(n.nx), np.zeros(n.ne)
        self.evaluations = 0
        self.accepted: Callable[[float, Array], None] | None = None  # called by the integrators after each step
        self.jacobian: Callable[[float, Array], tuple[Array, Array]] | None = None  # of the codes that need one
        self._convected = np.zeros(n.nx)  # h minus gravity on moving families at the last accelerated state
        self._last: State | None = None  # t, x, xd, xdd of the last accelerated state
        self._before: State | None = None  # the same of the one before, where the motion is prescribed

    def reload(self, loads: Loads, drive: Drive) -> None:
        """Put other loads and another prescribed motion on the same mechanism."""
        self.loads, self.drive = loads, drive
        self.forces = AppliedForces(self.mechanism, loads, self.sweep)
        self.law = StressLaw.of(self.mechanism, loads)

    # -- start --------------------------------------------------------------------------------------------------
    def start_values(self) -> Array:
        """The state of STARTDX, STARTDE and, for kinematic coordinates, of the reference configuration."""
        s = self.mechanism.start
        e_kinematic = s.e_kinematic.copy()
        unset = np.isnan(e_kinematic)
        if unset.any():
            self.sweep.strain(self.mechanism.x0)
            e_kinematic[unset] = self.sweep.e[self.es["kinematic"]][unset]
        y = np.concatenate((s.x_value, s.e_value, s.x_kinematic, e_kinematic, s.x_rate, s.e_rate))
        return y

    def start(self) -> Array:
        """Start state; brings the mechanism there from the reference configuration, in steps if it is far."""
        y = self.start_values()
        self.kinematics.begin()
        self.place(0.0, y)
        self.check_mass()
        return y

    def check_mass(self) -> None:
        """Raises AnalysisError when a dynamic degree of freedom carries no mass in the placed configuration."""
        if is_checked(self.numbering):
            self.sweep.mass()
            require_regular_mass(self.numbering, dynamic_mass(self.kinematics, self.coupling))

    def _slice(self, name: str) -> slice:
        edges = np.cumsum([0, self.n_xm, self.n_em, self.n_xk, int(self.numbering.nep[4])])
        k = ("xm", "em", "xk", "ek").index(name)
        return slice(int(edges[k]), int(edges[k + 1]))

    def given(self, drive: DriveState, y: Array) -> tuple[Array, Array]:
        xs, es = self.xs, self.es
        x = self.mechanism.x0.copy()
        e = np.zeros(self.numbering.ne)
        x[xs["input"]] = drive.x
        e[es["input"]] = drive.e
        a, b, c = self.n_xm, self.n_xm + self.n_em, self.n_xm + self.n_em + self.n_xk
        x[xs["dynamic"]], e[es["dynamic"]] = y[:a], y[a:b]
        x[xs["kinematic"]], e[es["kinematic"]] = y[b:c], y[c : self.n_positions]
        return x, e

    # -- one evaluation -----------------------------------------------------------------------------------------
    def place(self, t: float, y: Array) -> DriveState:
        """Position and velocity of the state: leaves x in the kinematics and xd, ed here.

        The guess of the position is the expansion of the last accelerated states, when the time has moved on.
        """
        n, xs, es = self.numbering, self.xs, self.es
        drive = self.drive.at(t)
        rates = y[self.n_positions :]
        xd, ed = np.zeros(n.nx), np.zeros(n.ne)
        xd[xs["input"]], xd[xs["dynamic"]] = drive.xd, rates[: self.n_xm]
        ed[es["input"]], ed[es["dynamic"]] = drive.ed, rates[self.n_xm :]
        guess = None
        if self._last is not None and t != self._last[0]:
            guess = extrapolated(t, self._last, self._before, self.kinematics.scale)
        self._before = None if n.nddof else self._last
        self._last = None
        self.xd = self.kinematics.place(*self.given(drive, y), xd, ed, guess)
        return drive

    def accelerate(self, t: float, drive: DriveState) -> tuple[Array, Array, Array]:
        """xdd (nx,), sigma (ne,) with multipliers, convective H(xd,xd) (ne,) at the placed state."""
        n, xs, es, sweep = self.numbering, self.xs, self.es, self.sweep
        convective = sweep.convective(self.xd)
        sigma, user = self.constitutive(t)
        sweep.mass()
        self._convected = self.forces.inertia(sweep, self.xd)
        force = self.forces(self.kinematics.x, user) - self._convected
        xdd, edd = np.zeros(n.nx), np.zeros(n.ne)
        xdd[xs["input"]], edd[es["input"]] = drive.xdd, drive.edd
        if n.nddof == 0:
            xdd = self.kinematics.dependent(xdd, edd - convective)
            inertia = sweep.mass_times(xdd) + self._coupling_force(xdd, convective)
            self.kinematics.reactions(inertia - force, sigma)
            self._last = (t, self.kinematics.x, self.xd, xdd)
            return xdd, sigma, convective
        if sigma.any():
            force -= sweep.rate_transposed(sigma)
        force -= self._coupling_force(xdd, convective) if self.coupling.present else 0.0
        strain = edd - convective
        if n.nxp[2]:
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
        self._last = (t, self.kinematics.x, self.xd, xdd)
        return xdd, sigma, convective

    def constitutive(self, t: float) -> tuple[Array, UserForces | None]:
        """Stresses of the active rows (the others zero), and what the user function returned."""
        sweep = self.sweep
        if not self.law.passive or self.forces.user is not None:
            self.ed = sweep.rate(self.xd)
        sigma = self.law(sweep.e, self.ed)
        user = None
        if self.forces.user is not None:
            user = self.forces.user(t, sweep.e, self.ed, self.kinematics.x, self.xd)
            sigma[self.law.first :] += user.sigma[self.law.first :]
        return sigma, user

    def _coupling_force(self, xdd: Array, convective: Array) -> Array:
        if not self.coupling.present:
            return np.zeros(self.numbering.nx)
        return self.sweep.rate_transposed(self.coupling.stress(self.sweep.rate(xdd) + convective))

    def rhs(self, t: float, y: Array) -> Array:
        """Time derivative of the state."""
        self.evaluations += 1
        drive = self.place(t, y)
        xdd, _, convective = self.accelerate(t, drive)
        xs, es = self.xs, self.es
        out = np.empty(len(y))
        m = self.n_positions
        out[: self.n_xm + self.n_em] = y[m:]
        if self.numbering.nk:
            out[self._slice("xk")] = self.xd[xs["kinematic"]]
            out[self._slice("ek")] = self.sweep.rate(self.xd)[es["kinematic"]]
        out[m : m + self.n_xm] = xdd[xs["dynamic"]]
        if self.n_em:
            edd = self.sweep.rate(xdd) + convective
            out[m + self.n_xm :] = edd[es["dynamic"]]
        return out

    # -- what checks ask after an evaluation ----------------------------------------------------------------------
    def settle(self) -> None:
        """Bring kinematics and sweep to the last evaluated state.

        Here they are at it already. The compiled evaluator, which computes states in C, overrides this and copies the
        state back, because the checks of an accepted step read it from kinematics and sweep.
        """

    def condition(self) -> float:
        """Condition number of V[E, U] at the last evaluated state; infinite when singular."""
        return condition_number(self.kinematics)

    def position_matrix(self) -> PositionMatrix:
        """V[E, U] at the last evaluated state."""
        return PositionMatrix(self.kinematics)

    def in_range(self) -> bool:
        """Whether it is known already that all elements are in the range of their theory; they are asked otherwise."""
        return False

    def companion(self) -> Dynamics:
        """An evaluator of the same mechanism, which follows its own path from the present configuration."""
        other = Dynamics(self.mechanism, loads=self.loads, drive=self.drive, kind=self.kind)
        other.kinematics.start_from(self.kinematics)
        return other

    def component_name(self, i: int) -> str:
        """Name of a component of the state, for messages."""
        n = self.numbering
        names = [n.q_names[k] for k in n.dynamic]
        names += n.k_names + [f"rate of {name}" for name in names]
        return names[i]

    # -- full evaluation ----------------------------------------------------------------------------------------
    def frame(self, t: float, y: Array) -> Frame:
        """Everything that is stored of a state."""
        converged, self.kinematics.converged = self.kinematics.converged, CONVERGED
        drive = self.place(t, y)
        self.kinematics.converged = converged
        xdd, sigma, convective = self.accelerate(t, drive)
        return self.complete(t, xdd, sigma, convective, self._convected)

    def complete(self, t: float, xdd: Array, sigma: Array, convective: Array, convected: Array) -> Frame:
        """Frame at the placed state; `convective` is H(xd,xd), `convected` is h minus gravity of moving families."""
        sweep, x = self.sweep, self.kinematics.x
        ed = sweep.rate(self.xd)
        edd = sweep.rate(xdd) + convective
        gravity = self.forces.gravity(sweep)
        applied = self.loads.force + self.forces.moments(x)
        if self.forces.user is not None:
            applied += self.forces.user(t, sweep.e, ed, x, self.xd).force
        total = sweep.mass_times(xdd) + convected + (gravity - self.forces.constant_gravity)
        stress = sigma + self.coupling.stress(edd) if self.coupling.present else sigma
        total += sweep.rate_transposed(stress)
        return Frame(
            t=t, x=x.copy(), xd=self.xd.copy(), xdd=xdd, e=sweep.e.copy(), ed=ed, edd=edd, sig=sigma,
            fx=applied, fxgrav=gravity, fxtot=total,
        )  # fmt: skip


def singular_motion(t: float, reason: str) -> AnalysisError:
    """The saddle-point matrix is singular: no mass on a motion, or dependent constraints."""
    text = (
        f"the equations of motion cannot be solved at t = {t:.9g}: {reason}; a degree of freedom carries no mass"
        " (add XM or EM) or constraints depend on each other in this position (`spacar 0`)"
    )
    return AnalysisError(text, "dynamics.singular-mass")
