"""The contract of evaluators.

A loaded mechanism never changes. An evaluator follows one motion of it: it remembers the configuration of the last
state that it evaluated, because a position has several solutions and the one near the last is meant. That memory is all
its state; it can be read (`placement`) and handed on. An evaluator knows nothing of tolerances, output times, Jacobians
or what is watched: the driver (`spacar.forward.driver`) does, and hands them over with every call.

What the driver integrates is a `RightHandSide`: F(t, y), the position solved to `within`; batches of cases have no
more. `spacar.dynamics.Dynamics` (NumPy) and `spacar.compiled.CompiledDynamics` (C) are an `Evaluator`, and
`tests/dynamics/test_evaluators.py` compares them.
"""

from __future__ import annotations

from typing import Any, Protocol

from spacar.arrays import Array
from spacar.dynamics.array_evaluator import Dynamics
from spacar.dynamics.loaded_mechanism import LoadedMechanism, Moving, Placement
from spacar.frame import Frame
from spacar.kinematics.regularity import PositionMatrix


class RightHandSide(Protocol):
    """What the driver integrates."""

    @property
    def n_positions(self) -> int:
        """How many components of the state are positions; the others are rates."""

    def rhs(self, t: float, y: Array, within: float = ...) -> Array:
        """Time derivative of the state. `within`: largest scaled correction that ends Newton's iteration."""

    @property
    def blocks(self) -> Any:
        """What makes many stages, steps or outputs in one call, None: they are asked one by one. A BlockEvaluator whose
        `stepper(monitor, output_block)` is a Stepper, and whose `output_block(times, ground, singular, far)` evaluates
        outputs (`spacar.compiled`)."""

    @property
    def by_case(self) -> tuple[int, int, int] | None:
        """Shape (blocks, components, lanes) of a state of many cases, see `spacar.integrators.problem.Problem`."""

    def component_name(self, i: int) -> str:
        """Name of a component of the state, for messages."""


class Evaluator(RightHandSide, Protocol):
    """Follows one motion of a loaded mechanism, and tells of its states. AnalysisError of any call says what cannot be
    evaluated and why."""

    @property
    def model(self) -> LoadedMechanism: ...

    # -- where it stands ------------------------------------------------------------------------------------------
    def start(self) -> Array:
        """The start state; the mechanism is brought there from the reference configuration. Raises AnalysisError
        'dynamics.singular-mass' too when a degree of freedom carries no mass.
        """

    @property
    def doubt(self) -> str | None:
        """What the log warns of after `start`: inertia that may be rounding."""

    def placement(self) -> Placement:
        """Configuration and velocity of the last evaluated state."""

    def moving(self) -> Moving | None:
        """The last evaluated state with its accelerations; None where they are not known."""

    def resume(self, at: Moving) -> None:
        """Go on from there: the next evaluations begin with its expansion, as if nothing had come after it."""

    def numpy_evaluator(self) -> Dynamics:
        """The NumPy evaluator at the last evaluated state, for linearization, transfer functions, diagnoses; holds
        until the next call of this evaluator."""

    def fork(self, independent: bool = ...) -> Evaluator:
        """Another evaluator of the same model, which follows its own path from the present configuration.
        `independent`: it shares nothing (factors, expansions) that this one could feel; else only
        this one's results stay the same to `within`.
        """

    # -- what is stored of a state and checked there: of the last evaluated one where none is named ---------------
    @property
    def iterations(self) -> int:
        """How many Newton iterations the position of the last frame took."""

    def frame(self, t: float, y: Array) -> Frame:
        """Everything that is stored of a state."""

    def condition(self) -> float:
        """Condition number of V[E, U] at the last evaluated state; infinite when singular."""

    def position_matrix(self) -> PositionMatrix:
        """V[E, U], always that of the last evaluated state."""

    def in_range(self) -> bool:
        """Whether it is known already that all elements are in the range of their theory; else ask them."""

    def sample(self) -> None:
        """From now on derivatives keep what `sampled` gives."""

    def sampled(self) -> tuple[float, bool]:
        """The logarithm of the smallest |det V[E, U]| of the derivatives since the last call (infinite: none), and
        whether its sign has changed among them.
        """
