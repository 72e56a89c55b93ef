"""Mode 1: forward kinematics and dynamics as a stream of frames."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from spacar.arrays import Array
from spacar.dynamics.array_evaluator import Dynamics
from spacar.dynamics.evaluator import Evaluator
from spacar.errors import AnalysisError
from spacar.forward.charts import Chart, ChartEnds, ChartWatch, tumbling_nodes
from spacar.forward.driver import at_time, frames, watched
from spacar.frame import Frame
from spacar.integrators import METHODS, EvenTimes
from spacar.integrators.times import RemainingTimes
from spacar.kinematics.output import TransferOutput
from spacar.stream import Run


def forward(run: Run) -> Iterator[Frame]:
    """Frames of mode 1. Raises AnalysisError; frames that were computed before stay valid."""
    output = TransferOutput(run)
    for evaluator, frame in motion(run, tumbling=not output.wanted):
        yield output.add(frame, evaluator.settled().kinematics) if output.wanted else frame


def motion(run: Run, tumbling: bool = False) -> Iterator[tuple[Evaluator, Frame]]:
    """Frames at the output times, and the evaluator that stands there.

    `tumbling`: Euler parameters may pass half a turn; the evaluators are then those of other coordinates, and whoever
    needs the degrees of freedom of the model (transfer functions, linearization) cannot use them.
    """
    settings = run.mechanism.settings
    evaluator = chosen(run)
    y = evaluator.start()
    run.header["condition"] = evaluator.condition()
    times = output_times(run)
    run.n_frames = len(times)
    if run.mechanism.numbering.nkddof and len(times) > 1:
        run.header["integrator"] = METHODS[settings.integrator].name
    nodes = tumbling_nodes(run.mechanism) if tumbling else ()
    if nodes and isinstance(times, EvenTimes):
        yield from _tumbling(run, evaluator, y, times, Chart.of(run.mechanism, dict.fromkeys(nodes, 1)))
    else:
        yield from frames(evaluator, y, times, settings, run.report, watch=watched(evaluator, run.report))


def _tumbling(
    run: Run, evaluator: Evaluator, y: Array, times: EvenTimes, chart: Chart
) -> Iterator[tuple[Evaluator, Frame]]:
    """The motion in as many charts as it needs, with the coordinates of the model."""
    settings, given, t, told = run.mechanism.settings, 0, times[0], False
    better = chart.suited(evaluator.placement().x)
    while True:
        if better is not None:
            at = chart.view(at_time(evaluator, t, y))
            before, chart = chart.mechanism.numbering, Chart.of(run.mechanism, better)
            y = chart.state(at, y, before)
            evaluator = chosen(replace(run, mechanism=chart.mechanism, header={}))
            evaluator.resume(chart.moving(at))
            evaluator.rhs(t, y)
            if not told:
                told = True
                node, c = next((n, c) for n, c in better.items() if c != 1)
                run.report.add(
                    f"from t = {t:.6g}: lambda{c - 1} of node {node} follows from the others instead of lambda0, as the"
                    " rotation comes near 180 degrees; the coordinates of the result stay the same"
                )
        watch = ChartWatch(chart)
        ahead = RemainingTimes(times.start, times.end, times.n, t, given) if given else times
        try:
            for i, (where, frame) in enumerate(
                frames(evaluator, y, ahead, settings, run.report, watch=watched(evaluator, run.report, watch))
            ):
                if i or not given:
                    yield where, chart.view(frame)
                    given += 1
            return
        except ChartEnds:
            pass
        except AnalysisError:
            if watch.next is None:
                raise
        t, y, better = watch.t, watch.y, watch.next


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
