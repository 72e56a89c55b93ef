"""Built-in blocks together: while their modes hold, their outputs and rates are affine in states and inputs,

    y = C x + D u + c,      x' = A x + B u + a,      u = W y,

so that blocks in a row are one product of a matrix each time instead of a call each (`AffineRun`), and the
Jacobian of a diagram follows block by block,

    dF/dx = A + B W (1 - D W)^-1 C,

with the constants of built-in blocks, and differences of those blocks alone that have none (`diagram_jacobian`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from spacar.arrays import Array
from spacar.simulation.algebraic_loops import DIFFERENCE, Group, differences
from spacar.simulation.blocks import Affine, Block
from spacar.simulation.diagram import Schedule


class AffineRun:
    """Outputs of blocks that follow each other, at `rows` of y: a `matrix` of z = (all states x, all signals y, 1)."""

    def __init__(self, s: Schedule, blocks: Sequence[Block]) -> None:
        n_x, n_y = s.n_states, s.wiring.shape[1]
        rows = [np.arange(s.outputs[b.name].start, s.outputs[b.name].stop) for b in blocks]
        self.rows = np.concatenate(rows)
        whole = np.zeros((n_y, n_x + n_y + 1))
        known = np.ones(n_y, bool)
        known[self.rows] = False
        for b, own in zip(blocks, rows, strict=True):
            f = b.affine()
            assert f is not None  # the caller has asked
            wired = f.D @ s.wiring[s.inputs[b.name]]
            whole[own] = (wired * ~known) @ whole  # of blocks that came before in this run
            whole[own, n_x:-1] += wired * known
            whole[own, s.states[b.name]] += f.C
            whole[own, -1] += f.c
        self.matrix = whole[self.rows]


@dataclass(frozen=True)
class Order:
    """Blocks whose outputs need no inputs; then runs of affine blocks and other groups, each after those it needs."""

    first: list[Block]
    later: list[AffineRun | Group]

    @classmethod
    def of(cls, s: Schedule, first: Sequence[Block], groups: Sequence[Group]) -> Order:
        """For the present modes of the blocks."""
        together = {b.name: b.affine() is not None for b in s.blocks}
        later: list[AffineRun | Group] = []
        run = [b for b in first if together[b.name] and not b.direct.any()]
        for group in groups:
            if not group.torn and together[group.blocks[0].name]:
                run.append(group.blocks[0])
                continue
            later += [AffineRun(s, run)] if run else []
            later.append(group)
            run = []
        later += [AffineRun(s, run)] if run else []
        return cls([b for b in first if not together[b.name]], later)


class Plan:
    """How a diagram is evaluated while no mode changes: `signals`, all of them; `for_rates` and `for_events`, those
    that the rates of states and the ends of modes depend on. Then inputs of blocks with rates of their own and the
    rates of affine blocks are one product.
    """

    def __init__(self, s: Schedule) -> None:
        self.signals = Order.of(s, s.first, s.later)
        self.for_rates = Order.of(s, *_behind(s, [b for b in s.blocks if b.n_states]))
        self.for_events = Order.of(s, *_behind(s, [b for b in s.blocks if b.n_events]))
        n_x, n_y = s.n_states, s.wiring.shape[1]
        self.alone: list[tuple[Block, slice, slice]] = []  # its states, its inputs in the product
        inputs, rates, places = [np.zeros((0, n_x + n_y + 1))], [], [np.zeros(0, np.int64)]
        for b in (b for b in s.blocks if b.n_states):
            states, wired, f = s.states[b.name], s.wiring[s.inputs[b.name]], b.affine()
            rows = np.zeros((b.n_in if f is None else b.n_states, n_x + n_y + 1))
            if f is None:
                rows[:, n_x:-1] = wired
                begin = sum(map(len, inputs))
                self.alone.append((b, states, slice(begin, begin + b.n_in)))
                inputs.append(rows)
            else:
                rows[:, states], rows[:, n_x:-1], rows[:, -1] = f.A, f.B @ wired, f.a
                rates.append(rows)
                places.append(np.arange(states.start, states.stop))
        self.matrix, self.places = np.vstack(inputs + rates), np.concatenate(places)
        self.n_inputs = sum(map(len, inputs))

    def rates(self, t: float, x: Array, z: Array) -> Array:
        """(n_states,), from the signals in z."""
        out, product = np.empty(len(x)), self.matrix @ z
        out[self.places] = product[self.n_inputs :]
        for b, states, inputs in self.alone:
            out[states] = b.derivative(t, x[states], product[inputs])
        return out


def _behind(s: Schedule, asking: Sequence[Block]) -> tuple[list[Block], list[Group]]:
    """The blocks and groups whose outputs the inputs of these blocks depend on; what is sampled or looks back needs no
    present inputs."""
    of_inputs = np.zeros(len(s.wiring), bool)
    for b in asking:
        of_inputs[s.inputs[b.name]] = True
    groups = []
    for group in reversed(s.later):
        if any((s.wiring[of_inputs][:, s.outputs[b.name]][:, b.direct] != 0.0).any() for b in group.blocks):
            groups.append(group)
            for b in group.blocks:
                of_inputs[s.inputs[b.name]] |= b.period is None and not b.lag
    signals = (s.wiring[of_inputs] != 0.0).any(axis=0)
    return [b for b in s.first if signals[s.outputs[b.name]].any()], groups[::-1]


def diagram_jacobian(s: Schedule, t: float, x: Array, u: Array, absolute: float) -> Array:
    """dF/dx (n, n) of all states at a time, for the inputs u of all blocks; `absolute` error of a state."""
    n_y, n_u, n_x = s.wiring.shape[1], len(s.wiring), len(x)
    A, B = np.zeros((n_x, n_x)), np.zeros((n_x, n_u))
    C, D = np.zeros((n_y, n_x)), np.zeros((n_y, n_u))
    for b in s.blocks:
        states, inputs, outputs = s.states[b.name], s.inputs[b.name], s.outputs[b.name]
        f = b.affine() or by_differences(b, t, x[states], u[inputs], absolute)
        A[states, states], B[states, inputs], C[outputs, states], D[outputs, inputs] = f.A, f.B, f.C, f.D
    return A + B @ s.wiring @ np.linalg.solve(np.eye(n_y) - D @ s.wiring, C)


def by_differences(b: Block, t: float, x: Array, u: Array, absolute: float) -> Affine:
    """The block about a state, by forward differences of sqrt(eps) of the size of each number."""
    n, m, p = b.n_states, b.n_in, b.n_out
    fixed = b.period is not None or b.lag > 0.0  # its outputs are held, or come from the past
    direct = not fixed and bool(b.direct.any())
    size = np.maximum(np.abs(np.concatenate((x, u))), [max(absolute / DIFFERENCE, 1e-6)] * n + [1.0] * m)
    slopes = np.zeros((p + n, n + m))

    def at(z: Array) -> Array:
        state, given = z[:n], z[n:]
        y = b.outputs(t, state, given) if direct else b.state_outputs(t, state)
        return np.concatenate((y, b.derivative(t, state, given))) if n else np.array(y)

    if not fixed and (n or direct):
        z = np.concatenate((x, u))
        slopes = differences(at, z, at(z), size)
    return Affine(slopes[p:, :n], slopes[p:, n:], slopes[:p, :n], slopes[:p, n:], np.zeros(n), np.zeros(p))
