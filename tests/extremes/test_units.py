"""Masses from 1e-9 to 1e9 kg, lengths from 1e-6 to 1e6 m, times from 1e-6 to 1e6 s: the results of a model do not
depend on the units in which it is written. Truth: multiplication by the dimension.

The tolerance 1e-9 is that of the issue. Fixed steps are used for motions, since the error that ERROR allows has no
dimension of its own. Stationary solutions are iterated to rounding: the tolerance of ITERSTEP has a unit.
"""

import numpy as np
import pytest

import spacar
from spacar.frame import Frame
from tests.examples import DATA

from .units import Dimensions, System, back, convert, dimension, per

SYSTEMS = (
    System(kg=1e9), System(kg=1e-9), System(m=1e6), System(m=1e-6), System(s=1e6), System(s=1e-6),
    System(kg=1e9, m=1e-6, s=1e3), System(kg=1e-9, m=1e6), System(kg=1e-9, m=1e-6), System(kg=1e9, m=1e6),
)  # fmt: skip
NAMES = [f"kg {s.kg:g}, m {s.m:g}, s {s.s:g}" for s in SYSTEMS]
# powers of all three units at once, and of time alone (Hz, rad/s); the others find nothing that these do not
MARKED = [
    pytest.param(s, id=name, marks=[pytest.mark.slow] * (k not in (4, 7)))
    for k, (s, name) in enumerate(zip(SYSTEMS, NAMES, strict=True))
]
TOLERANCE = 1e-9

PLANAR = """
PLBEAM 1 1 2 3 4   PLBEAM 2 3 4 5 6   PLTRUSS 3 5 7   PLRBEAM 4 5 6 8
X 3 0.6 0.4   X 5 1.3 0.7   X 7 1.6 -0.2   X 8 1.5 1.2
FIX 1   FIX 7   DYNX 2 1   DYNE 1 2 3   DYNE 2 1 2 3   RLSE 3   END HALT
EM 1 1.1 0.02   EM 2 0.7 0.01   EM 3 0.4   EM 4 0.8   XM 5 0.5   XM 6 0.05   MEE 1 2 0.07
ESTIFF 1 50. 3. 0.01   ESTIFF 2 400. 2.   ESTIFF 3 3000.   EDAMP 1 2. 0.5   EDAMP 3 0.9
ESIG 1 3. 0.4 -0.3   GRAVITY 0.3 -0.98   XF 5 0.2 0.3   XF 6 0.07
STARTDX 2 1 0.02 0.3   TIMESTEP 0.2 4   INTEGRAT 140 0.01   END END
"""

SPATIAL = """
BEAM 1 1 2 3 4 0. 1. 0.   HINGE 2 4 5 0. 0. 1.   BEAM 3 3 5 6 7 0. 0. 1.   TRUSS 4 6 8
RBEAM 6 6 7 10   X 3 0.7 0.2 0.1   X 6 1.2 0.8 0.4   X 8 1.5 0.2 1.4   X 10 1.5 1.0 0.7
FIX 1   FIX 2   FIX 8   DYNE 1 2 3 4 5 6   DYNE 2 1   DYNE 3 2 3 4 5 6   RLSE 4   END HALT
EM 1 1.1 0.02 0.013 0.014 0.001   EM 3 0.7 0.01 0.005 0.005   EM 4 0.3   XM 6 0.4
XM 7 0.05 0.01 0.02 0.06 0.01 0.07   XGYRO 7 3. 1. -2. 0.04   ESTIFF 1 5000. 20. 30. 40. 0.01 0.02
ESTIFF 2 2. 1. 1.5   ESTIFF 3 3000. 20. 10. 20.   ESTIFF 4 200.   EDAMP 1 5. 0.3 0.2 0.1
ESIG 1 2. 0.3 0.2 -0.1 0.3 0.2   GRAVITY 0.13 0.2 -0.98   XF 6 0.2 0.3 0.1   XF 7 0.05 -0.04 0.03
TIMESTEP 0.1 2   INTEGRAT 140 0.01   END END
"""
MODELS = {"planar": PLANAR, "spatial": SPATIAL}


def deck(name: str, mode: int) -> spacar.Deck:
    text = MODELS.get(name) or (DATA / f"{name}.dat").read_text()
    return spacar.parse_deck(text, mode=mode)


LIKE = {"e": "x", "ed": "xd", "edd": "xdd", "fxtot": "sig"}  # quantities whose rounding has the size of another one


def largest_difference(name: str, old: Frame, new: np.ndarray, x: list, e: list) -> float:
    """Largest difference over the largest value of the same kind; deformations compare with coordinates, since a
    rigid one is rounding."""
    values, groups = getattr(old, name), x if name.startswith(("x", "f")) else e
    like = LIKE.get(name, name)
    others, kinds = getattr(old, like), x if like.startswith("x") else e
    worst = 0.0
    for group in set(groups):
        rows = [i for i, g in enumerate(groups) if g == group]
        size = max(
            np.abs(values[rows]).max(),
            max((abs(v) for v, g in zip(others, kinds, strict=True) if g == group), default=0.0),
        )
        difference = np.abs(new[rows] - values[rows]).max()
        worst = max(worst, difference / size if size > 0.0 else difference)
    return worst


def compare(model: spacar.Deck, mode: int, to: System) -> None:
    old = list(spacar.frames(mode, model))
    run = spacar.frames(mode, convert(model, to))
    new = list(run)
    x, e = Dimensions(model).results(run.mechanism)
    names = ("x", "xd", "xdd", "e", "ed", "edd", "sig", "fxtot") if mode == 1 else ("x", "e", "sig")
    assert len(old) == len(new)
    for a, b in zip(old, new, strict=True):
        values = back(b, run.mechanism, to)
        for name in names:
            assert largest_difference(name, a, values[name], x, e) <= TOLERANCE, name


def test_units_are_read_as_powers():
    assert dimension("N m^2 s") == (1, 3, -1)
    assert dimension("kg/m") == (1, -1, 0)
    assert per((1, 2, -2), (0, 1, 0)) == (1, 1, -2)


@pytest.mark.parametrize("to", MARKED)
@pytest.mark.parametrize("name", ["planar", "spatial"])
def test_motion(name, to):
    compare(deck(name, 1), 1, to)


@pytest.mark.parametrize("to", MARKED[::2])
@pytest.mark.parametrize("name", ["crank", "slider", "cardan"])
def test_prescribed_motion_and_reactions(name, to):
    compare(deck(name, 1), 1, to)


@pytest.mark.parametrize("to", MARKED)
@pytest.mark.parametrize("name", ["planar", "spatial", "plbeam5"])
def test_equilibrium_and_frequencies(name, to):
    model = deck(name, 7)
    settings = "\nITERSTEP 20 10 1e-300\nEND\nEND"
    text = model.text.split("ITERSTEP")[0].rstrip().removesuffix("END").rstrip().removesuffix("END")
    model = spacar.parse_deck(text + settings, mode=7)
    compare(model, 7, to)
    old = list(spacar.frames(7, model))[-1].matrices["eigval"]
    new = list(spacar.frames(7, convert(model, to)))[-1].matrices["eigval"] * to.s
    # 1e-7: the eigenvalues of the non-symmetric state matrix, whose entries span the ratio of stiffness to mass
    assert np.abs(np.sort(new[:, 1]) - np.sort(old[:, 1])).max() <= 1e-7 * np.abs(old).max()


@pytest.mark.parametrize("to", MARKED[1::2])
@pytest.mark.parametrize("name", ["plbeam5buck", "column2", "lateral4"])
def test_buckling_loads_have_no_dimension(name, to):
    model = deck(name, 8)
    old = np.sort(list(spacar.frames(8, model))[-1].matrices["lmult"].ravel())
    new = np.sort(list(spacar.frames(8, convert(model, to)))[-1].matrices["lmult"].ravel())
    lowest = np.argmin(np.abs(old))
    assert new == pytest.approx(old, rel=1e-7, abs=1e-9 * abs(old[lowest]))
