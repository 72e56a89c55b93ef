"""All checks of a deck that need more than one statement, block by block; those of the elements: numbers, roles of
nodes, planar or spatial, support; those of input and output numbers."""

from spacar.deck.check_material import CheckMaterial, check_classes, check_once
from spacar.deck.checks_classes import classify
from spacar.deck.checks_dynamics import check_dynamics
from spacar.deck.checks_geometry import check_geometry
from spacar.deck.checks_trajectory import check_trajectories
from spacar.deck.findings import Findings, ranges
from spacar.deck.keyword_table import keyword_of
from spacar.deck.outline import Outline
from spacar.deck.statement import Statement, StatementIndex
from spacar.deck.table_elements import ELEMENT_TYPES
from spacar.deck.table_types import BlockKind, Purpose
from spacar.modes import MODES


def check(
    statements: StatementIndex, outline: Outline, mode: Purpose, third: BlockKind | None, findings: dict[int, Findings]
) -> None:
    """Run all checks; the messages of block b go to `findings[b]`."""
    scene = CheckMaterial(statements, outline, mode, third, findings[1])
    check_elements(scene)
    check_geometry(scene)
    classify(scene)
    check_once(scene, 1)
    for s in scene.index.of("OUTLEVEL", block=1):
        for i, most in enumerate((15, 3)[: len(s.values)]):
            if not -1 <= s.integer(i) <= most:
                text = f"output level {s.values[i]} has flags without meaning; allowed: -1 to {most}"
                scene.findings.warning(s, i, text, "choice")
    scene.findings = findings[2]
    if statements.keywords(2):
        check_once(scene, 2)
        check_classes(scene, 2)
    check_dynamics(scene)
    scene.findings = findings[3]
    if third is BlockKind.TRAJECTORY:
        check_trajectories(scene)
    elif third is not None:
        check_classes(scene, 3)
    if third is not None:
        check_ports(scene)


_HARM = ("not supported", "slips")  # what a type may have that speaks against its elements, at least in some modes


def check_elements(scene: CheckMaterial) -> None:
    outline, findings = scene.outline, scene.findings
    elements = scene.index.of(*ELEMENT_TYPES) if not outline.regular or not outline.traits.isdisjoint(_HARM) else []
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


def check_ports(scene: CheckMaterial) -> None:
    """The numbers are the positions in the vectors u and y, so there must be no gap and no second use."""
    used: dict[str, dict[int, Statement]] = {"input": {}, "output": {}}
    rows = [keyword_of(name, 3, scene.third) for name in scene.index.keywords(3)]
    nouns = {row.name: row.variants[0].parameters[0].of for row in rows}
    for s in scene.index.of(*(name for name, noun in nouns.items() if noun in used), block=3):
        noun, number = nouns[s.keyword], s.integer(0)
        first = used[noun].setdefault(number, s)
        if number < 1:
            scene.findings.error(s, 0, f"{noun} number {number} must be positive", "port-number")
        elif first is not s:
            text = f"{noun} number {number} is already used by {first.keyword} at line {first.line}"
            scene.findings.error(s, 0, text, "port-number")
    for noun, numbers in used.items():
        good = {n for n in numbers if n >= 1}
        if not good or max(good) == len(good) or 3 in scene.outline.broken_blocks:
            continue
        last = max(good)
        lowest = next(n for n in range(1, last) if n not in good)
        text = f"{noun} numbers must be 1 to n without gaps: {lowest} is missing, {ranges(good)} are used"
        scene.findings.error(numbers[last], 0, text, "port-number")
