"""The driver of every integrated motion: mode 1, mode 4, batches of cases.

Evaluators (`spacar.dynamics.evaluator`) know nothing of what is decided here: the tolerances, the Jacobian of the codes
that need one, what is watched after every accepted step, and how states and frames are collected at the output times.

A step may err by STEP times ERROR, for every code alike (reference/theory-system.md section 9); the absolute part of a
deformation is measured by the displacement that it causes (`spacar.forward.displaced`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Protocol

import numpy as np

from spacar.arrays import Array
from spacar.dynamics.evaluator import Evaluator, RightHandSide
from spacar.dynamics.limits import Limits
from spacar.dynamics.loaded_mechanism import LoadedMechanism
from spacar.errors import AnalysisError, Report
from spacar.forward.accepted_steps import FAR, SingularityMonitor, StepHistory, at_time, fail_at
from spacar.forward.displaced import displaced
from spacar.frame import Frame, FramesInRows
from spacar.integrators import AUTOMATIC, METHODS, EvenTimes, integrate
from spacar.integrators.problem import BlockOfOutputs, Jacobian, Problem, Stepper
from spacar.kinematics.kinematics import CONVERGED
from spacar.mechanism.mechanism import Polynomial, SolverSettings
from spacar.stream import Run

# Tolerance of one step / ERROR, for every code with variable steps alike. Errors of the steps add up, and the watch of
# dead points takes the degrees of freedom as known to ERROR: a hundred steps may err to the same side.
STEP = 0.01
# Position tolerance of intermediate states / tolerance of a step. The velocity has an error of this order, which the
# error estimate of the integrator must not see, and stiff beams make accelerations of what is left of a position: with
# 1e-3 a four-bar and a crank with eight beams took 1.4 and 1.5 times as many steps as with 1e-5, which costs rigid
# models 0 to 5 % (docs/performance.md).
POSITION = 1e-5
# The same of codes that solve equations with F: what is left of the residual of the position makes accelerations of
# stiff modes that no iteration can remove (16 elements with 595: 1 Jacobian instead of 16 with 1e-11; 1e-13 is not
# better).
ITERATED = 1e-12

WORK = ("steps", "rhs", "jacobians", "rejected", "iterations")  # `Counts` of the integrators, as frames have them

Times = Sequence[float] | EvenTimes | np.ndarray


@dataclass(frozen=True)
class Tolerances:
    """Errors that a step may have, and the largest scaled correction that ends the iteration of a position.

    atol   of every component of the state (n,), or the same for all
    """

    atol: float | Array
    rtol: float
    position: float

    @classmethod
    def of(cls, settings: SolverSettings, g: Array | None = None) -> Tolerances:
        """Those of ERROR and INTEGRAT; `g` (n,): displacement that a component causes, where it is not 1."""
        method = METHODS[settings.integrator]
        share = STEP if method.variable_step else 1.0
        atol, rtol = share * settings.atol, share * settings.rtol
        each = atol if g is None or not method.variable_step else atol / g
        if method.needs_jacobian:
            return cls(each, rtol, ITERATED)
        return cls(each, rtol, POSITION * min(atol, rtol) if method.variable_step else CONVERGED)


class AcceptedSteps(Protocol):
    """Whom an integration tells of its steps; a rejected one leads the evaluator back to the last accepted one, as a
    stage of a step that is too long may have led it far away."""

    def accepted(self, t: float, y: Array) -> None: ...
    def rejected(self) -> None: ...


class Integrand(Problem):
    """What the integrators see: calls of an evaluator, with what the driver adds to them.

    `within`: position tolerance; `report`: where it is said that the method has changed; `trail`: `steps` of a motion
    that may change it.
    """

    def __init__(
        self, evaluator: RightHandSide, steps: AcceptedSteps, within: float, stepper: Stepper | None = None, *,
        trail: StepHistory | None = None, jacobian: Jacobian | None = None, report: Report | None = None,
        may_jump: bool = False,
    ) -> None:  # fmt: skip
        self.n_positions, self.by_case = evaluator.n_positions, evaluator.by_case
        self._rhs, self.blocks, self.stepper = evaluator.rhs, evaluator.blocks, stepper
        self.component_name = evaluator.component_name  # type: ignore[method-assign]
        self.accepted, self.rejected = steps.accepted, steps.rejected  # type: ignore[method-assign]
        self.jacobian, self.may_jump = jacobian, may_jump
        self.within = self.usual = within
        self.report = report or Report()
        self.said = False  # that a method for stiff models has been kept
        self.trail = self.starting = trail
        self.continuity = None if trail is None else trail.continuity

    def rhs(self, t: float, y: Array) -> Array:
        f = self._rhs(t, y, self.within)
        if self.starting is not None:  # every code asks the start state first
            self.starting.started(t, y)
            self.starting = None
        return f

    def settle(self, t: float, y: Array) -> None:
        if self.trail is not None and self.trail.watch is not None:
            self.rhs(t, y)

    def rhs_for_differences(self) -> Callable[[float, Array], Array]:
        """F with a position that is exact enough for differences, by an evaluator that leaves this one where it is."""
        assert self.trail is not None  # without it there is no Jacobian, and nobody asks
        return partial(self.trail.evaluator.fork(independent=True).rhs, within=ITERATED)

    def switched(self, t: float, code: int, omega: float | None) -> None:
        """The automatic method goes on with another code: kept when `omega` is given, tried or left when not."""
        implicit = METHODS[code].needs_jacobian
        self.within = ITERATED if implicit else self.usual
        if self.continuity is not None:
            self.continuity.resolved = not implicit
        if omega is not None:
            self.report.add(
                f"from t = {t:.9g}: INTEGRAT {code} ({METHODS[code].name}), as the highest vibration or decay of the"
                f" model ({omega:.3g} rad/s) limits the steps of an explicit method; positions keep ERROR,"
                " velocities and accelerations of vibrations that it passes over do not (INTEGRAT 0 follows them)"
            )
            self.said = True
        elif self.said and not implicit:
            self.said = False
            self.report.add(
                f"from t = {t:.9g}: INTEGRAT {code} ({METHODS[code].name}) again, as the motion itself has become as"
                " fast as what was passed over"
            )


def frames(
    run: Run, evaluator: Evaluator, y: Array, times: Times, *, watch: SingularityMonitor | None = None,
    standing: bool = True,
) -> Iterator[tuple[Evaluator, Sequence[Frame]]]:  # fmt: skip
    """Frames of the motion that starts with y, one by one, and the evaluator that stands there; where nobody needs it
    `standing` there, in blocks of outputs that are passed together.

    Their `statistics` are the counters of the integrator since the last one. Raises AnalysisError.
    """
    model, settings, report = evaluator.model, run.mechanism.settings, run.report
    if not model.mechanism.numbering.nkddof or len(times) == 1:
        limits = Limits(evaluator, report)
        if not standing and evaluator.blocks is not None:
            block = evaluator.blocks.output_block(times, limits.wheels.rows, limits.matrix.zero)
            for at in block.prescribed(y):
                placed = checked_frames(evaluator, at, limits)
                iterations = at.work[:, 4:]
                if iterations[-1] < 0:  # C could not place it
                    iterations[-1] = evaluator.iterations
                placed.statistics = dict(zip(WORK[4:], iterations.T, strict=True))
                yield evaluator, placed
            return
        for t in times:
            frame = checked(evaluator, float(t), y, limits)
            frame.statistics = {WORK[4]: evaluator.iterations}
            yield evaluator, (frame,)
        return
    tolerances = Tolerances.of(settings, displaced(evaluator))
    jacobian: Jacobian | None = None
    if METHODS[settings.integrator].needs_jacobian or (settings.integrator == AUTOMATIC and has_forces(model)):
        jacobian = partial(_jacobian, evaluator)
    # Outputs are interpolated inside steps that may have passed a dead point: they are placed from the start of their
    # step or the last output in it, not back from its end.
    shown = evaluator.fork()
    limits = Limits(shown, report)
    trail = StepHistory(evaluator, watch, run.require_time)
    breaks = (*model.drive.breaks, *getattr(model.mechanism.user_signal, "breaks", ()))
    may_jump = not breaks and (model.mechanism.user_signal is not None or not isinstance(model.drive, Polynomial))
    stepper: Stepper | None = None
    output_block = None
    if evaluator.blocks is not None:
        one_by_one = may_jump and settings.integrator not in (0, AUTOMATIC)  # C looks for jumps in steps of Adams only
        if not (standing or one_by_one) and shown.blocks is not None:
            output_block = shown.blocks.output_block(times, limits.wheels.rows, limits.matrix.zero, FAR)
        stepper = evaluator.blocks.stepper(trail, output_block)
    problem = Integrand(
        evaluator, trail, tolerances.position, stepper, trail=trail, jacobian=jacobian, report=report, may_jump=may_jump
    )
    outputs = integrate(
        problem, y, times, settings.integrator, tolerances.atol, tolerances.rtol, settings.step, breaks=breaks
    )
    try:
        for out in outputs:
            if out.passed is not None:
                block = checked_frames(shown, out.passed, limits)
                block.statistics = dict(zip(WORK, out.passed.work.T, strict=True))
                yield shown, block
            else:
                trail.lead(shown)
                frame = checked(shown, float(out.t), out.y, limits)
                frame.statistics = dict(zip(WORK, out.work, strict=True))
                yield shown, (frame,)
    except AnalysisError as error:
        trail.ended(error)
        raise
    finally:
        trail.elsewhere = None
    if trail.continuity is not None:
        trail.continuity.finish()


def _jacobian(evaluator: Evaluator, t: float, y: Array) -> tuple[Array, Array]:
    """(dF/dy, dF/dt), which most runs do not ask for."""
    from spacar.linearization.state_jacobian import state_jacobian

    return state_jacobian(evaluator, t, y, within=ITERATED)


def has_forces(model: LoadedMechanism) -> bool:
    """Whether anything can make a vibration or a decay that is faster than the motion: stresses or forces that depend
    on the state. A rigid mechanism has none, and no method for stiff models is looked for."""
    return not model.law.passive or model.mechanism.user_signal is not None


def checked(evaluator: Evaluator, t: float, y: Array, limits: Limits) -> Frame:
    """The frame of a state whose elements, wheels and position have been looked at."""
    frame = at_time(evaluator, t, y)
    limits.check(evaluator, frame)
    return frame


def checked_frames(evaluator: Evaluator, passed: BlockOfOutputs, limits: Limits) -> FramesInRows:
    """The frames of outputs that were passed together: those that nobody has to look at, or what gives a single one."""
    shown: FramesInRows | Callable[[], FramesInRows] = passed.shown
    if isinstance(shown, FramesInRows):
        if len(limits.wheels.rows):
            limits.wheels.press(shown.variables["sig"][:, limits.wheels.rows].min(axis=0)[:, None])
        return shown
    try:
        block = shown()
    except AnalysisError as error:
        fail_at(passed.t, error)
    limits.check(evaluator, block[0])
    return block
