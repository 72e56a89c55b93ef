"""eigen, bode, compliance: numbers, names, pictures, errors."""

import csv
import io
import json
import shutil

import numpy as np
import pytest
from spacar_formats.vibration import mode_numbers, shown_order

import spacar
from tests.examples import DATA


@pytest.fixture
def results(call, tmp_path):
    for name in ("lever", "massspring", "plbeam5", "lateral4"):
        shutil.copy(DATA / f"{name}.dat", tmp_path)
    for mode, name in ((9, "lever"), (7, "massspring"), (8, "plbeam5"), (10, "lateral4")):
        assert call(mode, name).status == 0
    return call


def test_eigen_table(results):
    done = results("eigen", "massspring")
    assert done.status == 0
    for printed in ("55.55106", "24.78062", "element 1 (PLBEAM) e1 elongation"):
        assert printed in done.out


def test_eigen_from_state_space_matrices(results):
    """The lever: s^2 + 5 s + 1000 = 0."""
    rows = json.loads(results("eigen", "lever", "--json").out)
    assert [r["real"] for r in rows] == pytest.approx([-2.5, -2.5])
    assert rows[0]["modulus"] == pytest.approx(np.sqrt(1000))
    assert rows[0]["damping"] == pytest.approx(2.5 / np.sqrt(1000))
    assert rows[0]["dof"] == "node 2 x"


def test_eigen_csv_has_all_digits(results):
    rows = list(csv.DictReader(io.StringIO(results("eigen", "massspring", "--csv", "-", "--lowest", "2").out)))
    assert len(rows) == 2
    assert len(rows[0]["modulus [rad/s]"]) > 14


def test_pictures(results, tmp_path):
    assert results("eigen", "massspring", "-o", "a.png", "-o", "a.svg", "--against", "xd[2,1]").status == 0
    assert results("bode", "lever").status == 0
    for name in ("a.png", "a.svg", "lever_bode.png"):
        assert (tmp_path / name).stat().st_size > 1000
    assert "xd[2,1]" in (tmp_path / "a.svg").read_text()


def test_bode_numbers(results):
    """-6000 s (s + 5)/(s^2 + 5 s + 1000), the transfer function of the printed figure."""
    done = results("bode", "lever", "--csv", "-", "--low", "0.5", "--high", "50")
    header, *rows = csv.reader(io.StringIO(done.out))
    assert header[1] == "amplitude OUTF node 5 x / INX node 7 x"
    f, amplitude, phase = np.array(rows, float).T
    s = 2j * np.pi * f
    truth = -6000 * s * (s + 5) / (s * s + 5 * s + 1000)
    assert np.allclose(amplitude * np.exp(1j * np.radians(phase)), truth, rtol=1e-9)


def test_compliance_of_a_planar_node(results):
    """The printed directional compliances are its diagonal; the matrix is symmetric and turns with the axes."""
    found = json.loads(results("compliance", "plbeam5", "11", "--json").out)
    fixed, body = np.array(found["global"]), np.array(found["body"])
    assert fixed[0, 0] == pytest.approx(0.4859, abs=5e-5)
    assert fixed[1, 1] == pytest.approx(0.0633, abs=5e-5)
    assert np.allclose(fixed, fixed.T, rtol=1e-10)
    assert np.allclose(np.linalg.eigvalsh(fixed[:2, :2]), np.linalg.eigvalsh(body[:2, :2]), rtol=1e-10)


def test_compliance_of_a_spatial_node(call, tmp_path):
    """A bent and twisted beam: the rotation by a moment increment, from a second run, is the compliance column."""
    text = """
BEAM 1 1 2 3 4 0. 1. 0.
X 3 1. 0. 0.
FIX 1
FIX 2
DYNE 1 2 3 4 5 6
END
HALT
EM 1 1. 0.1
ESTIFF 1 0. 2. 1. 1.5
XF 4 {} {} {}
ITERSTEP 20 4 1e-13
END
END
"""
    moment, h = np.array([0.3, 0.2, -0.1]), 1e-5
    (tmp_path / "a.dat").write_text(text.format(*moment))
    assert call(7, "a").status == 0
    found = json.loads(call("compliance", "a", "3", "--json").out)

    def state(m: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        (tmp_path / "b.dat").write_text(text.format(*(repr(float(v)) for v in m)))
        assert call(7, "b").status == 0
        data = json.loads(call("getfrsbf", "b.sbd", "x", "--json").out)["data"]
        lnp = np.array(json.loads(call("getfrsbf", "b.sbd", "lnp", "--json").out)["data"]).reshape(-1, 4)
        x = np.ravel(data)
        return x[lnp[2, :3] - 1], x[lnp[3] - 1]

    for k in range(3):
        step = h * np.eye(3)[k]
        (xa, la), (xb, lb) = state(moment - step), state(moment + step)
        l0, l = (la[0] + lb[0]) / 2, (la[1:] + lb[1:]) / 2
        d = (lb - la) / (2 * h)
        turn = 2 * (-l * d[0] + l0 * d[1:] + np.cross(l, d[1:]))
        # the load is a constant moment, as K0 + N0 + G0 has it; differences of step 1e-5 reach 1e-7
        assert np.allclose(np.array(found["global"])[:, 3 + k], np.r_[(xb - xa) / (2 * h), turn], atol=1e-6)


def test_wrong_wishes(results):
    assert "no output 7; there are 1 (OUTF node 5 x)" in results("bode", "lever", "--of", "7").err
    assert "step 4 does not exist" in results("eigen", "massspring", "--at", "4").err
    assert "no position node" in results("compliance", "plbeam5", "2", "4").err
    assert "node 99 is no position node" in results("compliance", "plbeam5", "99").err
    assert "no eigenvalues" in results("eigen", "nothing").err or "not found" in results("eigen", "nothing").err
    assert results("bode", "lever", "--low", "5", "--high", "1").status == 2


# What linear analyses still give when a part of them is impossible, and what they say about it.
FREE_BEAM = """PLBEAM 1 1 2 3 4
X 3 1 0
DYNX 1 1
DYNX 1 2
DYNX 2
DYNE 1 2 3
END
HALT
EM 1 1
ESTIFF 1 0 1
XF 3 1 0
XF 1 -1 0
END
END
"""


def test_motions_free_in_stiffness_and_load_have_no_multiplier_and_leave_the_rest(call, tmp_path):
    """A free beam in tension: K0 and G0 share two rigid motions, and rotation has the multiplier 0.

    Reversed, the beam buckles: -12 and -60 EI/l^2 are those of one cubic element between hinges (exact: -9.87, -39.5).
    """
    (tmp_path / "free.dat").write_text(FREE_BEAM)
    done = call.done(10, "free")
    assert "2 common null vectors" in done.err
    assert "2 common null vectors" in (tmp_path / "free.log").read_text()
    result = spacar.run(10, spacar.parse_deck(FREE_BEAM, mode=10))
    multipliers = np.ravel(result["lmult"])
    assert multipliers == pytest.approx([0.0, -12.0, -60.0, np.inf, np.inf], rel=1e-6, abs=1e-9)
    assert np.array_equal(multipliers, np.ravel(spacar.run(8, spacar.parse_deck(FREE_BEAM, mode=8))["lmult"]))
    assert result["xcompl"].shape == (1, result.mechanism.numbering.nx)
    assert np.array_equal(result["eigval"], spacar.run(7, spacar.parse_deck(FREE_BEAM, mode=7))["eigval"])
    squares = np.sort(np.hypot(*result["eigval"][0].T))[::2] ** 2
    # cubic shape functions: 720 and 8400 EI/(m l^4), raised by the tension N by less than N/EI
    assert squares[:2] == pytest.approx(0.0, abs=1e-4)
    assert 11.9 < squares[2] < 12.0  # rotation: N l theta against m l^2 / 12, lowered a little by bending
    assert np.all((squares[3:] > [720, 8400]) & (squares[3:] < [720 * 1.1, 8400 * 1.1]))


def test_eigen_of_mode_3(call, tmp_path):
    """Eigenvalues of the stored matrices of every step of a linearization along set-points, with names."""
    for name in ("robotinv", "robotinvlin"):
        shutil.copy(DATA / f"{name}.dat", tmp_path)
    assert call(2, "robotinv").status == 0
    assert call(3, "robotinvlin").status == 0
    rows = json.loads(call("eigen", "robotinvlin", "--json", "--at", "3").out)
    result = spacar.run(2, DATA / "robotinv.dat")
    linear = spacar.run(3, DATA / "robotinvlin.dat", nominal=result)
    M, K, C = (linear[name][2] for name in ("m0", "k0b", "c0b"))
    n = len(M)
    A = np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])
    truth = np.linalg.eigvals(A)
    found = np.array([row["real"] + 1j * row["imag"] for row in rows])
    assert len(found) == len(truth)
    for value in found[np.abs(found) > 1e-3]:
        assert np.min(np.abs(truth - value)) <= 1e-9 * abs(value)
    assert {row["dof"] for row in rows} <= {f"element {k} (HINGE) e1 relative rotation" for k in (1, 2, 3)}


# `spacar eigen` shows physical modes by rising frequency, zero modes last, with the numbers of `spacar visual -m`.
def test_order_and_numbers():
    """1 mrad/s beside 10 000 rad/s is a mode of its own: sqrt(n eps) of the largest is 0.3 mrad/s."""
    values = np.array([50j, -50j, 3e-9j, -3e-9j, -1 + 5j, -1 - 5j, 2.0, -2.0])
    order = shown_order(values)
    assert [complex(values[i]) for i in order[:6]] == [2.0, -2.0, -1 + 5j, -1 - 5j, 50j, -50j]
    assert mode_numbers(values, order) == [1, 2, 3, 3, 4, 4, 5, 5]
    values = np.array([1e4j, -1e4j, 1e-3j, -1e-3j])
    assert [abs(values[i]) for i in shown_order(values)] == [1e-3, 1e-3, 1e4, 1e4]
