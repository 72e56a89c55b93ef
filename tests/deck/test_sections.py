"""SECTION, MATERIAL, BEAMSEC, UNITS: constants against handbooks, expansion against plain decks, wrong input."""

from math import pi

import numpy as np
import pytest

import spacar
from spacar.deck import parse_deck
from spacar.deck.cross_section import MATERIALS, SHAPES, rectangle_torsion
from spacar.deck.length_unit import metres, shown_in
from spacar.deck.rewrite.divide import divided
from spacar.deck.rewrite.refine import refine
from spacar.errors import InputError, UsageError
from spacar.mechanism.element_batches import by_angles
from tests.examples import DATA


def constants(shape, *dims, nu=0.3):
    return SHAPES[shape].constants(*dims, nu)


@pytest.mark.parametrize(
    ("ratio", "c2"), [(1, 0.1406), (1.5, 0.1958), (2, 0.2287), (3, 0.2633), (5, 0.2913), (10, 0.3123), (1e6, 1 / 3)]
)
def test_torsion_of_a_rectangle(ratio, c2):
    """It = c2 w t^3 of Timoshenko and Goodier, art. 109, four digits; the same when the sides change places."""
    assert rectangle_torsion(ratio, 1.0) == pytest.approx(c2 * ratio, abs=6e-5 * ratio)
    assert rectangle_torsion(1.0, ratio) == rectangle_torsion(ratio, 1.0)


def test_shear_coefficients():
    """Cowper for nu = 0.3: rectangle 0.850, circle 0.886, thin tube 0.531, thin square tube 20(1+nu)/(48+39nu)."""
    assert constants("RECT", 3.0, 1.0).kz == pytest.approx(0.850, abs=5e-4)
    assert constants("CIRC", 2.0).ky == pytest.approx(0.886, abs=5e-4)
    assert constants("TUBE", 1.0, 1e-5).ky == pytest.approx(0.531, abs=5e-4)
    thin = constants("RECTHOL", 1.0, 1.0, 1.0 - 2e-7, 1.0 - 2e-7)
    assert thin.kz == pytest.approx(20 * 1.3 / (48 + 39 * 0.3), rel=1e-6)
    assert thin.ky == thin.kz


def test_steel_handbook_sections():
    """Tube 60.3 x 3.2 (EN 10219): 5.74 cm^2, 23.5 and 46.9 cm^4; IPE 200: Iz 142 cm^4, Iw 12990 cm^6.

    Its fillets of 12 mm, which a SECTION does not have, are 4 % of A and 5 % of Iy.
    """
    tube = constants("TUBE", 60.3e-3, 3.2e-3)
    np.testing.assert_allclose((tube.A * 1e4, tube.Iy * 1e8, tube.It * 1e8), (5.74, 23.5, 46.9), rtol=2e-3)
    ipe = constants("I", 0.1, 0.2, 5.6e-3, 8.5e-3)
    np.testing.assert_allclose((ipe.Iz * 1e8, ipe.Cw * 1e12), (142, 12990), rtol=2e-3)
    np.testing.assert_allclose((ipe.A * 1e4, ipe.Iy * 1e8), (28.5, 1943), rtol=0.055)
    assert ipe.kz * ipe.A == pytest.approx(5.6e-3 * 0.19, rel=0.06)  # the web carries the force


def test_closed_forms():
    rect, circle = constants("RECT", 0.05, 0.5e-3), constants("CIRC", 0.02)
    np.testing.assert_allclose(
        (rect.A, rect.Iy, rect.Iz, rect.Cw), (2.5e-5, 0.05 * 0.5e-3**3 / 12, 0.5e-3 * 0.05**3 / 12, (2.5e-5) ** 3 / 144)
    )
    np.testing.assert_allclose((circle.Iy, circle.It, circle.Cw), (pi * 0.02**4 / 64, pi * 0.02**4 / 32, 0.0))
    box = constants("RECTHOL", 1.0, 1.0, 0.998, 0.998)
    assert box.It == pytest.approx(0.001 * 0.999**3, rel=1e-12)  # Bredt: t a^3 of a square


def test_the_strip_of_the_warping_theory():
    """ESTIFF and EM of theory-warping.md section 10, table E4 (nu = 0.3; 10 digits)."""
    deck = parse_deck(STRIP.format(kind="BEAMW 1  1 2 3  4 5 6  0 1 0\nFIX 3", n=1))
    stiffness, mass = (deck.first(k).values[1:] for k in ("ESTIFF", "EM"))
    expected = (5.25e6, 0.1672087158, 0.109375, 1093.75, 6.375e-8, 6.375e-4, 2.278645833e-5)
    np.testing.assert_allclose(stiffness, expected, rtol=1e-9)
    np.testing.assert_allclose(mass, (0.195, 4.06290625e-5, 4.0625e-9, 4.0625e-5, 0, 8.463541667e-13), rtol=1e-9)


STRIP = """SECTION leaf RECT 0.05 0.0005
MATERIAL spring 210e9 0.3 7800
{kind}
BEAMSEC 1 LEAF Spring {n}
X 4 0.3
DYNE 1
FIX 1
FIX 2
END HALT
XF 4 0. 1e-3
END END
"""
KINDS = ["PLBEAM 1  1 2  4 5", "BEAM 1  1 2  4 5  0 1 0", "BEAMW 1  1 2 3  4 5 6  0 1 0\nFIX 3"]


@pytest.mark.parametrize("kind", KINDS, ids=["PLBEAM", "BEAM", "BEAMW"])
@pytest.mark.parametrize("n", [1, 3])
def test_the_plain_deck_gives_identical_results(kind, n):
    """`to_text` is what `spacar check --expand` prints; every number of mode 7 is the same to the last bit."""
    deck = parse_deck(STRIP.format(kind=kind, n=n), mode=7)
    assert [use.parts for use in deck.sections] == [(1, *range(2, n + 1))]
    text = deck.to_text()
    plain = parse_deck(text, mode=7)
    assert not plain.sections
    assert not any(word in text for word in ("SECTION", "MATERIAL", "BEAMSEC"))
    assert plain.to_text() == text
    a, b = spacar.run(7, deck), spacar.run(7, plain)
    for name in ("x", "e", "sig", "fxtot", "eigval", "estiff", "em"):
        np.testing.assert_array_equal(a[name], b[name])
    assert "CROSSTYPE RECT" in text


def test_planar_beam_bends_about_its_normal():
    deck = parse_deck(STRIP.format(kind=KINDS[0], n=1))
    EI = 210e9 * 0.5e-3 * 0.05**3 / 12
    G, k = 210e9 / 2.6, 13 / 15.3
    assert deck.first("ESTIFF").values[2:] == pytest.approx((EI, EI / (G * 2.5e-5 * k)), rel=1e-12)
    assert deck.first("EM").values[1:] == pytest.approx((0.195, 7800 * 0.5e-3 * 0.05**3 / 12), rel=1e-12)


MILLIMETRES = """UNITS mm
SECTION leaf RECT 50 0.5
SECTION spare CUSTOM 25 0.5 5000 2 0.85 0.85 100
MATERIAL spring 210e3 80769.23076923077 7.8e-6
BEAM 1  1 2  4 5  0 1 0
HINGE 2  5 6  0 0 1
BEAMSEC 1 leaf spring 2
X 4 300 10
DYNE 1
INPUTE 2 1
INPUTX 4 3
FIX 1
FIX 2
END HALT
XM 4 0.2
XM 6 20.
ESTIFF 2 3000
XF 4 0. 2.
XF 5 0. 500. 0.
GRAVITY 0 -9810
INPUTX 4 3 1. 2.
INPUTE 2 1 0.1 0.2
ESIG 1 1. 2. 3.
END END
"""
METRES = [
    ("UNITS mm\n", ""), ("RECT 50 0.5", "RECT 0.05 0.0005"),
    ("210e3 80769.23076923077 7.8e-6", "210e9 80769230769.23077 7800"),
    ("CUSTOM 25 0.5 5000 2 0.85 0.85 100", "CUSTOM 25e-6 0.5e-12 5e-9 2e-12 0.85 0.85 1e-16"),
    ("X 4 300 10", "X 4 0.3 0.01"), ("XM 6 20.", "XM 6 20e-6"), ("ESTIFF 2 3000", "ESTIFF 2 3."), ("500. 0.", "0.5 0."),
    ("-9810", "-9.81"), ("INPUTX 4 3 1. 2.", "INPUTX 4 3 1e-3 2e-3"),
]  # fmt: skip


def test_millimetres():
    """Every value of a file in mm is that of the file in m, to the rounding of one product."""
    text = MILLIMETRES
    for old, new in METRES:
        assert old in text
        text = text.replace(old, new)
    one, other = parse_deck(MILLIMETRES), parse_deck(text)
    assert len(one.statements) == len(other.statements)
    for s, t in zip(one.statements, other.statements, strict=True):
        assert s.keyword == t.keyword
        assert s.values == pytest.approx(t.values, rel=1e-14, abs=0)
    assert one.sections[0].constants.It == pytest.approx(other.sections[0].constants.It, rel=1e-14)


@pytest.mark.parametrize(
    ("unit", "power"), [("N m^2", 2), ("kg/m", -1), ("m/s^2", 1), ("kg m^2", 2), ("rad/m", -1), ("N/m^2", -2), ("s", 0)]
)
def test_powers_of_the_metre(unit, power):
    assert metres(unit) == power
    assert shown_in("N/m^2", 1e-3) == (pytest.approx(1e-6), "N/mm^2")
    assert shown_in("N m", 1e-3)[1] == "N mm"
    assert shown_in("N m^2", 1.0) == (1.0, "N m^2")


def test_known_materials_are_isotropic():
    """E = 2 G (1 + nu), with a nu of metals."""
    for material in MATERIALS.values():
        assert 0.2 < material.nu < 0.4
        assert pytest.approx(2 * material.G * (1 + material.nu)) == material.E


BASE = """SECTION leaf RECT 50e-3 0.5e-3
MATERIAL spring 210e9 0.3 7800
BEAM 1 1 2 4 5 0 1 0
X 4 0.3
FIX 1
FIX 2
DYNE 1
"""
WRONG = [
    ("SECTION bad RECTO 1 2", "there is no shape 'RECTO'; nearest: RECT"),
    ("SECTION bad RECT 1", "1 numbers for a rectangle; expected 2: w along y', t along z'"),
    ("SECTION bad RECT 1 2 3", "3 numbers for a rectangle"),
    ("SECTION bad RECT 1 0.", "t along z' of a rectangle is 0; it must be positive"),
    ("SECTION bad TUBE 0.1 0.06", "wall 0.06 m, at least half of the width of the tube"),
    ("SECTION bad RECTHOL 1 1 2 0.5", "the hole 2 x 0.5 m does not fit into 1 x 1 m"),
    ("SECTION bad I 0.1 0.1 0.01 0.06", "two flanges of 0.06 m do not fit"),
    ("SECTION Leaf CIRC 1", "SECTION Leaf: already given at line 1"),
    ("MATERIAL m -1. 0.3", "Young's modulus -1 must be positive"),
    ("MATERIAL m 1. -1.", "Poisson's ratio -1 must be above -1"),
    ("BEAMSEC 1 leave steel", "there is no SECTION 'leave'; nearest: leaf"),
    ("BEAMSEC 1 leaf stele", "there is no MATERIAL 'stele'; nearest: steel"),
    ("BEAMSEC 9 leaf steel", "element 9 is not defined"),
    ("BEAMSEC 1 leaf steel 0", "number of beams 0 must be at least 1"),
    ("BEAMSEC 1 leaf\nDYNE 1", "too few arguments: 2 given, 3 needed"),
    ("HINGE 2 5 6 0 0 1\nBEAMSEC 2 leaf steel", "element 2 is a HINGE (spatial hinge); BEAMSEC is for PLBEAM, BEAM"),
    ("BEAMSEC 1 leaf steel\nBEAMSEC 1 leaf spring", "already given at line 8"),
    ("UNITS inch", "there is no unit of length 'inch'; expected m or mm"),
    ("BEAMSEC 1 leaf steel\nEND HALT\nESTIFF 1 1.", "ESTIFF 1 at line 10 is given too; BEAMSEC stands for it"),
    ("BEAMSEC 1 leaf steel 2\nEND HALT\nMEE 1 1 2.", "beam 1 cannot be divided"),
]


@pytest.mark.parametrize(("line", "sentence"), WRONG, ids=[w[0].replace("\n", " ") for w in WRONG])
def test_wrong_input(line, sentence):
    with pytest.raises(InputError) as caught:
        parse_deck(f"{BASE}{line}\nEND END\n", "model.dat")
    found = [m for m in caught.value.messages if sentence in str(m)]
    assert found
    assert found[0].line >= 8


ONE_SENTENCE = [
    ("SECTION bad RECT 50", "SECTION bad: 1 numbers for a rectangle"),
    ("SECTION bad RECT 50 abc", "'abc' is not a number"),
    ("SECTION bad RECT -50 1", "w along y' of a rectangle is -50; it must be positive"),
    ("SECTION bad TUBE 5 3", "wall 3 mm, at least half of the width of the tube (5 mm)"),
    ("SECTION bad RECTHOL 5 3 6 2", "the hole 6 x 2 mm does not fit into 5 x 3 mm"),
    ("SECTION bad I 1 2 3 0.5", "web 3 mm thicker than the flanges are wide (1 mm)"),
    ("SECTION bad CIRC 1\nMATERIAL steel 2e5", "MATERIAL steel: too few arguments"),
    ("SECTION bad CIRC 1\nMATERIAL steel -1. 0.3", "Young's modulus"),
]


@pytest.mark.parametrize(("lines", "sentence"), ONE_SENTENCE, ids=[w[0].replace("\n", " ") for w in ONE_SENTENCE])
def test_a_wrong_section_is_told_once_and_in_the_unit_of_the_file(lines, sentence):
    """The BEAMSEC that names it says nothing more."""
    text = f"UNITS mm\n{lines}\nBEAMSEC 1 bad steel\nPLBEAM 1 1 2 3 4\nX 3 5. 0.\nFIX 1\nFIX 2\nDYNE 1\nEND HALT\n"
    with pytest.raises(InputError) as caught:
        parse_deck(f"{text}XM 3 1.\nEND END\n", "model.dat")
    assert [str(m) for m in caught.value.messages if sentence in str(m)]
    assert len(caught.value.messages) == 1, [str(m) for m in caught.value.messages]


def test_bending_modes_of_one_pair_have_one_class():
    text = BASE.replace("DYNE 1", "DYNE 1 3") + "BEAMSEC 1 leaf steel 2\nEND END\n"
    with pytest.raises(InputError, match=r"modes 3 and 4 are of different classes \(DYNE, fixed\)"):
        parse_deck(text)


def test_numbers_of_a_section_can_be_set_and_those_that_follow_cannot():
    deck = parse_deck(STRIP.format(kind=KINDS[1], n=2))
    thicker = deck.set("SECTION", "leaf", 4, 1e-3)
    assert thicker.first("ESTIFF").values[1] == pytest.approx(2 * deck.first("ESTIFF").values[1])
    with pytest.raises(UsageError, match=r"ESTIFF 1 follows from the statement at this line \(BEAMSEC"):
        deck.set("ESTIFF", 1, 2, 5.0)


def test_division_of_an_undivided_model_changes_nothing():
    deck = parse_deck(STRIP.format(kind=KINDS[1], n=1))
    assert divided(deck.statements, {1: 1}) == (list(deck.statements), {})


# Beams that are divided keep their measure.
@pytest.mark.parametrize(("statement", "measured"), [("ADEFORM", range(1, 11)), ("ADEFORM 2", (2, 7))])
def test_adeform_of_all_and_of_one_beam(statement, measured):
    """plbeam5 in halves: beam 2 becomes 2 and 7. ADEFORM without a number failed with IndexError."""
    text = (DATA / "plbeam5.dat").read_text().replace("DYNE 1 2 3", f"{statement}\nDYNE 1 2 3", 1)
    deck = refine(parse_deck(text, mode=7), 2)
    assert by_angles(deck) == set(measured)
    result = spacar.run(7, deck)
    forms = {b.family.measure for b in result.mechanism.batches if b.family.keyword == "PLBEAM"}
    assert forms == ({"angle"} if statement == "ADEFORM" else {"", "angle"})
