"""The element types by keyword, and their statements in the kinematics block, which follow from them.

The rows stand in `planar_types` and `spatial_types`.
"""

from __future__ import annotations

from collections.abc import Callable

from spacar.deck.planar_types import PLANAR
from spacar.deck.spatial_types import COUPLING, SPATIAL
from spacar.deck.table_types import BlockKind, ElementType, Keyword, form, integer

_ALL = (*PLANAR, *SPATIAL)

ELEMENT_TYPES: dict[str, ElementType] = {t.keyword: t for t in _ALL}


def types_that(fit: Callable[[ElementType], bool]) -> str:
    """The keywords of the supported types that fit, for `types` of a form."""
    return " ".join(t.keyword for t in _ALL if t.supported and fit(t))


def types_with(statement: str, planar: bool | None = None) -> str:
    """Those that a statement for some types only applies to; of one space, or of both."""
    return types_that(lambda t: statement in t.statements and planar in (None, t.planar))


def _statement(t: ElementType) -> Keyword:
    head = (
        integer("element number", "element"),
        *(integer(n, f"{role} node") for n, role in zip(t.node_names, t.nodes, strict=True)),
    )
    space = "planar" if t.planar else "spatial"
    given = t.counts or (len(head + t.geometry),)
    counts = tuple(n for n in given if n != 6) if t.geometry[-1:] == (COUPLING,) else given
    variants = [form(head + t.geometry, *counts, space=space)]
    if counts != given:
        variants.append(form((*head, COUPLING), 6, space=space))
    modes = "; ".join(f"{i} {name} [{unit}]" for i, (name, unit) in enumerate(t.modes, 1))
    notes = (f"Deformation modes: {modes}.", *t.notes)
    return Keyword(t.keyword, BlockKind.KINEMATICS, f"{t.title} element", tuple(variants), notes=notes)


KEYWORDS = tuple(_statement(t) for t in _ALL)
