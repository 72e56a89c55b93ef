"""The driver of every integrated motion: mode 1, mode 4, batches of cases.

Evaluators (`spacar.dynamics.evaluator`) know nothing of what is decided here: the tolerances, the Jacobian of the codes
that need one, what is watched after every accepted step, and how states and frames are collected at the output times.

ERROR is read as what the user wants of the result; `Method.step_error` says how much of it a step may have.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from spacar.arrays import Array
from spacar.dynamics.evaluator import Evaluator, Integrable
from spacar.dynamics.limits import Limits
from spacar.errors import AnalysisError, Report
from spacar.forward.continuity import Continuity
from spacar.frame import Frame
from spacar.integrators import METHODS, EvenTimes, integrate
from spacar.integrators.problem import Jacobian, Output
from spacar.kinematics.kinematics import CONVERGED
from spacar.kinematics.regularity import HalfTurns
from spacar.linearization.state_jacobian import state_jacobian
from spacar.mechanism.mechanism import SolverSettings

# Position tolerance of intermediate states / tolerance of a step. The velocity has an error of this order, which the
# error estimate of the integrator must not see: with 853 and ERROR 1e-10 a position tolerance of 1e-11 made a
# pendulum take 34 s instead of 1.7 s.
POSITION = 1e-3
# The same of codes that solve equations with F: what is left of the residual of the position makes accelerations of
# stiff modes that no iteration can remove (16 elements with 595: 1 Jacobian instead of 16 with 1e-11; 1e-13 is not
# better).
ITERATED = 1e-12

Times = Sequence[float] | EvenTimes | np.ndarray
Watch = Callable[[float, Array], None]


@dataclass(frozen=True)
class Tolerances:
    """Errors that a step may have, and the largest scaled correction that ends the iteration of a position."""

    atol: float
    rtol: float
    position: float

    @classmethod
    def of(cls, settings: SolverSettings, divisor: float = 1.0) -> Tolerances:
        """Those of ERROR and INTEGRAT; `divisor`: how much smaller the norm of a step is than that of a case in it."""
        method = METHODS[settings.integrator]
        atol, rtol = method.step_error(settings.atol) / divisor, method.step_error(settings.rtol) / divisor
        if method.needs_jacobian:
            return cls(atol, rtol, ITERATED)
        return cls(atol, rtol, POSITION * min(atol, rtol) if method.variable_step else CONVERGED)


@dataclass(frozen=True, slots=True)
class Integrand:
    """The `Problem` of the integrators: calls of an evaluator, with what the driver adds to them."""

    n_positions: int
    rhs: Callable[[float, Array], Array]
    stages: Callable[..., int] | None
    jacobian: Jacobian | None
    accepted: Watch | None
    rejected: Callable[[], None] | None
    by_case: tuple[int, int, int] | None
    component_name: Callable[[int], str]


def integrand(
    evaluator: Integrable, within: float, jacobian: Jacobian | None, accepted: Watch | None,
    rejected: Callable[[], None] | None = None,
) -> Integrand:  # fmt: skip
    """The evaluator with this position tolerance."""
    rhs, together = evaluator.rhs, evaluator.stages

    def stages(*step: Any) -> int:
        assert together is not None
        return together(*step, within)

    return Integrand(
        evaluator.n_positions, lambda t, y: rhs(t, y, within), together and stages, jacobian, accepted,
        rejected, evaluator.by_case, evaluator.component_name,
    )  # fmt: skip


def integrated(
    evaluator: Integrable, y: Array, times: Times, settings: SolverSettings, tolerances: Tolerances, *,
    breaks: Sequence[float] = (), watch: Watch | None = None, back: Callable[[], None] | None = None,
    jacobian: Jacobian | None = None,
) -> Iterator[Output]:  # fmt: skip
    """States at the output times, with the work done since the last one. Raises AnalysisError.

    `watch` is called after accepted steps, `back` after rejected ones.
    """
    problem = integrand(evaluator, tolerances.position, jacobian, watch, back)
    return integrate(
        problem, y, times, settings.integrator, tolerances.atol, tolerances.rtol, settings.step, breaks=breaks
    )


def frames(
    evaluator: Evaluator, y: Array, times: Times, settings: SolverSettings, report: Report, *,
    watch: Watched | None = None, divisor: float = 1.0, moved_by: Integrable | None = None,
) -> Iterator[tuple[Evaluator, Frame]]:  # fmt: skip
    """Frames of the motion that starts with y, and the evaluator that stands there.

    Their `statistics` are the counters of the integrator since the last one. `divisor` as for Tolerances; `moved_by`:
    what is integrated, if not the evaluator itself. Raises AnalysisError.
    """
    model = evaluator.model
    if not model.mechanism.numbering.nkddof or len(times) == 1:
        limits = Limits(evaluator, report)
        for t in times:
            yield evaluator, checked(evaluator, float(t), y, limits)
        return
    tolerances = Tolerances.of(settings, divisor)
    jacobian: Jacobian | None = None
    if METHODS[settings.integrator].needs_jacobian:
        jacobian = partial(state_jacobian, evaluator, within=tolerances.position)
    # Outputs are interpolated inside steps that may have passed a dead point: they follow their own path from the last
    # one, not back from the end of the step.
    shown = evaluator.companion()
    limits = Limits(shown, report)
    for out in integrated(
        moved_by or evaluator, y, times, settings, tolerances,
        breaks=model.drive.breaks, watch=watch, back=watch.back if watch else None, jacobian=jacobian,
    ):  # fmt: skip
        frame = checked(shown, float(out.t), out.y, limits)
        frame.statistics = work(out)
        yield shown, frame


def work(out: Output) -> dict[str, int]:
    """Counters of the integrator as frames have them."""
    return {
        "steps": out.n_steps, "rhs": out.n_rhs, "jacobians": out.n_jacobian,
        "rejected": out.n_rejected, "iterations": out.newton_iterations,
    }  # fmt: skip


def checked(evaluator: Evaluator, t: float, y: Array, limits: Limits) -> Frame:
    """The frame of a state whose elements, wheels and position have been looked at."""
    frame = at_time(evaluator, t, y)
    limits.check(evaluator, frame)
    return frame


def at_time(evaluator: Evaluator, t: float, y: Array) -> Frame:
    """The frame of a state; failures say the time."""
    try:
        return evaluator.frame(t, y)
    except AnalysisError as error:
        if "t = " not in str(error):
            raise AnalysisError(f"at t = {t:.9g}: {error}", error.code, **error.data) from error
        raise


# -- what is watched after every accepted step ----------------------------------------------------------------------
class Watched:
    """Half turns of nodes, and the continuity of the motion at dead points."""

    def __init__(self, evaluator: Evaluator, half_turns: HalfTurns, continuity: Continuity | None) -> None:
        self.evaluator, self.half_turns, self.continuity = evaluator, half_turns, continuity

    def __call__(self, t: float, y: Array) -> None:
        if self.half_turns.nodes:
            self.half_turns.check(t, self.evaluator.placement().x)
        if self.continuity is not None:
            try:
                self.continuity.check(t, y)
            except AnalysisError:
                # A beam that is bent too far for one element is the cause rather than the choice of coordinates.
                Limits(self.evaluator, Report()).check(self.evaluator, self.evaluator.frame(t, y))
                raise

    def back(self) -> None:
        """After a rejected step: its last stages may stand on another branch."""
        if self.continuity is not None and self.continuity.steps:
            self.evaluator.resume(self.continuity.steps[-1].at)


def watched(evaluator: Evaluator, report: Report) -> Watched | None:
    """What is watched after every accepted step; None where there is nothing."""
    mechanism, matrix = evaluator.model.mechanism, evaluator.position_matrix()
    half_turns, settings = HalfTurns(mechanism.numbering), mechanism.settings
    continuity = Continuity(evaluator, matrix, report, (settings.atol, settings.rtol)) if len(matrix.columns) else None
    return Watched(evaluator, half_turns, continuity) if half_turns.nodes or continuity is not None else None
