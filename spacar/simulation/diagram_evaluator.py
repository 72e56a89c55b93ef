"""A diagram at a time and state: all signals, the rates of the states, their Jacobian, and the modes that fit.

While no mode changes, built-in blocks are evaluated together (affine_blocks.py), and for the rates of the states and
the ends of modes only the blocks that they depend on.
"""

from collections.abc import Sequence

import numpy as np

from spacar.arrays import Array
from spacar.errors import AnalysisError
from spacar.simulation.affine_blocks import AffineRun, Order, Plan, diagram_jacobian
from spacar.simulation.algebraic_loops import Group
from spacar.simulation.blocks import Block
from spacar.simulation.diagram import Schedule

MOST_RESTARTS = 200  # events in a row without progress of the time
CALM = "give a relay some hysteresis, or sample the controller"


class DiagramEvaluator:
    """`z`: the states, all signals `y`, and 1. `loops`: sweeps through algebraic loops so far; `whole`: events are seen
    in all signals.
    """

    def __init__(self, s: Schedule, whole: bool = False) -> None:
        self.s, self.whole = s, whole
        n_x, n_y = s.n_states, s.wiring.shape[1]
        self.z = np.zeros(n_x + n_y + 1)
        self.z[-1] = 1.0
        self.x, self.y = self.z[:n_x], self.z[n_x:-1]
        self.watched = [b for b in s.blocks if b.n_events]
        self.stale, self.loops = False, 0
        direct = [(b, group if group.torn else None) for group in s.later for b in group.blocks if b.n_events]
        self.settling = direct + [(b, None) for b in self.watched if not b.direct.any()]
        self.plan = Plan(s)

    def evaluate(self, t: float, x: Array, hit: Sequence[Block] = ()) -> Array:
        """All outputs at a time and state (in self.y), and all inputs as the result. Blocks in `hit` are sampled at
        this time; then blocks choose the mode that fits, each after those it needs.
        """
        order = Order([*self.s.first], [*self.s.later]) if hit else self.plan.signals
        self._together(t, x, order, hit)
        return self.s.wiring @ self.y

    def watch(self, t: float, x: Array) -> Array:
        """The numbers in which events are seen: all inputs, of which those of blocks whose modes end are of this time;
        if `whole`, they all are.
        """
        self._together(t, x, self.plan.signals if self.whole else self.plan.for_events)
        return self.s.wiring @ self.y

    def _together(self, t: float, x: Array, order: Order, hit: Sequence[Block] = ()) -> None:
        """The outputs of an order; only where blocks are sampled, `hit`, do they choose their modes."""
        s, y = self.s, self.y
        self.x[:] = x
        for b in order.first:
            y[s.outputs[b.name]] = b.state_outputs(t, x[s.states[b.name]])
        for part in order.later:
            if isinstance(part, AffineRun):
                y[part.rows] = part.matrix @ self.z
            elif part.torn:
                self._loop(t, x, part, bool(hit))
            else:
                self._output(t, x, part.blocks[0], hit)

    def _output(self, t: float, x: Array, b: Block, hit: Sequence[Block] = ()) -> None:
        """Outputs of a block with direct feedthrough from what is in self.y."""
        s, own = self.s, x[self.s.states[b.name]]
        u = s.wiring[s.inputs[b.name]] @ self.y
        if hit and b.n_events:
            self._switch(b, t, x, u)
        self.y[s.outputs[b.name]] = b.step(t, u) if b in hit else b.outputs(t, own, u)

    def _loop(self, t: float, x: Array, group: Group, settling: bool) -> None:
        """Solve an algebraic loop; when settling, with the modes that fit the solution."""

        def sweep() -> None:
            for b in group.blocks:
                self._output(t, x, b)

        self.loops += group.solve(t, self.y, self.s.wiring, sweep)
        for b in group.blocks if settling else ():
            u = self.s.wiring[self.s.inputs[b.name]] @ self.y
            if b.n_events and self._switch(b, t, x, u):
                group.jacobian = None  # solved anew in the next turn of `settle`

    def _switch(self, b: Block, t: float, x: Array, u: Array) -> bool:
        """Let a block choose its mode, for all states and its own inputs. True when it was another one before."""
        switched = b.switch(t, x[self.s.states[b.name]], u)
        self.stale |= switched and b.affine() is not None
        return switched

    def settle(self, t: float, x: Array) -> None:
        """Choose the modes that fit the signals at a time where these may have jumped, from the same numbers in which
        events are seen: one mode after the other, so that no block remembers a signal that was none.

        Raises AnalysisError 'simulation.chatter' when there are none.
        """
        for _ in range(MOST_RESTARTS * len(self.settling)):
            if self.stale:
                self.plan, self.stale = Plan(self.s), False
            u = self.watch(t, x)
            for b, group in self.settling:
                if self._switch(b, t, x, u[self.s.inputs[b.name]]):
                    if group is not None:
                        group.jacobian = None
                    break
            else:
                return
        if self.settling:
            names = ", ".join(b.name for b in self.watched)
            text = f"the modes of {names} do not settle at t = {t:.9g}: every choice asks for another one; {CALM}"
            raise AnalysisError(text, "simulation.chatter")

    def rates(self, t: float, x: Array) -> Array:
        """(n_states,) of the states. Raises AnalysisError where one is not finite."""
        self._together(t, x, self.plan.for_rates)
        out = self.plan.rates(t, x, self.z)
        if not np.isfinite(out.dot(out)) and not np.isfinite(out).all():
            k = int(np.flatnonzero(~np.isfinite(out))[0])
            states = self.s.states
            owner = next(b for b in self.s.blocks if states[b.name].start <= k < states[b.name].stop)
            state = k - states[owner.name].start + 1
            text = f"the derivative of state {state} of {owner.name} is {out[k]} at t = {t:.9g}"
            raise AnalysisError(text, "simulation.not-finite")
        return out

    def jacobian(self, t: float, x: Array, absolute: float) -> Array:
        """dF/dx (n, n), block by block; `absolute` error of a state."""
        return diagram_jacobian(self.s, t, x, self.evaluate(t, x), absolute)
