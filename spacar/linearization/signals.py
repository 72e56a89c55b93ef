"""Inputs and outputs of the linearized equations: which there are says input-language.md section 8."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from spacar.mechanism.mechanism import Mechanism
from spacar.mechanism.numbering import Numbering

DRIVING_SIGN = 1.0  # s_u of theory-system.md 5.1

INPUT_KINDS = ("INPUTS", "INPUTF", "INE", "INEP", "INEDP", "INX", "INXP", "INXDP")
OUTPUT_KINDS = ("OUTS", "OUTE", "OUTEP", "OUTEDP", "OUTF", "OUTX", "OUTXP", "OUTXDP")
ORDER = {"INX": 0, "INE": 0, "INXP": 1, "INEP": 1, "INXDP": 2, "INEDP": 2}  # value, rate, acceleration


@dataclass(frozen=True)
class Signal:
    """One input or output: kind (keyword), 0-based index into x or e, and a name for plots."""

    kind: str
    index: int
    name: str


def prescribed_row(n: Numbering, signal: Signal) -> int:
    """Place among all degrees of freedom of the one whose value, rate or acceleration an INX, INE, ... input is."""
    of_x = signal.kind.startswith("INX")
    found = np.flatnonzero((n.q_x if of_x else n.q_e) == signal.index)[0]
    return int(found) + (0 if of_x else len(n.q_x))


def has_feedthrough(inputs: Sequence[Signal], outputs: Sequence[Signal]) -> bool:
    """Can D differ from zero? Decided by the kinds alone, so that all steps of a run agree.

    Second derivatives and reactions follow every input; coordinates and deformations follow prescribed values, their
    rates prescribed values and rates.
    """
    prescribed = {"INX", "INE"}
    sources = {"OUTX": prescribed, "OUTE": prescribed}
    sources |= dict.fromkeys(("OUTXP", "OUTEP"), prescribed | {"INXP", "INEP"})
    kinds = {signal.kind for signal in inputs}
    return any(kinds & sources.get(signal.kind, kinds) for signal in outputs)


def signals(mechanism: Mechanism, kinds: tuple[str, ...]) -> list[Signal]:
    """Signals of these keywords in the order of their numbers."""
    n, deck = mechanism.numbering, mechanism.deck
    found: dict[int, Signal] = {}
    for s in deck.of(*kinds, block=3):
        place, a, b = (int(v) for v in s.values[:3])
        of_node = "X" in s.keyword or s.keyword.endswith("F")  # a coordinate, a force
        index = n.x_index(a, b) if of_node else n.e_index(a, b)
        found[place] = Signal(s.keyword, index, f"{s.keyword} {n.x_name(index) if of_node else n.e_name(index)}")
    return [found[k] for k in sorted(found)]


def linearization_signals(mechanism: Mechanism) -> tuple[list[Signal], list[Signal]]:
    """Inputs and outputs of modes 4 and 9."""
    return signals(mechanism, INPUT_KINDS), signals(mechanism, OUTPUT_KINDS)
