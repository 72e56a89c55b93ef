"""BEAMW in whole analyses: the tables of theory-warping.md sections 8 to 10.

Printed digits of a prototype with the same formulas are compared to half a unit of their last place (relative 1e-8
where nothing else is said, as eigenvalues and load multipliers have 9 digits); physics to the stated errors.
"""

import numpy as np
import pytest

import spacar
from spacar.deck.rewrite.refine import refine
from spacar.errors import AnalysisError
from tests.examples import DATA

from .warped_bars import bar

STRIP = {"EA": 5.25e6, "GIt": 0.1672087158, "EIy": 0.109375, "EIz": 1093.75, "ECw": 2.278645833e-5}  # 50 x 0.5 mm
STRIP_MASS = (0.195, 4.06290625e-5, 4.0625e-9, 4.0625e-5, 0.0, 8.463541667e-13)


def torsional_stiffness(n, stiffness, free=(), length=1.0):
    """Moment over angle of a bar clamped at p, with `free` nodes of warping, for a moment about x at q."""
    moment = 1e-6 * stiffness["GIt"] / length
    end = 3 * n
    fixed = [(1,), (2,), *((k,) for k in (3, end + 3) if k not in free)]
    deck = bar(n, 8, stiffness, length=length, fixed=fixed, loads=[("XF", end + 2, moment, 0.0, 0.0)])
    lam = spacar.run(8, deck).node(end + 2, 2)[-1]
    return moment / (2.0 * np.arcsin(lam))


@pytest.mark.parametrize(
    ("n", "both", "one"), [(1, 1.680000000, 1.285909091), (3, 1.655988652, 1.251278749), (4, 1.653370573, 1.250429093)]
)
def test_torsional_stiffness_of_constrained_ends(n, both, one):
    """Table E2: u = 5; exact with both ends 1.65192521. The sine of the twist costs 1e-13 at these angles."""
    rigidity = {"EA": 1.0, "GIt": 1.0, "EIy": 1.0, "EIz": 1.0, "ECw": 0.04}
    assert torsional_stiffness(n, rigidity) == pytest.approx(both, rel=1e-9)
    assert torsional_stiffness(n, rigidity, free=(3 * n + 3,)) == pytest.approx(one, rel=1e-9)
    assert torsional_stiffness(n, rigidity, free=(3, 3 * n + 3)) == pytest.approx(1.0, rel=1e-9)


def test_leaf_spring_against_the_solid():
    """Section 9: strip 50 x 0.5 mm, 100 mm long: 2.187725 N m/rad with 4 elements, 2.215606 of the solid (C3D20R)."""
    stiffness = torsional_stiffness(4, STRIP, length=0.1)
    assert stiffness == pytest.approx(2.187725, abs=1e-6)
    assert stiffness / 2.215606 == pytest.approx(0.98, abs=0.01)
    assert STRIP["GIt"] / 0.1 / 2.215606 == pytest.approx(0.76, abs=0.01)  # what BEAM gives


def test_bimoment_at_the_clamp():
    """u = 2, 8 elements: tanh(u/2)/u for a unit torque, 3.0e-7 by the mesh; torque by stresses exact."""
    deck = bar(8, 8, {"EA": 1.0, "GIt": 1.0, "EIy": 1.0, "EIz": 1.0, "ECw": 0.25},
               fixed=[(1,), (2,), (3,), (27,)], loads=[("XF", 26, 1e-6, 0.0, 0.0)])  # fmt: skip
    r = spacar.run(8, deck)
    found = r.node(3, 1, "fxtot")[-1] / -1e-6
    assert found == pytest.approx(0.3807975, abs=1e-7)
    assert found == pytest.approx(np.tanh(1) / 2, abs=6e-7)
    s2, s7, s8 = (r.element(4, k, "sig")[-1] for k in (2, 7, 8))
    assert (s2 + s7 - s8) / 8 == pytest.approx(1e-6, rel=1e-9)


@pytest.mark.parametrize(("n", "expected"), [(1, 12.12067276), (2, 9.84195546), (4, 9.76293187), (16, 9.75478)])
def test_lateral_buckling(n, expected):
    """Table E3: cantilever with r = GIt L^2/ECw = 4, exact 9.754739 (Ritz with 18 polynomials): order 4."""
    deck = bar(n, 8, {"GIt": 1.0, "EIz": 1.0, "ECw": 0.25}, dynamic=(2, 5, 6), loads=[("XF", 3 * n + 1, 0.0, 0.0, 1.0)])
    value = np.min(np.abs(spacar.run(8, deck)["lmult"][-1]))
    assert value == pytest.approx(expected, abs=5e-9 if n < 16 else 5e-6)
    if n == 16:
        assert value == pytest.approx(9.754739, rel=5e-6)


@pytest.mark.parametrize(("n", "expected"), [(2, 5.88760300), (4, 5.85251072)])
def test_buckling_by_a_uniform_moment(n, expected):
    """Table E3: fork supports, (pi/L) sqrt(EIz GIt (1 + pi^2/r)) = 5.850..., all warping free."""
    fixed = [(1, 1, 2, 3), (2, 2), (3 * n + 1, 2, 3), (3 * n + 2, 2)]
    loads = [("XF", 2, 0.0, -1.0, 0.0), ("XF", 3 * n + 2, 0.0, 1.0, 0.0)]
    deck = bar(n, 8, {"GIt": 1.0, "EIz": 1.0, "ECw": 0.25}, dynamic=(2, 5, 6), released=(2,), fixed=fixed, loads=loads)
    assert np.min(np.abs(spacar.run(8, deck)["lmult"][-1])) == pytest.approx(expected, abs=5e-8)


@pytest.mark.parametrize(
    ("n", "clamped", "expected"), [(2, False, 3.98876936), (4, False, 3.97493181), (4, True, 9.95507744)]
)
def test_axial_torsional_buckling(n, clamped, expected):
    """Table E3: f1 = Ip/A = 0.5, r = 10; (GIt + pi^2 ECw/L^2)/f1 = 3.97392, with clamped warping 4 pi^2 for pi^2."""
    end = 3 * n
    fixed = [(1,), (2,), (end + 1, 2, 3), (end + 2,), *([(3,), (end + 3,)] if clamped else [])]
    deck = bar(n, 8, {"EA": 1e7, "GIt": 1.0, "EIy": 1e5, "EIz": 1e5, "ECw": 0.1}, f1=0.5, fixed=fixed,
               released=(2, 3, 4, 5, 6), loads=[("XF", end + 1, -1.0, 0.0, 0.0)])  # fmt: skip
    found = spacar.run(8, deck)["lmult"][-1]
    exact = 2 * (1 + (4 if clamped else 1) * np.pi**2 * 0.1)
    value = np.min(found[found > 0])
    assert value == pytest.approx(expected, abs=5e-7)
    assert value == pytest.approx(exact, rel=7e-3)


@pytest.mark.parametrize(
    ("n", "expected"),
    [(3, (29.26126122, 183.95853456, 351.71041651, 519.79042735, 980.31507511, 1170.51671686)),
     (1, (29.39740247, 289.63548282, 321.87085283))],
)  # fmt: skip
def test_frequencies_of_a_strip(n, expected):
    """Table E4: rad/s; the stiff axial modes of the same matrix leave 1e-9 relative in the low ones."""
    deck = bar(n, 7, STRIP, length=0.3, mass=STRIP_MASS, shear=(6.375e-8, 6.375e-4))
    found = 2 * np.pi * spacar.run(7, deck).frequencies[-1][: len(expected)]
    np.testing.assert_allclose(found, expected, rtol=1e-8)


def test_massless_warping_in_vibration_and_motion():
    """Without Jw the low frequencies are those with a small one; in time a motion without mass is refused by name."""
    light = (*STRIP_MASS[:5], 0.0)
    with_mass, without = (
        spacar.run(7, bar(3, 7, STRIP, length=0.3, mass=mass)).frequencies[-1][:5] for mass in (STRIP_MASS, light)
    )
    np.testing.assert_allclose(without, with_mass, rtol=2e-5)  # Jw w'^2 against Jxx theta'^2: (Jw/Jxx) (pi/L)^2
    with pytest.raises(AnalysisError, match=r"singular mass matrix.*node 6 w.*node 9 w"):
        spacar.run(1, bar(3, 1, STRIP, length=0.3, mass=light, loads=[("TIMESTEP", 1e-4, 1)]))


HINGE = {
    1: ((0.11215516, 0.08526168, -0.00053018), (1.580582, 18.216475, 34.766601, 38.191929, 46.549612, 146.605666)),
    2: ((0.10726282, 0.09191316, -0.00017394), (1.525384, 29.478876, 47.043644, 52.968033, 61.428976, 148.325635)),
    10: ((0.06123053, 0.12502061, -0.00247408), (1.772466, 8.929174, 19.548532, 23.071794, 36.986271, 133.066005)),
}


def test_published_cross_hinge():
    """Table E5: ten steps of mode 10; six decimals, and equilibrium to 5e-7 of the forces (1e-7 of frequencies)."""
    r = spacar.run(10, DATA / "crosshingew.dat")
    assert (r["ndof"], r["le"].shape[1], r["ln"].shape[1]) == (34, 8, 6)
    for step, (place, frequencies) in HINGE.items():
        np.testing.assert_allclose([r.node(7, k)[step - 1] for k in (1, 2, 3)], place, atol=2e-8)
        np.testing.assert_allclose(r.frequencies[step - 1][:6], frequencies, rtol=1e-7, atol=6e-7)
    rates = [r.node(n, 1)[0] for n in (15, 18, 21, 24)]
    np.testing.assert_allclose(rates, (0.580474, -0.638751, -0.243504, 0.110414), atol=1e-6)
    np.testing.assert_allclose(r.node(3, 1, "fxtot")[[0, 9]], (-1.974787e-4, 5.980411e-4), rtol=1e-6)
    np.testing.assert_allclose(r.node(12, 1, "fxtot")[[0, 9]], (-1.477136e-4, 1.788179e-4), rtol=1e-6)
    np.testing.assert_allclose([r.element(1, k, "sig")[9] for k in (7, 8)], (-0.1746701, 0.1293223), atol=1e-6)


def test_overconstraints_are_those_of_beam():
    """Mode 0 of the hinge without its releases: 6 over-constraints, none from warping (theory-warping.md section 1)."""
    text = (DATA / "crosshingew.dat").read_text()
    for rows, over in (("RLSE 7", 0), ("DYNE 7", 6)):
        found = spacar.frames(0, spacar.parse_deck(text.replace("RLSE 7", rows), mode=0))
        list(found)
        diagnosis = found.header["diagnosis"]
        assert (diagnosis.over, diagnosis.under) == (over, 0)


def strip(mode, n=2):
    return bar(n, mode, STRIP, length=0.3, mass=STRIP_MASS, loads=[("TIMESTEP", 1e-5, 1)] if mode in (1, 4) else ())


def test_state_matrices_have_the_frequencies_of_mode_7():
    """Modes 9 and 4 (at rest): omega of the state matrix [0 I; -M^-1 K 0], not balanced: 1e-6 of the low ones."""
    omega = 2 * np.pi * spacar.run(7, strip(7)).frequencies[-1][:4]
    for mode in (9, 4):
        r = spacar.run(mode, strip(mode))
        M, K = r["m0"][0], r["k0"][0]
        found = np.sqrt(np.sort(np.linalg.eigvals(np.linalg.solve(M, K)).real)[:4])
        np.testing.assert_allclose(found, omega, rtol=1e-6)


def test_a_refined_strip_is_the_finer_model():
    """New warping nodes; the same frequencies as the deck written with four elements."""
    finer = 2 * np.pi * spacar.run(7, refine(strip(7), 2)).frequencies[-1][:4]
    np.testing.assert_allclose(finer, 2 * np.pi * spacar.run(7, strip(7, 4)).frequencies[-1][:4], rtol=1e-8)


def test_torsional_vibration_in_time():
    """Mode 1: started in the shape of its first mode with amplitude 1e-4, the end turns as cos(omega t); rtol 1e-9."""
    shaft = {"EA": 0.0, "GIt": 1.0, "ECw": 0.25}
    mass = (1.0, 1.0, 0.0, 0.0, 0.0, 0.1)
    options = {"dynamic": (2,), "mass": mass}
    r = spacar.run(7, bar(2, 7, shaft, **options))
    n = r.mechanism.numbering
    K, M = r["k0"][-1], r["m0"][-1]
    squares, shapes = (found.real for found in np.linalg.eig(np.linalg.solve(M, K)))  # K and M are positive definite
    k = int(np.argmin(squares))
    omega, shape = np.sqrt(squares[k]), 1e-4 * shapes[:, k] / np.abs(shapes[:, k]).max()
    starts = []
    for value, place in zip(shape, np.r_[n.q_x, n.q_e], strict=True):
        x = len(starts) < len(n.q_x)
        owner = n.x_owner(int(place)) if x else n.e_owner(int(place))
        starts.append(("STARTDX" if x else "STARTDE", *owner, float(value)))
    period = 2 * np.pi / omega
    loads = [*starts, ("TIMESTEP", period, 8), ("INTEGRAT", 853), ("ERROR", 1e-13, 1e-9)]
    turned = spacar.run(1, bar(2, 1, shaft, loads=loads, **options)).node(8, 2)
    np.testing.assert_allclose(turned / turned[0], np.cos(np.linspace(0, 2 * np.pi, 9)), atol=1e-6)


@pytest.mark.parametrize(
    ("deflection", "expected"),
    [(0.0, (7.436e6, 7.436e6, 2.1877)), (5e-3, (3.791e6, 1.784e6, 21.043)), (1e-2, (1.536e6, 7.146e5, 33.347))],
)
def test_support_stiffness_of_a_deflected_leaf_spring(deflection, expected):
    """Section 9, n = 4: ky with the rotation about x locked and free [N/m], and krx [N m/rad]; four digits and more.

    The solid has 3.790e6, 1.771e6, 20.76 at 5 mm and 1.576e6, 7.252e5, 33.47 at 10 mm; BEAM a third of that.
    """
    n, end = 4, 12
    found = []
    for locked in (True, False):
        deck = bar(n, 8, STRIP, length=0.1, mass=STRIP_MASS, shear=(6.375e-8, 6.375e-4),
                   released=(2, 3, 4, 5) if locked else (3, 4, 5),
                   fixed=[(1,), (2,), (3,), (end + 3,), (end + 2, 2, 3, 4) if locked else (end + 2, 3, 4)],
                   prescribed=(end + 1, 3), loads=[("INPUTX", end + 1, 3, 0.0), ("DELINPX", end + 1, 3, deflection),
                                                   ("ITERSTEP", 20, 8, 1e-9, 8, 2)])  # fmt: skip
        r = spacar.run(8, deck)
        compliance, numbering = r["xcompl"][-1], r.mechanism.numbering
        found.append(1 / compliance[numbering.x_index(end + 1, 2)])
        if not locked:  # theta = 2 lambda1, and M is half of the force dual to lambda1
            found.append(1 / (4 * compliance[numbering.x_index(end + 2, 2)]))
    np.testing.assert_allclose(found, expected, rtol=2e-4)
