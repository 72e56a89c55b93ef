"""A diagram: blocks and wires, and the order in which outputs can be computed.

Signals are named as text: "robot" is all signals of that block, "robot:1-6,10" some of them, numbered from 1
as in the input file. Several wires to one input are added. Outputs that do not depend directly on the inputs
of their block are computed first; then every other block follows those it needs. A loop of direct dependence
is refused.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import Array, Index
from spacar.errors import UsageError
from spacar.simulation.blocks import Block


@dataclass
class Diagram:
    """Blocks by name and wires (source block, its outputs, target block, its inputs, gain)."""

    blocks: dict[str, Block] = field(default_factory=dict)
    wires: list[tuple[str, Index, str, Index, Array]] = field(default_factory=list)

    def add(self, *blocks: Block) -> Diagram:
        """Add blocks. Raises UsageError when a name is taken or cannot be used in a signal name."""
        for block in blocks:
            if not block.name or any(c in block.name for c in ":, \t->"):
                raise UsageError(
                    f"'{block.name}' cannot be the name of a block: no spaces, ':', ',', '-', '>'", "simulation.name"
                )
            if block.name in self.blocks:
                raise UsageError(f"there are two blocks with the name {block.name}", "simulation.name")
            self.blocks[block.name] = block
        return self

    def connect(self, source: str, target: str, gain: float | Array = 1.0) -> Diagram:
        """A wire from outputs to inputs. `gain` is a number or a matrix (inputs, outputs).

        Raises UsageError when a block or signal does not exist or the numbers of signals differ.
        """
        source_name, rows = self.signals(source, "output")
        target_name, columns = self.signals(target, "input")
        K = np.asarray(gain, float)
        if K.ndim == 0:
            if len(rows) != len(columns):
                text = f"{source} -> {target}: {len(rows)} outputs cannot be connected to {len(columns)} inputs"
                raise UsageError(text, "simulation.wire")
            K = float(K) * np.eye(len(rows))
        if K.shape != (len(columns), len(rows)) or not np.isfinite(K).all():
            shape = (len(columns), len(rows))
            text = f"{source} -> {target}: the gain must be finite and of the shape {shape}, not {K.shape}"
            raise UsageError(text, "simulation.wire")
        self.wires.append((source_name, rows, target_name, columns, K))
        return self

    def signals(self, text: str, what: str = "output") -> tuple[str, Index]:
        """Block name and 0-based signal numbers of "name" or "name:1-3,7". Raises UsageError."""
        name, colon, numbers = text.strip().partition(":")
        block = self.blocks.get(name.strip())
        if block is None:
            known = ", ".join(self.blocks) or "none"
            raise UsageError(f"{text}: there is no block {name.strip()}; the blocks are {known}", "simulation.signal")
        count = block.n_in if what == "input" else block.n_out
        if not colon:
            return block.name, np.arange(count)
        found: list[int] = []
        for part in numbers.split(","):
            first, dash, last = part.partition("-")
            try:
                a = int(first)
                b = int(last) if dash else a
            except ValueError:
                raise UsageError(f"{text}: '{part.strip()}' is no signal number", "simulation.signal") from None
            if not 1 <= a <= b <= count:
                raise UsageError(f"{text}: block {block.name} has the {what}s 1 to {count}", "simulation.signal")
            found += range(a - 1, b)
        return block.name, np.array(found, np.int64)


@dataclass(frozen=True)
class Schedule:
    """A diagram ready to run: slices of all signals, the wiring matrix and the order of the blocks."""

    blocks: tuple[Block, ...]
    wiring: Array  # (all inputs, all outputs)
    inputs: dict[str, slice]
    outputs: dict[str, slice]
    states: dict[str, slice]
    first: tuple[Block, ...]  # blocks with outputs that need no inputs
    later: tuple[Block, ...]  # blocks with direct feedthrough, each after those it needs
    notes: tuple[str, ...] = ()


def schedule(diagram: Diagram) -> Schedule:
    """Number all signals and find the order. Raises UsageError for an algebraic loop."""
    blocks = tuple(diagram.blocks.values())
    inputs = _slices(blocks, [b.n_in for b in blocks])
    outputs = _slices(blocks, [b.n_out for b in blocks])
    wiring = np.zeros((sum(b.n_in for b in blocks), sum(b.n_out for b in blocks)))
    connected = np.zeros(len(wiring), bool)
    for source, rows, target, columns, K in diagram.wires:
        wiring[np.ix_(inputs[target].start + columns, outputs[source].start + rows)] += K
        connected[inputs[target].start + columns] = True
    direct = [b for b in blocks if b.direct.any()]
    needs = {
        b.name: [c.name for c in direct if np.any(wiring[inputs[b.name], outputs[c.name]][:, c.direct])] for b in direct
    }
    order = _sorted(needs)
    return Schedule(
        blocks, wiring, inputs, outputs, _slices(blocks, [b.n_states for b in blocks]),
        tuple(b for b in blocks if not b.direct.all() or not b.n_in), tuple(diagram.blocks[name] for name in order),
        _unconnected(blocks, inputs, connected),
    )  # fmt: skip


def _slices(blocks: tuple[Block, ...], sizes: list[int]) -> dict[str, slice]:
    edges = np.cumsum([0, *sizes]).tolist()
    return {b.name: slice(i, j) for b, i, j in zip(blocks, edges, edges[1:], strict=False)}


def _unconnected(blocks: tuple[Block, ...], inputs: dict[str, slice], connected: NDArray[np.bool_]) -> tuple[str, ...]:
    """What to say about inputs without a wire."""
    notes = []
    for block in blocks:
        open_ends = np.flatnonzero(~connected[inputs[block.name]])
        notes += [f"input {k + 1} ({block.inputs[k]}) of {block.name} is not connected: it is zero" for k in open_ends]
    return tuple(notes)


def _sorted(needs: dict[str, list[str]]) -> list[str]:
    """Topological order; UsageError that names the blocks of a loop."""
    order: list[str] = []
    state: dict[str, int] = {}

    def visit(name: str, trail: Iterable[str]) -> None:
        trail = (*trail, name)
        if state.get(name) == 1:
            loop = trail[trail.index(name) :]
            raise UsageError(
                f"algebraic loop: {' <- '.join(loop)}; each of these blocks needs the present output of the next one."
                " Feed back positions or rates instead of accelerations, or use a sampled block with delay, or a block"
                " with states",
                "simulation.algebraic-loop",
            )
        if name in state:
            return
        state[name] = 1
        for other in needs[name]:
            visit(other, trail)
        state[name] = 2
        order.append(name)

    for name in needs:
        visit(name, ())
    return order
