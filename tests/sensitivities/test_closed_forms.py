"""Derivatives that are known in closed form: cantilever, oscillator, columns, section formulas, repeated values."""

import numpy as np
import pytest

import spacar
from spacar import Deck
from spacar.errors import AnalysisError, UsageError
from spacar.expressions.evaluation import Value
from spacar.expressions.grammar import parse
from spacar.sensitivities.expression_derivatives import derivative

from .difference_truth import agree

L, EI, M = 0.5, 2.0, 0.3  # m, N m^2, kg/m


def cantilever(n: int = 4, force: tuple[float, ...] = (), length: float = L, more: list[tuple] | None = None) -> Deck:
    """n equal PLBEAM along x, clamped at node 1; the tip is node 2 n + 1."""
    rows: list[tuple] = [("FIX", 1), ("FIX", 2)]
    dynamics: list[tuple] = []
    for k in range(1, n + 1):
        p = 2 * k - 1
        rows += [("PLBEAM", k, p, p + 1, p + 2, p + 3), ("X", p + 2, length * k / n, 0.0), ("DYNE", k, 2, 3)]
        dynamics += [("ESTIFF", k, 0.0, EI), ("EM", k, M)]
    if force:
        dynamics.append(("XF", 2 * n + 1, *force))
    return Deck.build(rows, [*dynamics, *(more or [])], mode=10)


def scaled(found: spacar.Sensitivity, quantity: int, names: list[str]) -> float:
    """sum p dq/dp over some of the parameters: the derivative when all of them grow by the same part."""
    places = [found.parameters.index(n) for n in names]
    return float(found.derivatives[quantity, places] @ found.parameter_values[places])


def test_tip_deflection() -> None:
    """w = F L^3/(3 EI): dw/dF, dw/dEI, and dw/dL by moving all nodes; F so small that w/L squared is rounding."""
    F = 1e-7
    lengths = [f"X.{2 * k + 1}[2]" for k in range(1, 5)]
    found = spacar.sensitivity(cantilever(force=(0.0, F)), ["XF.9[3]", "ESTIFF.*[EI]", *lengths], ["x[9,2]", "Mz[1,1]"])
    w = F * L**3 / (3 * EI)
    assert found.values[0] == pytest.approx(w, rel=1e-9)
    assert found.derivatives[0, 0] == pytest.approx(w / F, rel=1e-9)
    assert found.derivatives[0, 1] == pytest.approx(-w / EI, rel=1e-9)
    assert scaled(found, 0, lengths) == pytest.approx(3 * w, rel=1e-9)
    assert abs(found.derivatives[1, 0]) == pytest.approx(L, rel=1e-9)
    assert scaled(found, 1, lengths) == pytest.approx(found.values[1], rel=1e-9)


def test_oscillator() -> None:
    """f = sqrt(k/m)/(2 pi), k = EA/l0, and its damped |lambda| = omega, real part -c/(2 m)."""
    rows = [("PLTRUSS", 1, 1, 2), ("X", 2, 2.0, 0.0), ("FIX", 1), ("FIX", 2, 2), ("DYNE", 1)]
    found = spacar.sensitivity(Deck.build(rows, [("XM", 2, 3.0), ("ESTIFF", 1, 96.0)], mode=10),
                               ["ESTIFF.1", "XM.2", "X.2[2]"], ["frequency[1]"])  # fmt: skip
    f = np.sqrt(16.0) / (2 * np.pi)
    np.testing.assert_allclose(found.values, f, rtol=1e-14)
    np.testing.assert_allclose(found.derivatives[0], [f / 192, -f / 6, -f / 4], rtol=1e-13)
    assert found.relative[0] == pytest.approx([0.5, -0.5, -0.5], rel=1e-13)
    damped = Deck.build(rows, [("XM", 2, 3.0), ("ESTIFF", 1, 96.0), ("EDAMP", 1, 4.8)], mode=10)
    found = spacar.sensitivity(
        damped, ["ESTIFF.1", "XM.2", "EDAMP.1"], ["frequency[1]", "real(eigval[1])", "imag(eigval[1])"]
    )
    c, k, m = 2.4, 48.0, 3.0
    wd = np.sqrt(k / m - (c / (2 * m)) ** 2)
    np.testing.assert_allclose(found.derivatives[0], [f / 192, -f / 6, 0.0], rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(found.derivatives[1], [0.0, c / (2 * m**2), -0.5 / (2 * m)], rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(
        found.derivatives[2],
        [0.5 / (2 * m * wd), (-k / m**2 + c**2 / (2 * m**3)) / (2 * wd), -0.5 * c / (4 * m**2 * wd)], rtol=1e-12,
    )  # fmt: skip


def test_frequencies_of_a_cantilever() -> None:
    """f = (1.8751/L)^2 sqrt(EI/m)/(2 pi): powers 1/2, -1/2, -2 hold for the discretized beam exactly."""
    lengths = [f"X.{2 * k + 1}[2]" for k in range(1, 7)]
    found = spacar.sensitivity(cantilever(6), ["ESTIFF.*[EI]", "EM.*", *lengths], ["frequency[1]", "frequency[3]"])
    exact = 1.8751040687**2 / L**2 * np.sqrt(EI / M) / (2 * np.pi)
    assert found.values[0] == pytest.approx(exact, rel=1e-5)
    assert found.derivatives[0, 0] == pytest.approx(exact / (2 * EI), rel=1e-5)
    for q, f in enumerate(found.values):
        assert found.derivatives[q, 0] == pytest.approx(f / (2 * EI), rel=1e-11)
        assert found.derivatives[q, 1] == pytest.approx(-f / (2 * M), rel=1e-11)
        assert scaled(found, q, lengths) == pytest.approx(-2 * f, rel=1e-11)


def test_euler_column() -> None:
    """lambda = pi^2 EI/(4 L^2 F): powers 1, -1, -2."""
    lengths = [f"X.{2 * k + 1}[2]" for k in range(1, 5)]
    found = spacar.sensitivity(cantilever(force=(-1e-3, 0.0)), ["ESTIFF.*[EI]", "XF.9[2]", *lengths], ["lmult[1]"])
    exact = np.pi**2 * EI / (4 * L**2 * 1e-3)
    assert found.values[0] == pytest.approx(exact, rel=1e-4)
    assert found.derivatives[0, 0] == pytest.approx(found.values[0] / EI, rel=1e-9)
    assert found.derivatives[0, 1] == pytest.approx(found.values[0] / 1e-3, rel=1e-9)
    assert scaled(found, 0, lengths) == pytest.approx(-2 * found.values[0], rel=1e-9)


def test_string_of_prestressed_trusses() -> None:
    """A mass between two rods with preload T: f^2 = 2 T/(l m)/(2 pi)^2, ESIG and INPUTX (a stretch) as parameters."""
    rows = [("PLTRUSS", 1, 1, 2), ("PLTRUSS", 2, 2, 3), ("X", 2, 1.0, 0.0), ("X", 3, 2.0, 0.0), ("FIX", 1),
            ("FIX", 3, 2), ("INPUTX", 3, 1), ("DYNX", 2), ("RLSE", 1), ("RLSE", 2)]  # fmt: skip
    law = [("ESTIFF", 1, 500.0), ("ESTIFF", 2, 500.0), ("XM", 2, 0.5), ("ESIG", 1, 8.0), ("ESIG", 2, 8.0)]
    deck = Deck.build(rows, [*law, ("INPUTX", 3, 1, 2.02)], mode=10)
    found = spacar.sensitivity(
        deck, ["ESIG.1 & ESIG.2", "INPUTX.3.1", "ESTIFF.*", "XM.2"], ["frequency[1]", "sig[1,1]", "fxtot[3,1]"]
    )
    T, l = 8.0 + 500.0 * 0.01, 1.01
    f = np.sqrt(2 * T / (l * 0.5)) / (2 * np.pi)
    np.testing.assert_allclose(found.values, [f, T, T], rtol=1e-10)
    by_stretch = 0.5 * f * (250.0 / T - 0.5 / l)  # half of the stretch in each rod
    np.testing.assert_allclose(found.derivatives[0], [f / (2 * T), by_stretch, 0.5 * f * 0.01 / T, -f], rtol=1e-9)
    np.testing.assert_allclose(found.derivatives[1], [1.0, 250.0, 0.01, 0.0], rtol=1e-10, atol=1e-12)


def crossed(angle: float, *more: tuple) -> Deck:
    """A mass on two equal springs at right angles."""
    c, s = np.cos(angle), np.sin(angle)
    rows = [("PLTRUSS", 1, 1, 2), ("PLTRUSS", 2, 1, 3), ("X", 2, c, s), ("X", 3, -s, c), ("FIX", 2), ("FIX", 3),
            ("DYNX", 1), ("RLSE", 1), ("RLSE", 2)]  # fmt: skip
    return Deck.build(rows, [("XM", 1, 0.7), ("ESTIFF", 1, 9.0), ("ESTIFF", 2, 9.0), *more], mode=10)


@pytest.mark.parametrize("angle", [0.0, 0.4, 1.1])
def test_repeated_frequency(angle: float) -> None:
    """When one gets stiffer, one frequency keeps its value and the other
    has f/(2 k), in whatever directions the springs stand; when both do, both have."""
    found = spacar.sensitivity(
        crossed(angle), ["ESTIFF.1", "ESTIFF.2", "ESTIFF.*", "XM.1"], ["frequency[1]", "frequency[2]", "abs(eigval[1])"]
    )
    f = np.sqrt(9.0 / 0.7) / (2 * np.pi)
    grown = f / 18.0
    np.testing.assert_allclose(found.values[:2], f, rtol=1e-12)
    np.testing.assert_allclose(found.derivatives[0], [0.0, 0.0, grown, -f / 1.4], rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose(found.derivatives[1], [grown, grown, grown, -f / 1.4], rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose(found.derivatives[2, :2], 2 * np.pi * grown, rtol=1e-10)
    assert any("occurs 2 times" in note for note in found.notes)


def test_repeated_damped_eigenvalue() -> None:
    """The same mass with equal dampers too: one pair keeps its modulus, the other has that of m, c, k."""
    deck = crossed(0.4, ("EDAMP", 1, 0.6), ("EDAMP", 2, 0.6))
    found = spacar.sensitivity(deck, ["ESTIFF.1", "EDAMP.2", "XM.1"], ["frequency[1]", "frequency[2]"])
    f = np.sqrt(9.0 / 0.7) / (2 * np.pi)  # |lambda| = sqrt(k/m) whatever c
    np.testing.assert_allclose(found.values, f, rtol=1e-12)
    np.testing.assert_allclose(found.derivatives[0], [0.0, 0.0, -f / 1.4], rtol=1e-9, atol=1e-11)
    np.testing.assert_allclose(found.derivatives[1], [f / 18.0, 0.0, -f / 1.4], rtol=1e-9, atol=1e-11)


def test_repeated_multiplier() -> None:
    """A column with a square section buckles in every direction; a change of EIy lifts one of the two multipliers."""
    rows = [("BEAM", 1, 1, 2, 3, 4, 0.0, 0.3, 1.0), ("BEAM", 2, 3, 4, 5, 6, 0.0, 0.3, 1.0), ("X", 3, 0.25, 0.0, 0.0),
            ("X", 5, 0.5, 0.0, 0.0), ("FIX", 1), ("FIX", 2), ("DYNE", 1), ("DYNE", 2)]  # fmt: skip
    law = [("ESTIFF", k, 1e5, 1.5, 2.0, 2.0) for k in (1, 2)] + [("EM", k, 0.1, 1e-5, 1e-5, 1e-5) for k in (1, 2)]
    deck = Deck.build(rows, [*law, ("XF", 5, -1.0, 0.0, 0.0)], mode=10)
    names = ["ESTIFF.*[EIy]", "ESTIFF.*[EIy] & ESTIFF.*[EIz]"]
    found = spacar.sensitivity(deck, names, ["lmult[1]", "lmult[2]", "frequency[1]", "frequency[2]"])
    np.testing.assert_allclose(found.values[1], found.values[0], rtol=1e-7)
    # both multipliers depend on the axial stiffness too (second order in the load): 1 N of 1e5 N, 1e-5
    np.testing.assert_allclose(found.derivatives[:2, 1], found.values[0] / 2.0, rtol=1e-4)
    np.testing.assert_allclose(found.derivatives[:2, 0], [0.0, found.values[0] / 2.0], rtol=1e-4, atol=1e-4)
    both = found.derivatives[2:, 1]
    np.testing.assert_allclose(found.derivatives[2:, 0], [0.0, both[1]], rtol=1e-3, atol=1e-3 * both[1])


def test_strongly_bent_cantilever() -> None:
    """Tip turned by about 80 degrees: positions, reaction, stress, frequency, multiplier and compliance."""
    deck = cantilever(8, force=(-8.0, 34.0), more=[("ITERSTEP", 20, 4, 1e-10)])
    names = ["ESTIFF.3[EI]", "ESTIFF.1[EI]", "X.9[2]", "X.9[3]", "XF.17[2]", "XF.17[3]", "EM.4"]
    quantities = [
        "x[17,1]",
        "x[17,2]",
        "x[18,1]",
        "fxtot[2,1]",
        "sig[4,2]",
        "Mz[3,5]",
        "frequency[1]",
        "lmult[1]",
        "xcompl[17,2]",
    ]
    found = agree(deck, names, quantities, rel=1e-7)
    assert found.values[2] > 1.2


def test_section_and_material_of_a_tension_rod() -> None:
    """sigma = F/(w t), u = F L/(E w t), tau of torsion scales with 1/(w t^2) of a fixed shape: in mm."""
    text = (
        "UNITS mm\nSECTION rod RECT 4 2\nMATERIAL m 2e5 0.3 7.8e-6\nBEAM 1 1 2 3 4 0 1 0\nX 3 100 0 0\n"
        "BEAMSEC 1 rod m 2\nFIX 1\nFIX 2\nDYNE 1\nEND\nHALT\nXF 3 500 0 0\nEND\nEND\n"
    )
    names = ["SECTION.rod[w]", "SECTION.rod[t]", "MATERIAL.m[Young]", "X.3[2]", "XF.3[2]"]
    found = spacar.sensitivity(spacar.parse_deck(text, mode=10), names, ["mises[1]", "x[3,1]", "N[1,3]"])
    assert found.parameter_units == ("mm", "mm", "N/mm^2", "mm", "N")
    stress, u = 500 / 8e-6, 0.5 * 100 * 1e-3 / (2e5 * 8 * 1e-3)
    np.testing.assert_allclose(
        found.derivatives[0], [-stress / 4, -stress / 2, 0, 0, stress / 500], rtol=1e-6, atol=1e-3
    )
    np.testing.assert_allclose(found.derivatives[1], [-u / 4, -u / 2, -u / 2e5, 1e-3 + u / 100, u / 500], rtol=2e-3)
    np.testing.assert_allclose(found.derivatives[2], [0, 0, 0, 0, 1], rtol=1e-9, atol=1e-9)


def test_expressions_follow_the_chain_rule() -> None:
    """Powers, quotients, functions and steps of the derivatives of their variables."""
    deck = cantilever(3, force=(0.0, 3.0), more=[("DELXF", 7, 0.0, 3.0), ("ITERSTEP", 10, 3, 1e-9, 1, 2)])
    names = ["ESTIFF.*[EI]", "XF.7[3]"]
    plain = spacar.sensitivity(deck, names, ["x[7,1]@end", "x[7,2]@end", "x[7,2]@2"])
    (a, b, c), (da, db, dc) = plain.values, plain.derivatives
    wanted = {
        "hypot(x[7,1],x[7,2])@end": (np.hypot(a, b), (a * da + b * db) / np.hypot(a, b)),
        "deg(atan2(x[7,2],x[7,1]))@end": (
            np.degrees(np.arctan2(b, a)),
            np.degrees((a * db - b * da) / (a * a + b * b)),
        ),
        "max(x[7,2])": (b, db),
        "(x[7,2]@end/x[7,1]@end)**2": (b**2 / a**2, 2 * b / a * (db / a - b * da / a**2)),
        "sqrt(x[7,2]@2*x[7,2]@end)": (np.sqrt(b * c), (b * dc + c * db) / (2 * np.sqrt(b * c))),
        "abs(-x[7,2]@2)": (c, dc),
    }
    found = spacar.sensitivity(deck, names, [f"q{i}: {text}" for i, text in enumerate(wanted)])
    for i, (value, rate) in enumerate(wanted.values()):
        assert found.values[i] == pytest.approx(value, rel=1e-12)
        np.testing.assert_allclose(found.derivatives[i], rate, rtol=1e-11)
    assert found.quantities[0] == "q0"
    assert found.quantity_units[:2] == ("m", "deg")
    assert found.of("q2", "XF.7[3]") == found.derivatives[2, 1]


def test_critical_states_have_no_derivatives() -> None:
    """Rods in a line under no load: nothing holds the middle node, the tangent is singular."""
    rows = [("PLTRUSS", 1, 1, 2), ("PLTRUSS", 2, 2, 3), ("X", 2, 1.0, 0.0), ("X", 3, 2.0, 0.0), ("FIX", 1),
            ("FIX", 3), ("DYNX", 2), ("RLSE", 1), ("RLSE", 2)]  # fmt: skip
    deck = Deck.build(rows, [("ESTIFF", 1, 5.0), ("ESTIFF", 2, 5.0), ("XM", 2, 1.0)], mode=10)
    with pytest.raises(AnalysisError, match="no derivatives at load step"):
        spacar.sensitivity(deck, ["ESTIFF.1"], ["x[2,1]"])


@pytest.mark.parametrize(
    ("parameters", "quantities", "words"),
    [
        (["ESTIFF.9[EI]"], ["x[9,1]"], "no statement ESTIFF 9"),
        (["ESTIFF.1[EJ]"], ["x[9,1]"], "its arguments are 1 element number, 2 EA"),
        (["X.9"], ["x[77,1]"], "node 77 does not exist; nodes are 1 to 10"),
        (["X.9"], ["sig[1,7]"], "element 1 has the deformation modes 1 to 3"),
        (["X.9"], ["xd[9,1]"], "'xd' is no quantity of stationary states"),
        (["X.9"], ["m0[1,1]"], "these are x, fx, fxgrav, fxtot, e, sig, frequency"),
        (["X.9"], ["frequenzy[1]"], "variables with indices are x, xd"),
        (["X.9"], ["frequency[99]"], "the model has 8 of them"),
        (["X.9"], ["eigval[1]"], "is complex; take its abs"),
        (["X.9"], ["mises[1]"], "no cross-section"),
        (["X.9"], ["Mz[7]"], "element 7 is no beam or truss; these are 1, 2, 3, 4"),
        (["X.9"], ["Mz[1,12]"], "places along an element are 1 to 9"),
        (["X.9"], ["x[9,1]@5"], "step 5 does not exist"),
        (["FIX.1[1]"], ["x[9,1]"], "is no real number"),
        (["X.*[2]"], ["x[9,1]"], "stands for 4 different numbers"),
        (["BEAMSEC.1"], ["x[9,1]"], "no statement BEAMSEC 1"),
    ],
)  # fmt: skip
def test_what_there_is_not(parameters: list[str], quantities: list[str], words: str) -> None:
    with pytest.raises(UsageError) as caught:
        spacar.sensitivity(cantilever(force=(0.0, 1.0)), parameters, quantities)
    assert words in str(caught.value)


def test_rotating_spring() -> None:
    """Steady rotation: k e = m w^2 (l0 + e), so e = l0/(k/(m w^2) - 1); EA, mass, speed and length."""
    rows = [("PLBEAM", 1, 1, 2, 3, 4), ("X", 3, 0.4, 0.0), ("FIX", 1), ("INPUTX", 2), ("DYNE", 1, 1)]
    law = [("ESTIFF", 1, 80.0, 1.0), ("XM", 3, 0.5), ("INPUTX", 2, 1, 0.0, 12.0), ("ITERSTEP", 20, 4, 1e-10)]
    names = ["ESTIFF.1", "XM.3", "INPUTX.2.1[start rate]", "X.3[2]"]
    quantities = ["e[1,1]", "sig[1,1]", "x[3,1]", "N[1,5]", "frequency[1]"]
    found = spacar.sensitivity(Deck.build(rows, law, mode=10), names, quantities)
    k, m, w, l0 = 80.0 / 0.4, 0.5, 12.0, 0.4
    ratio = k / (m * w * w)
    e = l0 / (ratio - 1)
    by_ratio = -e / (ratio - 1)
    want = [by_ratio * ratio / 80.0, -by_ratio * ratio / m, -2 * by_ratio * ratio / w, e / l0 - by_ratio * ratio / l0]
    f = np.sqrt(k / m - w * w) / (2 * np.pi)  # at constant speed
    np.testing.assert_allclose(found.values, [e, k * e, l0 + e, k * e, f], rtol=1e-10)
    slopes = np.array([k / m / 80.0, -k / m / m, -2 * w, -k / m / l0]) / (8 * np.pi**2 * f)
    np.testing.assert_allclose(found.derivatives[4], slopes, rtol=1e-9)
    np.testing.assert_allclose(found.derivatives[0], want, rtol=1e-9)
    np.testing.assert_allclose(found.derivatives[2], np.add(want, [0, 0, 0, 1]), rtol=1e-9)
    np.testing.assert_allclose(
        found.derivatives[1], np.add(np.multiply(k, want), [e / l0, 0, 0, -k * e / l0]), rtol=1e-9
    )
    np.testing.assert_allclose(found.derivatives[3], found.derivatives[1], rtol=1e-12)


def test_low_modes_beside_a_motion_of_hardly_any_mass() -> None:
    """The twist rate of a BEAMW without warping inertia moves at 1e19 rad/s: low ones are not zero beside it, with and
    without a moment, whose stiffness is not symmetric."""
    rows = [("BEAMW", 1, 1, 2, 3, 4, 5, 6, 0.1, 1.0, 0.2), ("X", 4, 0.5, 0.1, 0.2), ("FIX", 1), ("FIX", 2), ("FIX", 3),
            ("DYNE", 1)]  # fmt: skip
    for moment in (0.0, 0.05):
        law = [("ESTIFF", 1, 90.0, 2.0, 3.0, 4.0, 0.0, 0.0, 0.05), ("EM", 1, 0.7, 0.01, 0.006, 0.007), ("XM", 4, 0.3),
               ("XF", 4, 0.3, -0.6, 0.4), ("XM", 5, 0.01, 0.0, 0.0, 0.01, 0.0, 0.01), ("XF", 5, moment)]  # fmt: skip
        agree(Deck.build(rows, law, mode=7), ["XM.4"], ["frequency[1]", "frequency[2]"])


@pytest.mark.parametrize("rotor", [(), (0,), (1,)])
def test_rotor_of_each_type(rotor: tuple[int, ...]) -> None:
    """Two springs k1, k2, inertia I and momentum h = J Omega: I^2 w^4 - (I (k1 + k2) + h^2) w^2 + k1 k2 = 0."""
    rows = [("HINGE", 1, 1, 2, 1, 0, 0), ("HINGE", 2, 2, 3, 0, 1, 0), ("FIX", 1), ("DYNE", 1, 1), ("DYNE", 2, 1)]
    dynamics = [("XM", 3, 0.05, 0, 0, 0.05, 0, 0.01), ("XGYRO", 3, 0, 0, 200.0, 0.02, *rotor), ("ESTIFF", 1, 6.0),
                ("ESTIFF", 2, 7.0)]  # fmt: skip
    names = ["XGYRO.3[4]", "XGYRO.3[5]"]
    deck = Deck.build(rows, dynamics, mode=7)
    found = spacar.sensitivity(deck, names, ["frequency[1]", "frequency[2]"])
    w = 2 * np.pi * found.values
    per_unit = 4.0**2 * w / (2 * 0.05**2 * w**2 - (0.05 * 13.0 + 4.0**2)) / (2 * np.pi)  # h df/dh
    np.testing.assert_allclose(w**2, np.sort(np.roots([0.05**2, -(0.05 * 13.0 + 4.0**2), 42.0])), rtol=1e-11)
    np.testing.assert_allclose(found.derivatives, np.outer(per_unit, [1 / 200.0, 1 / 0.02]), rtol=1e-10)


@pytest.mark.parametrize(
    ("text", "want"),
    [
        ("(t + lmult[1]@end)@2", [4.0, 40.0]), ("(t - lmult[1]@end)@3", [-4.0, -40.0]),
        ("real(t + lmult[1]@end)@2", [4.0, 40.0]), ("(2**2 + t)@2 + lmult[1]@1", [1.0, 10.0]),
        ("(sin(1) + t)@3 * lmult[1]@1", [2.0 + np.sin(1.0), 10.0 * (2.0 + np.sin(1.0))]),
        ("max(t + lmult[1]@2)", [2.0, 20.0]), ("(t * lmult[1])@3", [6.0, 60.0]),
    ],
)  # fmt: skip
def test_a_step_of_a_sum_of_a_series_and_a_number(text: str, want: list[float]) -> None:
    """lmult = 1, 2, 3, 4 with the derivatives 1, 10; 2, 20; ... at t = 0, 1, 2, 3: the number has no axis of steps."""
    series = np.arange(1.0, 5.0)
    known = Value(series, (), np.outer(series, [1.0, 10.0]))
    np.testing.assert_allclose(derivative(parse(text), lambda node: known, 4, 2).rates, want, rtol=1e-15)
