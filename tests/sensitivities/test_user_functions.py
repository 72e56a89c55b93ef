"""Models with functions of the user, and stresses of rows without stiffness in steady motion."""

from pathlib import Path

import pytest

import spacar
from spacar import Deck, parse_deck
from spacar.deck import read_deck
from spacar.errors import UsageError

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


@pytest.fixture
def with_law(tmp_path: Path):
    def made(stated: str = "") -> Deck:
        (tmp_path / "law.py").write_text(LAW.format(stated=stated))
        (tmp_path / "model.dat").write_text(TURNING.format(rate="").replace("XF 5", "USERSIG law\nXF 5"))
        return read_deck(tmp_path / "model.dat", 10)

    return made


@pytest.mark.parametrize("stated", ["", ", 3.0, 0.0"])
def test_forces_and_stresses_of_the_user(with_law, stated: str) -> None:
    """Non-linear in deformations and coordinates, whether the function states a stiffness or not."""
    names = ["ESTIFF.1[EI]", "X.7[2]", "X.5[2]", "XF.5[2]", "INPUTX.2.1", "ESIG.3[2]"]
    quantities = ["x[5,1]", "x[5,2]", "e[3,1]", "sig[1,2]", "sig[3,1]", "fx[5,2]", "fxtot[2,1]"]
    agree(with_law(stated), names, quantities, rel=1e-7)


def test_linearized_equations_with_forces_of_the_user_are_refused(with_law) -> None:
    """They hold what the function states, whose derivatives are not known."""
    with pytest.raises(UsageError, match="USERSIG"):
        spacar.sensitivity(with_law(), ["ESTIFF.1[EI]"], ["frequency[1]"])


def test_forces_of_the_user_in_steady_motion(tmp_path: Path) -> None:
    """A function of deformations, coordinates and rates."""
    law = LAW.format(stated="").replace("push = ", "push = 0.2 * xp[lnp[5, 0]] * ep[le[2, 0]] - 0.1 * xp[j] ** 2 ")
    (tmp_path / "law.py").write_text(law)
    (tmp_path / "model.dat").write_text(TURNING.format(rate="0.8").replace("XF 5", "USERSIG law\nXF 5"))
    deck = read_deck(tmp_path / "model.dat", 10)
    names = ["ESTIFF.1[EI]", "X.7[2]", "INPUTX.2.1[start rate]"]
    agree(deck, names, ["x[5,1]", "e[3,1]", "sig[1,2]", "fx[5,2]", "fxtot[2,1]"], rel=1e-7)


def test_prescribed_motion_of_the_user(tmp_path: Path) -> None:
    """It depends on no number of the file: what the function does not mention still does."""
    (tmp_path / "drive.py").write_text("def drive(t, step):\n    return t, [], [[2, 1, 0.3, 0.0, 0.0]]\n")
    text = TURNING.format(rate="").replace("FIX 7", "INPUTX 7").replace("XF 5", "USERINP drive\nINPUTX 7 2 0.8\nXF 5")
    (tmp_path / "model.dat").write_text(text)
    deck = read_deck(tmp_path / "model.dat", 10)
    names = ["ESTIFF.1[EI]", "INPUTX.7.2", "XF.5[2]", "X.3[2]"]
    agree(deck, names, ["x[5,1]", "sig[1,2]", "fxtot[2,1]", "frequency[1]"], rel=1e-6)
    found = spacar.sensitivity(deck, ["INPUTX.2.1"], ["x[5,1]", "x[2,1]"])
    assert found.values[1] == 0.3
    assert not found.derivatives.any()
