"""Flexible deformations in modes 2 and 3: fixed or INPUTE in mode 2 is the same rigid motion.

Independent truths: the rigid mechanism (deformations fixed), and the equations of motion of mode 1 with everything
free: their accelerations at one instant, and differences of them.
"""

import numpy as np
import pytest
from spacar_formats.ltvfile import read_ltv
from spacar_formats.setpoint_files import find_setpoints

import spacar
from spacar.deck import parse_deck, read_deck
from spacar.simulation import TimeVarying, simulate_ltv, with_gain
from tests.command_line import call
from tests.examples import DATA

FIXED = (DATA / "robotflexinv.dat").read_text()
LINEAR = (DATA / "robotflexinvlin.dat").read_text()
BENDING = "INPUTE 4 3 4 5 6\nINPUTE 5 3 4 5 6\n"
PRESCRIBED = FIXED.replace("RLSE 1 1\n", BENDING + "RLSE 1 1\n")
FLEXIBLE = [(element, mode) for element in (4, 5) for mode in (3, 4, 5, 6)]
STEPS = (0, 33, 70, 119)  # rest, both phases of acceleration, the trajectory at rest


def relative(a, b):
    """Largest difference in parts of the largest number."""
    return float(np.max(np.abs(np.asarray(a) - b)) / np.max(np.abs(b)))


@pytest.fixture(scope="module")
def nominal():
    return {name: spacar.run(2, parse_deck(text, name, 2)) for name, text in (("f", FIXED), ("p", PRESCRIBED))}


@pytest.fixture(scope="module")
def linear(nominal):
    return {name: spacar.run(3, DATA / "robotflexinvlin.dat", nominal=result) for name, result in nominal.items()}


def test_inputs_and_stresses_are_those_of_the_rigid_mechanism(nominal):
    """The same equations with rows in another order: equal to rounding times their condition, 11: 1e-12."""
    rigid, prescribed = nominal["f"], nominal["p"]
    assert rigid["u0"][0] == pytest.approx([0.0, 196.980, 82.276], abs=5e-4)
    assert relative(prescribed["u0"], rigid["u0"]) < 1e-12
    stresses = [np.array([r.element(i, k, "sig") for i, k in FLEXIBLE]) for r in (prescribed, rigid)]
    assert relative(*stresses) < 1e-12
    assert prescribed["x"].shape == rigid["x"].shape
    assert not prescribed.report


def test_the_linearization_does_not_depend_on_the_file_of_mode_2(linear):
    fixed, prescribed = linear["f"], linear["p"]
    for name in ("NNOM", "NX", "NU", "NY", "NRBM"):
        assert fixed.header[name] == prescribed.header[name]
    assert (prescribed.header["NRBM"], prescribed.header["NU"]) == (3, 11)
    assert prescribed["sig0"].shape == (121, 8)
    for name in ("A", "B", "C", "m0", "c0b", "k0b", "sig0", "u0", "y0", "G"):
        # as above; G is a second derivative: the error of the position (1e-12) times one more inverse
        assert relative(prescribed[name], fixed[name]) < 1e-10, name
    assert not any("warning" in line for line in prescribed.report)


def test_the_vibration_does_not_depend_on_the_file_of_mode_2(linear, nominal):
    """The response to SIG0 alone, which was zero; held joints (stiff ESTIFF-like gain) keep it small."""
    def tip(result):
        data = with_gain(TimeVarying.of(result), 2e5 * np.eye(3), 2e3 * np.eye(3))
        return simulate_ltv(data, substeps=4).y[:, 6:9]

    fixed, prescribed = tip(linear["f"]), tip(linear["p"])
    assert np.abs(fixed).max() > 1e-4
    assert relative(prescribed, fixed) < 1e-9


def free(result, motion, step, dynamics="", shift=None):
    """Accelerations of mode 1 with all joints and bending deformations free, at a set-point moved by `shift`."""
    inputs, q = joints_and_bending(motion)
    values = np.array([[result.element(i, k, v)[step] for v in ("e", "ed")] for i, k in q])
    if shift is not None:
        values += shift
    lines = [f"STARTDE {i} {k} {a!r} {b!r}" for (i, k), (a, b) in zip(q, values.tolist(), strict=True)]
    lines += [f"ESIG {i} {-u!r}" for i, u in zip(inputs, result["u0"][step].tolist(), strict=True)]
    text = LINEAR.replace("INPUTE", "DYNE").split("END\nHALT\nNOMS")[0] + "END\nEND\n"
    text = text.replace("GRAVITY", "\n".join([*lines, dynamics, "GRAVITY"]))
    run = spacar.run(1, parse_deck(text, "free", 1))
    return np.array([run.element(i, k, "edd")[0] for i, k in q])


def joints_and_bending(motion):
    n = motion.mechanism.numbering
    return (1, 2, 3), [n.e_owner(int(i)) for i in n.q_e]


@pytest.mark.parametrize("step", STEPS)
def test_sigma0_is_what_the_released_links_feel(nominal, linear, step):
    """The moment the links are released, joints driven by u0, the accelerations differ from the rigid motion by
    B sigma0 exactly: elastic stresses are still zero. 22 accelerations from a solve with condition 1e4.
    """
    result = linear["p"]
    _, q = joints_and_bending(result)
    released = free(result, result, step)
    rigid = np.array([result.element(i, k, "edd")[step] for i, k in q])
    expected = result["B"][step][11:, 3:] @ result["sig0"][step]
    assert np.abs(expected).max() > 1.0
    assert relative(released - rigid, expected) < 1e-9


@pytest.mark.parametrize("step", [33])
def test_state_matrix_is_the_difference_quotient_of_the_equations_of_motion(linear, step):
    """With SIG0 as preload the free links follow the rigid motion; A are the derivatives of the accelerations there.

    Central differences, h = 1e-5: truncation h^2 and rounding 1e-11 / h, of the largest entries: 1e-6.
    """
    result, h = linear["p"], 1e-5
    _, q = joints_and_bending(result)
    places = {pair: value for pair, value in zip(FLEXIBLE, result["sig0"][step].tolist(), strict=True)}
    preload = "\n".join(f"ESIG {i} 0 0 " + " ".join(repr(places[i, k]) for k in (3, 4, 5, 6)) for i in (4, 5))
    rigid = np.array([result.element(i, k, "edd")[step] for i, k in q])
    assert relative(free(result, result, step, preload), rigid) < 1e-8
    A = result["A"][step][11:]
    for j in range(22):
        shift = np.zeros((11, 2))
        shift[j % 11, j // 11] = h
        column = free(result, result, step, preload, shift) - free(result, result, step, preload, -shift)
        part = A[:, :11] if j < 11 else A[:, 11:]
        assert np.abs(column / (2 * h) - A[:, j]).max() < 1e-6 * np.abs(part).max(), j


def test_a_preload_is_not_part_of_the_excitation(nominal, linear):
    """ESIG on a flexible deformation acts when it is released: sigma0 is the stress resultant less the preload."""
    preload = "ESIG 4 0 0 30. -20. 5. 7.\n"
    deck = parse_deck(LINEAR.replace("GRAVITY", preload + "GRAVITY"), "preload", 3)
    result = spacar.run(3, deck, nominal=nominal["p"])
    expected = linear["p"]["sig0"] - [30.0, -20.0, 5.0, 7.0, 0.0, 0.0, 0.0, 0.0]
    assert relative(result["sig0"], expected) < 1e-12
    released = free(result, result, 33, preload)
    rigid = np.array([result.element(i, k, "edd")[33] for i, k in joints_and_bending(result)[1]])
    assert relative(released - rigid, result["B"][33][11:, 3:] @ result["sig0"][33]) < 1e-9


@pytest.mark.slow
def test_from_files(tmp_path, linear):
    """As the command line does it: the classes come from the tables of the sbd file."""
    (tmp_path / "arm.dat").write_text(PRESCRIBED)
    (tmp_path / "armlin.dat").write_text(LINEAR)
    for mode, name in (("2", "arm"), ("3", "armlin")):
        call.done(mode, tmp_path / name)
    nominal = find_setpoints(tmp_path / "armlin.dat")
    result = spacar.run(3, read_deck(tmp_path / "armlin.dat", 3), nominal=nominal)
    assert result.header["NRBM"] == 3
    assert relative(result["sig0"], linear["f"]["sig0"]) < 1e-10
    data, _ = read_ltv(tmp_path / "armlin")
    assert (data.n_rigid, data.sigma0.shape) == (3, (121, 8))


@pytest.mark.parametrize("of_mode_2", [pytest.param("f", marks=pytest.mark.slow), "p"])
def test_an_actuator_in_a_link_is_an_input(nominal, of_mode_2):
    """NOMS on a bending deformation that rests: it is no rigidified one, its input is the moment that holds it."""
    extra = ("NOMS 3 3 1\n", "NOMS 3 3 1\nNOMS 4 4 4\n")
    moving = spacar.run(2, parse_deck(PRESCRIBED.replace(*extra), "inverse", 2))
    assert moving["u0"].shape == (121, 4)
    assert relative(moving["u0"][:, 3], -moving.element(4, 4, "sig")) < 1e-12
    result = spacar.run(3, parse_deck(LINEAR.replace(*extra), "linear", 3), nominal=nominal[of_mode_2])
    assert (result.header["NRBM"], result.header["NU"]) == (4, 11)
    assert relative(result["u0"], moving["u0"]) < 1e-10


def test_more_inputs_than_the_rigid_mechanism_needs():
    """The smallest inputs are those of the rigid mechanism: the links take no part in the choice."""
    extra = ("NOMS 3 3 1\n", "NOMS 3 3 1\nNOMF 4 8 3\n")
    rigid, prescribed = (spacar.run(2, parse_deck(text.replace(*extra), "inverse", 2)) for text in (FIXED, PRESCRIBED))
    assert relative(prescribed["u0"], rigid["u0"]) < 1e-11
    for result in (rigid, prescribed):
        assert any("4 nominal inputs for 3 degrees of freedom" in line for line in result.report)


def test_a_prescribed_deformation_with_a_path_is_a_degree_of_freedom():
    """TRE without an actuator: nothing drives it, which the log says as before."""
    text = PRESCRIBED.replace("INPUTX 8 1\nINPUTX 8 2\nINPUTX 8 3\n", "").replace("RLSE", "INPUTE")
    text = text.split("TRAJECT 1")[0] + "TRAJECT 1\nTRE 1 0.2\nTRE 2 0.3\nTRE 3 0.4\nTRTIME 1 10\n"
    text += "NOMS 1 1 1\nNOMS 2 2 1\nNOMS 3 3 1\nEND\nEND\n"
    assert not spacar.run(2, parse_deck(text, "inverse", 2)).report
    result = spacar.run(2, parse_deck(text.replace("NOMS 3 3 1\n", ""), "inverse", 2))
    assert any("2 nominal inputs are fewer than the degrees of freedom" in line for line in result.report)


def test_motion_of_a_user_function(tmp_path):
    """USERTRAJ moves the joints; the links, which it does not mention, are rigidified."""
    joints = "INPUTE 1 1\nINPUTE 2 1\nINPUTE 3 1\n"
    base = FIXED.replace("INPUTX 8 1\nINPUTX 8 2\nINPUTX 8 3\n", joints)
    base = base.replace("RLSE 1 1\nRLSE 2 1\nRLSE 3 1\n", "").split("TRAJECT 1")[0]
    base += "TRAJECT 1\nUSERTRAJ swing\nTRTIME 1.0 10\nNOMS 1 1 1\nNOMS 2 2 1\nNOMS 3 3 1\nEND\nEND\n"
    (tmp_path / "swing.py").write_text(
        "def swing(t, step):\n    return t, [[i, 1, 0.1 * i * t * t, 0.2 * i * t, 0.2 * i] for i in (1, 2, 3)], []\n"
    )
    found = []
    for name, text in (("fixed", base), ("prescribed", base.replace("INPUTE 1 1\n", "INPUTE 1 1\n" + BENDING))):
        (tmp_path / f"{name}.dat").write_text(text)
        found.append(spacar.run(2, tmp_path / f"{name}.dat"))
        assert not any("fewer" in line for line in found[-1].report)
    assert relative(found[1]["u0"], found[0]["u0"]) < 1e-12
