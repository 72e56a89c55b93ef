"""Every element type, load and coefficient: derivatives of the whole state against differences of whole analyses.

The differences (two steps of 4e-4 and less, extrapolated) are known to about 1e-9 of a quantity that a Newton
iteration leaves at 1e-11, by the step: 1e-7 of the derivatives, less for eigenvalues of matrices with wide spectra.
"""

import pytest

from spacar import Deck, parse_deck
from spacar.deck import read_deck
from tests.examples import DATA
from tests.linear import linear_models
from tests.linear.flexure_models import random_model

from .difference_truth import agree

CLAMPED = [("FIX", 1), ("FIX", 2)]


def still(text: str) -> Deck:
    """A model of linear_models with prescribed values, but at rest."""
    text = text.replace("1.6 0.3 0.2", "1.6").replace("1.5 0.3 0.2", "1.5")
    text = text.replace("5 1 0.1 0.2 0.3", "5 1 0.1").replace("4 1 0.1 0.2 0.3", "4 1 0.1")
    text = text.replace("XGYRO 7 3. 1. -2. 0.04", "")
    return parse_deck(text.format(extra="", third="") if "{" in text else text, mode=10)


def test_everything_planar() -> None:
    """PLBEAM, PLTRUSS, PLTOR, PLRBEAM with shear, preload, MEE, damping, gravity, prescribed values, releases."""
    deck = still(linear_models.PLANAR.format(extra="", third=""))
    names = ["ESTIFF.1[EI]", "ESTIFF.1[4]", "ESTIFF.6", "EM.1", "EM.1[3]", "XM.5", "MEE.2.1", "MEE.1.2", "EDAMP.2[3]",
             "X.5[2]", "X.10[3]", "ESIG.1[3]", "GRAVITY[2]", "XF.5[2]", "XF.6", "INPUTX.7.1", "INPUTE.4.1"]  # fmt: skip
    state = ["x[5,1]", "x[3,2]", "e[2,1]", "sig[1,2]", "sig[4,1]", "fxtot[7,1]", "fxgrav[5,2]", "fx[5,1]", "Mz[1,3]",
             "Qy[2,1]"]  # fmt: skip
    linear = ["frequency[1]", "frequency[3]", "lmult[1]", "xcompl[5,1]", "real(eigval[1])"]
    agree(deck, names, state + linear, rel=[1e-8] * len(state) + [1e-6] * len(linear))


def test_everything_spatial() -> None:
    """BEAM, HINGE, TRUSS, RBEAM with global moments and forces on Euler parameters (unsymmetric), preload, MEE."""
    deck = still(linear_models.SPATIAL.format(extra="", third=""))
    names = ["ESTIFF.1[GIt]", "ESTIFF.3[EIy]", "ESTIFF.1[6]", "EM.1", "EM.1[3]", "XM.7[4]", "MEE.1.3", "EDAMP.3[4]",
             "X.6[2]", "X.8[4]", "ESIG.1[4]", "GRAVITY[2]", "XF.7[2]", "XF.4[3]", "INPUTX.8.1", "INPUTE.5.1",
             "ESTIFF.2[2]", "ESTIFF.4", "HINGE.2[4]", "BEAM.1[6]"]  # fmt: skip
    agree(deck, names, ["x[6,1]", "x[7,2]", "e[2,1]", "sig[1,2]", "sig[5,1]", "fxtot[8,1]", "fx[7,2]", "T[3,1]",
                        "frequency[1]", "lmult[1]", "xcompl[6,1]", "imag(eigval[3])"], rel=1e-6)  # fmt: skip


@pytest.mark.parametrize("method", [0, 1])
def test_steady_motion(method: int) -> None:
    """Everything planar with prescribed rates: centrifugal forces, dampers, MEE; also where the iteration of the file
    (ITERSTEP type 1) leaves terms of its tangent out."""
    text = linear_models.PLANAR.format(extra=f"ITERSTEP 60 4 1e-10 1 {method}", third="")
    if method == 1:  # slower, that the iteration without them converges
        text = text.replace("1.6 0.3 0.2", "1.6 0.03").replace("0.1 0.2 0.3", "0.1 0.02")
    names = ["ESTIFF.1[EI]", "ESTIFF.6", "EM.1", "EM.1[3]", "XM.5", "MEE.2.1", "MEE.1.2", "EDAMP.2[3]", "X.5[2]",
             "X.10[3]", "ESIG.1[3]", "GRAVITY[2]", "XF.5[2]", "INPUTX.7.1[start rate]", "INPUTE.4.1[start rate]",
             "INPUTX.7.1"]  # fmt: skip
    state = ["x[5,1]", "x[3,2]", "e[2,1]", "sig[1,2]", "sig[4,1]", "fxtot[7,1]", "fxgrav[5,2]", "Mz[1,3]"]
    linear = ["frequency[1]", "real(eigval[1])", "xcompl[5,1]", "lmult[1]"]
    bounds = [1e-6] * len(state) + [1e-5] * len(linear)
    agree(parse_deck(text, mode=10), names, state + linear, rel=bounds)


@pytest.mark.parametrize("measure", ["", pytest.param("ADEFORM", marks=pytest.mark.slow)])
def test_steady_motion_in_space(measure: str) -> None:
    """The same with gyrostats, hinges and beams in space. In angles all matrices hold third derivatives of the
    deformations, whose complex step takes fourth ones."""
    names = ["ESTIFF.1[GIt]", "ESTIFF.3[EIy]", "EM.1", "XM.7[4]", "MEE.1.3", "EDAMP.3[4]", "X.6[2]", "XGYRO.7[2]",
             "INPUTX.8.1[start rate]", "INPUTE.5.1[start rate]", "GRAVITY[2]", "HINGE.2[4]"]  # fmt: skip
    text = linear_models.SPATIAL.format(extra="ITERSTEP 60 8 1e-10", third="").replace("FIX 1 ", f"FIX 1   {measure} ")
    state = ["x[6,1]", "x[7,2]", "e[2,1]", "sig[1,2]", "sig[5,1]", "fxtot[8,1]", "T[3,1]"]
    linear = ["frequency[1]", "frequency[4]", "real(eigval[2])", "xcompl[6,2]", "lmult[1]"]
    agree(parse_deck(text, mode=10), names, state + linear, rel=[1e-6] * len(state) + [1e-5] * len(linear))


PLANAR_RODS = [("X", 3, 0.8, 0.3), ("X", 5, 1.5, 0.1)]
PLANAR_CHAINS = {
    "angle": (
        [("PLBEAM", 1, 1, 2, 3, 4), ("PLBEAM", 2, 3, 4, 5, 6), ("ADEFORM",), ("DYNE", 1), ("DYNE", 2)],
        [("ESTIFF", 1, 50.0, 3.0, 0.02), ("ESTIFF", 2, 40.0, 2.0), ("EM", 1, 0.7, 0.01), ("EM", 2, 0.5)],
        ["ESTIFF.1[EI]", "ESTIFF.1[4]", "EM.1"],
    ),
    "linear strain": (
        [("PLBEAM", 1, 1, 2, 3, 4), ("PLBEAM", 2, 3, 4, 5, 6), ("LDEFORM", 1), ("DYNE", 1), ("DYNE", 2)],
        [("ESTIFF", 1, 50.0, 3.0), ("ESTIFF", 2, 40.0, 2.0), ("EM", 1, 0.7, 0.01), ("EM", 2, 0.5)],
        ["ESTIFF.1[EI]", "EM.1"],
    ),
    "tube with flow": (
        [("PLTUBE", 1, 1, 2, 3, 4, 0.1, -0.2), ("PLTUBE", 2, 3, 4, 5, 6), ("DYNE", 1), ("DYNE", 2)],
        [("ESTIFF", 1, 50.0, 3.0), ("ESTIFF", 2, 40.0, 2.0), ("EM", 1, 0.7, 0.4, 0.9, 1.1), ("EM", 2, 0.5, 0.4, 0.9)],
        ["ESTIFF.1[EI]", "EM.1[4]", "EM.1[3]", "PLTUBE.1[6]"],
    ),
    "curved tube, angles": (
        [("PLTUBE", 1, 1, 2, 3, 4, 0.1, -0.2), ("PLBEAM", 2, 3, 4, 5, 6), ("ADEFORM",), ("DYNE", 1), ("DYNE", 2)],
        [("ESTIFF", 1, 50.0, 3.0), ("ESTIFF", 2, 40.0, 2.0), ("EM", 1, 0.7, 0.4), ("EM", 2, 0.5)],
        ["ESTIFF.1[EI]", "EM.1[3]", "PLTUBE.1[6]"],
    ),
}  # fmt: skip


@pytest.mark.parametrize("chain", [
    pytest.param("angle", marks=pytest.mark.slow), "linear strain", "tube with flow", "curved tube, angles",
])  # fmt: skip
def test_planar_chains(chain: str) -> None:
    rows, dynamics, names = PLANAR_CHAINS[chain]
    loads = [("XF", 5, 0.2, -0.4), ("XF", 6, 0.1), ("GRAVITY", 0.0, -0.3), ("XM", 5, 0.2), ("XM", 6, 0.02)]
    deck = Deck.build([*rows, *PLANAR_RODS, *CLAMPED], [*dynamics, *loads], mode=10)
    quantities = ["x[5,1]", "x[6,1]", "e[1,3]", "sig[1,1]", "sig[2,2]", "fxtot[1,2]", "Mz[1,1]", "frequency[1]",
                  "frequency[3]", "xcompl[5,2]"]  # fmt: skip
    more = [] if "tube" in chain else ["lmult[1]"]
    agree(deck, [*names, "X.3[2]", "X.5[3]", "XF.5[3]", "GRAVITY[2]"], [*quantities, *more], rel=1e-6)


def test_belt_and_pinbody() -> None:
    """PLBELT around two discs on springs, PLPINBOD with projections and directions."""
    rows = [("PLBELT", 1, 1, 2, 3, 4, 0.1, 0.25), ("PLTRUSS", 2, 3, 5), ("PLTOR", 3, 4, 6), ("PLPINBOD", 4, 3, 4, 7),
            ("PLTRUSS", 5, 7, 8), ("X", 3, 1.0, 0.1), ("X", 5, 1.6, 0.9), ("X", 7, 1.2, 0.4), ("X", 8, 2.0, 0.3),
            ("FIX", 1), ("FIX", 5), ("FIX", 6), ("FIX", 8), ("INPUTX", 2), ("DYNE", 1), ("DYNE", 2), ("DYNE", 3),
            ("RLSE", 5)]  # fmt: skip
    dynamics = [("ESTIFF", 1, 30.0), ("ESTIFF", 2, 20.0), ("ESTIFF", 3, 2.0), ("ESTIFF", 5, 10.0),
                ("EM", 1, 0.1, 1.0, 1.0), ("XM", 3, 1.0), ("XM", 4, 0.1), ("XM", 7, 0.3), ("XF", 7, 1.0, -0.5),
                ("INPUTX", 2, 1, 0.3)]  # fmt: skip
    deck = Deck.build(rows, dynamics, mode=10)
    names = ["PLBELT.1[6]", "PLBELT.1[7]", "ESTIFF.1", "ESTIFF.3", "ESTIFF.5", "X.3[2]", "X.7[3]", "X.5[2]",
             "INPUTX.2.1", "XF.7[2]", "EM.1"]  # fmt: skip
    quantities = ["x[3,1]", "x[4,1]", "x[7,2]", "sig[1,1]", "sig[4,1]", "fxtot[2,1]", "frequency[1]", "lmult[1]"]
    agree(deck, names, quantities)


SPATIAL_CHAINS = {
    "beam": ("BEAM", []), "angle measure": ("BEAM", [("ADEFORM",)]), "tube with flow": ("TUBE", []),
    "tube in angles": ("TUBE", [("ADEFORM",)]),
}


@pytest.mark.parametrize("chain", [
    *(pytest.param(c, marks=pytest.mark.slow) for c in ("beam", "angle measure")), "tube with flow", "tube in angles",
])  # fmt: skip
def test_spatial_chains(chain: str) -> None:
    """Beams and tubes in both measures, skew in space: also the coupling f1 and directions of local axes."""
    word, more = SPATIAL_CHAINS[chain]
    rows = [(word, 1, 1, 2, 3, 4, 0.1, 1.0, 0.2, 1e-3), (word, 2, 3, 4, 5, 6, 0.0, 0.9, 0.3), ("X", 3, 0.5, 0.1, 0.2),
            ("X", 5, 0.9, 0.3, 0.1), *CLAMPED, ("DYNE", 1), ("DYNE", 2), *more]  # fmt: skip
    flow = chain == "tube with flow"
    pipe = (0.3, 0.2 if flow else 0.0, 1.1, 0) if word == "TUBE" else ()
    em = (0.7, *pipe, 0.01, 0.006, 0.007, 0.001)
    dynamics = [("EM", 1, *em), ("EM", 2, *em), ("ESTIFF", 1, 90.0, 2.0, 3.0, 4.0, 0.01, 0.02),
                ("ESTIFF", 2, 80.0, 1.5, 2.0, 3.0), ("XF", 5, 0.3, -0.6, 0.4), ("XF", 6, 0.1, 0.2, -0.1),
                ("XM", 5, 0.3), ("XM", 6, 0.02, 0.001, 0, 0.03, 0, 0.02), ("GRAVITY", 0.0, 0.1, -0.5)]  # fmt: skip
    deck = Deck.build(rows, dynamics, mode=10)
    names = ["X.3[2]", "X.5[4]", f"{word}.1[6]", f"{word}.1[9]", "ESTIFF.1[GIt]", "ESTIFF.2[EIy]", "ESTIFF.1[6]",
             "EM.1", "XF.5[3]", "XF.6[2]", "XM.6[4]", "GRAVITY[3]"]  # fmt: skip
    quantities = ["x[5,1]", "x[6,2]", "e[1,2]", "sig[1,3]", "fxtot[1,3]", "T[1,1]", "My[2,4]", "frequency[1]",
                  "frequency[4]", "xcompl[5,3]"]  # fmt: skip
    agree(deck, names, [*quantities, *([] if flow else ["lmult[1]"])], rel=1e-6)


def test_directions_and_flow() -> None:
    """Curved TUBE with ORTUBE and a jet, no gravity; PINBODY with ORPINBOD and DRPINBOD; additional flow DELOMF."""
    rows = [("TUBE", 1, 1, 2, 3, 4, 0.0, 1.0, 0.0), ("ORTUBE", 1, 1.0, 0.1, 0.05, 0.95, 0.3, 0.1, 0.0, 1.0, 0.0),
            ("X", 3, 1.0, 0.2, 0.1), *CLAMPED, ("DYNE", 1), ("PINBODY", 2, 3, 4, 5), ("TRUSS", 3, 5, 6), ("RLSE", 3),
            ("ORPINBOD", 2, 1.0, 0.1, 0.0, 0.1, 1.0, 0.2), ("DRPINBOD", 2, 0.31, 0.02, 0.19), ("X", 5, 1.3, 0.2, 0.3),
            ("X", 6, 1.5, 0.9, 0.9), ("FIX", 6)]  # fmt: skip
    law = [("EM", 1, 0.7, 0.3, 0.1, 1.1, 2, 0.01, 0.006, 0.007, 0.001), ("ESTIFF", 1, 90.0, 2.0, 3.0, 4.0),
           ("XM", 5, 0.4), ("ESTIFF", 3, 5.0), ("XF", 5, 0.1, 0.3, -0.2), ("ITERSTEP", 20, 1, 1e-10)]  # fmt: skip
    names = ["ORTUBE.1[3]", "ORTUBE.1[6]", "ORTUBE.1[9]", "X.3[2]", "EM.1[4]", "ORPINBOD.2[3]", "DRPINBOD.2[3]"]
    quantities = ["x[3,1]", "x[5,2]", "sig[1,2]", "sig[2,1]", "fxtot[1,1]", "frequency[1]"]
    agree(Deck.build(rows, law, mode=10), names, quantities, rel=1e-6)
    rows = [("PLTUBE", 1, 1, 2, 3, 4), ("PLTUBE", 2, 3, 4, 5, 6), ("X", 3, 0.5, 0.0), ("X", 5, 1.0, 0.1), *CLAMPED,
            ("DYNE", 1), ("DYNE", 2)]  # fmt: skip
    law = [("ESTIFF", 1, 50.0, 3.0), ("ESTIFF", 2, 40.0, 2.0), ("EM", 1, 0.7, 0.4, 0.9, 1.1, 2), ("XF", 5, 0.0, 0.2),
           ("EM", 2, 0.5, 0.4, 0.9, 1.0, 2), ("DELOMF", 1, 0.3), ("DELOMF", 2, 0.3),
           ("ITERSTEP", 20, 2, 1e-10, 1, 2)]  # fmt: skip
    quantities = ["x[5,2]@end", "sig[2,2]@end", "frequency[1]@end"]
    agree(Deck.build(rows, law, mode=10), ["DELOMF.1", "DELOMF.2", "EM.1[4]", "EM.2[3]"], quantities, rel=1e-6)


def test_spatial_joints() -> None:
    """PINBODY and RBEAM with inertia, SCREW with pitch, HINGE springs."""
    rows = [("BEAM", 1, 1, 2, 3, 4, 0.0, 1.0, 0.0), ("RBEAM", 2, 3, 4, 5, 0.0, 0.0, 1.0), ("PINBODY", 3, 3, 4, 6),
            ("SCREW", 4, 3, 4, 7, 8, 1.0, 0.2, 0.1, 0.05), ("TRUSS", 5, 7, 9), ("HINGE", 6, 8, 10, 0.2, 1.0, 0.1),
            ("TRUSS", 7, 5, 11), ("TRUSS", 8, 6, 11), ("X", 3, 0.5, 0.1, 0.2), ("X", 5, 0.6, 0.5, 0.2),
            ("X", 6, 0.8, 0.1, 0.4), ("X", 7, 0.9, 0.2, 0.2), ("X", 9, 1.5, 0.8, 0.3), ("X", 11, 0.9, 0.9, 0.9),
            *CLAMPED, ("FIX", 9), ("FIX", 11), ("DYNE", 1), ("DYNE", 4, 1), ("RLSE", 5), ("DYNE", 6), ("RLSE", 7),
            ("RLSE", 8)]  # fmt: skip
    dynamics = [("EM", 1, 0.7, 0.01, 0.006, 0.007), ("EM", 2, 0.4, 0.01, 0.01, 0.01),
                ("ESTIFF", 1, 90.0, 2.0, 3.0, 4.0), ("ESTIFF", 4, 1.0), ("ESTIFF", 5, 12.0),
                ("ESTIFF", 6, 1.0, 2.0, 3.0), ("ESTIFF", 7, 9.0), ("ESTIFF", 8, 5.0), ("XM", 7, 0.4),
                ("XM", 8, 0.05, 0, 0, 0.06, 0, 0.07), ("XM", 10, 0.02, 0, 0, 0.03, 0, 0.02), ("XF", 5, 0.3, -0.6, 0.4),
                ("XF", 10, 0.05, 0.02, -0.1)]  # fmt: skip
    deck = Deck.build(rows, dynamics, mode=10)
    names = ["SCREW.4[9]", "SCREW.4[6]", "RBEAM.2[6]", "X.5[3]", "X.7[2]", "X.6[4]", "ESTIFF.4", "ESTIFF.8", "EM.2",
             "XM.10[2]", "XF.10[3]"]  # fmt: skip
    agree(deck, names, ["x[5,2]", "x[7,1]", "x[10,3]", "e[4,1]", "sig[4,2]", "sig[2,1]", "sig[6,1]", "fxtot[9,1]",
                        "frequency[1]", "lmult[1]"], rel=1e-6)  # fmt: skip


@pytest.mark.parametrize("beams", ["sine", pytest.param("angle", marks=pytest.mark.slow)])
def test_sections_materials_units_and_warping(beams: str) -> None:
    """BEAMW described by SECTION, MATERIAL and BEAMSEC in mm, divided into parts, at two load steps."""
    deck = read_deck(DATA / "leafguide.dat", 10)
    if beams == "angle":
        deck = parse_deck(deck.text.replace("DYNE 1\n", "DYNE 1\nADEFORM\n", 1), mode=10)
    names = ["SECTION.leaf[t]", "SECTION.leaf[w]", "MATERIAL.spring[Young]", "MATERIAL.spring[density]",
             "X.4[3] & X.10[3]", "X.1[2]", "DELXF.7[2]", "SECTION.bar[t]"]  # fmt: skip
    quantities = ["x[7,1]@end", "sig[1,1]@2", "fxtot[1,1]@end", "mises[1]@end", "shear[4]@3", "frequency[1]@end"]
    if beams == "sine":
        quantities.append("B[1,1]@end")  # zero but for rounding in angles
    agree(deck, names, quantities, rel=1e-6)


@pytest.mark.parametrize("seed", [1, 6, *(pytest.param(k, marks=pytest.mark.slow) for k in (2, 5, 9, 10))])
def test_random_flexures(seed: int) -> None:
    """Loaded chains and guides of random size, slenderness, direction and material."""
    model = random_model(seed)
    deck = parse_deck(model.text(), mode=10)
    last = model.nodes - 1
    names = ["ESTIFF.1[EI]" if model.planar else "ESTIFF.1[EIy]", f"X.{last}[2]", f"X.{last}[3]", "XF.*[2]"]
    state, linear = [f"x[{last},1]", "sig[1,2]", "fxtot[1,1]"], ["frequency[1]", f"xcompl[{last},2]"]
    agree(deck, names, state + linear, seed=seed, rel=[1e-6] * 3 + [1e-5] * 2, step=4e-3)
