"""Simulation of a diagram: integration between sampling times and discontinuities, events, output.

The time axis is cut (time_axis.py). Inside a piece the states follow a one-step code with error control
(spacar/integrators). Events are zeros of functions of the signals: those of the caller, and those of blocks whose mode
ends (blocks.Block). They are looked for at the middle and the end of every step and at the output times in it; the
first one is located on the dense output to rounding (event_location.py), and the integration starts again behind it
with new modes. Blocks whose modes end more than MOST_RESTARTS times in a row while the time makes no progress chatter,
which is a failure. While no mode changes, built-in blocks are evaluated together, and implicit codes take a Jacobian
block by block (affine_blocks.py).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from spacar.arrays import Array
from spacar.errors import AnalysisError, UsageError
from spacar.integrators import Step, Tolerance, named, steps
from spacar.simulation.affine_blocks import AffineRun, Plan, diagram_jacobian
from spacar.simulation.algebraic_loops import Group
from spacar.simulation.blocks import Block
from spacar.simulation.diagram import Diagram, Schedule, schedule
from spacar.simulation.event_location import first_event, passed
from spacar.simulation.response import Event, Response, Signals
from spacar.simulation.time_axis import TimeAxis
from spacar.simulation.transport_delay import TransportDelay

MOST_RESTARTS = 200  # events in a row without progress of the time
CALM = "give a relay some hysteresis, or sample the controller"


def simulate(
    diagram: Diagram, times: Sequence[float] | Array, *, method: int | str = 155, atol: float = 1e-8,
    rtol: float = 1e-6, max_step: float = np.inf, events: Sequence[Event] = (),
    x0: Mapping[str, Sequence[float]] | None = None,
) -> Response:  # fmt: skip
    """Simulate from times[0] and report at every time of `times` [s].

    method    code of INTEGRAT with variable steps (135, 155, 853, 553, 595) or a name of spacar.integrators.NAMES
    atol, rtol error tolerances of a step; max_step [s]
    x0        start states by block name instead of those of the block

    Raises UsageError (arguments, algebraic loop), AnalysisError (a block failed, returned a wrong shape or a
    value that is not finite, or the step size became too small).
    """
    output_times = np.asarray(times, float)
    code = named(method).code
    if output_times.ndim != 1 or len(output_times) < 2 or not np.all(np.diff(output_times) > 0.0):
        raise UsageError("the output times must increase, and there must be at least two", "simulation.times")
    if not (atol > 0.0 and rtol >= 0.0 and max_step > 0.0):
        raise UsageError("atol and max_step must be positive, rtol must not be negative", "simulation.tolerance")
    return _Simulation(diagram, output_times, code, atol, rtol, max_step, tuple(events), x0 or {}).run()


class _Mistake(Exception):
    """An error of a block, on its way through the integrator."""

    def __init__(self, error: AnalysisError) -> None:
        super().__init__(str(error))
        self.error = error


@dataclass
class _Problem:
    """The diagram as the integrators see it (integrators/problem.py)."""

    n_positions: int
    rhs: Callable[[float, Array], Array]
    jacobian: Callable[[float, Array], tuple[Array, Array]]


class _Simulation:
    """One run through the time axis."""

    def __init__(
        self, diagram: Diagram, times: Array, code: int, atol: float, rtol: float, max_step: float,
        events: tuple[Event, ...], x0: Mapping[str, Sequence[float]],
    ) -> None:  # fmt: skip
        self.diagram, self.times, self.user_events = diagram, times, events
        self.s: Schedule = schedule(diagram)
        self.code, self.tolerance, self.max_step = code, Tolerance(atol, rtol), max_step
        self.y = np.zeros(self.s.wiring.shape[1])
        self.x = np.concatenate([np.zeros(0), *(b.start() for b in self.s.blocks)])
        for name, values in x0.items():
            place = self.s.states.get(name)
            if place is None or len(values) != place.stop - place.start:
                raise UsageError(f"x0: {name} is no block with {len(values)} states", "simulation.start")
            self.x[place] = values
        self.doubts = tuple(f"{b.name}: {b.doubt}" for b in self.s.blocks if b.doubt)
        self.dynamic = [b for b in self.s.blocks if b.n_states]
        self.watched = [b for b in self.s.blocks if b.n_events]
        self.delayed = [b for b in self.s.blocks if isinstance(b, TransportDelay)]
        self.max_step = min([self.max_step, *(b.lag for b in self.delayed)])
        self.axis = TimeAxis(float(times[0]), float(times[-1]), self.s.blocks)
        self.shift = self.axis.shift
        self.window = (float(times[0]), float(times[-1]))
        self.statistics = {"steps": 0, "rhs": 0, "restarts": 0, "samples": 0}
        if any(group.torn for group in self.s.later):
            self.statistics["loops"] = 0
        self.switched, self.streak = False, 0
        self.plan = Plan.of(self.s)

    # -- evaluation --------------------------------------------------------------------------------------------------
    def evaluate(self, t: float, x: Array, hit: Sequence[Block] = (), settling: bool = False) -> Array:
        """All outputs at a time and state (in self.y), and all inputs as the result. Blocks in `hit` are sampled at
        this time; when `settling`, blocks choose the mode that fits.
        """
        s, y = self.s, self.y
        if not hit and not settling:
            return self._evaluate_together(t, x)
        for b in s.first:
            y[s.outputs[b.name]] = b.state_outputs(t, x[s.states[b.name]])
        for group in s.later:
            if group.torn:
                self._loop(t, x, group, settling)
            else:
                self._output(t, x, group.blocks[0], hit, settling)
        return np.asarray(s.wiring @ y)

    def _evaluate_together(self, t: float, x: Array) -> Array:
        """`evaluate` while no block is sampled and none chooses a mode."""
        s, y = self.s, self.y
        for b in self.plan.first:
            y[s.outputs[b.name]] = b.state_outputs(t, x[s.states[b.name]])
        for part in self.plan.later:
            if isinstance(part, AffineRun):
                part.into(x, y)
            elif part.torn:
                self._loop(t, x, part, False)
            else:
                self._output(t, x, part.blocks[0])
        return np.asarray(s.wiring @ y)

    def _output(self, t: float, x: Array, b: Block, hit: Sequence[Block] = (), settling: bool = False) -> None:
        """Outputs of a block with direct feedthrough from what is in self.y."""
        s, own = self.s, x[self.s.states[b.name]]
        u = s.wiring[s.inputs[b.name]] @ self.y
        if settling and b.n_events:
            self.switched |= b.switch(t, own, u)
        self.y[s.outputs[b.name]] = b.step(t, u) if b in hit else b.outputs(t, own, u)

    def _loop(self, t: float, x: Array, group: Group, settling: bool) -> None:
        """Solve an algebraic loop; when settling, with the modes that fit the solution."""

        def sweep() -> None:
            for b in group.blocks:
                self._output(t, x, b)

        self.statistics["loops"] += group.solve(t, self.y, self.s.wiring, sweep)
        if not settling:
            return
        for b in group.blocks:
            if b.n_events and b.switch(t, x[self.s.states[b.name]], self.s.wiring[self.s.inputs[b.name]] @ self.y):
                self.switched, group.jacobian = True, None  # solved anew in the next turn of `settle`

    def settle(self, t: float, x: Array) -> None:
        """Choose the modes that fit the signals at a time where these may have jumped.

        Raises AnalysisError 'simulation.chatter' when there are none.
        """
        if not self.watched:
            return
        changed: list[str] = []
        for turn in range(MOST_RESTARTS):
            self.switched = False
            u = self.evaluate(t, x, (), True)
            changed = []
            for b in self.watched:
                if not b.direct.any() and b.switch(t, x[self.s.states[b.name]], u[self.s.inputs[b.name]]):
                    changed.append(b.name)
            if not changed and not self.switched:
                if turn:
                    self.plan = Plan.of(self.s)
                return
        names = ", ".join(b.name for b in self.watched)
        text = f"the modes of {names} do not settle at t = {t:.9g}: every choice asks for another one; {CALM}"
        raise AnalysisError(text, "simulation.chatter")

    def sample(self, t: float, hit: Sequence[Block]) -> None:
        """At a sampling time: step the blocks in `hit`, those with direct feedthrough in their order, then the delayed
        ones with the inputs that follow from them.
        """
        self.settle(t, self.x)
        if not hit:
            return
        delayed = [b for b in hit if b.delay]
        for b in delayed:
            b.release()  # type: ignore[attr-defined]
        u = self.evaluate(t, self.x, [b for b in hit if not b.delay], True)
        for b in delayed:
            b.step(t, u[self.s.inputs[b.name]])
        self.statistics["samples"] += len(hit)
        self.settle(t, self.x)

    def rhs(self, t: float, x: Array) -> Array:
        t = min(max(t, self.window[0]), self.window[1])
        self.statistics["rhs"] += 1
        u = self.evaluate(t, x)
        out = np.empty(len(x))
        self.plan.rates.into(x, u, out)
        for b in self.plan.alone:
            out[self.s.states[b.name]] = b.derivative(t, x[self.s.states[b.name]], u[self.s.inputs[b.name]])
        if not np.isfinite(out).all():
            k = int(np.flatnonzero(~np.isfinite(out))[0])
            owner = next(b for b in self.dynamic if self.s.states[b.name].start <= k < self.s.states[b.name].stop)
            state = k - self.s.states[owner.name].start + 1
            text = f"the derivative of state {state} of {owner.name} is {out[k]} at t = {t:.9g}"
            raise AnalysisError(text, "simulation.not-finite")
        return out

    def derivative(self, t: float, x: Array) -> Array:
        """What the integrator evaluates. It would answer an AnalysisError with a smaller step, which does not cure a
        mistake in a block: that goes straight through as a _Mistake.
        """
        try:
            return self.rhs(t, x)
        except AnalysisError as error:
            if error.code.startswith(("simulation.", "user-function")):
                raise _Mistake(error) from error
            raise

    def jacobian(self, t: float, x: Array) -> tuple[Array, Array]:
        """(dF/dx, dF/dt), (n, n) and (n,): block by block (affine_blocks.py), dF/dt as zero; a simplified Newton
        iteration needs no more.
        """
        t = min(max(t, self.window[0]), self.window[1])
        u = self.evaluate(t, x)
        return diagram_jacobian(self.s, t, x, u, float(np.min(self.tolerance.absolute))), np.zeros(len(x))

    def signs(self, t: float, x: Array) -> Array:
        """Event functions: those of the blocks, then those of the caller."""
        if not self.watched and not self.user_events:
            return np.zeros(0)
        t = min(max(t, self.window[0]), self.window[1])
        u = self.evaluate(t, x)
        values = [b.events(t, x[self.s.states[b.name]], u[self.s.inputs[b.name]]) for b in self.watched]
        view = Signals(self.diagram, self.s.outputs, self.y)
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
        ys, xs = np.zeros((n, len(self.y))), np.zeros((n, len(self.x)))
        us = np.zeros((n, len(self.s.wiring)))
        log: list[tuple[float, str]] = []
        done = 0
        h: float | None = None
        stopped = False

        def record(t: float, x: Array) -> None:
            nonlocal done
            us[done] = self.evaluate(t, x)
            ys[done], xs[done] = self.y, x
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
                t_new, interpolate, x_new, h = self.step(t, b, h)
                t_event, x_new, found = self.locate(t, t_new, interpolate, x_new, before)
                self.remember(t, t_event, interpolate)
                while done < n and self.times[done] <= t_event and abs(self.times[done] - b) > 4.0 * self.shift:
                    record(float(self.times[done]), interpolate(float(self.times[done])))
                self.x = x_new
                if found:
                    self.streak = self.streak + 1 if t_event - t <= 64.0 * self.shift else 0
                    if self.streak > MOST_RESTARTS:
                        self._chatters(t_event, found)
                    self.settle(t_event, self.x)
                    self.pass_on_jumps(k, t_event, t_event)
                    self.window = (self.window[0], self.axis.window(k)[1])
                    self.statistics["restarts"] += 1
                    self.solver = None
                now = self.signs(t_event, self.x)
                stopped = self._tell(t_event, found, before, now, log)
                before, t = now, t_event
            self.solver = None
            if stopped:
                if done < n and (not done or self.times[done - 1] < t):
                    self.times = np.concatenate((self.times[:done], [t]))
                    record(t, self.x)
                break
        return Response(
            self.times[:done], ys[:done], xs[:done], self.diagram, self.s.outputs, self.s.states, self.s.inputs,
            us[:done], tuple(log), self.s.notes + self.doubts, self.statistics,
        )  # fmt: skip

    def remember(self, t: float, t_new: float, interpolate: Callable[[float], Array]) -> None:
        """Tell the blocks that look back their inputs in an accepted step."""
        for b in self.delayed if t < t_new else ():

            def inputs(time: float, block: Block = b) -> Array:
                time = min(max(time, self.window[0]), self.window[1])
                return self.evaluate(time, interpolate(time))[self.s.inputs[block.name]].copy()

            b.remember(t, t_new, inputs, self.tolerance)

    def pass_on_jumps(self, k: int, t: float, jump: float) -> None:
        """Cut the time axis where a jump in the input of a delay comes out again.

        t is where the input behind the jump is evaluated, in piece k; `jump` the time of the jump [s].
        """
        if not self.delayed:
            return
        u = self.evaluate(t, self.x)
        for b in self.delayed:
            if b.jumped(u[self.s.inputs[b.name]], self.tolerance):
                b.jumps_out(self.axis.cut(k, jump + b.lag))

    solver: Iterator[Step] | None = None

    def step(
        self, t: float, end: float, h: float | None
    ) -> tuple[float, Callable[[float], Array], Array, float | None]:
        """One accepted step from t, not beyond `end`: new time, interpolation inside the step, new state, and the step
        size with which an integration that starts anew behind it begins.
        """
        if not len(self.x):
            return min(end, t + self.max_step), lambda time: self.x, self.x, h
        if self.solver is None:
            problem = _Problem(0, self.derivative, self.jacobian)  # of first order: no positions
            self.solver = steps(problem, t, self.x, end, self.window, self.code, self.tolerance, h, self.max_step)
        try:
            taken = next(self.solver)
        except _Mistake as mistake:
            raise mistake.error from None
        except AnalysisError as error:
            if error.code != "integrator.step-too-small":
                raise
            text = (
                f"the step size became too small at t = {error.data.get('t', t):.9g}; the loop may be unstable or"
                " stiff: check the gains, or use the method 553"
            )
            raise AnalysisError(text, "simulation.step-too-small") from None
        self.statistics["steps"] += 1
        size = float(taken.t) - t
        # The last step of a piece is short only because the piece ends.
        h = max(size, h or 0.0) if taken.t >= end else size
        return float(taken.t), taken.interpolate, np.array(taken.y), h

    def locate(
        self, t: float, t_new: float, interpolate: Callable[[float], Array], x_new: Array, before: Array
    ) -> tuple[float, Array, list[Block]]:
        """The first event inside a step: its time, its state and the blocks whose mode ends there."""
        if not len(before):
            return t_new, x_new, []
        first, last = np.searchsorted(self.times, (t, t_new), side="right")
        looks = (*sorted({0.5 * (t + t_new), *self.times[first:last].tolist()}), t_new)

        def state(time: float) -> Array:
            return x_new if time == t_new else interpolate(time)

        found = first_event(self.signs, state, t, before, looks, self.user_events, self.shift)
        if found is None:
            return t_new, x_new, []
        time, x_event, ended = found
        owners = [b for b in self.watched for _ in range(b.n_events)]
        return time, x_event, list(dict.fromkeys(b for b, end in zip(owners, ended, strict=True) if end))

    def _tell(self, t: float, ended: Sequence[Block], before: Array, now: Array, log: list[tuple[float, str]]) -> bool:
        """Log the modes that ended and the events of the caller that happened. True when one ends the simulation."""
        n = len(now) - len(self.user_events)
        counted = passed(before, now, self.user_events)[n:]
        crossed = [e for e, yes in zip(self.user_events, counted, strict=True) if yes]
        names = {f"{b.event_word} of {b.name}" for b in ended} | {e.name for e in crossed}
        log += [(t, name) for name in sorted(names)]
        return any(e.terminal for e in crossed)

    def _chatters(self, t: float, ended: Sequence[Block]) -> None:
        names = ", ".join(b.name for b in ended)
        text = f"{names} chatters at t = {t:.9g}: {MOST_RESTARTS} changes of mode and time does not go on; {CALM}"
        raise AnalysisError(text, "simulation.chatter")
