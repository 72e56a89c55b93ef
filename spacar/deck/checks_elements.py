"""Checks of the elements: numbers, node roles, planar or spatial, support."""

from __future__ import annotations

from spacar.deck.check_material import CheckMaterial
from spacar.deck.statement import Statement
from spacar.deck.table_elements import ELEMENT_TYPES
from spacar.modes import MODES

_HARM = ("not supported", "slips")  # what a type may have that speaks against its elements, at least in some modes


def check_elements(scene: CheckMaterial) -> None:
    """Everything that concerns the element statements as such."""
    outline, findings = scene.outline, scene.findings
    elements = scene.of(*ELEMENT_TYPES) if not outline.regular or not outline.traits.isdisjoint(_HARM) else []
    if not outline.types and outline.complete and not findings.errors:
        findings.add("error", None, "", "the kinematics block defines no element", "no-element")
    first_of_kind: dict[bool, Statement] = {}
    for s in elements:
        kind = ELEMENT_TYPES[s.keyword]
        first = outline.elements[s.integer(0)]
        if first is not s:
            text = f"element {s.values[0]} is already defined at line {first.line} ({first.keyword})"
            findings.error(s, 0, text, "duplicate-element")
        if not kind.supported:
            text = f"a {kind.title} is not supported, also not by the original program"
            findings.error(s, None, text, "not-supported")
        if kind.slips and scene.analysis is not None and not scene.analysis.wheels:
            able = ", ".join(str(number) for number, mode in MODES.items() if mode.wheels)
            text = f"non-holonomic element in mode {scene.mode}: only modes {able} support it"
            findings.error(s, None, text, "non-holonomic")
        other = first_of_kind.get(not kind.planar)
        if kind.planar not in first_of_kind:
            first_of_kind[kind.planar] = s
            if other is not None:
                words = ("planar", "spatial") if kind.planar else ("spatial", "planar")
                text = f"{words[0]} element in a model with the {words[1]} element {other.subject} (line {other.line})"
                findings.error(s, None, text, "planar-and-spatial")
        _check_nodes(s, scene)


def _check_nodes(s: Statement, scene: CheckMaterial) -> None:
    """Every node in its role; the two ends of an element must be different."""
    outline = scene.outline
    seen: dict[tuple[int, str], int] = {}
    for i, role in enumerate(ELEMENT_TYPES[s.keyword].nodes, 1):
        node = s.integer(i)
        if (node, role) in seen:
            scene.findings.error(s, i, f"p and q are the same {role} node {node}", "same-node")
            continue
        seen[node, role] = i
        if outline.roles.get(node, role) != role:
            user = outline.user(node)
            at = f"{user.subject} (line {user.line})" if user is not s else "this element itself"
            text = f"{role} node {node} is used as {outline.roles[node]} node by {at}"
            scene.findings.error(s, i, text, "node-role")
