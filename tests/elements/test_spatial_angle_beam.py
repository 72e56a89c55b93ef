"""BEAM and TUBE in the angle measure (theory-beam-order4.md sections 2 to 4): digits, derivatives, order 4."""

import numpy as np
import pytest

import spacar
from spacar.deck.rewrite.refine import linear_strain
from spacar.elements.spatial.angle_measure import rotation_factor
from spacar.elements.spatial.beam import SpatialBeam
from spacar.elements.spatial.beam_angle import SpatialAngleBeam, SpatialAngleTube

from .derivatives import check_inertia, check_strain, close, evaluate, group

X0 = np.zeros((14, 1))
X0[3] = X0[7] = X0[10] = 1.0
ELASTIC = [(1.0, 0.4, 0.7, 1.3, 0.1, 0.2)]
RIGID_TORSION = [(1.0, 0.0, 0.7, 1.3)]


def beam(estiff=ELASTIC, x0=X0, **values) -> SpatialAngleBeam:
    n = x0.shape[1]
    return SpatialAngleBeam(group("BEAM", x0, geometry=[(0.0, 1, 0, 0.03)] * n, estiff=estiff * n, **values))


def state_of_the_theory() -> tuple[np.ndarray, np.ndarray]:
    """x and v of section 4.1."""
    x, w = X0.copy(), [np.sin((4, 5, 6)), np.sin((10, 11, 12))]
    x[7:10, 0] = 0.9, 0.25, -0.2
    v = np.zeros((14, 1))
    v[:3, 0], v[7:10, 0] = np.sin((1, 2, 3)), np.sin((7, 8, 9))
    for row, angle, axis, omega in ((3, 0.2, (1, 2, 3), w[0]), (10, 0.35, (-1, 1, 2), w[1])):
        x[row, 0] = np.cos(angle)
        x[row + 1 : row + 4, 0] = np.sin(angle) * np.array(axis) / np.linalg.norm(axis)
        a, b, c, d = x[row : row + 4, 0]
        bar = np.array([[-b, a, -d, c], [-c, d, a, -b], [-d, -c, b, a]])
        v[row : row + 4, 0] = 0.5 * bar.T @ omega
    return x, v


def test_single_digits_of_the_theory():
    """Section 4.1: value, first and second derivative, all twelve digits."""
    x, v = state_of_the_theory()
    family = SpatialAngleBeam(group("BEAM", X0, geometry=[(0.0, 1, 0)]))
    c, e, V = evaluate(family, x)
    second = np.zeros((6, 1))
    family.convective_strain(c, v, second)
    truth = [
        (-0.038920609743, -0.408738312885, 0.083800853237, 0.224799833978, 0.091630891710, 0.340225334091),
        (-0.244811890587, 0.259164173629, 0.213230285991, -0.408774422496, -0.969488871542, -1.507862389423),
        (0.244041835077, -0.082171822820, 0.099428057540, 0.475680091168, 1.894445331108, -0.373780324023),
    ]
    for got, expected in zip((e, np.einsum("ejn,jn->en", V, v), second), truth, strict=True):
        e1, e2, e3, e4, e5, e6 = got[:, 0]
        np.testing.assert_allclose((e1, e2, e3 + e4, e5 + e6, e4 - e3, e6 - e5), expected, rtol=0, atol=1.1e-12)


def test_energy_is_that_of_the_twist_gradient_at_its_minimum():
    """Section 2.2: W of e1..e6 = the smallest of W(A_x) = sum of EI M(A_x)^2, GIt M_x^2, 3 GIt A_x^2, ... over A_x."""
    from scipy.optimize import minimize_scalar

    x, _ = state_of_the_theory()
    GIt, EIy, EIz = 0.05, 3.0, 0.7
    bare = SpatialAngleBeam(group("BEAM", X0, geometry=[(0.0, 1, 0)]))
    full = SpatialAngleBeam(group("BEAM", X0, geometry=[(0.0, 1, 0)], estiff=[(0.0, GIt, EIy, EIz)]))
    c, e, _ = evaluate(bare, x)
    psi = c.strain.inner.y[1:4, 0] * c.strain.G[0, 0]
    B_y, B_z, A_y, A_z = e[2] + e[3], e[4] + e[5], e[3] - e[2], e[5] - e[4]

    def energy(a):
        M_y, M_z = B_y[0] - a * psi[2] / 2, B_z[0] + a * psi[1] / 2
        fixed = GIt * e[1, 0] ** 2 + 3 * EIy * A_y[0] ** 2 + 3 * EIz * A_z[0] ** 2
        return 0.5 * (EIy * M_y**2 + EIz * M_z**2 + 3 * GIt * a**2 + fixed)

    got = evaluate(full, x)[1][:, 0]
    S = full.stiffness()[0][:, :, 0]
    least = minimize_scalar(energy, method="brent", options={"xtol": 1e-12}).fun
    assert least < energy(0.0) - 1e-4
    assert 0.5 * got @ S @ got == pytest.approx(least, rel=1e-13)


@pytest.mark.parametrize("estiff", [ELASTIC, RIGID_TORSION, [(0.0, 1e-4, 1.0, 1e4)]], ids=["elastic", "stiff", "leaf"])
@pytest.mark.parametrize("spread", [0.0, 0.1, 0.4])
def test_derivatives(estiff, spread):
    """Also off the unit sphere, and where the rotation is large."""
    rng = np.random.default_rng(4)
    n = 4
    x0 = np.tile(X0, n)
    x0[7:10] += 0.3 * rng.normal(size=(3, n))
    family = beam(estiff, x0, em=[(1.0, 0.1, 0.2, 0.3, 0.01)] * n, nonlinear=[True, True, True, False])
    x = np.tile(state_of_the_theory()[0], n) + spread * rng.normal(size=(14, n))
    v, a = rng.normal(size=(2, 14, n))
    check_strain(family, x, v, rng.normal(size=(6, n)), tolerance=1e-11)
    check_inertia(family, x, v, a)


def test_derivatives_of_curved_tubes():
    rng = np.random.default_rng(2)
    n = 3
    x0 = np.tile(X0, n)
    frames = [(1.0, 0.2, 0.1, 0.9, -0.3, 0.2, 0.1, 1.0, 0.1)] * n
    tube = SpatialAngleTube(group("TUBE", x0, directions=frames, geometry=[(0.0, 1, 0)] * n, estiff=ELASTIC * n))
    close(evaluate(tube, x0)[1], np.zeros((6, n)), "e at the start", 1e-15)
    x = x0 + 0.1 * rng.normal(size=x0.shape)
    check_strain(tube, x, rng.normal(size=x.shape), rng.normal(size=(6, n)), tolerance=1e-11)


@pytest.mark.parametrize("shear", [(0.0, 0.0), (0.1, 0.0), (0.05, 0.2)])
def test_small_deformations_are_those_of_the_sine_measure(shear):
    """To second order in the rotations: a difference of third order, 1e-15 at 1e-5."""
    x = X0 + 1e-5 * np.random.default_rng(1).normal(size=X0.shape)
    for row in (3, 10):
        x[row : row + 4] /= np.linalg.norm(x[row : row + 4])
    values = {"geometry": [(0.0, 1, 0, 0.03)], "estiff": [(1.0, 0.4, 0.7, 1.3, *shear)]}
    sine, angle = (evaluate(k(group("BEAM", X0, **values)), x) for k in (SpatialBeam, SpatialAngleBeam))
    close(angle[1], sine[1], "e", 3e-15)


def test_rotation_factor():
    """2 acos(c)/sqrt(1 - c^2) and its derivatives, on both sides of the switch between series and closed form."""
    import mpmath

    with mpmath.workdps(40):
        for c in (-0.99, -0.5, 0.3, 0.7999, 0.8001, 0.9, 0.999999, 1.0 - 1e-15, 1.00001, 1.1, 1.3):
            truth = [mpmath.diff(lambda z: 2 * mpmath.acos(z) / mpmath.sqrt(1 - z * z), c, k) for k in range(4)]
            got = rotation_factor(np.array([c]))[:, 0]
            np.testing.assert_allclose(got, [float(mpmath.re(t)) for t in truth], rtol=3e-13)


@pytest.mark.parametrize(
    ("axis", "degrees", "fatal"),
    [((0, 0, 1), 80, []), ((0, 0, 1), 100, [False, False]), ((1, 0, 0), 120, [False]), ((1, 0, 0), 352, [True])],
)
def test_range(axis, degrees, fatal):
    """Rotation of the ends to each other: warned beyond 90 degrees, refused beyond 350; the chord beyond 45 and 85."""
    x = X0.copy()
    half = np.radians(degrees) / 2
    x[10, 0], x[11:14, 0] = np.cos(half), np.sin(half) * np.array(axis)
    family = beam()
    c, e, _ = evaluate(family, x)
    assert [t.fatal for t in family.troubles(c, e, e)] == fatal


# -- whole program -------------------------------------------------------------------------------------------------
def cantilever(n, EIz, EIy, GIt, F=(0, 0, 0), M=(0, 0, 0), modes=(2, 3, 4, 5, 6), em=(), steps=8) -> spacar.Deck:
    """Section 4.2: clamped at 0, L = 1 along x, dead force F and global moment M at the end."""
    rows: list[tuple] = [("FIX", 1), ("FIX", 2)]
    dynamics: list[tuple] = []
    for k in range(1, n + 1):
        p = 2 * k - 1
        rows += [("BEAM", k, p, p + 1, p + 2, p + 3, 0.0, 1.0, 0.0), ("DYNE", k, *modes), ("X", p + 2, k / n, 0.0, 0.0)]
        dynamics.append(("ESTIFF", k, 0.0, GIt, EIy, EIz))
        dynamics += [("EM", k, *em)] if em else []
    tip = 2 * n + 1
    dynamics += [("XF", tip, *map(float, F)), ("XF", tip + 1, *map(float, M)), ("ITERSTEP", 50, steps, 1e-12)]
    return spacar.Deck.build(rows, dynamics)


def tip(result, n) -> np.ndarray:
    return np.array([result.node(2 * n + 1, k)[-1] for k in (1, 2, 3)])


DIGITS = {
    1: ((0.820135131021, 0.423877277433, 0.292638436176), (0.969271380762, 0.030184840936, 0.22285603039)),
    2: ((0.816262866607, 0.429707690104, 0.297196541809), (0.964439157347, 0.038750651981, 0.243615129797)),
    4: ((0.815991374572, 0.430275182785, 0.297556975533), (0.963710633507, 0.040226181401, 0.246330153192)),
    8: ((0.815975129025, 0.43031344371, 0.297580396468), (0.963657786797, 0.040341694931, 0.246527545892)),
}
LOADS = (1, 1, 0.7, (0, 2.0, 1.0), (0.5, 0, 0)), (1, 0.1, 0.05, (0, 0.2, 0.1), (0.05, 0, 0))


@pytest.mark.parametrize("case", [0, 1])
@pytest.mark.parametrize("n", DIGITS)
def test_cantilever_digits(n, case):
    """Tables 4.2, rows 2a+2b: the eliminated twist gradient gives the digits of the coordinate."""
    result = spacar.run(8, cantilever(n, *LOADS[case]), beams="angle")
    np.testing.assert_allclose(tip(result, n), DIGITS[n][case], rtol=0, atol=2e-11)


def lateral(n, EIy=0.0, beams="angle", change=lambda deck: deck):
    """First load multiplier of the narrow cantilever of lateral4; EIy = 0: rigid in the plane of the load."""
    modes = (2, 3, 4, 5, 6) if EIy else (2, 5, 6)
    deck = change(cantilever(n, 1.0, EIy, 2.0, (0, 0, -1), modes=modes, steps=2))
    result = spacar.run(8, deck, beams=beams)
    multipliers = result.frames[-1].matrices["lmult"]
    assert len(multipliers) == result.mechanism.numbering.nddof
    assert multipliers[0] * multipliers[1] < 0  # symmetric: the same load upwards
    return abs(multipliers[0])


def test_lateral_buckling():
    """Table 3.5, exact 5.6746723; the twist gradient is a row of its own in the eigenvalue problem (section 2.6)."""
    got = [lateral(n) for n in (1, 2, 4, 8, 16)]
    np.testing.assert_allclose(got, (6.41426981, 5.71603660, 5.67830355, 5.67492315, 5.67468848), rtol=0, atol=1e-8)


def test_lateral_buckling_in_the_sine_measure():
    """theory-spatial.md section 14, six digits; published (bibliography.md) are 5.7619 with four elements, and 6.1694
    with GIt = 2.39034 in the first of them. 5.93576: without the bending-torsion terms."""
    got = [lateral(n, beams="sine") for n in (2, 4, 8, 16, 32)]
    np.testing.assert_allclose(got, (6.06701, 5.76187, 5.69659, 5.68017, 5.67605), rtol=0, atol=6e-6)
    assert got[1] == pytest.approx(5.76187499, abs=1e-8)
    stiffened = lateral(4, beams="sine", change=lambda deck: deck.set("ESTIFF", 1, 3, 2.39034))
    assert stiffened == pytest.approx(6.1694, abs=6e-5)
    assert lateral(4, beams="sine", change=linear_strain) == pytest.approx(5.93576, abs=6e-6)


def test_pure_bending_obeys_the_sine_law():
    """One element of the sine measure bent to a circle arc by theta: M l0/EI = sin theta, and the chord has half."""
    theta = 0.6
    deck = linear_strain(cantilever(1, 1, 1, 1, M=(0, 0, np.sin(theta))))
    result = spacar.run(8, deck, beams="sine")
    assert 2 * np.arctan2(result.node(4, 4)[-1], result.node(4, 1)[-1]) == pytest.approx(theta, rel=1e-12)
    np.testing.assert_allclose(tip(result, 1), (np.cos(theta / 2), np.sin(theta / 2), 0.0), atol=1e-12)


def test_lateral_buckling_of_a_beam_flexible_in_the_plane_of_the_load():
    """There the twist gradient is eliminated; EIy = 1e7 EIz gives the multipliers of the rigid plane."""
    for n in (2, 4):
        assert lateral(n, 1e7) == pytest.approx(lateral(n), rel=1e-6)


def test_frequencies_about_a_bent_state():
    """Table 3.8, modes 1, 2, 4 [rad/s]; torsional inertia 1e-9 changes the sixth digit of the last."""
    table = {
        2: (1.179578, 2.607954, 17.877035),
        4: (1.175034, 2.576394, 16.746099),
        8: (1.174567, 2.573621, 16.681577),
    }
    for n, truth in table.items():
        result = spacar.run(7, cantilever(n, 1, 0.1, 0.05, (0, 0.2, 0.1), em=(1.0, 1e-9)), beams="angle")
        omega = np.sort(np.abs(result.frames[-1].matrices["eigval"][:, 1]))[::2]
        np.testing.assert_allclose(omega[[0, 1, 3]], truth, rtol=5e-7)


@pytest.mark.parametrize("n", [3, *(pytest.param(n, marks=pytest.mark.slow) for n in (4, 8))])
def test_full_circle_and_twist_are_exact(n):
    """M_z = 2 pi EI/L rolls up to a circle; torsion by pi GIt/L turns the end by 180 degrees."""
    result = spacar.run(8, cantilever(n, 1, 1, 1, M=(0, 0, 2 * np.pi), steps=24), beams="angle")
    np.testing.assert_allclose(tip(result, n), 0.0, atol=1e-9)
    result = spacar.run(8, cantilever(n, 1, 1, 1, M=(np.pi, 0, 0), steps=24), beams="angle")
    turned = [result.node(2 * n + 2, k)[-1] for k in (1, 2, 3, 4)]
    np.testing.assert_allclose(np.abs(turned), (0, 1, 0, 0), atol=1e-9)


# Kirchhoff rod by shooting (scipy DOP853 and fsolve, 1e-12): radius 100, inextensible, P = 600 along z.
BEND = np.array((46.89532848, 15.55940126, 53.59978863))


def bend(n, beams):
    """45 degree arc of TUBEs whose frames follow the arc."""
    a = np.linspace(0, np.pi / 4, n + 1)
    points, tangents = 100 * np.stack((np.sin(a), 1 - np.cos(a), 0 * a), 1), np.stack((np.cos(a), np.sin(a), 0 * a), 1)
    rows: list[tuple] = [("FIX", 1), ("FIX", 2)]
    dynamics: list[tuple] = [("XF", 2 * n + 1, 0.0, 0.0, 600.0), ("ITERSTEP", 60, 12, 1e-10)]
    for k in range(1, n + 1):
        p = 2 * k - 1
        rows += [("TUBE", k, p, p + 1, p + 2, p + 3, 0.0, 0.0, 1.0), ("DYNE", k, 2, 3, 4, 5, 6)]
        rows += [("ORTUBE", k, *map(float, (*tangents[k - 1], *tangents[k])), 0.0, 0.0, 1.0)]
        rows += [("X", p + 2, *map(float, points[k]))]
        dynamics.append(("ESTIFF", k, 0.0, 704000.0, 1e7 / 12, 1e7 / 12))
    return tip(spacar.run(8, spacar.Deck.build(rows, dynamics), beams=beams), n)


def test_curved_tubes_are_of_fourth_order():
    """Table 3 of the theory, arc length and e - e0: with the sine measure order 2."""
    errors = {b: [np.linalg.norm(bend(n, b) - BEND) for n in (2, 4, 8)] for b in ("sine", "angle")}
    orders = {b: np.log2(np.divide(v[:-1], v[1:])) for b, v in errors.items()}
    np.testing.assert_allclose(orders["angle"], 4.0, atol=0.35)
    np.testing.assert_allclose(orders["sine"], 2.0, atol=0.15)
    assert errors["angle"][2] < 1e-3 < 0.3 < errors["sine"][2]


def test_multipliers_do_not_depend_on_the_axes_of_a_round_section():
    """A force between the axes of the section couples both planes with the twist gradient; what the measure neglects
    are 2e-6 of a multiplier here, with a wrong coupling they are 0.2 of it."""
    dynamics = [("ESTIFF", 1, 1e3, 1.0, 2.0, 2.0), ("EM", 1, 1.0, 0.1), ("XF", 3, 0.0, 0.03, 0.02)]
    found = []
    for angle in (0.0, 0.5):
        beam = ("BEAM", 1, 1, 2, 3, 4, 0.0, float(np.cos(angle)), float(np.sin(angle)))
        rows = [beam, ("X", 3, 2.0, 0.0, 0.0), ("ADEFORM",), ("FIX", 1), ("FIX", 2), ("DYNE", 1, 1, 2, 3, 4, 5, 6)]
        found.append(spacar.run(8, spacar.Deck.build(rows, dynamics))["lmult"][-1][:2])
    np.testing.assert_allclose(*found, rtol=1e-5)
