"""Mode 3 on NAME_3 after a mode 10 run on NAME: matrices about the stored load steps."""

import json
from pathlib import Path

import numpy as np
import pytest

import spacar
from spacar.deck import parse_deck
from spacar.errors import UsageError
from tests.command_line import call

HINGE = """PLBEAM 1 1 2 3 4   PLBEAM 2 3 4 5 6   PLBEAM 3 5 6 7 8   X 3 0.1 0   X 5 0.2 0.02   X 7 0.3 0.02
FIX 1   FIX 2   {held} 7 2   DYNE 1 1 2 3   DYNE 2 1 2 3   DYNE 3 {last}   {released}   OUTLEVEL 0 1
END HALT
EM 1 0.8   EM 2 0.8   EM 3 0.8   XM 7 0.5   ESTIFF 1 2e6 2.1   ESTIFF 2 2e6 2.1   ESTIFF 3 2e6 2.1
EDAMP 2 0 0.01   ESIG 1 3 0.02 0   GRAVITY 1 -9.81   XF 7 -4 0   {motion}
ITERSTEP 40 4 1e-10 1 2 3   END END
"""
HELD = {"held": "INPUTX", "last": "1 3", "released": "RLSE 3 2"}
MOTION = "INPUTX 7 2 0.01\nDELINPX 7 2 0.05\nDELXF 5 2 1"
STEPS = 5


def text(held: str = "INPUTX", motion: str = MOTION, **more: str) -> str:
    return HINGE.format(**{**HELD, "held": held, "motion": motion, **more})


@pytest.fixture(scope="module")
def ten() -> spacar.Result:
    return spacar.run(10, parse_deck(text(), mode=10))


@pytest.fixture(scope="module")
def three(ten: spacar.Result) -> spacar.Result:
    return spacar.run(3, parse_deck(text("DYNX"), mode=3), nominal=ten)


def rows(ten: spacar.Result, three: spacar.Result) -> np.ndarray:
    """Rows of q in mode 3 that mode 10 has too."""
    names = list(three.mechanism.numbering.q_names)
    n = ten.mechanism.numbering
    return np.array([names.index(n.q_names[i]) for i in n.dynamic])


def test_matrices_are_those_of_mode_10(ten, three):
    """Two ways to the stresses: from the equilibrium with all loads of the step, and the stationary solution."""
    kept = rows(ten, three)
    assert len(three.t) == len(ten.t) == STEPS
    assert len(three["m0"][0]) == len(kept) + 1
    for name in ("m0", "k0", "n0", "g0", "d0", "c0"):
        for k in range(STEPS):
            here, there = three[name][k][np.ix_(kept, kept)], ten[name][k]
            # the stationary solution is in equilibrium to 1e-8 of its loads, on which only G0 depends
            size = np.max(np.abs(ten["k0"][k] if name == "g0" else there), initial=0.0)
            assert np.max(np.abs(here - there)) <= 1e-9 * size, (name, k)
    assert three["sig"] == pytest.approx(ten["sig"], rel=1e-6, abs=1e-6)
    assert three["x"] == pytest.approx(ten["x"], abs=1e-12)


def test_frequencies_are_those_of_the_free_mechanism_in_the_same_state(ten, three):
    """The reaction of the held coordinate as a dead force: the free mechanism is in equilibrium at the same place."""
    n = ten.mechanism.numbering
    at = n.x_index(7, 2)
    reaction = (ten["fxtot"] - ten["fx"] - ten["fxgrav"])[-1, at]
    loads = f"DELXF 5 2 1\nDELXF 7 0 {float(reaction)!r}"
    free = text("DYNX", motion=loads)
    result = spacar.run(7, parse_deck(free.replace("ITERSTEP 40 4 1e-10 1 2 3", "ITERSTEP 40 20 1e-10 20 2 3"), mode=7))
    # the released moment of beam 3 stays released: one degree of freedom more, the held coordinate
    assert result["x"][-1] == pytest.approx(ten["x"][-1], abs=1e-7)
    M, K, C = (three[name][-1] for name in ("m0", "k0b", "c0b"))
    size = len(M)
    A = np.block([[np.zeros((size, size)), np.eye(size)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])
    found, truth = np.linalg.eigvals(A), result["eigval"][-1] @ [1, 1j]
    for value in truth:
        assert np.min(np.abs(found - value)) <= 1e-6 * abs(value)


def test_the_nominal_force_is_the_reaction(ten):
    """A force named as nominal input holds the coordinate: u0 is the reaction of every load step, y0 its place."""
    deck = parse_deck(text("DYNX").replace("END END", "END HALT NOMF 1 7 2 REFX 1 7 2 END END"), mode=3)
    result = spacar.run(3, deck, nominal=ten)
    at = ten.mechanism.numbering.x_index(7, 2)
    reaction = (ten["fxtot"] - ten["fx"] - ten["fxgrav"])[:, at]
    assert result["u0"][:, 0] == pytest.approx(reaction, rel=1e-7, abs=1e-7)
    assert result["y0"][:, 0] == pytest.approx(ten["x"][:, at], abs=1e-12)
    assert not [line for line in result.report if "warning" in line]


def test_another_iterstep_is_refused(ten):
    deck = parse_deck(text("DYNX").replace("ITERSTEP 40 4", "ITERSTEP 40 3"), mode=3)
    with pytest.raises(UsageError, match="5 load steps, but ITERSTEP of this file asks for 4"):
        spacar.run(3, deck, nominal=ten)


def command(*words: object) -> str:
    """Standard output of a command that must succeed."""
    done = call.done(*words)
    return done.out


def test_the_files_as_spacar_light_writes_them(tmp_path: Path):
    """NAME_3 finds NAME; values of what is free now are no errors; M0, K0B, C0B are in the .ltv."""
    (tmp_path / "hinge.dat").write_text(text())
    (tmp_path / "hinge_3.dat").write_text(text("DYNX"))
    for mode, name in (("10", "hinge"), ("9", "hinge"), ("10", "hinge"), ("3", "hinge_3")):
        command(mode, tmp_path / name)
        if mode == "9":  # the last run on NAME may be one of mode 9
            command("3", tmp_path / "hinge_3")
    log = (tmp_path / "hinge_3.log").read_text()
    assert "the mode 10 result hinge.sbd" in log
    assert "node 7 y" in command("eigen", tmp_path / "hinge_3")
    assert {"M0", "K0B", "C0B"} <= set(command("checksbf", tmp_path / "hinge_3.ltv").split())


def test_compliance_of_the_free_mechanism(tmp_path: Path):
    """`spacar compliance NAME_3`: with the coordinate free, W K^-1 W^T of the stored matrices."""
    (tmp_path / "hinge.dat").write_text(text())
    (tmp_path / "hinge_3.dat").write_text(text("DYNX"))
    command("10", tmp_path / "hinge")
    command("3", tmp_path / "hinge_3")
    found = np.array(json.loads(command("compliance", tmp_path / "hinge_3", "7", "--at", "2", "--json"))["global"])
    nominal = spacar.run(10, tmp_path / "hinge.dat")
    result = spacar.run(3, tmp_path / "hinge_3.dat", nominal=nominal)
    n = result.mechanism.numbering
    rows = [n.x_index(7, 1), n.x_index(7, 2), n.x_index(8, 1)]
    W = result["dx"][1].reshape(n.nx, -1)[rows][:, : n.ndof]
    assert found == pytest.approx(W @ np.linalg.solve(result["k0b"][1], W.T), rel=1e-8, abs=1e-12)
