"""All checks of a deck that need more than one statement, block by block."""

from __future__ import annotations

from spacar.deck.check_material import CheckMaterial
from spacar.deck.checks_classes import classify
from spacar.deck.checks_dynamics import check_dynamics
from spacar.deck.checks_elements import check_elements
from spacar.deck.checks_geometry import check_geometry
from spacar.deck.checks_ports import check_ports
from spacar.deck.checks_references import check_classes, check_once
from spacar.deck.checks_trajectory import check_trajectories
from spacar.deck.findings import Findings
from spacar.deck.mode_blocks import Purpose
from spacar.deck.outline import Outline
from spacar.deck.statement_index import StatementIndex
from spacar.deck.table_types import BlockKind


def check(
    statements: StatementIndex, outline: Outline, mode: Purpose, third: BlockKind | None, findings: dict[int, Findings]
) -> None:
    """Run all checks; the messages of block b go to `findings[b]`."""
    scene = CheckMaterial(statements, outline, mode, third, findings[1])
    check_elements(scene)
    check_geometry(scene)
    classify(scene)
    check_once(scene, 1)
    if scene.has(("OUTLEVEL",), 1):
        _check_output_level(scene)
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


def _check_output_level(scene: CheckMaterial) -> None:
    for s in scene.of("OUTLEVEL", block=1):
        for i, most in enumerate((15, 3)[: len(s.values)]):
            if not -1 <= s.integer(i) <= most:
                text = f"output level {s.values[i]} has flags without meaning; allowed: -1 to {most}"
                scene.findings.warning(s, i, text, "choice")
