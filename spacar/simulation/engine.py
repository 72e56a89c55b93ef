"""Simulation of a diagram: integration between sampling times and discontinuities, events, output.

Inside a piece of the time axis the states follow a one-step code with error control (spacar/integrators). Events are
zeros of functions of the signals: those of the caller, and those of blocks whose mode ends (blocks.Block). They are
looked for at the middle and the end of every step and at the output times in it; the first one is located on the dense
output to rounding, and the integration starts again behind it with new modes. Blocks whose modes
end more than MOST_RESTARTS times in a row while the time makes no progress chatter, which is a failure. Signals and
rates: diagram_evaluator.py; steps and their method: stepping.py.

The time axis is cut at every sampling time and at every break of a block. Values next to a cut are those of the side on
which the integration works: a piece is evaluated `shift` inside its cuts, a few roundings of the largest time. Cuts
nearer than four of these are one.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import EPS, Array
from spacar.errors import AnalysisError, UsageError
from spacar.integrators import AUTOMATIC, Step, Tolerance, named
from spacar.simulation.blocks import Block, Function, Sampled
from spacar.simulation.diagram import Diagram, schedule
from spacar.simulation.diagram_evaluator import CALM, MOST_RESTARTS, DiagramEvaluator
from spacar.simulation.plant import Spasim
from spacar.simulation.response import Event, Response, Signals
from spacar.simulation.stepping import Stepping
from spacar.simulation.transport_delay import TransportDelay

MOST_LOOKS = 160  # for one event; every third halves the interval
MOST_CUTS = 10_000_000  # edges or samples of one block: a chosen bound of memory, 2 GB


def simulate(
    diagram: Diagram, times: Sequence[float] | Array, *, method: int | str = AUTOMATIC, atol: float = 1e-8,
    rtol: float = 1e-6, max_step: float = np.inf, events: Sequence[Event] = (),
    x0: Mapping[str, Sequence[float]] | None = None, progress: Callable[[float], None] | None = None,
) -> Response:  # fmt: skip
    """Simulate from times[0] and report at every time of `times` [s].

    method    code of INTEGRAT with variable steps (135, 155, 853, 553, 595), a name of spacar.integrators.NAMES, or -1:
              155, and 595 where that goes on faster (stepping.py)
    atol, rtol error tolerances of a step; max_step [s]
    x0        start states by block name instead of those of the block
    progress  called after every step with the time that is reached [s]

    Raises UsageError (arguments, algebraic loop), AnalysisError (a block failed, returned a wrong shape or a
    value that is not finite, or the step size became too small).
    """
    if not isinstance(diagram, Diagram):
        raise UsageError(f"a simulation takes a Diagram, not {diagram!r:.60}", "simulation.diagram")
    try:
        output_times = np.asarray(times, float)
    except (TypeError, ValueError):
        raise UsageError(f"the output times are a list of numbers, not {times!r:.60}", "simulation.times") from None
    code = named(method).code
    if output_times.ndim != 1 or len(output_times) < 2 or not np.all(np.diff(output_times) > 0.0):
        raise UsageError("the output times must increase, and there must be at least two", "simulation.times")
    numbers = all(isinstance(value, Real) for value in (atol, rtol, max_step))
    if not (numbers and atol > 0.0 and rtol >= 0.0 and max_step > 0.0):
        raise UsageError("atol and max_step must be positive, rtol must not be negative", "simulation.tolerance")
    tolerance = Tolerance(atol, rtol)
    return _Simulation(diagram, output_times, code, tolerance, max_step, tuple(events), x0 or {}, progress).run()


@dataclass
class _Simulation:
    diagram: Diagram
    times: Array
    code: int
    tolerance: Tolerance
    max_step: float
    user_events: tuple[Event, ...]
    x0: Mapping[str, Sequence[float]]
    progress: Callable[[float], None] | None

    def __post_init__(self) -> None:
        self.s = schedule(self.diagram)
        self.x = np.concatenate([np.zeros(0), *(b.start() for b in self.s.blocks)])
        for name, values in self.x0.items():
            place = self.s.states.get(name)
            if place is None or len(values) != place.stop - place.start:
                raise UsageError(f"x0: {name} is no block with {len(values)} states", "simulation.start")
            self.x[place] = values
        self.doubts = tuple(f"{b.name}: {b.doubt}" for b in self.s.blocks if b.doubt)
        self.evaluator = DiagramEvaluator(self.s, bool(self.user_events))
        self.delayed = [b for b in self.s.blocks if isinstance(b, TransportDelay)]
        longest = min([self.max_step, *(b.lag for b in self.delayed)])
        self.window = float(self.times[0]), float(self.times[-1])
        self.stepping = Stepping(self.evaluator, self.code, self.tolerance, longest, self.window)
        self.axis = TimeAxis(*self.window, self.s.blocks)
        self.shift = self.axis.shift
        self.restarts = self.samples = self.streak = 0

    # -- evaluation -----------------------------------------------------------------------------------------------
    def sample(self, t: float, hit: Sequence[Block]) -> None:
        """At a sampling time: step the blocks in `hit`, those with direct feedthrough in their order, then the delayed
        ones with the inputs that follow from them.
        """
        delayed = [b for b in hit if b.delay]
        for b in delayed:
            b.release()  # type: ignore[attr-defined]
        self.evaluator.settle(t, self.x)
        if not hit:
            return
        u = self.evaluator.evaluate(t, self.x, [b for b in hit if not b.delay])
        for b in delayed:
            b.step(t, u[self.s.inputs[b.name]])
        self.samples += len(hit)
        self.evaluator.settle(t, self.x)

    def signs(self, t: float, x: Array) -> Array:
        """Event functions: those of the blocks, then those of the caller."""
        if not self.evaluator.watched and not self.user_events:
            return np.zeros(0)
        t = min(max(t, self.window[0]), self.window[1])
        u = self.evaluator.watch(t, x)
        values = [b.events(t, x[self.s.states[b.name]], u[self.s.inputs[b.name]]) for b in self.evaluator.watched]
        view = Signals(self.diagram, self.s.outputs, self.evaluator.y)
        for event in self.user_events:
            value = float(event.function(t, view))
            if not np.isfinite(value):
                raise AnalysisError(f"event {event.name} at t = {t:.9g} is {value}", "simulation.not-finite")
            values.append(np.array([value]))
        return np.concatenate(values)

    # -- the time axis -----------------------------------------------------------------------------------------------
    def run(self) -> Response:
        cuts = self.axis.cuts
        n = len(self.times)
        ys, xs = np.zeros((n, len(self.evaluator.y))), np.zeros((n, len(self.x)))
        us = np.zeros((n, len(self.s.wiring)))
        log: list[tuple[float, str]] = []
        done = 0
        stopped = False

        plants = [b for b in self.s.blocks if isinstance(b, Spasim)]

        def record(t: float, x: Array) -> None:
            nonlocal done
            us[done] = self.evaluator.evaluate(t, x)
            ys[done], xs[done] = self.evaluator.y, x
            for b in plants:
                b.frame(t, x[self.s.states[b.name]], us[done, self.s.inputs[b.name]])  # is it within its limits?
            done += 1

        before: Array | None = None
        for k, (a, hit) in enumerate(cuts):
            self.window = self.axis.window(k)
            self.sample(a, hit)
            self.pass_on_jumps(k, self.window[0], a)
            self.window = self.axis.window(k)
            now = self.signs(a, self.x)
            if before is not None:  # a sample or a jump may carry a signal through an event
                stopped = self._tell(a, [], before, now, log)
            before = now
            if done < n and abs(self.times[done] - a) <= 4.0 * self.shift:
                record(self.window[0], self.x)
            if k == len(cuts) - 1 or stopped:
                break
            t = a
            while t < (b := cuts[k + 1][0]) and not stopped:
                step = self.stepping.step(t, self.x, b, self.window)
                t_event, x_new, now, found = self.locate(t, step, before)
                self.remember(t, t_event, step.interpolate)
                while done < n and self.times[done] <= t_event and abs(self.times[done] - b) > 4.0 * self.shift:
                    record(float(self.times[done]), step.interpolate(float(self.times[done])))
                self.x = x_new
                if found:
                    self.streak = self.streak + 1 if t_event - t <= 64.0 * self.shift else 0
                    if self.streak > MOST_RESTARTS:
                        text = f"{', '.join(b.name for b in found)} chatters at t = {t_event:.9g}: {MOST_RESTARTS}"
                        text += f" changes of mode and time does not go on; {CALM}"
                        raise AnalysisError(text, "simulation.chatter")
                    self.evaluator.settle(t_event, self.x)
                    self.pass_on_jumps(k, t_event, t_event)
                    self.window = (self.window[0], self.axis.window(k)[1])
                    self.restarts += 1
                    self.stepping.restart()
                    now = self.signs(t_event, self.x)
                stopped = self._tell(t_event, found, before, now, log)
                before, t = now, t_event
                if self.progress is not None:
                    self.progress(t)
            self.stepping.restart()
            if stopped:
                if done < n and (not done or self.times[done - 1] < t):
                    self.times = np.concatenate((self.times[:done], [t]))
                    record(t, self.x)
                break
        stepping = self.stepping
        work = stepping.n_steps, stepping.problem.n_rhs, self.restarts, self.samples
        statistics = dict(zip(("steps", "rhs", "restarts", "samples"), work, strict=True))
        if any(group.torn for group in self.s.later):
            statistics["loops"] = self.evaluator.loops
        warned = [f"{b.name}: {line.removeprefix('warning: ')}" for b in plants for line in b.motion.report.lines]
        return Response(
            self.times[:done], ys[:done], xs[:done], self.diagram, self.s.outputs, self.s.states, self.s.inputs,
            us[:done], tuple(log), (*self.s.notes, *self.doubts, *stepping.notes, *warned), statistics, stepping.hint(),
        )  # fmt: skip

    def remember(self, t: float, t_new: float, interpolate: Callable[[float], Array]) -> None:
        """Tell the blocks that look back their inputs in an accepted step."""
        for b in self.delayed if t < t_new else ():

            def inputs(time: float, block: Block = b) -> Array:
                time = min(max(time, self.window[0]), self.window[1])
                return self.evaluator.evaluate(time, interpolate(time))[self.s.inputs[block.name]].copy()

            b.remember(t, t_new, inputs, self.tolerance)

    def pass_on_jumps(self, k: int, t: float, jump: float) -> None:
        """Cut the time axis where a jump in the input of a delay comes out again.

        t is where the input behind the jump is evaluated, in piece k; `jump` the time of the jump [s].
        """
        if not self.delayed:
            return
        u = self.evaluator.evaluate(t, self.x)
        for b in self.delayed:
            if b.jumped(u[self.s.inputs[b.name]], self.tolerance):
                b.jumps_out(self.axis.cut(k, jump + b.lag))

    def locate(self, t: float, step: Step, before: Array) -> tuple[float, Array, Array, list[Block]]:
        """The first event inside a step: its time, its state, the values there and the blocks whose mode ends."""
        if not len(before):
            return step.t, step.y, before, []
        first, last = np.searchsorted(self.times, (t, step.t), side="right")
        looks = (*sorted({0.5 * (t + step.t), *self.times[first:last].tolist()}), step.t)

        def state(time: float) -> Array:
            return step.y if time == step.t else step.interpolate(time)

        time, x_event, now, ended = first_event(self.signs, state, t, before, looks, self.user_events, self.shift)
        owners = [b for b in self.evaluator.watched for _ in range(b.n_events)] if ended.any() else []
        return time, x_event, now, list(dict.fromkeys(b for b, end in zip(owners, ended, strict=False) if end))

    def _tell(self, t: float, ended: Sequence[Block], before: Array, now: Array, log: list[tuple[float, str]]) -> bool:
        """Log the modes that ended and the events of the caller that happened. True when one ends the simulation."""
        if not ended and not self.user_events:
            return False
        n = len(now) - len(self.user_events)
        counted = passed(before, now, self.user_events)[n:]
        crossed = [e for e, yes in zip(self.user_events, counted, strict=True) if yes]
        names = {f"{b.event_word} of {b.name}" for b in ended} | {e.name for e in crossed}
        log += [(t, name) for name in sorted(names)]
        return any(e.terminal for e in crossed)


def passed(before: Array, after: Array, events: Sequence[Event]) -> NDArray[np.bool_]:
    """(n,) of the values of all event functions at two times, (n,) each: which modes ended in between, and which
    functions of the caller, the last ones, changed their sign in a direction that counts.
    """
    ended = (before >= 0.0) & (after < 0.0)
    if not events:
        return ended
    n = len(before) - len(events)
    direction = np.array([e.direction for e in events])
    before, after = before[n:], after[n:]
    rising, falling = (before < 0.0) & (after >= 0.0), (before > 0.0) & (after <= 0.0)
    return np.concatenate((ended[:n], (rising & (direction >= 0)) | (falling & (direction <= 0))))


def first_event(
    signs: Callable[[float, Array], Array], state: Callable[[float], Array], t: float, before: Array,
    looks: Sequence[float], events: Sequence[Event], shift: float,
) -> tuple[float, Array, Array, NDArray[np.bool_]]:  # fmt: skip
    """Time [s] just behind the first event, its state (n_states,), the values there and which event functions of blocks
    ended; without an event those of the end of the step.

    signs    values of the event functions at a time and its state
    state    the dense output of the step
    before   the values at its start t
    looks    ascending times at which the functions are looked at, the end of the step last
    shift    the rounding of a time [s]
    """
    low, f_low = t, before
    for high in looks:
        if not low < high:
            continue
        at = state(high)
        f_high = signs(high, at)
        if passed(f_low, f_high, events).any():
            break
        low, f_low = high, f_high
    else:
        return low, state(low), f_low, np.zeros(len(f_low) - len(events), bool)
    for k in range(MOST_LOOKS):
        if high - low <= 3.0 * shift:
            break
        guess = 0.5 * (low + high)
        if k % 3 < 2:  # a secant, a little before and a little behind its zero: the interval closes from both sides
            crossing = passed(f_low, f_high, events)
            start, end = f_low[crossing], f_high[crossing]
            part = np.min(start / (start - end))  # one of them is not zero, and they differ in sign
            guess = low + float(part) * (high - low) + (shift if k % 3 else -shift)
            guess = min(max(guess, low + shift), high - shift)
        if not low < guess < high:
            break
        at_guess = state(guess)
        f = signs(guess, at_guess)
        if passed(f_low, f, events).any():
            high, f_high, at = guess, f, at_guess
        else:
            low, f_low = guess, f
    return high, np.array(at), f_high, passed(f_low, f_high, events)[: len(f_high) - len(events)]


class TimeAxis:
    """`cuts`: times from the first to the last one [s], each with the blocks that are sampled there. Piece k lies
    between cuts k and k + 1. `shift` [s], see above.
    """

    def __init__(self, first: float, last: float, blocks: Sequence[Block]) -> None:
        self.shift = 4.0 * EPS * max(abs(first), abs(last), last - first)
        found: list[tuple[float, Block | None]] = [(first, None), (last, None)]
        for block in blocks:
            if (stops := block.stops_within(last - first)) > MOST_CUTS:
                text = f"{block.name}: the integration stops {stops:.3g} times in {last - first:g} s, at every edge or"
                text += f" sample; at most {MOST_CUTS:.0e} stay in memory: a shorter time or a longer period helps"
                raise UsageError(text, "simulation.times")
            found += [(t, None) for t in (*block.breaks, *block.breaks_until(first, last)) if first < t < last]
            if block.period is not None:
                period, offset = block.period, block.offset
                k0 = int(np.ceil((first - offset) / period - 1e-9))
                k1 = int(np.floor((last - offset) / period + 1e-9))
                found += [(min(max(offset + k * period, first), last), block) for k in range(k0, k1 + 1)]
        found.sort(key=lambda pair: pair[0])
        self.cuts: list[tuple[float, list[Block]]] = []
        for t, b in found:
            if not self.cuts or not self.same(t, self.cuts[-1][0]):
                self.cuts.append((t, []))
            if b is not None:
                self.cuts[-1][1].append(b)
        self.cuts[-1] = (last, self.cuts[-1][1])

    def same(self, t: float, other: float) -> bool:
        return abs(t - other) <= 4.0 * self.shift

    def window(self, k: int) -> tuple[float, float]:
        """Where the blocks are evaluated in piece k: a little inside its cuts, but at the first and last time."""
        low = self.cuts[k][0] + (self.shift if 0 < k < len(self.cuts) - 1 else 0.0)
        if k + 1 >= len(self.cuts):
            return low, low
        return low, self.cuts[k + 1][0] - self.shift

    def cut(self, k: int, t: float) -> float:
        """Cut at t, behind cut k. Returns the time of the cut: t, or that of an existing cut at the same time."""
        for place in range(k + 1, len(self.cuts)):
            other = self.cuts[place][0]
            if self.same(t, other):
                return other
            if other > t:
                self.cuts.insert(place, (t, []))
                return t
        return t  # behind the end


def closed_loop(
    plant: Spasim, control: Callable[..., Any], times: Sequence[float] | Array, *, feedback: str | None = None,
    period: float | None = None, **options: Any,
) -> Response:  # fmt: skip
    """Simulate a mechanism with u = control(t, y).

    feedback  numbers (from 1) of the outputs that the law gets, such as "1-6"; default: all. The vector y has the
              length of all outputs, so that numbers keep their place; those that are not fed back are NaN
    period    sampling period [s] of a discrete-time law; default: continuous
    options   of `simulate`

    The blocks of the response are the plant under its own name and "control". Raises as `simulate`.
    """
    diagram = Diagram().add(plant)
    fed_back = plant.name if feedback is None else f"{plant.name}:{feedback}"
    rows = diagram.signals(fed_back)[1]
    chosen = [plant.outputs_[k] for k in rows]

    def law(t: float, y: Array) -> Any:
        full = np.full(plant.n_out, np.nan)
        full[rows] = y
        return control(t, full)

    if period is None:
        diagram.add(Function("control", law, chosen, plant.inputs, getattr(control, "breaks", ())))
    else:
        diagram.add(Sampled("control", lambda t, x, y: (x, law(t, y)), period, chosen, plant.inputs))
    return simulate(diagram.connect(fed_back, "control").connect("control", plant.name), times, **options)
