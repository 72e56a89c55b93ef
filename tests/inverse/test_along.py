"""Mode 3: against mode 4 at the same states, against differences, and refusals."""

from dataclasses import replace

import numpy as np
import pytest

import spacar
from spacar.errors import UsageError
from spacar.inverse import Nominal

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
    ports = [
        ("INPUTS", 1, 1, 1),
        ("INPUTS", 2, 2, 1),
        ("OUTX", 1, 7, 1),
        ("OUTX", 2, 7, 2),
        ("OUTE", 3, 1, 1),
        ("OUTXP", 4, 7, 1),
    ]
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
    at_rest = (0,)  # the change of coordinates depends on time while the arm moves
    for k in at_rest:
        a, b = (np.sort_complex(np.linalg.eigvals(r["A"][k] @ r["A"][k])) for r in (joints, tip))
        # rate terms vanish only at rest with zero acceleration (front 2 starts smoothly)
        assert a == pytest.approx(b, rel=1e-8)


# -- refusals -------------------------------------------------------------------------------------------------------
def linearize(nominal, driven=arm.PRESCRIBED_JOINTS, **changes):
    return spacar.run(3, arm.deck(driven, arm.MOTORS, mode=3, **changes), nominal=nominal)


def test_without_a_nominal_motion():
    with pytest.raises(UsageError, match="needs the result of mode 2"):
        linearize(None)


def test_result_of_another_mode():
    result = spacar.run(1, arm.deck(arm.FREE_JOINTS, mode=1))
    with pytest.raises(UsageError, match="needs a result of mode 2, this one is of mode 1"):
        linearize(result)


def test_other_geometry_is_refused(nominal):
    with pytest.raises(UsageError, match=r"mechanism differs .*at t = 0 node \d .* here, .* there"):
        linearize(nominal, q=arm.Q0 + np.array([0.1, 0.0]))


def test_other_element_is_refused(nominal):
    given = Nominal.of(nominal)
    other = replace(given, keywords=(given.keywords[0], "PLTOR", *given.keywords[2:3], "PLRBEAM"))
    with pytest.raises(
        UsageError, match="element 4 is PLBEAM with nodes 4 6 7 8 here, PLRBEAM with nodes 4 6 7 8 there"
    ):
        linearize(other)


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
