"""The evaluator on NumPy arrays: the equations of motion with start, frames and checks.

It fulfils the contract of `spacar.dynamics.evaluator`, and `numpy_evaluator` of every evaluator
returns it: linearized equations, transfer functions and diagnoses need the element sweeps and factors at a state.
"""

from __future__ import annotations

import numpy as np

from spacar.arrays import Array
from spacar.dynamics.loaded_mechanism import LoadedMechanism, Moving, Placement
from spacar.dynamics.mass_check import (
    dynamic_mass,
    is_checked,
    is_doubtful,
    largest_mass,
    require_inertia_of_many,
    require_regular_mass,
)
from spacar.dynamics.motion_equations import Accelerations, EquationsOfMotion
from spacar.dynamics.saddle_point import SaddlePoint
from spacar.frame import Frame
from spacar.kinematics.constraint_condition import condition_number
from spacar.kinematics.regularity import PositionMatrix
from spacar.linear_systems import DENSE_LIMIT
from spacar.mechanism.mechanism import Drive, Loads, Mechanism
from spacar.mechanism.numbering import Numbering


class Dynamics(EquationsOfMotion):
    """Evaluator of one mechanism; `loads` and `drive` replace those of the mechanism, `kind` forces the storage."""

    by_case = None
    blocks = None  # stages, steps and outputs are made one by one

    def __init__(
        self, mechanism: Mechanism, *, loads: Loads | None = None, drive: Drive | None = None, kind: str | None = None
    ) -> None:
        super().__init__(LoadedMechanism.of(mechanism, loads, drive), kind)
        self._low, self._signs = float("inf"), set[float]()
        self.doubt: str | None = None

    # -- start --------------------------------------------------------------------------------------------------
    def start_values(self) -> Array:
        """The state of STARTDX, STARTDE and, for kinematic coordinates, of the reference configuration."""
        s = self.mechanism.start
        if s.is_complete:
            return s.state(s.e_kinematic)
        self.sweep.strain(self.mechanism.x0)
        return s.state(np.where(np.isnan(s.e_kinematic), self.sweep.e[self.es["kinematic"]], s.e_kinematic))

    def start(self) -> Array:
        """Start state; brings the mechanism there from the reference configuration, in steps if it is far."""
        y = self.start_values()
        x0 = self.mechanism.x0
        self.stand(Placement(x0, np.zeros_like(x0), np.zeros(self.numbering.ne)))
        self.kinematics.begin()
        self.place(0.0, y)
        self.check_mass()
        return y

    def check_mass(self) -> None:
        """Raises AnalysisError when a dynamic degree of freedom carries no mass in the placed configuration.

        Sets `doubt` where the inertia may be rounding.
        """
        self.doubt = None
        if not self.numbering.nddof:
            return
        mechanism, sweep = self.mechanism, self.sweep
        sweep.mass()
        if not is_checked(self.numbering):
            saddle = SaddlePoint(mechanism, sweep, self.kind)
            self.doubt = require_inertia_of_many(mechanism, saddle, self.condition)
            return
        largest, condition = largest_mass(mechanism, sweep), self.condition()
        if is_doubtful(mechanism, dynamic_mass(self.kinematics, self.coupling), condition, largest):
            self.doubt = require_regular_mass(mechanism, SaddlePoint(mechanism, sweep, self.kind), condition)

    # -- frames -------------------------------------------------------------------------------------------------
    def frame(self, t: float, y: Array) -> Frame:
        return self.complete(t, self.accelerate(t, self.place(t, y)), self.convected)

    def complete(self, t: float, found: Accelerations, convected: Array) -> Frame:
        """Frame at the placed state; `convected` is h minus gravity of moving families."""
        sweep, x = self.sweep, self.kinematics.x
        xdd, sigma, convective = found
        ed = sweep.rate(self.xd)
        edd = sweep.rate(xdd) + convective
        gravity = self.forces.gravity(sweep)
        applied = self.loads.force + self.forces.moments(x)
        lost: dict[int, str] = {}
        if self.forces.user is not None:
            user = self.forces.user(float(t), sweep.e, ed, x, self.xd)
            applied += user.force
            lost = user.lost
        total = sweep.mass_times(xdd) + convected + (gravity - self.forces.constant_gravity)
        stress = sigma + self.coupling.stress(edd) if self.coupling.present else sigma
        total += sweep.rate_transposed(stress)
        return Frame(
            t=t, x=x.copy(), xd=self.xd.copy(), xdd=xdd, e=sweep.e.copy(), ed=ed, edd=edd, sig=sigma,
            fx=applied, fxgrav=gravity, fxtot=total, lost=lost,
        )  # fmt: skip

    # -- where it stands, and checks there ----------------------------------------------------------------------
    @property
    def iterations(self) -> int:
        return self.kinematics.iterations

    def placement(self) -> Placement:
        k = self.kinematics
        return Placement(k.x, self.xd, k.e)

    def moving(self) -> Moving | None:
        return None if self.last is None else Moving(*self.last, self.sweep.e.copy())

    def resume(self, at: Moving) -> None:
        self.kinematics.start_at(at.x, at.e)
        self.last, self.before = (at.t, at.x, at.xd, at.xdd), None

    def stand(self, at: Placement) -> None:
        """Go on from where another evaluator of the same mechanism stands, without its memory of earlier states."""
        self.kinematics.start_at(at.x, at.e)
        self.xd = at.xd.copy()
        self.last = None

    def numpy_evaluator(self) -> Dynamics:
        return self

    def fork(self, independent: bool = True) -> Dynamics:
        """An evaluator of the same mechanism, always apart, which follows its own path from this configuration."""
        other = Dynamics(self.mechanism, kind=self.kind)
        other.use(self.model)
        other.kinematics.start_from(self.kinematics)
        return other

    def sample(self) -> None:
        matrix = self.position_matrix()

        def keep() -> None:
            sign, size = matrix.determinant()
            self._signs.add(sign)
            self._low = min(self._low, size)

        self.after_rhs = keep if matrix.has_determinant else None

    def sampled(self) -> tuple[float, bool]:
        found = self._low, len(self._signs) > 1
        self._low = float("inf")
        self._signs.clear()
        return found

    def condition(self) -> float:
        return condition_number(self.kinematics)

    def position_matrix(self) -> PositionMatrix:
        n = self.numbering.e_class["dynamic"].stop
        dense = self.kind == "dense" or (self.kind is None and n <= DENSE_LIMIT)
        return PositionMatrix(self.mechanism, lambda: self.kinematics, dense)

    def in_range(self) -> bool:
        return False  # not known: the elements have to be asked

    def component_name(self, i: int) -> str:
        return component_name(self.numbering, i)


def component_name(numbering: Numbering, i: int) -> str:
    """Name of a component of the state, for messages."""
    names = [numbering.q_names[k] for k in numbering.dynamic]
    names += numbering.k_names + [f"rate of {name}" for name in names]
    return names[i]
