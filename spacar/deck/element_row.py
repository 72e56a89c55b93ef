"""What a row of an element type is written with: the call that makes it, and the nodes and modes that several share."""

from __future__ import annotations

from typing import Any

from spacar.deck.table_types import ElementType, Parameter

P, O, W = "position", "orientation", "warping"
BEAM_NODES = ((P, O, P, O), ("p position node", "p orientation node", "q position node", "q orientation node"))
BAR_NODES = ((P, P), ("p position node", "q position node"))
JOINT_NODES = ((O, O), ("p orientation node", "q orientation node"))
BODY_NODES = ((P, O, P), ("p position node", "p orientation node", "q position node"))

STRETCH = (("elongation", "m"),)
TURN = (("relative rotation", "rad"),)
BODY_MODES = tuple((f"displacement along direction {i}", "m") for i in (1, 2, 3))


def element_type(
    keyword: str, title: str, code: int, planar: bool, nodes: tuple[tuple[str, ...], tuple[str, ...]],
    modes: tuple[tuple[str, str], ...], geometry: tuple[Parameter, ...] = (), counts: tuple[int, ...] = (),
    **facts: Any,
) -> ElementType:  # fmt: skip
    """A row; `facts` are the other fields of `ElementType`."""
    roles, names = nodes
    counts = counts or (1 + len(roles) + len(geometry),)
    return ElementType(keyword, title, code, planar, roles, names, modes, geometry, counts, **facts)
