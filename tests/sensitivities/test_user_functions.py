"""Models with functions of the user, and stresses of rows without stiffness in steady motion."""

from pathlib import Path

import numpy as np
import pytest

import spacar
from spacar import Deck, parse_deck
from spacar.deck import read_deck
from spacar.elements.spatial.angle_measure import rotation_factor
from spacar.errors import UsageError
from tests.examples import DATA

from .difference_truth import agree

TURNING = """
PLBEAM 1 1 2 3 4   PLBEAM 2 3 4 5 6   PLTRUSS 3 3 7   PLTRUSS 4 5 8
X 3 0.6 0.1   X 5 1.2 0.0   X 7 0.4 0.9   X 8 1.5 1.1
FIX 1   INPUTX 2   FIX 7   FIX 8   DYNE 1   DYNE 2   RLSE 3   RLSE 4   END HALT
ESTIFF 1 400 3   ESTIFF 2 400 3   EM 1 0.5   EM 2 0.5   EDAMP 4 0.7   ESIG 3 2.0   XM 5 0.2
INPUTX 2 1 0.1 {rate}   XF 5 0.4 -0.5   END END
"""
LAW = """
import math
def law(t, ne, le, e, ep, nx, lnp, x, xp):
    i, j = le[2, 0], lnp[4, 1]
    pull = 3.0 * math.sin(e[i]) + 0.5 * e[i] ** 3
    push = -0.4 * x[j] ** 2 + 0.3 * x[lnp[2, 0]]
    return t, [[3, 1, pull{stated}]], [[5, 2, push], [6, 1, 0.05 * math.exp(e[le[1, 1]])]]
"""


@pytest.mark.parametrize("rate", ["", "0.8"])
def test_rows_without_stiffness(rate: str) -> None:
    """A constant force and a damper alone, at rest and in steady motion, where the tangent has a place for them."""
    deck = parse_deck(TURNING.format(rate=rate), mode=10)
    names = ["ESIG.3[2]", "ESTIFF.1[EI]", "X.7[2]", "XF.5[2]"]
    names += ["EDAMP.4[2]", "INPUTX.2.1[start rate]"] if rate else []
    agree(deck, names, ["x[5,1]", "x[5,2]", "e[3,1]", "sig[1,2]", "sig[3,1]", "sig[4,1]", "fxtot[2,1]"], rel=1e-7)


def with_function(folder: Path, name: str, function: str, text: str) -> Deck:
    (folder / f"{name}.py").write_text(function)
    (folder / "model.dat").write_text(text)
    return read_deck(folder / "model.dat", 10)


@pytest.mark.parametrize("stated", ["", ", 3.0, 0.0"])
def test_forces_and_stresses_of_the_user(tmp_path: Path, stated: str) -> None:
    """Non-linear in deformations and coordinates, whether the function states a stiffness or not. Linearized equations
    hold the slopes of the function, which change with the state."""
    text = TURNING.format(rate="").replace("XF 5", "USERSIG law\nXF 5")
    deck = with_function(tmp_path, "law", LAW.format(stated=stated), text)
    names = ["ESTIFF.1[EI]", "X.7[2]", "X.5[2]", "XF.5[2]", "INPUTX.2.1", "ESIG.3[2]"]
    agree(deck, names, ["x[5,1]", "x[5,2]", "e[3,1]", "sig[1,2]", "sig[3,1]", "fx[5,2]", "fxtot[2,1]"], rel=1e-7)
    wanted = ["frequency[1]", "frequency[3]", "lmult[1]", "xcompl[5,2]", "abs(eigval[2])"]
    agree(deck, [*names, "XM.5"], wanted, rel=1e-6)


def test_a_spring_that_stiffens(tmp_path: Path) -> None:
    """F = k u + b u + c u^2: m omega^2 = k + b + 2 c u, d(m omega^2)/dF = 2 c du/dF, du/dF = 1/(m omega^2)."""
    function = "def spring(t, ne, le, e, ep, nx, lnp, x, xp):\n    u = e[le[0, 0]]\n"
    function += "    return t, [[1, 1, 50.0 * u + 300.0 * u**2]], []\n"
    kinematics = "PLTRUSS 1 1 2   X 2 1   FIX 1   FIX 2 2   DYNE 1   END HALT"
    text = f"{kinematics} XM 2 2  ESTIFF 1 100  XF 2 10  USERSIG spring\nEND END\n"
    deck = with_function(tmp_path, "spring", function, text)
    found = spacar.sensitivity(deck, ["XF.2[2]", "ESTIFF.1"], ["x[2,1]", "(2*pi*frequency[1])**2"])
    u = (-150.0 + np.sqrt(150.0**2 + 4 * 300.0 * 10.0)) / 600.0
    K = 150.0 + 600.0 * u
    np.testing.assert_allclose(found.values, [1.0 + u, K / 2.0], rtol=1e-10)
    want = [[1.0 / K, -u / K], [300.0 / K, 0.5 - 300.0 * u / K]]
    np.testing.assert_allclose(found.derivatives, want, rtol=1e-9)


def test_linearized_equations_of_wheels_are_refused() -> None:
    with pytest.raises(UsageError, match="wheels for eigenvalues"):
        spacar.sensitivity(read_deck(DATA / "trike2.dat", 7), ["XM.1"], ["frequency[1]"])


def test_forces_of_the_user_in_steady_motion(tmp_path: Path) -> None:
    """A function of deformations, coordinates and rates."""
    law = LAW.format(stated="").replace("push = ", "push = 0.2 * xp[lnp[5, 0]] * ep[le[2, 0]] - 0.1 * xp[j] ** 2 ")
    deck = with_function(tmp_path, "law", law, TURNING.format(rate="0.8").replace("XF 5", "USERSIG law\nXF 5"))
    names = ["ESTIFF.1[EI]", "X.7[2]", "INPUTX.2.1[start rate]"]
    agree(deck, names, ["x[5,1]", "e[3,1]", "sig[1,2]", "fx[5,2]", "fxtot[2,1]"], rel=1e-7)
    agree(deck, names, ["frequency[1]", "real(eigval[1])", "lmult[1]"], rel=1e-6)


def test_prescribed_motion_of_the_user(tmp_path: Path) -> None:
    """It depends on no number of the file: what the function does not mention still does."""
    function = "def drive(t, step):\n    return t, [], [[2, 1, 0.3, 0.0, 0.0]]\n"
    text = TURNING.format(rate="").replace("FIX 7", "INPUTX 7").replace("XF 5", "USERINP drive\nINPUTX 7 2 0.8\nXF 5")
    deck = with_function(tmp_path, "drive", function, text)
    names = ["ESTIFF.1[EI]", "INPUTX.7.2", "XF.5[2]", "X.3[2]"]
    agree(deck, names, ["x[5,1]", "sig[1,2]", "fxtot[2,1]", "frequency[1]"], rel=1e-6)
    found = spacar.sensitivity(deck, ["INPUTX.2.1"], ["x[5,1]", "x[2,1]"])
    assert found.values[1] == 0.3
    assert not found.derivatives.any()


# Spatial beams in the angle measure: the factor G, and multipliers in steady motion.
@pytest.mark.parametrize("c", [0.95, 0.81, 0.79, 0.3, -0.4, 1.02])
def test_the_factor_carries_a_complex_step_through_all_its_derivatives(c):
    """G^(k)(c + ih): the imaginary parts are h G^(k+1), of the third by a difference of the third (SERIES lies at 0.8).
    """
    step, h = 1e-50, 1e-5
    moved = rotation_factor(np.array([c + 1j * step]))[:, 0]
    real = rotation_factor(np.array([c]))[:, 0]
    np.testing.assert_allclose(moved.real, real, rtol=1e-15)
    np.testing.assert_allclose(moved.imag[:3] / step, real[1:], rtol=1e-13)
    third = [rotation_factor(np.array([c + k * h]))[3, 0] for k in (-2, -1, 1, 2)]
    fourth = (third[0] - 8 * third[1] + 8 * third[2] - third[3]) / (12 * h)
    assert moved.imag[3] / step == pytest.approx(fourth, rel=1e-7)


@pytest.mark.slow
def test_multipliers_with_the_twist_gradient_in_steady_motion():
    """A deep cantilever on a turning hub: lateral buckling, in which the twist gradient is an unknown of its own."""
    lines = ["ADEFORM", "FIX 1", "FIX 2 3 4", "INPUTX 2 2"]
    for k in (1, 2):
        nodes = f"{2 * k - 1} {2 * k} {2 * k + 1} {2 * k + 2}"
        lines += [f"BEAM {k} {nodes} 0 1 0", f"DYNE {k}", f"X {2 * k + 1} {0.5 * k} 0 0"]
    lines += ["X 1 0 0 0", "END", "HALT", "INPUTX 2 2 0 0.4"]
    lines += [f"ESTIFF {k} 1e4 1 40 1 0 0\nEM {k} 0.3 0.001 0.0005 0.0005" for k in (1, 2)]
    deck = parse_deck("\n".join([*lines, "XM 5 0.1", "XF 5 0 0 2", "END", "END"]), mode=10)
    names = ["ESTIFF.1[GIt]", "ESTIFF.2[EIz]", "XF.5[4]", "INPUTX.2.2[start rate]", "X.5[2]"]
    agree(deck, names, ["lmult[1]", "frequency[1]"], rel=1e-5)


# Wheels in stationary rolling: the tricycles with a spring on the steering, against differences of whole analyses.
STEERED = {
    "planar": ("trike2", "ESTIFF 6 30\nESIG 6 14\n"),
    "spatial": ("trike3v", "ESTIFF 8 30\nESIG 8 14\n"),
}
ASKED = {
    "planar": (
        ["XM.1", "X.1[2]", "X.7[2]", "STARTDX.4.1[start rate]", "PLWHEEL.2[5]", "PLWHEEL.2[6]", "ESTIFF.6", "ESIG.6"],
        ["sig[1,1]", "sig[5,2]", "sig[2,2]", "x[9,2]", "e[6,1]"],
    ),
    "spatial": (
        ["XM.1", "X.1[2]", "X.9[2]", "STARTDE.2.1[start rate]", "ESTIFF.8", "ESIG.8", "GRAVITY[3]"],
        ["sig[3,1]", "sig[11,2]", "sig[4,3]", "x[13,2]", "e[8,1]"],
    ),
}


def tricycle(kind: str):
    name, steering = STEERED[kind]
    return parse_deck((DATA / f"{name}.dat").read_text().replace("TIMESTEP", f"{steering}TIMESTEP"), mode=7)


@pytest.mark.parametrize("kind", STEERED)
def test_circles_that_a_tricycle_rolls(kind: str) -> None:
    """Constraint forces, slip forces and the steering angle of steady rolling by masses, places, radii, speed."""
    found = agree(tricycle(kind), *ASKED[kind], rel=1e-7)
    assert np.abs(found.derivatives).max(axis=0).all()  # every number matters


def test_where_it_rolls_is_kept() -> None:
    """The spin angle has no stiffness: it stays where the file puts it, and so do the kinematic coordinates."""
    names = ["STARTDX.4.1[start value]", "X.1[2]", "ESTIFF.6"]
    found = spacar.sensitivity(tricycle("planar"), names, ["x[4,1]", "x[1,1]", "e[6,1]"])
    np.testing.assert_allclose(found.derivatives[0], [1.0, 0.0, 0.0], atol=1e-12)
    assert found.of("x[1,1]", "X.1[2]") == pytest.approx(1.0, abs=1e-12)
    assert found.of("e[6,1]", "STARTDX.4.1[start value]") == pytest.approx(0.0, abs=1e-12)
