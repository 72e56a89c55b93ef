"""Inputs and outputs of the linearization from the deck (input-language.md section 8)."""

from __future__ import annotations

from spacar.linear.state_space import INPUT_KINDS, OUTPUT_KINDS, Signal
from spacar.mechanism.mechanism import Mechanism

OF_NODES = (
    "INPUTF", "INX", "INXP", "INXDP", "OUTF", "OUTX", "OUTXP", "OUTXDP", "NOMF", "REFX", "REFXP", "REFXDP", "REFXS",
)  # fmt: skip


def signals(mechanism: Mechanism, kinds: tuple[str, ...]) -> list[Signal]:
    """Signals of these keywords in the order of their numbers."""
    n, deck = mechanism.numbering, mechanism.deck
    found: dict[int, Signal] = {}
    for s in deck.of(*kinds, block=3):
        place, a, b = (int(v) for v in s.values[:3])
        if s.keyword in OF_NODES:
            index = n.x_index(a, b)
            name = n.x_name(index)
        else:
            index = n.e_index(a, b)
            name = n.e_name(index)
        found[place] = Signal(s.keyword, index, f"{s.keyword} {name}")
    return [found[k] for k in sorted(found)]


def linearization_signals(mechanism: Mechanism) -> tuple[list[Signal], list[Signal]]:
    """Inputs and outputs of modes 4 and 9."""
    return signals(mechanism, INPUT_KINDS), signals(mechanism, OUTPUT_KINDS)
