"""What an integrator needs from a problem and what it gives back: protocol, records and the counted evaluation."""

from collections.abc import Callable, Iterator, Sequence
from math import isfinite
from typing import Any, NamedTuple, Protocol

import numpy as np

from spacar.errors import AnalysisError

Jacobian = Callable[[float, np.ndarray], tuple[Any, np.ndarray]]
Rate = Callable[[float, np.ndarray], np.ndarray]


class Counts(NamedTuple):
    """Work done: accepted and rejected steps, evaluations of F and of its Jacobian, Newton iterations."""

    n_steps: int = 0
    n_rhs: int = 0
    n_jacobian: int = 0
    n_rejected: int = 0
    newton_iterations: int = 0


class BlockEvaluator(Protocol):
    """Evaluates F at all stages of a step in one call; `within` as `Problem.within`."""

    def stages(
        self, done: int, c: np.ndarray, a: np.ndarray, t: float, h: float, window: tuple[float, float], y: np.ndarray,
        K: np.ndarray, within: float,
    ) -> int:  # fmt: skip
        """F(t + c_i h, y + h a_i K) into the rows i of K from `done` on, at times clipped to the window. Returns the
        first row that it could not do; that one is then asked from `rhs`, which says why."""

    def newton(self, method: Any) -> tuple[bool, float, float] | None:
        """Makes the Newton iteration of the step of a method 553 or 595 from the guess in `method.Z`. Returns whether
        it converged, size and contraction of the last change; None when it cannot."""


class Stepper(Protocol):
    """Takes the steps of codes 0, 135, 155 and 853 itself, with what `accepted` and `rejected` do. `output_block`:
    passes outputs too, many in a call; None: a call ends at each."""

    @property
    def output_block(self) -> Any: ...

    def steps(self, method: Any, t: float, t_end: float, h: float, longest: float) -> "Iterator[Step]":
        """Yields the steps with an output, or the last of many with the outputs in all of them."""


class Problem:
    """First-order problem dy/dt = F(t, y) with y = (positions, velocities), shape (n,), n_positions of them positions.

    Positions include the kinematic coordinates of a non-holonomic system; the second-order codes 220 and 225
    need `len(y) == 2 * n_positions`. `rhs` may return the same array at every call: integrators copy what
    they keep. It must neither change nor keep the `y` it is given. What a problem does not have stays as it is here.

    jacobian   (t, y) -> (dF/dy, dF/dt), shapes (n, n), or a sparse form (`resolvent`), and (n,); implicit codes need it
    by_case    the shape (blocks, components, lanes) of a state of many cases, each of which keeps the tolerance
               (Runge-Kutta codes)
    may_jump   whether F may jump at times that are not told as `breaks` (`Jumps` of `drive`)
    within     tolerance of iterations inside F, which `blocks` and `stepper` are given
    """

    n_positions: int
    jacobian: Jacobian | None = None
    blocks: BlockEvaluator | None = None
    stepper: Stepper | None = None
    by_case: tuple[int, int, int] | None = None
    may_jump = False
    within = 0.0

    def rhs(self, t: float, y: np.ndarray) -> np.ndarray:
        """F(t, y), shape (n,)."""
        raise NotImplementedError

    def rhs_for_differences(self) -> Rate:
        """F to rounding, without a trace in the problem."""
        return self.rhs

    def component_name(self, i: int) -> str:
        """State component i in words; empty: it has its number only."""
        return ""

    def settle(self, t: float, y: np.ndarray) -> None:
        """At the end of a step whose last evaluation was elsewhere, before `accepted`."""

    def accepted(self, t: float, y: np.ndarray) -> None:
        """After each accepted step; a problem can update its branch memory."""

    def rejected(self) -> None:
        """After each rejected step; a problem goes back to that memory."""

    def switched(self, t: float, code: int, omega: float | None) -> None:
        """The automatic method goes on with another code; omega is given when 595 is kept."""


class IntegrationStatistics:
    """The `Counts` so far."""

    def __init__(self) -> None:
        self.n_steps = self.n_rhs = self.n_jacobian = self.n_rejected = self.newton_iterations = 0

    def counts(self) -> Counts:
        return Counts(**vars(self))


class BlockOfOutputs(NamedTuple):
    """Outputs that the problem has passed in steps of its own, the last one at `t` with the state `y`, shape (n,): the
    work since the output before each, shape (outputs, 5) in the order of `Counts`, what had been counted where that of
    the first one begins (`begun`) and at the last one (`now`), and what the problem has made of them."""

    t: float
    y: np.ndarray
    work: np.ndarray
    begun: Counts
    now: Counts
    shown: Any


class Output(NamedTuple):
    """State `y`, shape (n,), at the output time `t`, and the work done since the previous output. Or the last of many
    outputs that were `passed` together, and the work since the one before them; of each they have its own."""

    t: float
    y: np.ndarray
    work: Counts
    passed: BlockOfOutputs | None = None


class Step(NamedTuple):
    """An accepted step to `t`; `y` and `interpolate` are valid until the integrator is asked for the next
    step. `sizes` of the step before it and of its own are told where other steps than the last one may lie behind.
    `passed`: the outputs that have been passed since the last one; None: those up to `t` are to be interpolated."""

    t: float
    y: np.ndarray
    interpolate: Callable[[float], np.ndarray]
    sizes: tuple[float, float] | None = None
    passed: Sequence[BlockOfOutputs] | None = None


class Tolerance(NamedTuple):
    """Absolute and relative error, ERROR positions 1 and 2; the weight of y_i is `relative * |y_i| +
    absolute`, the absolute one (n,) or the same for all."""

    absolute: float | np.ndarray
    relative: float


class Evaluation:
    """Counted, checked access to a problem inside the time window [first, last].

    Times are clipped to the window. So nothing is evaluated beyond the last time, and the values next to a
    discontinuity are those of the side on which the integrator works. Raises AnalysisError
    `integrator.not-finite` when F has an infinite or undefined component.
    """

    def __init__(self, problem: Problem, first: float, last: float) -> None:
        self.problem = problem
        self.statistics = IntegrationStatistics()
        self.first = first
        self.last = last
        self.rhs_of, self.jacobian_of = problem.rhs, problem.jacobian
        self.blocks, self.stepper = problem.blocks, problem.stepper
        # `Jumps` of `drive`: difference above which a stepper does not pass an output, whether one was left
        self.suspect, self.suspected = 0.0, False
        self.times: Sequence[float] | np.ndarray = (first, last)
        # Accepted steps after which a stepper gives way at the next output, to whoever looks at the steps.
        self.halt = float("inf")
        self.next = 0

    def next_output(self, t: float) -> int:
        """Number of the first output after t, the last one at most; it never goes back."""
        last = len(self.times) - 1
        while self.next < last and self.times[self.next] <= t:
            self.next += 1
        return self.next

    def rhs(self, t: float, y: np.ndarray) -> np.ndarray:
        """F at the clipped time, shape (n,)."""
        self.statistics.n_rhs += 1
        t = min(max(t, self.first), self.last)
        f = self.rhs_of(t, y)
        # One dot product finds every inf and nan; only when it is not finite does the exact check run.
        if not isfinite(f.dot(f)) and not np.isfinite(f).all():
            i = int(np.flatnonzero(~np.isfinite(f))[0])
            text = f"the derivative of {self.name(i)} is {f[i]} at t = {t:.9g} s"
            raise AnalysisError(text, "integrator.not-finite", t=t, component=i)
        return f

    def jacobian(self, t: float, y: np.ndarray) -> tuple[Any, np.ndarray]:
        """(dF/dy, dF/dt) at the clipped time."""
        self.statistics.n_jacobian += 1
        assert self.jacobian_of is not None  # `integrate` has asked
        return self.jacobian_of(min(max(t, self.first), self.last), y)

    def step_accepted(self, t: float, y: np.ndarray) -> None:
        """Counts a step and tells the problem about it."""
        self.statistics.n_steps += 1
        self.problem.accepted(t, y)

    def step_rejected(self) -> None:
        """Counts a step that is tried again, and tells the problem that its state is the last accepted one."""
        self.statistics.n_rejected += 1
        self.problem.rejected()

    def name(self, i: int) -> str:
        number, name = f"state component {i}", self.problem.component_name(i)
        return f"{name} ({number})" if name else number
