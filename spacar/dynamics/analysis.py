"""Mode 1: forward kinematics and dynamics as a stream of frames."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from spacar.dynamics.dynamics import Dynamics
from spacar.dynamics.limits import Limits
from spacar.errors import AnalysisError
from spacar.frame import Frame
from spacar.integrators import METHODS, integrate
from spacar.kinematics.output import TransferOutput
from spacar.mechanism.mechanism import Array
from spacar.modes import Run


def forward(run: Run) -> Iterator[Frame]:
    """Frames of mode 1. Raises AnalysisError; frames that were computed before stay valid."""
    output = TransferOutput(run)
    limits: Limits | None = None
    for dynamics, t, y, statistics in states(run):
        limits = limits or Limits(dynamics, run.report)
        frame = at_time(dynamics, t, y)
        limits.check(dynamics, frame)
        frame.statistics = statistics
        yield output.add(frame, dynamics.kinematics)


def states(run: Run) -> Iterator[tuple[Dynamics, float, Array, dict[str, float]]]:
    """The states at the output times, with the counters of the integrator since the last one."""
    settings = run.mechanism.settings
    dynamics = Dynamics(run.mechanism)
    y = dynamics.start()
    run.header["condition"] = dynamics.kinematics.condition()
    times = output_times(run)
    run.n_frames = len(times)
    if not run.mechanism.numbering.nkddof or len(times) == 1:
        for t in times:
            yield dynamics, float(t), y, {}
        return
    run.header["integrator"] = METHODS[settings.integrator].name
    for out in integrate(
        dynamics, y, times, settings.integrator, settings.atol, settings.rtol, settings.step, breaks=dynamics.drive.breaks
    ):
        statistics = {
            "steps": out.n_steps, "rhs": out.n_rhs, "jacobians": out.n_jacobian,
            "rejected": out.n_rejected, "iterations": out.newton_iterations,
        }  # fmt: skip
        yield dynamics, float(out.t), out.y, statistics


def output_times(run: Run) -> Array:
    """t_i = i T/N; only the initial state without TIMESTEP."""
    settings = run.mechanism.settings
    if settings.duration is None or settings.n_steps < 1:
        return np.zeros(1)
    return np.linspace(0.0, settings.duration, settings.n_steps + 1)


def at_time(dynamics: Dynamics, t: float, y: Array) -> Frame:
    """The frame of a state; failures say the time."""
    try:
        return dynamics.frame(t, y)
    except AnalysisError as error:
        if "t = " not in str(error):
            raise AnalysisError(f"at t = {t:.9g}: {error}", error.code, **error.data) from error
        raise
