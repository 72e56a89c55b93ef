"""Mode 1: forward kinematics and dynamics as a stream of frames."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from spacar.dynamics.array_evaluator import Dynamics
from spacar.dynamics.evaluator import Evaluator
from spacar.forward.driver import frames, watched
from spacar.frame import Frame
from spacar.integrators import METHODS, EvenTimes
from spacar.kinematics.output import TransferOutput
from spacar.stream import Run


def forward(run: Run) -> Iterator[Frame]:
    """Frames of mode 1. Raises AnalysisError; frames that were computed before stay valid."""
    output = TransferOutput(run)
    for evaluator, frame in motion(run):
        yield output.add(frame, evaluator.settled().kinematics) if output.wanted else frame


def motion(run: Run) -> Iterator[tuple[Evaluator, Frame]]:
    """Frames at the output times, and the evaluator that stands there."""
    settings = run.mechanism.settings
    evaluator = chosen(run)
    y = evaluator.start()
    run.header["condition"] = evaluator.condition()
    times = output_times(run)
    run.n_frames = len(times)
    if run.mechanism.numbering.nkddof and len(times) > 1:
        run.header["integrator"] = METHODS[settings.integrator].name
    yield from frames(evaluator, y, times, settings, run.report, watch=watched(evaluator, run.report))


def chosen(run: Run) -> Evaluator:
    """The compiled evaluator where that is possible, else that of NumPy; the header says which, and why."""
    from spacar.compiled import CompiledDynamics, level, why_general

    reason = why_general(run.mechanism)
    run.header["engine"] = ("compiled", level()) if reason is None else ("general", reason)
    return CompiledDynamics(run.mechanism) if reason is None else Dynamics(run.mechanism)


def output_times(run: Run) -> Sequence[float]:
    """t_i = i T/N, each computed when it is reached; only the initial state without TIMESTEP."""
    settings = run.mechanism.settings
    if settings.duration is None or settings.n_steps < 1:
        return (0.0,)
    return EvenTimes(0.0, settings.duration, settings.n_steps)
