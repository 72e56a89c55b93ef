"""Mode 3: against mode 4 at the same states, against differences, and refusals."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from spacar_formats.ltvfile import read_ltv

import spacar
from spacar import Deck
from spacar.deck import parse_deck
from spacar.errors import AnalysisError, UsageError
from spacar.inverse import Nominal
from spacar.linear import form
from spacar.simulation.time_varying import TimeVarying
from tests.command_line import call
from tests.dynamics.test_mass_check import in_line
from tests.examples import DATA

from . import arm

MOTION = [
    ("TRAJECT", 1), ("TRE", 1, 0.5), ("TREPMAX", 1, 0.3, 0.8), ("TRE", 2, -0.8), ("TRFRONT", 2, 1), ("TRTIME", 1.0, 10),
    *arm.MOTORS,
]  # fmt: skip
OUTPUTS = [("REFXS", 1, 7, 1), ("REFX", 2, 7, 2), ("REFE", 3, 1, 1), ("REFXP", 4, 7, 1), ("REFXDP", 5, 7, 2)]


@pytest.fixture(scope="module")
def nominal():
    return spacar.run(2, arm.deck(arm.PRESCRIBED_JOINTS, MOTION))


@pytest.fixture(scope="module")
def linear(nominal):
    deck = arm.deck(arm.PRESCRIBED_JOINTS, [*arm.MOTORS, *OUTPUTS], mode=3)
    return spacar.run(3, deck, nominal=nominal)


@pytest.mark.parametrize("step", [0, 2, 5, 9])
def test_matrices_equal_those_of_mode_4_at_the_same_state(nominal, linear, step):
    """In mode 4 the joints are free and carry the nominal stresses as preload: the same motion at that instant."""
    q = [nominal.element(i, 1)[step] for i in (1, 2)]
    qd = [nominal.element(i, 1, "ed")[step] for i in (1, 2)]
    dynamics = [*arm.DYNAMICS]
    for i in (0, 1):
        dynamics += [("STARTDE", i + 1, 1, float(q[i]), float(qd[i])), ("ESIG", i + 1, -float(nominal["u0"][step, i]))]
    ports = [("INPUTS", 1, 1, 1), ("INPUTS", 2, 2, 1)]
    ports += [("OUTX", 1, 7, 1), ("OUTX", 2, 7, 2), ("OUTE", 3, 1, 1), ("OUTXP", 4, 7, 1)]
    free = spacar.run(4, arm.deck(arm.FREE_JOINTS, ports, mode=4, dynamics=dynamics))
    for name in ("m0", "c0", "d0", "k0", "n0", "g0", "A", "B"):
        here, there = linear[name][step], free[name][0]
        # the accelerations of mode 4 come from a solved system: rounding times its condition (about 100)
        assert here == pytest.approx(there, abs=1e-10 * max(1.0, np.max(np.abs(there)))), name
    assert linear["C"][step][:4] == pytest.approx(free["C"][0], abs=1e-9)


def test_matrices_are_those_of_the_closed_form(nominal, linear):
    """M0 is the textbook mass matrix; K and C are differences of the textbook torques."""
    for k in (0, 3, 7):
        q = arm.Q0 + np.array([nominal.element(i, 1)[k] for i in (1, 2)])
        qd = np.array([nominal.element(i, 1, "ed")[k] for i in (1, 2)])
        qdd = np.array([nominal.element(i, 1, "edd")[k] for i in (1, 2)])
        h = 1e-5
        stiffness = np.column_stack(
            [(arm.torques(q + d, qd, qdd) - arm.torques(q - d, qd, qdd)) / (2 * h) for d in h * np.eye(2)]
        )
        damping = np.column_stack(
            [(arm.torques(q, qd + d, qdd) - arm.torques(q, qd - d, qdd)) / (2 * h) for d in h * np.eye(2)]
        )
        assert linear["m0"][k] == pytest.approx(arm.mass(q), rel=1e-11)
        # central differences with h = 1e-5: truncation 1e-10, rounding 1e-15 * 100 / 1e-5 = 1e-8
        assert linear["k0b"][k] == pytest.approx(stiffness, abs=1e-7)
        assert linear["c0b"][k] == pytest.approx(damping, abs=1e-7)


def test_second_order_output_is_the_second_derivative(nominal, linear):
    """G of the tip coordinate x = l1 cos q1 + l2 cos(q1 + q2): closed form."""
    for k in (0, 6):
        q = arm.Q0 + np.array([nominal.element(i, 1)[k] for i in (1, 2)])
        far = -arm.L2 * np.cos(q[0] + q[1])
        expected = np.array([[-arm.L1 * np.cos(q[0]) + far, far], [far, far]])
        assert linear["G"][k].reshape(2, 2) == pytest.approx(expected, abs=1e-11)


def test_header_and_setpoints(nominal, linear):
    h = linear.header
    assert (h["NNOM"], h["NX"], h["NU"], h["NY"], h["NRBM"], h["NYS"], h["DFT"]) == (2, 4, 2, 5, 2, 1, 0)
    assert h["NYSI"].tolist() == [1]
    assert linear["u0"] == pytest.approx(nominal["u0"], rel=1e-11)
    assert not linear["C"][:, 4].any()
    assert any("REFXDP" in line for line in linear.report)


def test_end_point_prescribed_gives_the_same_linearization():
    """RLSE and INPUTX of the tip instead of the joints: the same mechanism in other coordinates has the same
    eigenvalues.
    """
    end = arm.elbow_and_tip(arm.Q0 + np.array([0.3, -0.4]))[1]
    motion = [("TRAJECT", 1), ("TRANS", 7, *map(float, end)), ("TRFRONT", 7, 2), ("TRTIME", 1.0, 5), *arm.MOTORS]
    inverse = spacar.run(2, arm.deck(arm.END_POINT, motion))
    joints = spacar.run(3, arm.deck(arm.PRESCRIBED_JOINTS, arm.MOTORS, mode=3), nominal=inverse)
    tip = spacar.run(3, arm.deck(arm.END_POINT, arm.MOTORS, mode=3), nominal=inverse)
    assert tip["u0"] == pytest.approx(inverse["u0"], rel=1e-10)
    # at rest with zero acceleration (front 2 starts smoothly): the change of coordinates depends on time otherwise
    a, b = (np.sort_complex(np.linalg.eigvals(r["A"][0] @ r["A"][0])) for r in (joints, tip))
    assert a == pytest.approx(b, rel=1e-8)


# -- refusals -------------------------------------------------------------------------------------------------------
def linearize(nominal, driven=arm.PRESCRIBED_JOINTS, **changes):
    return spacar.run(3, arm.deck(driven, arm.MOTORS, mode=3, **changes), nominal=nominal)


def test_nominal_motions_that_are_refused(nominal):
    given = Nominal.of(nominal)
    other = replace(given, keywords=(given.keywords[0], "PLTOR", *given.keywords[2:3], "PLRBEAM"))
    turned = {"q": arm.Q0 + np.array([0.1, 0.0])}
    for motion, options, said in (
        (None, {}, "needs the result of mode 2"),
        (spacar.run(1, arm.deck(arm.FREE_JOINTS, mode=1)), {}, "needs a result of mode 2, this one is of mode 1"),
        (nominal, turned, r"mechanism differs .*at t = 0 node \d .* here, .* there"),
        (other, {}, "element 4 is PLBEAM with nodes 4 6 7 8 here, PLRBEAM with nodes 4 6 7 8 there"),
    ):
        with pytest.raises(UsageError, match=said):
            linearize(motion, **options)


def test_other_masses_are_mentioned(nominal):
    result = linearize(nominal, dynamics=[("XM", 4, 1.0), *arm.DYNAMICS[1:]])
    assert any("nominal inputs differ" in line for line in result.report)


def test_dynamic_degrees_of_freedom_count_as_prescribed(nominal, linear):
    """A file with DYNE instead of INPUTE gives the same matrices; start values do not matter."""
    driven = [("INPUTE", 1, 1), ("DYNE", 2, 1)]
    result = linearize(nominal, driven=driven, dynamics=[*arm.DYNAMICS, ("STARTDE", 2, 1, 0.3)])
    assert result.header["NRBM"] == 2
    assert np.array_equal(result["k0b"], linear["k0b"])
    assert result.mechanism.numbering.nddof == 0


# Mode 3 of a large model: the sparse equations of all degrees of freedom, prescribed ones too, are those of the full
# matrices; and the warning about inertia that is rounding.
PAIRS = [("robotinv", "robotinvlin"), ("robotflexinv", "robotflexinvlin")]


@pytest.mark.parametrize(("first", "second"), PAIRS)
def test_the_sparse_form_is_that_of_the_full_matrices(first, second, monkeypatch):
    """A, B, C after elimination; set-points and stresses are the same numbers."""
    nominal = spacar.run(2, DATA / f"{first}.dat")
    full = spacar.run(3, DATA / f"{second}.dat", nominal=nominal)
    monkeypatch.setattr(form, "LARGE", 0)
    sparse = spacar.run(3, DATA / f"{second}.dat", nominal=nominal)
    assert any("sparse linearized equations" in line for line in sparse.report)
    assert "A" not in sparse.frames[0].state_space
    for name in ("u0", "y0", "sig0"):
        np.testing.assert_array_equal(sparse[name], full[name])
    a, b = (TimeVarying.of(r) for r in (full, sparse))
    assert b.D is None
    for name in "ABC":  # the elimination loses some digits, as in modes 4 and 9
        mine, theirs = getattr(b, name), getattr(a, name)
        size = np.abs(theirs).max(initial=1e-300)
        np.testing.assert_allclose(mine, theirs, rtol=0, atol=1e-9 * size)
    with pytest.raises(UsageError, match="MODES 0"):
        b.need("m0")
    everything = spacar.run(3, DATA / f"{second}.dat", nominal=nominal, modes=0)
    np.testing.assert_array_equal(everything["A"], full["A"])


@pytest.mark.parametrize("tilt", [0.0, 0.3])
def test_inertia_of_rounding_is_said(tilt):
    """The slider carries the mass and stands at its dead point: the crank's own motion has no inertia."""
    rows = in_line(tilt, 1e-4)
    deck = Deck.build(rows, [("XM", 3, 1.0), ("ESTIFF", 3, 100.0)], mode=8)
    nominal = spacar.run(8, deck)
    try:
        text = " ".join(spacar.run(3, deck, nominal=nominal).report)
    except AnalysisError as error:
        text = str(error)
    assert "is that of rounding" in text or "singular mass matrix" in text
    crank = Deck.build(rows, [("XM", 2, 1e-8), ("XM", 3, 1.0), ("ESTIFF", 3, 100.0)], mode=8)
    assert "inertia" not in " ".join(spacar.run(3, crank, nominal=spacar.run(8, crank)).report)


# Mode 3 on NAME_3 after a mode 10 run on NAME: matrices about the stored load steps.
HINGE = """PLBEAM 1 1 2 3 4   PLBEAM 2 3 4 5 6   PLBEAM 3 5 6 7 8   X 3 0.1 0   X 5 0.2 0.02   X 7 0.3 0.02
FIX 1   FIX 2   {held} 7 2   DYNE 1 1 2 3   DYNE 2 1 2 3   DYNE 3 {last}   {released}   OUTLEVEL 0 1
END HALT
EM 1 0.8   EM 2 0.8   EM 3 0.8   XM 7 0.5   ESTIFF 1 2e6 2.1   ESTIFF 2 2e6 2.1   ESTIFF 3 2e6 2.1
EDAMP 2 0 0.01   ESIG 1 3 0.02 0   GRAVITY 1 -9.81   XF 7 -4 0   {motion}
ITERSTEP 40 4 1e-10 1 2 3   END END
"""
HELD = {"held": "INPUTX", "last": "1 3", "released": "RLSE 3 2"}
LOAD_MOTION = "INPUTX 7 2 0.01\nDELINPX 7 2 0.05\nDELXF 5 2 1"
STEPS = 5


def text(held: str = "INPUTX", motion: str = LOAD_MOTION, **more: str) -> str:
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


@pytest.fixture
def hinge_3(tmp_path: Path) -> Path:
    """NAME of mode 10 and NAME_3 of mode 3, not run yet."""
    (tmp_path / "hinge.dat").write_text(text())
    (tmp_path / "hinge_3.dat").write_text(text("DYNX"))
    return tmp_path / "hinge_3"


def test_the_files_as_spacar_light_writes_them(hinge_3: Path):
    """NAME_3 finds NAME; values of what is free now are no errors; M0, K0B, C0B are in the .ltv."""
    for mode in (9, 10):  # the last run on NAME may be one of mode 9
        call.done(mode, hinge_3.with_name("hinge"))
        call.done(3, hinge_3)
    assert "the mode 10 result hinge.sbd" in hinge_3.with_suffix(".log").read_text()
    assert "node 7 y" in call.done("eigen", hinge_3).out
    assert {"M0", "K0B", "C0B"} <= set(call.done("checksbf", hinge_3.with_suffix(".ltv")).out.split())


def test_compliance_of_the_free_mechanism(hinge_3: Path, three: spacar.Result):
    """`spacar compliance NAME_3`: with the coordinate free, W K^-1 W^T of the matrices."""
    call.done(10, hinge_3.with_name("hinge"))
    call.done(3, hinge_3)
    found = np.array(json.loads(call.done("compliance", hinge_3, 7, "--at", 2, "--json").out)["global"])
    n = three.mechanism.numbering
    rows = [n.x_index(7, 1), n.x_index(7, 2), n.x_index(8, 1)]
    W = three["dx"][1].reshape(n.nx, -1)[rows][:, : n.ndof]
    assert found == pytest.approx(W @ np.linalg.solve(three["k0b"][1], W.T), rel=1e-8, abs=1e-12)


# `spacar 3 --modes` and what reads its files, as a user meets them above the size from which equations are sparse.
BEAMS = 3
NODES = range(1, BEAMS + 1)
ARM = [*(f"PLBEAM {i} {2 * i - 1} {2 * i} {2 * i + 1} {2 * i + 2}" for i in NODES),
       *(f"X {2 * i + 1} {0.3 * i} 0." for i in NODES), "FIX 1", "INPUTX 2 1"]  # fmt: skip
MASSES = [f"EM {i} 2." for i in NODES]
STIFF = [*(f"ESTIFF {i} 0. 200." for i in NODES), *(f"EDAMP {i} 0. 0.02" for i in NODES)]
TURN = ["TRAJECT 1", "TROT 2 0.8", "TRVMAX 2 0.1", "TRTIME 0.5 5"]
PORTS = ["NOMF 1 2 1", "REFX 1 2 1", f"REFX 2 {2 * BEAMS + 1} 1"]
BENDING = [f"INPUTE {i} 3" for i in NODES]  # rigid in mode 2


def large_text(*blocks: list[str]) -> str:
    return "\nHALT\n".join("\n".join([*block, "END"]) for block in blocks) + "\nEND\n"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A turning arm in three beams, linearized along its motion as a large model is."""
    monkeypatch.setattr(form, "LARGE", 0)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "arm.dat").write_text(large_text(ARM, MASSES, [*TURN, *PORTS]))
    (tmp_path / "armlin.dat").write_text(large_text([*ARM, *BENDING], [*MASSES, *STIFF], PORTS))
    call.done(2, "arm")
    call.done(3, "armlin")
    return tmp_path


def test_a_number_of_modes_is_refused_before_files_are_touched(folder):
    before = {p.name: p.read_bytes() for p in folder.iterdir()}
    err = call.refused(3, "armlin", "--modes", 5)
    assert "mode 3 computes no modes of vibration: the option modes = 5 can only be 0" in err
    assert {p.name: p.read_bytes() for p in folder.iterdir()} == before
    with pytest.raises(UsageError, match="modes = 5 can only be 0"):
        spacar.run(3, folder / "armlin.dat", modes=5)


def test_gains_need_the_matrices_that_modes_0_asks_for(folder):
    """The refusal says how large the model is and what to do, and leaves no file; what it says helps."""
    gain = ("spacntrl", "armlin", "--kp", 10)
    err = call.refused(*gain)
    assert "armlin.ltv has no m0" in err
    assert f"({BEAMS + 1} degrees of freedom) with --modes 0 (MODES 0): run it again" in err
    assert not (folder / "armlinkp.ltv").exists()
    call.done(3, "armlin", "--modes", 0)
    log = (folder / "armlin.log").read_text()
    assert "--modes      0" in log
    assert "sparse" not in log
    call.done(*gain)
    before, after = (read_ltv(folder / name)[0] for name in ("armlin", "armlinkp"))
    change = np.zeros((BEAMS + 1, BEAMS + 1))
    change[0, 0] = 10.0  # the moment acts on the input, the first degree of freedom
    np.testing.assert_allclose(after.k0b - before.k0b, np.broadcast_to(change, before.k0b.shape), atol=1e-9)
