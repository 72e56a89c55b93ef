"""Mode 1: forward kinematics and dynamics as a stream of frames.

`Extent` tells whether ERROR is small beside the motion. ERROR has one absolute part for lengths [m] and rotations
[rad]. Its default 1e-5 suits mechanisms that move by centimetres; a resonator that moves by 1e-7 m is lost in it. Of
each kind that the state contains, the largest span over the output times of a coordinate or of a deformation in the
state counts. A span below ROUNDED is rest.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from spacar.arrays import EPS, Array
from spacar.dynamics.array_evaluator import Dynamics
from spacar.dynamics.evaluator import Evaluator
from spacar.dynamics.loaded_mechanism import Moving
from spacar.errors import AnalysisError, Report
from spacar.forward.accepted_steps import at_time, singularity_monitor
from spacar.forward.charts import Chart, ChartEnds, ChartWatch, tumbling_nodes
from spacar.forward.driver import frames
from spacar.frame import Frame, StoredFrames
from spacar.integrators import METHODS, EvenTimes
from spacar.integrators.times import RemainingTimes
from spacar.kinematics.transfer import TransferOutput
from spacar.mechanism import Mechanism
from spacar.mechanism.numbering import Numbering
from spacar.stream import Run

OWN = 1e-6  # |lambda0| of a node below which its degrees of freedom have no digits: eps/lambda0^2 = 2e-4
DEGREES_LOSE = 1e-4  # below it what is linear in them is known to less than the usual ERROR, 2e-8
UNITS = {"lengths": "m", "rotations": "rad"}
LARGEST = 0.01  # ERROR over the largest motion of its kind, above which the run is warned of
ROUNDED = 1e4 * EPS  # of the size of the model, or of a radian


def forward(run: Run) -> Iterator[Sequence[Frame]]:
    """Frames of mode 1. Raises AnalysisError; frames that were computed before stay valid."""
    output = TransferOutput(run)
    for evaluator, block in motion(run, own=output.wanted):
        yield [output.add(frame, evaluator.numpy_evaluator().kinematics) for frame in block] if output.wanted else block


def motion(run: Run, own: bool = True) -> Iterator[tuple[Evaluator, Sequence[Frame]]]:
    """Blocks of frames at the output times, and the evaluator that stands at the last of them.

    Euler parameters may pass half a turn. The evaluators are then those of other coordinates, unless whoever asks needs
    the degrees of freedom of the model (transfer functions, linearization): with `own` they are of that model, and
    each block is one frame.
    """
    settings = run.mechanism.settings
    evaluator = chosen(run)
    y = evaluator.start()
    if evaluator.doubt:
        run.report.add(f"warning: {evaluator.doubt}")
    run.header["condition"] = evaluator.condition()
    times = output_times(run)
    run.n_frames = len(times)
    if not run.mechanism.numbering.nkddof or run.n_frames == 1:
        yield from frames(run, evaluator, y, times, standing=own)
        return
    run.header["integrator"] = METHODS[settings.integrator].name
    extent = Extent(run.mechanism)
    for where, block in _moved(run, evaluator, y, times, own):
        extent.take(block)
        yield where, block
    extent.tell(run.report)


def _moved(
    run: Run, evaluator: Evaluator, y: Array, times: Sequence[float], own: bool
) -> Iterator[tuple[Evaluator, Sequence[Frame]]]:
    nodes = tumbling_nodes(run.mechanism)
    if nodes and isinstance(times, EvenTimes):
        moved = _tumbling(run, evaluator, y, times, Chart.of(run.mechanism, dict.fromkeys(nodes, 1)), own)
        yield from _at_home(run, moved, nodes) if own else moved
    else:
        watch = singularity_monitor(evaluator, run.report)
        try:
            yield from frames(run, evaluator, y, times, watch=watch, standing=own)
        except AnalysisError as error:
            if error.code != "position.singular":
                raise
            from spacar.kinematics.failure import other_release

            advice = other_release(run.mechanism, evaluator.placement().x)
            if not advice:
                raise
            raise AnalysisError(f"{error}{advice}", error.code, **error.data) from None


def _tumbling(
    run: Run, evaluator: Evaluator, y: Array, times: EvenTimes, chart: Chart, own: bool
) -> Iterator[tuple[Evaluator, Sequence[Frame]]]:
    """The motion in as many charts as it needs, with the coordinates of the model."""
    given, t, told = 0, times[0], False
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
            looked = singularity_monitor(evaluator, run.report, watch)
            again = bool(given)  # the first frame is the start, which has been given
            for where, block in frames(run, evaluator, y, ahead, watch=looked, standing=own):
                new = block[1:] if again else block
                again = False
                if len(new):
                    yield where, chart.views(new)
                    given += len(new)
            return
        except ChartEnds:
            pass
        except AnalysisError:
            if watch.next is None:
                raise
        t, y, better = watch.t, watch.y, watch.next


def _at_home(
    run: Run, moved: Iterator[tuple[Evaluator, Sequence[Frame]]], nodes: Sequence[int]
) -> Iterator[tuple[Evaluator, Sequence[Frame]]]:
    """The frames, one by one, each with an evaluator of the model's own degrees of freedom, where these exist.

    Raises AnalysisError 'position.singular' at an output within OWN of half a turn.
    """
    n = run.mechanism.numbering
    rows = np.array([n.x_index(node, 1) for node in nodes])
    home = chosen(replace(run, header={}))
    home.start()
    told = False
    for evaluator, (frame,) in moved:
        least = np.abs(frame.x[rows]).min()
        if evaluator.model.mechanism is run.mechanism and least > DEGREES_LOSE:
            yield evaluator, (frame,)
            continue
        node = nodes[int(np.argmin(np.abs(frame.x[rows])))]
        if least < OWN:
            raise AnalysisError(
                f"singular position at t = {frame.t:.9g}: the rotation of node {node} is 180 degrees at this output,"
                " where lambda1, lambda2, lambda3 (DYNX) are no coordinates to linearize in; take other output times,"
                " or describe it by HINGE elements (DYNE)",
                "position.singular",
            )
        if least < DEGREES_LOSE and not told:
            told = True
            run.report.add(
                f"warning: at t = {frame.t:.6g} the rotation of node {node} is near 180 degrees: transfer functions and"
                f" linearized equations in lambda1, lambda2, lambda3 are known to {EPS / least**2:.0e} of their size"
            )
        home.resume(Moving(frame.t, frame.x.copy(), frame.xd.copy(), frame.xdd.copy(), frame.e.copy()))
        home.frame(frame.t, _state(n, frame))
        yield home, (frame,)


def _state(n: Numbering, frame: Frame) -> Array:
    """The state of a frame, as `Dynamics.start_values`."""
    x, e = n.x_class, n.e_class
    positions = (frame.x[x["dynamic"]], frame.e[e["dynamic"]], frame.x[x["kinematic"]], frame.e[e["kinematic"]])
    return np.concatenate((*positions, frame.xd[x["dynamic"]], frame.ed[e["dynamic"]]))


def chosen(run: Run) -> Evaluator:
    """The compiled evaluator where that is possible, else that of NumPy; the header says which, and why. Where factors
    of the engine take too long that of NumPy with elements in C."""
    from spacar.compiled import CompiledDynamics, is_compiled

    if not is_compiled(run):
        return Dynamics(run.mechanism)
    evaluator = CompiledDynamics(run.mechanism)
    return evaluator.general if evaluator.solver.too_large() else evaluator


def output_times(run: Run) -> Sequence[float]:
    """t_i = i T/N, each computed when it is reached; only the initial state without TIMESTEP."""
    settings = run.mechanism.settings
    if settings.duration is None or settings.n_steps < 1:
        return (0.0,)
    return EvenTimes(0.0, settings.duration, settings.n_steps)


class Extent:
    """Least and largest value of every coordinate and deformation so far."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self.low: list[np.ndarray] = []
        self.high: list[np.ndarray] = []

    def take(self, block: Sequence[Frame]) -> None:
        if not len(block):
            return
        columns = [
            block.column(name) if isinstance(block, StoredFrames) else np.array([getattr(f, name) for f in block])
            for name in ("x", "e")
        ]
        seen = [(c.min(axis=0), c.max(axis=0)) for c in columns if c is not None]
        if not self.low:
            self.low, self.high = [low.copy() for low, _ in seen], [high.copy() for _, high in seen]
        for (low, high), lowest, highest in zip(seen, self.low, self.high, strict=True):
            np.minimum(lowest, low, out=lowest)
            np.maximum(highest, high, out=highest)

    def sizes(self) -> dict[str, float]:
        """The largest motion of each kind that the state contains and that does not rest."""
        mechanism = self.mechanism
        n = mechanism.numbering
        if not self.low:
            return {}
        of_x, of_e = n.x_class["dynamic"].start, slice(n.e_class["dynamic"].start, n.e_class["kinematic"].stop)
        x, e = (high - low for low, high in zip(self.low, self.high, strict=True))
        e, is_length = e[of_e], mechanism.is_length[of_e]
        is_position = np.zeros(n.nx, bool)
        is_position[n.positions] = True
        found = {}
        for kind, size, own_x, own_e in (
            ("lengths", mechanism.length, is_position, is_length), ("rotations", 1.0, ~is_position, ~is_length),
        ):  # fmt: skip
            if own_x[of_x:].any() or own_e.any():
                most = max(float(x[own_x].max(initial=0.0)), float(e[own_e].max(initial=0.0)))
                if most > ROUNDED * size:
                    found[kind] = most
        return found

    def tell(self, report: Report) -> None:
        """Warn of an absolute ERROR that is large beside the motion."""
        settings = self.mechanism.settings
        if not METHODS[settings.integrator].variable_step:
            return
        for kind, most in self.sizes().items():
            if most < settings.atol / LARGEST:
                unit = UNITS[kind]
                report.add(
                    f"warning: ERROR allows {settings.atol:.3g} {unit} (its absolute part), and no motion of {kind} is"
                    f" larger than {most:.3g} {unit}: the result may be wrong by as much; take {1e-4 * most:.1g} or"
                    " less (--atol), or --accuracy, which counts in parts of the motion"
                )
