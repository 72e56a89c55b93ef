"""PLBEAM and PLTUBE in the angle measure (theory-beam-order4.md section 1): derivatives, digits, order 4."""

import numpy as np
import pytest
from scipy.linalg import eigvalsh
from scipy.optimize import brentq

import spacar
from spacar.elements.planar.plbeam import PlanarBeam
from spacar.elements.planar.plbeam_angle import PlanarAngleBeam, PlanarAngleTube

from .derivatives import check_inertia, check_strain, close, evaluate, group, mass_of
from .rod import cantilever_tip

N = 6
EXACT = np.array((3.810897752359167, -8.404448390735478))  # elastica, P L^2/EI = 14 100/102


def random_state(seed: int, kind=PlanarAngleBeam, **values):
    rng = np.random.default_rng(seed)
    x0 = np.zeros((6, N))
    x0[[0, 1, 3, 4]] = rng.normal(size=(4, N))
    settings = {"em": rng.uniform(0.5, 2.0, (N, 2)), "estiff": rng.uniform(0.1, 2.0, (N, 3)), **values}
    x = x0 + 0.4 * rng.normal(size=x0.shape)
    x[2::3] += 1.0
    keyword = "PLBEAM" if kind is PlanarAngleBeam else "PLTUBE"
    return kind(group(keyword, x0, **settings)), x0, x, rng


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("nonlinear", [True, False])
def test_derivatives(seed, nonlinear):
    family, _, x, rng = random_state(seed, nonlinear=[nonlinear] * N)
    v, a = rng.normal(size=(2, 6, N))
    check_strain(family, x, v, rng.normal(size=(3, N)))
    check_inertia(family, x, v, a)


@pytest.mark.parametrize("seed", range(2))
def test_derivatives_of_curved_tubes(seed):
    geometry = np.random.default_rng(seed).uniform(-0.4, 0.4, (N, 2))
    em = [(0.7, 0.5, 0.3, 1.1, 2, 0.1)] * N
    family, x0, x, rng = random_state(seed, PlanarAngleTube, geometry=geometry, em=em)
    v, a = rng.normal(size=(2, 6, N))
    check_strain(family, x, v, rng.normal(size=(3, N)))
    check_inertia(family, x, v, a, lagrange=False)
    close(evaluate(family, x0)[1], np.zeros((3, N)), "e at the start", 1e-15)


def test_bending_is_the_angle_between_end_and_chord():
    """Turned by 0.7 rad, stretched to 2.2, ends at +1.9 and -1.3 rad: angles the sine cannot tell apart."""
    x0 = np.array([[0.0, 0, 0, 2, 0, 0]]).T
    family = PlanarAngleBeam(group("PLBEAM", x0))
    x = np.array([[1.0, 2, 0.7 + 1.9, 1 + 2.2 * np.cos(0.7), 2 + 2.2 * np.sin(0.7), 0.7 - 1.3]]).T
    e2, e3 = 2 * 1.9, 2 * 1.3
    e1 = 0.2 + (2 * e2**2 + e2 * e3 + 2 * e3**2) / 60
    close(evaluate(family, x)[1][:, 0], (e1, e2, e3), "e", 1e-15)


def test_small_deformations_are_those_of_the_sine_measure():
    rng = np.random.default_rng(1)
    x0 = np.array([[0.0, 0, 0, 2, 0, 0]]).T
    values = {"estiff": [(1.0, 1.0, 0.02)]}
    x = x0 + 1e-5 * rng.normal(size=x0.shape)
    sine, angle = (evaluate(k(group("PLBEAM", x0, **values)), x) for k in (PlanarBeam, PlanarAngleBeam))
    close(angle[1], sine[1], "e", 1e-14)
    close(angle[2], sine[2], "V", 1e-8)


def test_range():
    """Warned beyond 60 degrees, refused beyond 170: the angle jumps at 180."""
    x0 = np.array([[0.0, 0, 0, 1, 0, 0]]).T
    family = PlanarAngleBeam(group("PLBEAM", x0))
    found = []
    for degrees in (59, 61, 169, 171):
        x = x0.copy()
        x[5] = np.radians(degrees)
        c, e, _ = evaluate(family, x)
        found.append([t.fatal for t in family.troubles(c, e, e)])
    assert found == [[], [False], [False], [True]]


# -- whole program -------------------------------------------------------------------------------------------------
def row(nodes, dynamics, *, modes=(2, 3), clamp=("FIX", 2), **values) -> spacar.Deck:
    """Beams between these places along x, held at the first one; values: ESTIFF=..., EM=... of each."""
    rows: list[tuple] = [("FIX", 1), clamp, ("X", 1, float(nodes[0]), 0.0)]
    laws: list[tuple] = []
    for k, x in enumerate(nodes[1:], 1):
        p = 2 * k - 1
        rows += [("PLBEAM", k, p, p + 1, p + 2, p + 3), ("DYNE", k, *modes), ("X", p + 2, float(x), 0.0)]
        laws += [(name, k, *value) for name, value in values.items()]
    return spacar.Deck.build(rows, [*laws, *dynamics])


def unit_row(n: int, dynamics, **values) -> spacar.Deck:
    """n equal inextensible beams on 1 m, EI = m = 1."""
    return row(np.linspace(0, 1, n + 1), dynamics, **{"ESTIFF": (0.0, 1.0), "EM": (1.0,)} | values)


def cantilever(nodes) -> spacar.Deck:
    """Inextensible, EI = 102: 14 N down at the end."""
    load = [("XF", 2 * len(nodes) - 1, 0.0, -14.0), ("ITERSTEP", 50, 10, 1e-12)]
    return row(nodes, load, ESTIFF=(0.0, 102.0), EM=(1.0,))


def tip(result, n: int) -> np.ndarray:
    return np.array([result.node(2 * n + 1, k)[-1] for k in (1, 2)])


@pytest.mark.parametrize(
    ("nodes", "position", "compliance"),
    [
        ((0, 1.666, 3.333, 5, 6.666, 10), (3.811730467057, -8.402940532932), (0.464292477322, 0.060048616681)),
        ((0, 2, 4, 6, 8, 10), (3.812602281681, -8.401409989021), (0.464167558889, 0.059895872492)),
    ],
)
def test_single_digits_of_the_theory(nodes, position, compliance):
    """Table of theory-beam-order4.md section 1: plbeam5 and five equal elements, all printed digits."""
    result = spacar.run(8, cantilever(nodes), beams="angle")
    np.testing.assert_allclose(tip(result, 5), position, rtol=0, atol=1e-11)
    n = result.mechanism.numbering
    got = [result.frames[-1].xcompl[n.x_index(11, k)] for k in (1, 2)]
    np.testing.assert_allclose(got, compliance, rtol=0, atol=1e-10)


TABLE = {5: (2.3e-2, 3.5e-4), 10: (5.4e-3, 2.2e-5), 20: (1.3e-3, 1.4e-6), 40: (3.3e-4, 8.8e-8), 80: (8.1e-5, 5.5e-9)}


@pytest.mark.parametrize("n", [5, 10, 20, *(pytest.param(n, marks=pytest.mark.slow) for n in (40, 80))])
def test_cantilever_converges_with_order_four(n):
    """Errors relative to the length: the table of the theory, both measures."""
    deck = cantilever(np.linspace(0, 10, n + 1))
    errors = [np.linalg.norm(tip(spacar.run(7, deck, beams=b), n) - EXACT) / 10 for b in ("sine", "angle")]
    np.testing.assert_allclose(errors, TABLE[n], rtol=0.03)


@pytest.mark.parametrize("n", [3, 4, 8])
def test_full_circle_by_a_moment_is_exact(n):
    """M = 2 pi EI/L: the end is back at the clamp for any number of elements."""
    deck = unit_row(n, [("XF", 2 * n + 2, 2 * np.pi), ("ITERSTEP", 50, 20, 1e-13)])
    result = spacar.run(7, deck, beams="angle")
    np.testing.assert_allclose(tip(result, n), 0.0, atol=1e-11)
    np.testing.assert_allclose(result.node(2 * n + 2, 1)[-1], 2 * np.pi, rtol=1e-12)


def errors_of(beams, counts, force, *, EA: float = 0.0, shear: float = 0.0, q=(0.0, 0.0), truth) -> np.ndarray:
    """Errors of the tip of cantilevers of length 1 and EI = 1 under a dead force and gravity q per length."""
    found = []
    for n in counts:
        loads = [("XF", 2 * n + 1, *force), ("ITERSTEP", 60, 10, 1e-12), ("GRAVITY", *q)]
        deck = unit_row(n, loads, modes=(1, 2, 3) if EA else (2, 3), ESTIFF=(EA, 1.0, shear))
        found.append(np.linalg.norm(tip(spacar.run(8, deck, beams=beams), n) - truth))
    return np.array(found)


def orders(errors) -> np.ndarray:
    return np.log2(errors[:-1] / errors[1:])


@pytest.mark.parametrize(
    ("force", "q"), [((0.0, -5.0), (0.0, 0.0)), ((0.0, 0.0), (0.0, -10.0)), ((2.0, -3.0), (0.0, -5.0))]
)
def test_gravity_is_a_load_of_fourth_order(force, q):
    """Table 3.9 of the theory, against a rod by shooting."""
    truth = cantilever_tip(force, q=q)[:2]
    angle = errors_of("angle", (4, 8, 16), force, q=q, truth=truth)
    np.testing.assert_allclose(orders(angle), 4.0, atol=0.1)
    sine = errors_of("sine", (8, 16), force, q=q, truth=truth)
    np.testing.assert_allclose(orders(sine), 2.0, atol=0.1)


@pytest.mark.parametrize("EA", [1e4, 1e2])
def test_what_finite_extension_leaves(EA):
    """Section 2.7: order 4 down to about 0.9 n^-2 EI/(EA L^2) of the length, with order 2 there."""
    force = (0.0, -5.0)
    error = errors_of("angle", (16,), force, EA=EA, truth=cantilever_tip(force, EA=EA)[:2])[0]
    fourth = errors_of("angle", (16,), force, truth=cantilever_tip(force)[:2])[0]
    assert abs(error - fourth) < 0.95 / 16**2 / EA


def test_shear_flexible_beams_tend_to_engesser():
    """Section 2.7: the rod whose line is inextensible; the sine measure tends to something else."""
    force, shear = (0.0, -5.0), 0.01
    truth = cantilever_tip(force, GAk=1 / shear, line=True)[:2]
    angle = errors_of("angle", (2, 4, 8, 16), force, shear=shear, truth=truth)
    np.testing.assert_allclose(angle, (3.25e-3, 3.91e-4, 6.85e-5, 1.54e-5), rtol=0.02)
    assert errors_of("sine", (16,), force, shear=shear, truth=truth)[0] > 2e-3


def bent_tube(n, beams) -> np.ndarray:
    """Quarter of a circle of radius 1 of PLTUBEs without fluid, EI = 1, dead force at the free end."""
    angles, half = np.linspace(0, np.pi / 2, n + 1), np.pi / 4 / n
    rows: list[tuple] = [("FIX", 1), ("FIX", 2)]
    dynamics: list[tuple] = [("XF", 2 * n + 1, 0.4, -0.7), ("ITERSTEP", 60, 10, 1e-12)]
    for k in range(1, n + 1):
        p = 2 * k - 1
        rows += [("PLTUBE", k, p, p + 1, p + 2, p + 3, -half, half), ("DYNE", k, 2, 3)]
        rows.append(("X", p + 2, float(np.sin(angles[k])), float(1 - np.cos(angles[k]))))
        dynamics.append(("ESTIFF", k, 0.0, 1.0))
    return tip(spacar.run(8, spacar.Deck.build(rows, dynamics), beams=beams), n)


def test_curved_tubes_are_of_fourth_order():
    """Section 1.2, against the rod by shooting."""
    truth = cantilever_tip((0.4, -0.7), L=np.pi / 2, kappa0=1.0)[:2]
    errors = {b: np.array([np.linalg.norm(bent_tube(n, b) - truth) for n in (2, 4, 8)]) for b in ("sine", "angle")}
    np.testing.assert_allclose(orders(errors["angle"]), 4.0, atol=0.35)
    np.testing.assert_allclose(orders(errors["sine"]), 2.0, atol=0.35)


def swung(n, beams) -> np.ndarray:
    """Cantilever (all unity) whose clamp turns with 8 rad/s^2: position of the end after 0.8 s."""
    turn = [("INPUTX", 2, 1, 0.0, 0.0, 8.0), ("TIMESTEP", 0.8, 4), ("ERROR", 1e-8, 1e-8), ("INTEGRAT", 595)]
    return tip(spacar.run(1, unit_row(n, turn, clamp=("INPUTX", 2, 1)), beams=beams), n)


@pytest.mark.slow
def test_time_integration_is_of_fourth_order():
    """n = 2, 4 against n = 8; both measures go to the same motion, the sine slowly."""
    fine = swung(8, "angle")
    angle = [np.linalg.norm(swung(n, "angle") - fine) for n in (2, 4)]
    assert np.log2(angle[0] / angle[1]) == pytest.approx(3.8, abs=0.2)
    sine = np.linalg.norm(swung(4, "sine") - fine)
    assert 0.06 < sine < 0.08
    assert sine > 30 * angle[1]


def test_start_values_are_angles():
    """STARTDE e2 = 0.3, e3 = 0 on a beam of 1 m: the tangent at p is 0.3 rad from the chord, asin 0.3 with sines."""
    rows = [("PLBEAM", 1, 1, 2, 3, 4), ("X", 3, 1.0, 0.0), ("FIX", 1), ("FIX", 2), ("DYNE", 1, 2, 3)]
    deck = spacar.Deck.build(
        rows, [("ESTIFF", 1, 0.0, 1.0), ("EM", 1, 1.0), ("STARTDE", 1, 2, 0.3, 0.0), ("TIMESTEP", 0.001, 1)]
    )
    for beams, angle in (("angle", 0.3), ("sine", np.arcsin(0.3))):
        result = spacar.run(1, deck, beams=beams)
        chord = np.arctan2(result.node(3, 2)[0], result.node(3, 1)[0])
        assert -chord == pytest.approx(angle, rel=1e-12)


# Rotary inertia of planar beams: consistent in the angle measure (theory-beam-order4.md section 1.3, table 3.13).
J = 1e-2  # rotary inertia per length; EI = L = m = 1


def rayleigh():
    """The two lowest frequencies [rad/s] of the cantilever EI w'''' + w2 J w'' = w2 m w: with w'''' = ... the roots
    +-i a, +-c, w''(L) = 0 and EI w'''(L) + w2 J w'(L) = 0."""

    def determinant(omega):
        b = J * omega**2
        a, c = (np.sqrt((s * b + np.sqrt(b * b + 4.0 * omega**2)) / 2.0) for s in (1.0, -1.0))
        C, S, Ch, Sh = np.cos(a), np.sin(a), np.cosh(c), np.sinh(c)
        even = -a * a * C - c * c * Ch, a**3 * S - c**3 * Sh + b * (-a * S - c * Sh)  # cos ax - cosh cx
        odd = -a * S - c * Sh, -a * a * C - c * c * Ch + b * (C - Ch)  # sin ax/a - sinh cx/c
        return even[0] * odd[1] - odd[0] * even[1]

    return np.array([brentq(determinant, *pair, xtol=1e-13) for pair in ((2.0, 4.0), (10.0, 25.0))])


def frequencies(n, beams, force=0.0):
    deck = unit_row(n, [("XF", 2 * n + 1, 0.0, force), ("ITERSTEP", 50, 4, 1e-12)], EM=(1.0, J))
    return 2.0 * np.pi * spacar.run(7, deck, beams=beams).frequencies[-1][:2]


def orders_to(found, truth):
    return orders(np.abs(np.array(found) / truth - 1.0))


def test_lumped_inertia_limits_frequencies_to_order_two():
    """The sine measure, straight: 36 parts in a million with 32 beams, second frequency."""
    found = [frequencies(n, "sine") for n in (16, 32)]
    assert orders_to(found, rayleigh())[0, 1] == pytest.approx(1.95, abs=0.05)
    assert abs(found[1][1] / rayleigh()[1] - 1.0) == pytest.approx(3.6e-5, rel=0.02)


def test_consistent_inertia_is_of_order_four():
    found = [frequencies(n, "angle") for n in (4, 8, 16)]
    np.testing.assert_allclose(orders_to(found, rayleigh()), 3.97, atol=0.15)


def test_consistent_inertia_is_of_order_four_about_a_bent_state():
    """The tip turns by 45 degrees; the truth from 16 and 32 beams, extrapolated."""
    found = [frequencies(n, "angle", 2.0) for n in (4, 8, 16, 32)]
    truth = found[3] + (found[3] - found[2]) / 15.0
    np.testing.assert_allclose(orders_to(found[:3], truth), 3.97, atol=0.15)


def test_a_rigid_turn_has_all_of_the_inertia():
    """All angles turn at 1 rad/s about node p: the rotary part of 2 T is J l0."""
    x0 = np.array([[0.0, 0.0, 0.0, 1.5, 0.8, 0.0]]).T
    beam = PlanarAngleBeam(group("PLBEAM", x0, em=[(0.0, 0.7)]))
    v = np.array([0.0, 0.0, 1.0, -0.8, 1.5, 1.0])
    assert v @ mass_of(beam, x0)[:, :, 0] @ v == pytest.approx(0.7 * 1.7, rel=1e-14)


@pytest.mark.parametrize(("kind", "size"), [(PlanarBeam, "lumped"), (PlanarAngleBeam, "consistent")])
def test_dispersion_of_waves(kind, size):
    """An endless row of beams, wave number k: the closed forms of section 1.3 for the error of omega^2."""
    h, k, r = 0.25, 1.0, 0.7  # next terms: a hundredth of the first ones
    x0 = np.array([[0.0, 0.0, 0.0, h, 0.0, 0.0]]).T
    beam = kind(group("PLBEAM", x0, em=[(1.0, r * r)], estiff=[(1.0, 1.0)]))
    V, M = evaluate(beam, x0)[2], mass_of(beam, x0)
    K = np.einsum("ai,ab,bj->ij", V[:, :, 0], beam.stiffness()[0][:, :, 0], V[:, :, 0])
    z = np.exp(1j * k * h)
    P = np.zeros((6, 2), complex)  # transverse displacement and angle of p, and of q a phase later
    P[[1, 2], [0, 1]], P[[4, 5], [0, 1]] = 1.0, z
    found = eigvalsh(P.conj().T @ K @ P, P.conj().T @ M[:, :, 0] @ P)[0] * (1.0 + (r * k) ** 2) / k**4 - 1.0
    square = (r * k) ** 2
    exact = {"lumped": -(square**2) * (k * h) ** 2 / (12.0 * (1.0 + square) ** 2), "consistent": (k * h) ** 4 / 720.0}
    assert found == pytest.approx(exact[size], rel=0.05)
