"""Diagrams of blocks in a row."""

from itertools import pairwise
from typing import Any

from spacar.simulation import Diagram


def chain(*blocks: Any) -> Diagram:
    """The outputs of each block are the inputs of the next one."""
    d = Diagram().add(*blocks)
    for a, b in pairwise(blocks):
        d.connect(a.name, b.name)
    return d


def ring(*blocks: Any) -> Diagram:
    """And those of the last one the inputs of the first."""
    return chain(*blocks).connect(blocks[-1].name, blocks[0].name)
