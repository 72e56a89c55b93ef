"""A diagram: blocks and wires, and the order in which outputs can be computed.

Signals are named as text: "robot" is all signals of that block, "robot:1-6,10" some of them, numbered from 1 as in the
input file. Several wires to one input are added. Outputs that do not depend directly on the inputs of their block are
computed first; then every other block follows those it needs. Blocks that need each other at the same time are an
algebraic loop, solved in algebraic_loops.py; a loop with a sampled block in it is refused.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from spacar.arrays import Array, Index
from spacar.errors import UsageError
from spacar.simulation.algebraic_loops import Group, Needs, components, one_loop, torn_order
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
    later: tuple[Group, ...]  # blocks with direct feedthrough and algebraic loops, each after those it needs
    notes: tuple[str, ...] = ()

    @property
    def n_states(self) -> int:
        return sum(b.n_states for b in self.blocks)


def schedule(diagram: Diagram) -> Schedule:
    """Number all signals and find the order. Raises UsageError for an algebraic loop with a sampled block."""
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
    groups = tuple(_group(diagram, needs, part, inputs, outputs) for part in components(needs))
    loops = [
        f"the algebraic loop {g.loop} is solved at every step, {len(g.tearing)} unknown" + "s" * (len(g.tearing) > 1)
        for g in groups
        if g.torn
    ]
    unconnected = [
        f"input {k + 1} ({b.inputs[k]}) of {b.name} is not connected: it is zero"
        for b in blocks
        for k in np.flatnonzero(~connected[inputs[b.name]])
    ]
    return Schedule(
        blocks, wiring, inputs, outputs, _slices(blocks, [b.n_states for b in blocks]),
        tuple(b for b in blocks if not b.direct.all() or not b.n_in), groups,
        (*unconnected, *loops),
    )  # fmt: skip


def _group(
    diagram: Diagram, needs: Needs, part: list[str], inputs: dict[str, slice], outputs: dict[str, slice]
) -> Group:
    """A block, or a loop in the order of its evaluation. Raises UsageError for a loop with a sampled block."""
    if len(part) == 1 and part[0] not in needs[part[0]]:
        return Group((diagram.blocks[part[0]],))
    loop = " <- ".join(one_loop(needs, part))
    sampled = [name for name in part if diagram.blocks[name].period is not None]
    if sampled:
        text = (
            f"algebraic loop: {loop}; each of these blocks needs the present output of the next one, and the sampled"
            f" block {sampled[0]} cannot be asked twice at the same time. Feed back positions or rates instead of"
            " accelerations, or delay a sampled block (delay, unit-delay), or use a block with states"
        )
        raise UsageError(text, "simulation.algebraic-loop")
    into = {}
    for source in part:
        rows = np.unique(np.concatenate([r for s, r, t, _, _ in diagram.wires if s == source and t in part]))
        into[source] = rows[diagram.blocks[source].direct[rows]]
    order, torn = torn_order(needs, part, {name: len(rows) for name, rows in into.items()})
    return Group(
        tuple(diagram.blocks[name] for name in (*order, *torn)),
        tuple(diagram.blocks[name] for name in torn),
        np.concatenate([outputs[name].start + into[name] for name in torn]),
        np.concatenate([np.arange(inputs[name].start, inputs[name].stop) for name in part]),
        loop,
    )


def _slices(blocks: tuple[Block, ...], sizes: list[int]) -> dict[str, slice]:
    edges = np.cumsum([0, *sizes]).tolist()
    return {b.name: slice(i, j) for b, i, j in zip(blocks, edges, edges[1:], strict=False)}


def wired_names(diagram: Diagram, block: Block) -> list[str]:
    """What comes into each input of a block, by the names of the signals: "y0:10 - robot:10" with their names."""
    terms: list[list[str]] = [[] for _ in block.inputs]
    for source, rows, target, columns, K in diagram.wires:
        if target != block.name:
            continue
        names = diagram.blocks[source].outputs_
        for i, row in zip(columns, K, strict=True):
            for j, factor in zip(rows, row, strict=True):
                if factor:
                    size = "" if abs(factor) == 1.0 else f"{abs(factor):.4g} "
                    terms[i].append(f"{'-' if factor < 0.0 else '+'} {size}{source} {names[j]}")
    return [" ".join(t).removeprefix("+ ") or "not connected" for t in terms]
