"""Warnings at RLSE on a beam without ESTIFF: where stiffness is lost, and only there."""

from pathlib import Path

import pytest

import spacar
from spacar.kinematics.lost_stiffness import lost_stiffness
from spacar.kinematics.release import release
from spacar.mechanism import build
from tests.examples import DATA

from .guides import guide


def warnings(text: str) -> list[str]:
    deck = spacar.parse_deck(text)
    return [str(m) for m in lost_stiffness(deck, build(deck))]


def test_hinges_in_the_coupler_are_said_in_every_mode() -> None:
    """What mode 0 once suggested: status 0, no warning, a quarter of the stiffness."""
    deck = release(spacar.parse_deck(guide(2))).deck
    text = deck.text.replace("END HALT", "RLSE 2 1 2 3\nEND HALT", 1).replace("RLSE 3 4\n", "DYNE 3 4\n")
    found = warnings(text)
    assert len(found) == 1
    assert found[0].startswith("warning: <deck>:")
    assert "RLSE 2: releases mode 1 (elongation), 2 (torsion), 3 (bending at p in the x'z' plane) of a BEAM" in found[0]
    assert "hinge" in found[0]
    assert any("RLSE 2: releases" in line for line in spacar.run(0, spacar.parse_deck(text, mode=0)).report)


@pytest.mark.parametrize("path", sorted(DATA.glob("*.dat")), ids=lambda p: p.stem)
def test_the_examples_have_no_such_warning(path: Path) -> None:
    deck = spacar.read_deck(path)
    assert lost_stiffness(deck, build(deck)) == []


def test_releases_that_keep_the_physics_have_none() -> None:
    assert warnings(release(spacar.parse_deck(guide(3))).deck.text) == []


RIGID_RING = (
    "PLBEAM 1 1 2 3 4\nPLBEAM 2 3 4 5 6\nPLBEAM 3 5 6 1 2\nX 1 0. 0.\nX 3 1. 0.\nX 5 0. 1.\nFIX 1\n{classes}\n"
    "END HALT\nXM 3 1.\nXM 4 1.\n{dynamics}\nEND END\n"
)


def test_a_cut_ring_of_rigid_beams_loses_nothing() -> None:
    """Three rigid beams in a triangle are over-constrained three times: cutting one leaves a rigid body."""
    assert warnings(RIGID_RING.format(classes="DYNX 2\nRLSE 3 1 2", dynamics="EM 3 1.")) == []
    free = RIGID_RING.format(classes="DYNX 2\nRLSE 3 1 2\nRLSE 2 3\nDYNX 5 1", dynamics="")
    assert warnings(free)


@pytest.mark.parametrize("law", ["ESTIFF 1 0. 1.", "EDAMP 1 0. 1.", "ESIG 1 0. 1. 1."])
def test_any_stress_law_counts(law: str) -> None:
    arm = "PLBEAM 1 1 2 3 4\nX 3 1. 0.\nFIX 1\nFIX 2\nRLSE 1 2 3\nDYNX 3 2\nDYNX 4\nEND HALT\nXM 3 1.\n{}\nEND END\n"
    assert len(warnings(arm.format(""))) == 1
    assert warnings(arm.format(law)) == []


def test_measuring_beams_and_files_without_dynamics_have_none() -> None:
    arm = "PLBEAM 1 1 2 3 4\nX 3 1. 0.\nFIX 1\nFIX 2\nRLSE 1\nDYNX 3\nDYNX 4\n{}END END\n"
    assert warnings(arm.format("END HALT\nXM 3 1.\n")) == []  # carries nothing and has no mass: it measures
    assert len(warnings(arm.format("END HALT\nEM 1 1.\n"))) == 1
    assert warnings(arm.format("")) == []
