"""Dynamics whose right-hand side and frames are evaluated by the compiled solver."""

from __future__ import annotations

import copy
from collections.abc import Callable
from typing import TypeVar

import numpy as np

from spacar.arrays import Array
from spacar.compiled.model import Model
from spacar.compiled.numbers import of_one
from spacar.dynamics.dynamics import Dynamics
from spacar.dynamics.mass_check import require_regular_mass
from spacar.frame import Frame
from spacar.kinematics.condition import of_gradient
from spacar.kinematics.kinematics import CONVERGED, FARTHEST_GUESS
from spacar.kinematics.regularity import PositionMatrix
from spacar.mechanism.mechanism import Drive, Loads, Mechanism, Polynomial

Result = TypeVar("Result")


SMALL = 64  # equations up to which the exact condition in C is cheaper than an estimate in the general path


class CompiledPositionMatrix(PositionMatrix):
    """V[E, U] as it is factored in C; that of the general path after a state that C could not do."""

    def __init__(self, dynamics: CompiledDynamics) -> None:
        super().__init__(dynamics.kinematics)
        self.dynamics = dynamics

    def determinant(self) -> tuple[float, float]:
        if not self.dynamics.state.c.known:
            return super().determinant()
        sign, size = self.dynamics.model.determinant()
        return float(sign[0]), float(size[0])

    def rcond(self) -> float:
        if self.dynamics.state.c.known:
            if len(self.rows) <= SMALL:
                rcond = self.dynamics.model.rcond(self.rows, self.columns)
                if rcond > self.zero:
                    return rcond
            self.dynamics.settle()
        return super().rcond()


class CompiledDynamics(Dynamics):
    """As Dynamics, with `rhs` and `frame` in C. What fails there is done again by the general path, which explains."""

    def __init__(self, mechanism: Mechanism, *, loads: Loads | None = None, drive: Drive | None = None) -> None:
        super().__init__(mechanism, loads=loads, drive=drive)
        k = self.kinematics
        scales, polynomial = (k.scale, mechanism.deformation_scale), isinstance(self.drive, Polynomial)
        self.model = Model(self.numbering, of_one(self), scales, len(k.E), polynomial)
        self.state = self.model.state()
        self._y, self._out = np.zeros((2, 2 * self.numbering.nddof))
        self._addresses = self._y.ctypes.data, self._out.ctypes.data
        self._step_of: tuple[Array, Array, Array, tuple[int, ...]] | None = None

    # -- the two paths --------------------------------------------------------------------------------------------
    def start(self) -> Array:
        """Start state. One that is near the reference configuration is placed in C; else the general path goes there.

        Near is what a guess of Newton's method may be away.
        """
        y, x0 = self.start_values(), self.mechanism.x0
        self.state.begin(x0[:, None], np.zeros((self.numbering.ne, 1)))
        if self._derivative(0.0, y, CONVERGED) < 0 or self._far(x0):
            y = super().start()
            self._take_over()
        else:
            M = self.model.reduced_mass()
            if M is None:
                self.settle()
                self.check_mass()
            else:
                self._hand_over()
                require_regular_mass(self.numbering, M[:, :, 0])
        return y

    def condition(self) -> float:
        n = self.numbering
        if len(self.kinematics.E) > SMALL or not self.state.c.known:
            self.settle()
            return super().condition()
        rows, columns = self.model.places()
        values = np.zeros((len(rows), 1))
        self.model.gradient(values)
        V = np.zeros((n.ne, n.nx))
        V[rows, columns] = values[:, 0]
        return of_gradient(self.kinematics, V)

    def _far(self, x: Array) -> bool:
        moved = np.abs(self.state.x[:, 0] - x) / self.kinematics.scale
        return bool(moved.max() > FARTHEST_GUESS)

    def _take_over(self) -> None:
        """The state in C becomes that of the general path."""
        self.state.begin(self.kinematics.x[:, None], self.sweep.near[:, None])

    def _hand_over(self) -> None:
        """The general path becomes the state in C."""
        s, k = self.state, self.kinematics
        k.start_at(s.x[:, 0], s.e[:, 0])
        k.e_given = s.given_e[:, 0].copy()
        self.xd = s.xd[:, 0].copy()

    def settle(self) -> None:
        self._hand_over()
        self.kinematics.refresh()

    def position_matrix(self) -> PositionMatrix:
        return CompiledPositionMatrix(self)

    def in_range(self) -> bool:
        known = self.model.in_range(self.state)
        if not known:
            self.settle()
        return known

    def companion(self) -> Dynamics:
        """Another state of the same model; the general path is handed over to whoever needs it."""
        other = copy.copy(self)
        other.state = self.model.state()
        other._take_over()
        return other

    def _in_general(self, evaluate: Callable[[], Result]) -> Result:
        """Let the general path look at a state that C could not do; it explains failures."""
        self._hand_over()
        self._last = None
        result = evaluate()
        self._take_over()
        return result

    def _prescribe(self, t: float) -> None:
        """Prescribed motion that is not a polynomial: its values at t."""
        drive, m = self.drive.at(t), self.model
        m.x_motion[:, :, 0] = np.column_stack((drive.x, drive.xd, drive.xdd))
        m.e_motion[:, :, 0] = np.column_stack((drive.e, drive.ed, drive.edd))

    # -- evaluation -----------------------------------------------------------------------------------------------
    def _derivative(self, t: float, y: Array, converged: float) -> int:
        """Time derivative of y into `_out`; a negative number when C cannot."""
        if not self.model.polynomial:
            self._prescribe(t)
        self._y[:] = y
        return self.model.rhs(self.state, t, *self._addresses, converged)

    def rhs(self, t: float, y: Array) -> Array:
        if self._derivative(t, y, self.kinematics.converged) < 0:
            return self._in_general(lambda: super(CompiledDynamics, self).rhs(t, y))
        self.evaluations += 1
        return self._out.copy()

    def stages(
        self, done: int, c: Array, a: Array, t: float, h: float, window: tuple[float, float], y: Array, K: Array
    ) -> int:
        """Stages of an explicit Runge-Kutta step, see `spacar.integrators.problem.Problem`."""
        if not self.model.polynomial:
            return done
        kept = self._step_of  # an integrator keeps its arrays
        if kept is None or kept[0] is not c or kept[1] is not y or kept[2] is not K:
            kept = self._step_of = c, y, K, (c.ctypes.data, a.ctypes.data, y.ctypes.data, K.ctypes.data)
        at_c, at_a, at_y, at_K = kept[3]
        reached = self.model.stages(
            self.state, done, len(c), at_c, at_a, t, h, window, at_y, at_K, len(y), self.kinematics.converged
        )
        self.evaluations += reached - done
        return reached

    def frame(self, t: float, y: Array) -> Frame:
        m, s = self.model, self.state
        if not m.polynomial:
            self._prescribe(t)
        self._y[:] = y
        if m.evaluate(s, t, self._y, CONVERGED) < 0:
            return self._in_general(lambda: super(CompiledDynamics, self).frame(t, y))
        x, xd, xdd = s.of_x[:, :, 0].copy()
        e, ed, edd, sigma = s.of_e[:4, :, 0].copy()
        gravity, total = m.forces[:, :, 0].copy()
        self.xd = xd
        return Frame(
            t=t, x=x, xd=xd, xdd=xdd, e=e, ed=ed, edd=edd, sig=sigma, fx=self.loads.force.copy(), fxgrav=gravity,
            fxtot=total,
        )  # fmt: skip
