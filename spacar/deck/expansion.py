"""What SECTION, MATERIAL and BEAMSEC come to: plain statements, and what is kept of the beams for logs and pictures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

from spacar.deck.outline import Outline
from spacar.deck.statement import Statement
from spacar.deck.table_sections import KEYWORDS

if TYPE_CHECKING:
    from spacar.deck.cross_section import Material, SectionConstants  # most models have no sections

WORDS = frozenset(k.name for k in KEYWORDS)


@dataclass(frozen=True)
class BeamSection:
    """What one BEAMSEC says: the element, its parts (the first is the element), names, shape and dimensions [m]."""

    element: int
    parts: tuple[int, ...]
    section: str
    material_name: str
    shape: str
    dims: tuple[float, ...]
    constants: SectionConstants
    material: Material


class Expansion(NamedTuple):
    """Plain statements, the outline of their model, what was expanded, and lines for pictures."""

    statements: tuple[Statement, ...]
    outline: Outline
    sections: tuple[BeamSection, ...]
    visualization: tuple[str, ...]
