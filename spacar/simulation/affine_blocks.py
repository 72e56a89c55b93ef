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
from spacar.simulation.algebraic_loops import Group
from spacar.simulation.blocks import Affine, Block
from spacar.simulation.diagram import Schedule

DIFFERENCE = float(np.finfo(float).eps) ** 0.5


class AffineRun:
    """Outputs of blocks that follow each other, of all signals y and states x, (n,) of these blocks."""

    def __init__(self, s: Schedule, blocks: Sequence[Block]) -> None:
        n_x, n_y = sum(b.n_states for b in s.blocks), s.wiring.shape[1]
        rows = [np.arange(s.outputs[b.name].start, s.outputs[b.name].stop) for b in blocks]
        self.rows = np.concatenate(rows) if rows else np.zeros(0, np.int64)
        whole, constant = np.zeros((n_y, n_x + n_y)), np.zeros(n_y)
        known = np.ones(n_y, bool)
        known[self.rows] = False
        for b, own in zip(blocks, rows, strict=True):
            f = b.affine()
            assert f is not None  # the caller has asked
            wired = f.D @ s.wiring[s.inputs[b.name]]
            inside = wired * ~known  # of blocks that came before in this run
            whole[own] = inside @ whole
            whole[own, n_x:] += wired * known
            whole[own, s.states[b.name]] += f.C
            constant[own] = inside @ constant + f.c
        self.by_states, self.by_outputs = whole[self.rows, :n_x].copy(), whole[self.rows, n_x:].copy()
        self.constant = constant[self.rows]

    def into(self, x: Array, y: Array) -> None:
        """Put the outputs into y."""
        y[self.rows] = self.by_states @ x + self.by_outputs @ y + self.constant


class AffineRates:
    """Rates of the states of blocks, of all inputs u and states x."""

    def __init__(self, s: Schedule, blocks: Sequence[Block]) -> None:
        n_x = sum(b.n_states for b in s.blocks)
        A, B, a = np.zeros((n_x, n_x)), np.zeros((n_x, len(s.wiring))), np.zeros(n_x)
        places = [np.arange(s.states[b.name].start, s.states[b.name].stop) for b in blocks]
        self.places = np.concatenate(places) if places else np.zeros(0, np.int64)
        for b, own in zip(blocks, places, strict=True):
            f = b.affine()
            assert f is not None  # the caller has asked
            A[own, s.states[b.name]], B[own, s.inputs[b.name]], a[own] = f.A, f.B, f.a
        self.A, self.B, self.a = A[self.places], B[self.places], a[self.places]

    def into(self, x: Array, u: Array, out: Array) -> None:
        """Put the rates into out."""
        out[self.places] = self.A @ x + self.B @ u + self.a


@dataclass(frozen=True)
class Plan:
    """How a diagram is evaluated while no mode changes: blocks whose outputs need no inputs, runs of affine blocks and
    the other groups in their order, the rates of affine blocks together, and blocks with rates of their own."""

    first: list[Block]
    later: list[AffineRun | Group]
    rates: AffineRates
    alone: list[Block]

    @classmethod
    def of(cls, s: Schedule) -> Plan:
        """For the present modes of the blocks."""
        together = {b.name: b.affine() is not None for b in s.blocks}
        later: list[AffineRun | Group] = []
        run = [b for b in s.first if together[b.name] and not b.direct.any()]
        for group in s.later:
            if not group.torn and together[group.blocks[0].name]:
                run.append(group.blocks[0])
                continue
            later += [AffineRun(s, run)] * bool(run)
            later.append(group)
            run = []
        later += [AffineRun(s, run)] * bool(run)
        dynamic = [b for b in s.blocks if b.n_states]
        rates = AffineRates(s, [b for b in dynamic if together[b.name]])
        first = [b for b in s.first if not together[b.name]]
        return cls(first, later, rates, [b for b in dynamic if not together[b.name]])


def diagram_jacobian(s: Schedule, t: float, x: Array, u: Array, absolute: float) -> Array:
    """dF/dx (n, n) of all states at a time, for the inputs u of all blocks; `absolute` error of a state."""
    n_y, n_u, n_x = s.wiring.shape[1], len(s.wiring), len(x)
    A, B = np.zeros((n_x, n_x)), np.zeros((n_x, n_u))
    C, D = np.zeros((n_y, n_x)), np.zeros((n_y, n_u))
    for b in s.blocks:
        states, inputs, outputs = s.states[b.name], s.inputs[b.name], s.outputs[b.name]
        f = b.affine() or by_differences(b, t, x[states], u[inputs], absolute)
        A[states, states], B[states, inputs], C[outputs, states], D[outputs, inputs] = f.A, f.B, f.C, f.D
    return np.asarray(A + B @ s.wiring @ np.linalg.solve(np.eye(n_y) - D @ s.wiring, C))


def by_differences(b: Block, t: float, x: Array, u: Array, absolute: float) -> Affine:
    """The block about a state, by forward differences of sqrt(eps) of the size of each number."""
    n, m, p = b.n_states, b.n_in, b.n_out
    fixed = b.period is not None or b.lag > 0.0  # its outputs are held, or come from the past
    direct = not fixed and bool(b.direct.any())
    A, B, C, D = np.zeros((n, n)), np.zeros((n, m)), np.zeros((p, n)), np.zeros((p, m))
    if fixed:
        return Affine(A, B, C, D, np.zeros(n), np.zeros(p))

    def at(state: Array, given: Array) -> tuple[Array, Array]:
        y = b.outputs(t, state, given) if direct else b.state_outputs(t, state)
        return np.array(y), np.array(b.derivative(t, state, given)) if n else np.zeros(0)

    y0, f0 = at(x, u) if n or direct else (np.zeros(p), np.zeros(0))
    for k in range(n):
        moved = x.copy()
        moved[k] += DIFFERENCE * max(abs(float(x[k])), absolute / DIFFERENCE, 1e-6)
        y, f = at(moved, u)
        C[:, k], A[:, k] = (y - y0) / (moved[k] - x[k]), (f - f0) / (moved[k] - x[k])
    for k in range(m) if n or direct else ():
        moved = u.copy()
        moved[k] += DIFFERENCE * max(abs(float(u[k])), 1.0)
        y, f = at(x, moved)
        D[:, k], B[:, k] = (y - y0) / (moved[k] - u[k]), (f - f0) / (moved[k] - u[k])
    return Affine(A, B, C, D, np.zeros(n), np.zeros(p))
