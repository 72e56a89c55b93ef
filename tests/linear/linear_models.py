"""Small mechanisms in which everything acts at once."""

from pathlib import Path

from spacar.deck import parse_deck, read_deck
from spacar.mechanism import build
from spacar.mechanism.mechanism import Mechanism
from tests.examples import DATA

# Flexible four-bar-like loop: prescribed x and e, dynamic x and e, released, rigid, damper, preload, MEE, gravity.
PLANAR = """
PLBEAM 1 1 2 3 4   PLBEAM 2 3 4 5 6   PLTRUSS 3 5 7   PLTOR 4 2 8   PLRBEAM 5 5 6 9   PLTRUSS 6 9 10
X 3 0.6 0.4   X 5 1.3 0.7   X 7 1.6 -0.2   X 9 1.5 1.2   X 10 2.4 1.3
FIX 1   FIX 10   FIX 8   INPUTX 7 1   FIX 7 2   INPUTE 4 1   DYNE 1 2 3   DYNX 5 2   DYNE 2 2 3
RLSE 2 1   RLSE 3   RLSE 6   END HALT
EM 1 1.1 0.02   EM 2 0.7 0.01   EM 3 0.4   EM 5 0.8   XM 5 0.5   XM 6 0.05   XM 9 0.3   MEE 1 2 0.07
MEE 2 1 1 3 0.03   MEE 3 1 0.11   MEE 4 1 0.02   ESTIFF 1 50. 3. 0.01   ESTIFF 2 40. 2.
ESTIFF 3 30.   ESTIFF 6 25.   EDAMP 1 2. 0.5   EDAMP 2 1. 0.4   EDAMP 3 0.9   EDAMP 6 0.6
ESIG 1 3. 0.4 -0.3   ESIG 2 -2. 0.3 0.1   ESIG 6 1.5   GRAVITY 1.3 -9.8   XF 5 2. 3.   XF 6 0.7
INPUTX 7 1 1.6 0.3 0.2   INPUTE 4 1 0.1 0.2 0.3   {extra}   END
{third}END
"""

SPATIAL = """
BEAM 1 1 2 3 4 0. 1. 0.   HINGE 2 4 5 0. 0. 1.   BEAM 3 3 5 6 7 0. 0. 1.   TRUSS 4 6 8
HINGE 5 2 9 1. 0. 0.   RBEAM 6 6 7 10
X 3 0.7 0.2 0.1   X 6 1.2 0.8 0.4   X 8 1.5 0.2 1.4   X 10 1.5 1.0 0.7
FIX 1   FIX 9   INPUTX 8 1   FIX 8 2 3   INPUTE 5 1   DYNE 1 2 3 4 5 6   DYNE 2 1   DYNE 3 3 5 6
RLSE 4   END HALT
EM 1 1.1 0.02 0.013 0.014 0.001   EM 3 0.7 0.01   EM 4 0.3   XM 6 0.4
XM 7 0.05 0.01 0.02 0.06 0.01 0.07   XGYRO 7 3. 1. -2. 0.04   MEE 1 3 0.05   MEE 3 3 3 5 0.02
ESTIFF 1 50. 2. 3. 4. 0.01 0.02   ESTIFF 2 2. 1. 1.5   ESTIFF 3 30. 2. 1. 2.   ESTIFF 4 20.
EDAMP 1 0.5 0.3 0.2 0.1   EDAMP 3 0.5 0.3 0.2 0.1   EDAMP 4 0.7   ESIG 1 2. 0.3 0.2 -0.1 0.3 0.2
ESIG 4 1.5   GRAVITY 1.3 2. -9.8   XF 6 2. 3. 1.   XF 7 0.5 -0.4 0.3   XF 4 0.1 0.2 0.3 0.4
INPUTX 8 1 1.5 0.3 0.2   INPUTE 5 1 0.1 0.2 0.3   {extra}   END
{third}END
"""

TUBE = """
PLTUBE 1 1 2 3 4   PLTUBE 2 3 4 5 6   X 3 0.6 0.   X 5 1.2 0.
FIX 1   INPUTX 2 1   DYNE 1 2 3   DYNE 2 1 2 3   END HALT
EM 1 1.1 0.6 0.8 1.1   EM 2 1.2 0.5 0.8 1.2   ESTIFF 1 50. 3.   ESTIFF 2 50. 3.   EDAMP 1 1. 0.1
GRAVITY 0. -9.8   INPUTX 2 1 0. 0.4   {extra}   END
{third}END
"""

USER = '''
import numpy as np

def forces(t, ne, le, e, ep, nx, lnp, x, xp):
    """Linear springs and dampers, so that the stated k and d are exact."""
    i, j = le[:2, 1].copy(), lnp[4, :2]
    i[1] = le[1, 0]
    s = 0.3 + 4.0 * e[i] + 0.6 * ep[i]
    g = 0.2 - 7.0 * x[j] - 0.8 * xp[j]
    sig = [[1, 2, s[0], 4.0, 0.6], [2, 1, s[1], 4.0, 0.6]]  # a dynamic and a released deformation
    f = [[5, 1, g[0], 7.0, 0.8], [5, 2, g[1], 7.0, 0.8]]  # a calculable and a dynamic coordinate
    return t, np.array(sig), np.array(f)
'''


TRIKE_SPRING = ("XM 10 0.05\n", "XM 10 0.05\nESTIFF 6 3.0\nEDAMP 6 0.2\nGRAVITY 1.0 2.0\nXF 3 1.0 2.0\n")


def mechanism(text: str, mode: int = 4, extra: str = "", third: str = "", folder: Path | None = None) -> Mechanism:
    """Build a model text; with `folder` the user function `forces` is beside it."""
    text = text.format(extra=extra, third=f"HALT\n{third}END\n" if third else "")
    if folder is None:
        return build(parse_deck(text, mode=mode), mode)
    (folder / "forces.py").write_text(USER)
    (folder / "model.dat").write_text(text)
    return build(read_deck(folder / "model.dat", mode), mode)


def example(name: str, mode: int = 4, *replacements: tuple[str, str]) -> Mechanism:
    """An example model, with parts of its text replaced."""
    text = (DATA / f"{name}.dat").read_text()
    for old, new in replacements:
        assert old in text
        text = text.replace(old, new)
    return build(parse_deck(text, name, mode), mode)
