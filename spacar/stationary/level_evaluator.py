"""Loads of a level put on the evaluator, with the equations and the tangent that belong to it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from spacar.arrays import Array
from spacar.dynamics.array_evaluator import Dynamics
from spacar.dynamics.loaded_mechanism import LoadedMechanism
from spacar.mechanism.mechanism import Mechanism
from spacar.stationary.contract import Tangent
from spacar.stationary.flexibility import Flexibility
from spacar.stationary.loading import WITHOUT_N0, LoadLevel, SteadyDrive, loads_at, with_flow
from spacar.stationary.moving_tangent import MovingTangent
from spacar.stationary.resting_tangent import RestingTangent
from spacar.stationary.stationary_equations import Given, StationaryEquations
from spacar.stationary.tangent import SparseTangent


class LevelEvaluator:
    """`dynamics`, `equations`, `tangent` under the loads of the last level that was loaded.

    `y` (state vector) holds the kinematic values and the rates that non-holonomic systems keep; `hold` (nx,) are forces
    that hold a start state which is no equilibrium; they fade out until the first level is reached.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        level = LoadLevel(0.0, 0.0)
        loads = loads_at(mechanism, level)
        drive = SteadyDrive.at_level(mechanism, level)
        self.dynamics = Dynamics(with_flow(mechanism, loads), loads=loads, drive=drive)
        n = mechanism.numbering
        self.y = self.dynamics.start_values()
        if n.holonomic:
            self.y[self.dynamics.n_positions :] = 0.0
        rates = self.y[self.dynamics.n_positions :]
        self.moving = SteadyDrive.at_level(mechanism, LoadLevel(1.0, 0.0)).moving or bool(rates.any())
        self.plain = n.holonomic and not self.moving and mechanism.user_signal is None
        self.hold: Array | None = None
        self._hold_until = 1.0
        self._renew()

    def _renew(self) -> None:
        flexibility = Flexibility(self.dynamics)
        rates = self.y[self.dynamics.n_positions :]
        self.equations = StationaryEquations(self.dynamics, flexibility, self.moving, rates)
        self.sparse: SparseTangent | None = None
        self.tangent: Tangent
        if self.plain:
            self.sparse = SparseTangent(self.dynamics, flexibility)
            self.tangent = RestingTangent(self.sparse)
        else:
            self.tangent = MovingTangent(self.equations, self.mechanism.settings.stationary_type in WITHOUT_N0)

    def held_by(self, force: Array, until: float) -> None:
        """The force (nx,) acts at the start and fades until this place on the way."""
        self.hold, self._hold_until = force, until

    def load(self, level: LoadLevel) -> Given:
        """Put the loads of a level on the evaluator, and return the prescribed values. Where the flow in tubes changes,
        `dynamics`, `equations` and `tangent` are made anew."""
        loads, drive = loads_at(self.mechanism, level), SteadyDrive.at_level(self.mechanism, level)
        mechanism = with_flow(self.mechanism, loads)
        if mechanism is self.mechanism:
            law = self.dynamics.law  # the same, with another preload
            preload = np.where(np.arange(law.ne) < law.first, 0.0, loads.preload)
            self.dynamics.use(LoadedMechanism(mechanism, loads, drive, replace(law, preload=preload)))
        else:
            following = Dynamics(mechanism, loads=loads, drive=drive)
            following.kinematics.start_from(self.dynamics.kinematics)
            self.dynamics = following
            self._renew()
        if self.hold is not None:
            self.equations.held = max(0.0, 1.0 - level.path / self._hold_until) * self.hold
        return self.equations.given(self.y)

    def place(self) -> None:
        """A mechanism without dynamic degrees of freedom: the configuration of the prescribed values."""
        self.dynamics.place(0.0, self.y)
