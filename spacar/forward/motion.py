"""Mode 1: forward kinematics and dynamics as a stream of frames.

ERROR is read as what the user wants of the result; `Method.step_error` says how much of it a step may have.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial

from spacar.arrays import Array
from spacar.dynamics.dynamics import Dynamics
from spacar.dynamics.limits import Limits
from spacar.errors import AnalysisError, Report
from spacar.frame import Frame
from spacar.integrators import METHODS, EvenTimes, integrate
from spacar.kinematics.output import TransferOutput
from spacar.kinematics.regularity import DeadPoints, HalfTurns
from spacar.linearization.jacobian import state_jacobian
from spacar.stream import Run

# Position tolerance of intermediate states / tolerance of a step. The velocity has an error of this order, which the
# error estimate of the integrator must not see: with 853 and ERROR 1e-10 a position tolerance of 1e-11 made a
# pendulum take 34 s instead of 1.7 s.
POSITION = 1e-3
# The same of codes that solve equations with F: what is left of the residual of the position makes accelerations of
# stiff modes that no iteration can remove (16 elements with 595: 1 Jacobian instead of 16 with 1e-11; 1e-13 is not
# better).
ITERATED = 1e-12


def forward(run: Run) -> Iterator[Frame]:
    """Frames of mode 1. Raises AnalysisError; frames that were computed before stay valid."""
    output = TransferOutput(run)
    limits: Limits | None = None
    for dynamics, t, y, statistics in states(run):
        limits = limits or Limits(dynamics, run.report)
        frame = at_time(dynamics, t, y)
        limits.check(dynamics, frame)
        frame.statistics = statistics
        if output.wanted:
            dynamics.settle()
        yield output.add(frame, dynamics.kinematics)


def states(run: Run) -> Iterator[tuple[Dynamics, float, Array, dict[str, int]]]:
    """The states at the output times, with the counters of the integrator since the last one."""
    settings = run.mechanism.settings
    dynamics = evaluator(run)
    y = dynamics.start()
    run.header["condition"] = dynamics.condition()
    dynamics.accepted = watch(dynamics)
    times = output_times(run)
    run.n_frames = len(times)
    if not run.mechanism.numbering.nkddof or len(times) == 1:
        for t in times:
            yield dynamics, float(t), y, {}
        return
    run.header["integrator"] = METHODS[settings.integrator].name
    method = METHODS[settings.integrator]
    atol, rtol = method.step_error(settings.atol), method.step_error(settings.rtol)
    if method.needs_jacobian:
        dynamics.jacobian = partial(state_jacobian, dynamics)
        dynamics.kinematics.converged = ITERATED
    elif method.variable_step:
        dynamics.kinematics.converged = POSITION * min(atol, rtol)
    # Outputs are interpolated inside steps that may have passed a dead point: they follow their own path from the last
    # one, not back from the end of the step.
    shown = dynamics.companion()
    for out in integrate(
        dynamics, y, times, settings.integrator, atol, rtol, settings.step, breaks=dynamics.drive.breaks
    ):
        statistics = {
            "steps": out.n_steps, "rhs": out.n_rhs, "jacobians": out.n_jacobian,
            "rejected": out.n_rejected, "iterations": out.newton_iterations,
        }  # fmt: skip
        yield shown, float(out.t), out.y, statistics


def evaluator(run: Run) -> Dynamics:
    """The general evaluator, or the compiled one when the run asks for it and the mechanism allows it."""
    if not run.mechanism.settings.compiled:
        return Dynamics(run.mechanism)
    from spacar.compiled import CompiledDynamics, why_not

    reason = why_not(run.mechanism)
    if reason:
        run.report.add(f"warning: not compiled: {reason}")
        return Dynamics(run.mechanism)
    return CompiledDynamics(run.mechanism)


def watch(dynamics: Dynamics) -> Callable[[float, Array], None] | None:
    """What is checked after every accepted step."""
    half_turns, dead_points = HalfTurns(dynamics.kinematics), DeadPoints(dynamics.position_matrix())
    if not half_turns.nodes and not dead_points.watches:
        return None

    def check(t: float, y: Array) -> None:
        if half_turns.nodes:
            dynamics.settle()
            half_turns.check(t, y)
        if dead_points.watches:
            try:
                dead_points.check(t)
            except AnalysisError:
                # A beam that is bent too far for one element is the cause rather than the choice of coordinates.
                Limits(dynamics, Report()).check(dynamics, dynamics.frame(t, y))
                raise

    return check


def output_times(run: Run) -> Sequence[float]:
    """t_i = i T/N, each computed when it is reached; only the initial state without TIMESTEP."""
    settings = run.mechanism.settings
    if settings.duration is None or settings.n_steps < 1:
        return (0.0,)
    return EvenTimes(0.0, settings.duration, settings.n_steps)


def at_time(dynamics: Dynamics, t: float, y: Array) -> Frame:
    """The frame of a state; failures say the time."""
    try:
        return dynamics.frame(t, y)
    except AnalysisError as error:
        if "t = " not in str(error):
            raise AnalysisError(f"at t = {t:.9g}: {error}", error.code, **error.data) from error
        raise
