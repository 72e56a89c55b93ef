"""Loads of a level put on the evaluator, with the equations and the tangent that belong to it; states of the level.

The elements and matrices of NumPy are made when something asks for them: where states are found in C
(`spacar.stationary.equilibrium`) an ordinary run asks for none of them.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import Protocol

from spacar.arrays import Array
from spacar.dynamics.array_evaluator import Dynamics
from spacar.dynamics.loaded_mechanism import LoadedMechanism
from spacar.kinematics.element_sweep import SweepArrays
from spacar.kinematics.kinematics import Kinematics
from spacar.mechanism.mechanism import Drive, Loads, Mechanism
from spacar.stationary.flexibility import Flexibility
from spacar.stationary.loading import WITHOUT_N0, LoadLevel, SteadyDrive, loads_at, with_flow
from spacar.stationary.moving_tangent import MovingTangent
from spacar.stationary.newton import Converged, Demand, newton
from spacar.stationary.resting_tangent import RestingTangent
from spacar.stationary.stability import Stability, stability
from spacar.stationary.stationary_equations import Iterate, Prescribed, StationaryEquations, Tangent
from spacar.stationary.tangent import SparseTangent


class LevelDynamics(Dynamics):
    """The evaluator of one mechanism, which goes from state to state of load levels.

    arrays  what its elements have in common with equations in C
    y       state vector: the kinematic values, and the rates that are kept
    """

    def __init__(self, mechanism: Mechanism, loads: Loads, drive: Drive) -> None:
        super().__init__(mechanism, loads=loads, drive=drive)
        self.arrays = SweepArrays.of(mechanism)
        self._at: tuple[Array, bool] | None = None  # x, and is it a solution?
        self.y = self.start_values()

    def evaluate(self, x: Array) -> None:
        """The elements at x (nx,)."""
        self._go(x, False)

    def stand_at(self, x: Array) -> None:
        """At the solution x (nx,) of the level, where the prescribed deformations are as they are given."""
        self._go(x, True)

    def prescribed(self) -> tuple[Array, Array]:
        """x (nx,), e (ne,) with the values that are prescribed, and the kinematic ones of the start."""
        x, e = self.given(self.drive.at(0.0), self.y)
        e[self.es["dynamic"]] = 0.0
        return x, e

    def _go(self, x: Array, solution: bool) -> None:
        self._at = x, solution
        if "kinematics" in vars(self):
            self._bring(self.kinematics)

    def _made(self, arrays: SweepArrays | None = None) -> Kinematics:
        found = super()._made(arrays or self.arrays)
        if self._at is not None:
            self._bring(found)
        return found

    def _bring(self, k: Kinematics) -> None:
        assert self._at is not None
        x, solution = self._at
        sweep, n = k.sweep, self.numbering
        sweep.strain(x)
        if not solution:
            return
        sweep.mass()
        given = ~n.slips
        given[self.es["input"].stop :] = False
        sweep.e[given] = self.prescribed()[1][given]  # exact, while S times the rounding of e is not small
        k.stand_at(x, sweep.e)
        if not n.nddof:
            k.factor_waiting()  # for the prediction of the next position


class LevelEvaluator:
    """`dynamics`, `equations`, `tangent` under the loads of the last level that was loaded.

    `y` (state vector) holds the kinematic values and the rates that non-holonomic systems keep; `fading_force` (nx +
    ne,), forces and misfits of deformations, holds a start which is no equilibrium, and fades on the way to the first
    level. The initial loading grows, or acts as a whole from the start on (`whole_from_start`). `evaluated`: where the
    elements have to be when they are asked for, if that is elsewhere than before.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism, self.scale = mechanism, mechanism.scale
        self.level = LoadLevel(0.0, 0.0)
        self.evaluated: Array | None = None
        self._in_place = 1.0, 0.0  # fractions of both parts of the loading that `_dynamics` has
        self.whole = SteadyDrive.at_level(mechanism, LoadLevel(1.0, 0.0))  # prescribed values of the initial loading
        self._dynamics = LevelDynamics(with_flow(mechanism, mechanism.loads), mechanism.loads, self.whole)
        n = mechanism.numbering
        rates = self._dynamics.y[self._dynamics.n_positions :]
        self.leaves_rates = bool(n.holonomic and rates.any())  # those of degrees of freedom, which do not move then
        if self.leaves_rates:
            rates[:] = 0.0
        self.moving = self.whole.moving or bool(rates.any())
        self.plain = n.holonomic and not self.moving and mechanism.user_signal is None
        self.fading_force: Array | None = None
        self._fades_until = 1.0
        self.whole_from_start = False
        self._forget()

    def _forget(self) -> None:
        """What NumPy evaluates is made when it is asked for."""
        for name in ("_equations", "sparse"):
            vars(self).pop(name, None)
        self._tangent: Tangent | None = None

    @cached_property
    def _equations(self) -> StationaryEquations:
        d = self._dynamics
        return StationaryEquations(d, Flexibility(d), self.moving, self.y[d.n_positions :])

    # -- loads --------------------------------------------------------------------------------------------------
    def set_fading_force(self, force: Array | None, until: float = 1.0) -> None:
        """From the next load on the force and the misfits (nx + ne,) act at the start and fade until this place."""
        self.fading_force, self._fades_until = force, until

    @property
    def fading_part(self) -> float:
        """The part of the fading force that acts: linear in the level, also where differences look beyond it."""
        return 0.0 if self.fading_force is None else 1.0 - self.level.path / self._fades_until

    def load(self, level: LoadLevel) -> None:
        """Go to the loads of a level. Where the flow in tubes changes, `settle` makes `dynamics`, `equations` and
        `tangent` anew."""
        self.level = level

    @property
    def acting(self) -> LoadLevel:
        """The level with the part of the initial loading that acts."""
        return self.level._replace(initial=1.0) if self.whole_from_start else self.level

    def settle(self) -> None:
        """Loads and elements as Python needs them."""
        level = self.acting
        if (level.initial, level.additional) != self._in_place:
            self._in_place = level.initial, level.additional
            self._use(loads_at(self.mechanism, level), SteadyDrive.at_level(self.mechanism, level))
        if self.evaluated is not None:
            x, self.evaluated = self.evaluated, None
            self._dynamics.evaluate(x)

    def _use(self, loads: Loads, drive: SteadyDrive) -> None:
        mechanism = with_flow(self.mechanism, loads)
        if mechanism is self.mechanism:
            law = self._dynamics.law  # the same, with another preload
            preload = loads.preload.copy()
            preload[: law.first] = 0.0
            self._dynamics.use(LoadedMechanism(mechanism, loads, drive, replace(law, preload=preload)))
        else:
            following = LevelDynamics(mechanism, loads, drive)
            following.y = self._dynamics.y
            following.kinematics.start_from(self._dynamics.kinematics)
            self._dynamics = following
            self._forget()

    @property
    def dynamics(self) -> LevelDynamics:
        self.settle()
        return self._dynamics

    @property
    def y(self) -> Array:
        return self._dynamics.y

    @property
    def equations(self) -> StationaryEquations:
        self.settle()
        q = self._equations
        held = self.fading_part
        q.held = held * self.fading_force if self.fading_force is not None and held else None
        q.user_part = self.acting.initial
        return q

    @cached_property
    def sparse(self) -> SparseTangent:
        """The sparse tangent, of what is `plain`."""
        return SparseTangent(self._dynamics, self._equations.flexibility)

    @property
    def tangent(self) -> Tangent:
        q = self.equations
        if self._tangent is None:
            without_n0 = self.mechanism.settings.stationary_type in WITHOUT_N0
            self._tangent = RestingTangent(self.sparse) if self.plain else MovingTangent(q, without_n0)
        return self._tangent

    @property
    def given(self) -> Prescribed:
        """Prescribed values of the level."""
        return Prescribed(*self.dynamics.prescribed())

    # -- what stays the same --------------------------------------------------------------------------------------
    @property
    def arrays(self) -> SweepArrays:
        """What the elements share with equations in C."""
        return self._dynamics.arrays

    @property
    def branch(self) -> Array:
        """What the branch of the next state is chosen by, (ne,)."""
        return self.arrays.branch

    def follow(self, x: Array) -> None:
        """The next state is on the branch of the one at x (nx,), which was evaluated last."""
        self.branch[:] = self.mechanism.layout.branch(x, self.arrays.e)

    @property
    def unknowns(self) -> int:
        n = self.mechanism.numbering
        prescribed = n.x_class["input"]
        return n.nx - n.x_class["calculable"].start - (prescribed.stop - prescribed.start) + n.ne

    def stand_at(self, x: Array) -> LevelDynamics:
        """`dynamics` under the loads of the level, at its solution x (nx,)."""
        self.evaluated = None
        self.settle()
        self._dynamics.stand_at(x)
        return self._dynamics

    def place(self) -> None:
        """A mechanism without dynamic degrees of freedom: the configuration of the prescribed values."""
        self.dynamics.place(0.0, self.y)


class StaticEquilibrium(Protocol):
    """The states of a load level: what a continuation asks for, in NumPy (`ArrayEquilibrium`) or in C
    (`spacar.stationary.equilibrium.CompiledEquilibrium`); `level_equilibrium` there chooses."""

    @property
    def levels(self) -> LevelEvaluator: ...
    def load(self, level: LoadLevel) -> None:
        """Put the loads of a level on the evaluator, with the fading force as it is now."""
    def newton(self, x: Array, sigma: Array, demand: Demand) -> Converged:
        """The state in equilibrium near x (nx,), sigma (ne,).

        Raises Astray, SingularMatrixError, AnalysisError of user functions.
        """
    def point(self, x: Array, sigma: Array) -> Iterate:
        """Evaluate at x (nx,), sigma (ne,). Raises SingularMatrixError as `StationaryEquations.motion`."""
    def set_state(self, p: Iterate) -> None:
        """Evaluate at a state of this level again, and factor its matrix. Raises SingularMatrixError."""
    def stability(self, p: Iterate, noise: float, regular: bool, before: Stability | None) -> Stability | None:
        """As `stability`, at a state of this level that was evaluated last."""
    def sign(self, p: Iterate, factored: bool) -> float:
        """Sign of the determinant of the tangent stiffness at a state of this level; `factored`: where the last matrix
        was factored, near it. Raises SingularMatrixError."""


class ArrayEquilibrium:
    """`StaticEquilibrium` on the equations and the tangent of NumPy."""

    def __init__(self, levels: LevelEvaluator) -> None:
        self.levels = levels

    def load(self, level: LoadLevel) -> None:
        self.levels.load(level)
        self.levels.settle()

    def newton(self, x: Array, sigma: Array, demand: Demand) -> Converged:
        v = self.levels
        return newton(v.equations, v.tangent, x, sigma, v.given, demand)

    def point(self, x: Array, sigma: Array) -> Iterate:
        return self.levels.equations.point(x, sigma, self.levels.given)

    def set_state(self, p: Iterate) -> None:
        self.levels.tangent.factor(self.point(p.x, p.sigma))

    def stability(self, p: Iterate, noise: float, regular: bool, before: Stability | None) -> Stability | None:
        return stability(self.levels.equations, self.levels.tangent, p, noise, regular, before)

    def sign(self, p: Iterate, factored: bool) -> float:
        if not factored:
            self.levels.tangent.factor(p)
        return self.levels.tangent.sign()
