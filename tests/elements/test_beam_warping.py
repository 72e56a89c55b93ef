"""BEAMW: deformations, derivatives, stiffness and inertia against theory-warping.md and against BEAM.

Tolerances: 1e-12 relative (see `derivatives`); printed digits have half a unit of their last place, 5e-11.
"""

from typing import Any

import numpy as np
import pytest

from spacar.elements.spatial.beam import SpatialBeam
from spacar.elements.spatial.beam_angle import SpatialAngleBeam
from spacar.elements.spatial.beam_warping import BeamWithWarping
from spacar.elements.spatial.beam_warping_angle import AngleBeamWithWarping

from .derivatives import check_gravity, check_inertia, check_stiffness, check_strain, close, evaluate, group, mass_of
from .spatial_truth import G, moved, reference, turn

N = 5
BEAM = [*range(7), *range(8, 15)]  # coordinates that a BEAM has too
DIGITS = 5e-11


def with_rates(x: Any, w: Any) -> Any:
    """Coordinates (16, n) from those of a BEAM (14, n) and twist rates (2, n)."""
    out = np.zeros((16, x.shape[1]))
    out[BEAM], out[[7, 15]] = x, w
    return out


SINE: Any = BeamWithWarping, SpatialBeam
ANGLE: Any = AngleBeamWithWarping, SpatialAngleBeam
ESTIFF = [(1.0, 0.4, 0.7, 1.3, 0.1, 0.2, 0.05)] * N


def random_beams(seed: int, kinds: Any = SINE, **kwargs: Any) -> tuple[Any, Any, Any, Any]:
    """The same beams with and without warping, start and moved configuration."""
    rng = np.random.default_rng(seed)
    x0 = reference(rng, N, "xlxl")
    geometry = [(*rng.normal(size=3), rng.uniform(-0.05, 0.05)) for _ in range(N)]
    x = with_rates(moved(rng, x0, "xlxl"), 0.3 * rng.normal(size=(2, N)))
    start = with_rates(x0, 0.0)
    warped = kinds[0](group("BEAMW", start, geometry=geometry, **kwargs))
    return warped, kinds[1](group("BEAM", x0, geometry=geometry, **kwargs)), start, x


def test_the_printed_element() -> None:
    """Table E1 of theory-warping.md section 10: raw and corrected deformations, stresses, nodal forces."""
    x0 = with_rates(np.array([[0.0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 1, 0, 0, 0]]).T, 0.0)
    beam = BeamWithWarping(group("BEAMW", x0, geometry=[(0.0, 1, 0, 0.03)], estiff=[[3.0, 1, 2, 4, 0, 0, 0.05]]))
    p, q = np.array((0.1, -0.05, 0.08)), np.array((0.25, 0.06, -0.07))
    lam_p, lam_q = (turn(r, float(np.linalg.norm(r))) for r in (p, q))
    x = np.concatenate(([0.01, -0.02, 0.03], lam_p, [0.04, 2.02, 0.05, -0.04], lam_q, [-0.03]))[:, None]
    c, e, V = evaluate(beam, x)
    raw = [0.0124363344, 0.2984290274, 0.1677939473, 0.0164520309, -0.1020875394, -0.2032704045, 0.1384290274,
           -0.4184290274]  # fmt: skip
    full = [0.0157087148, 0.3146430255, 0.1587770580, 0.0204977985, -0.1067930885, -0.1986074926, 0.1546430255,
            -0.4346430255]  # fmt: skip
    stress = [0.0235630723, 0.0393303782, 0.1485281587, -0.0588907304, -0.0149786844, -0.2904218968, 0.0030911495,
              -0.0097994829]  # fmt: skip
    force = [-0.0084834416, -0.2990030019, 0.1348179296, 0.0698089652, -0.1667244575, -0.5801216406, 0.0144823807,
             -0.0101299790, 0.0084834416, 0.2990030019, -0.1348179296, 0.0819475425, 0.1742484466, -0.0952021297,
             -1.1755141877, -0.0397261412]  # fmt: skip
    sigma = np.einsum("ij,j->i", beam.stiffness()[0][:, :, 0], e[:, 0])
    np.testing.assert_allclose(c.strain.raw[:, 0], raw, rtol=0, atol=DIGITS)
    np.testing.assert_allclose(e[:, 0], full, rtol=0, atol=DIGITS)
    np.testing.assert_allclose(sigma, stress, rtol=0, atol=DIGITS)
    np.testing.assert_allclose(V[:, :, 0].T @ sigma, force, rtol=0, atol=DIGITS)


@pytest.mark.parametrize("linear", [(), (0, 3), range(N)])
@pytest.mark.parametrize(("kinds", "spread"), [(SINE, 0.1), (ANGLE, 0.0), (ANGLE, 0.1)])
def test_derivatives(linear: Any, kinds: Any, spread: float) -> None:
    """Also off the unit sphere."""
    nonlinear = np.ones(N, bool)
    nonlinear[list(linear)] = False
    em = [(1.0, 0.1, 0.2, 0.3, 0.01, 0.02)] * N
    beams, _, _, x = random_beams(3, kinds, nonlinear=nonlinear, em=em, estiff=ESTIFF)
    rng = np.random.default_rng(4)
    x = x + spread * rng.normal(size=x.shape)
    v, a = rng.normal(size=(2, *x.shape))
    check_strain(beams, x, v, rng.normal(size=(8, N)), tolerance=1e-12 if kinds is SINE else 1e-11)
    check_inertia(beams, x, v, a)
    check_gravity(beams, x, G)


@pytest.mark.parametrize("second", [True, False])
def test_without_warping_it_is_the_beam(second: bool) -> None:
    """With eb7 = eb8 = 0, that is w = eb2/l0^2 at both ends, e1 ... e6 are those of BEAM."""
    beams, plain, start, x = random_beams(5, nonlinear=np.full(N, second))
    x[[7, 15]] = evaluate(plain, x[BEAM])[0].strain.raw[1] / beams.length**2
    e = evaluate(beams, x)[1]
    truth = evaluate(plain, x[BEAM])[1]
    np.testing.assert_allclose(evaluate(beams, x)[0].strain.raw[6:], 0.0, atol=1e-14)
    close(e[:6], truth, "e1 ... e6")
    close(evaluate(beams, start)[1], np.zeros((8, N)), "undeformed")


def test_stiffness_is_that_of_a_cubic_twist() -> None:
    """ECw/l^3 [12 6l ...] + GIt/(30 l) [36 3l ...] in (theta_p, w_p, theta_q, w_q), theory-warping.md section 4."""
    l, GIt, ECw = 1.7, 2.3, 0.9
    x0 = with_rates(np.array([[0.0, 0, 0, 1, 0, 0, 0, l, 0, 0, 1, 0, 0, 0]]).T, 0.0)
    beam = BeamWithWarping(
        group("BEAMW", x0, geometry=[(0.0, 1, 0)], estiff=[[0, GIt, 0, 0, 0, 0, ECw]], edamp=[[0, 2, 0, 0, 0, 0, 3.0]])
    )
    check_stiffness(beam)
    V = evaluate(beam, x0)[2][:, :, 0]
    nodal = V[:, [4, 7, 12, 15]] / [2, 1, 2, 1]  # theta = 2 lambda1
    K = nodal.T @ beam.stiffness()[0][:, :, 0] @ nodal
    bend = np.array([[12, 6 * l, -12, 6 * l], [6 * l, 4 * l**2, -6 * l, 2 * l**2],
                     [-12, -6 * l, 12, -6 * l], [6 * l, 2 * l**2, -6 * l, 4 * l**2]])  # fmt: skip
    string = np.array([[36, 3 * l, -36, 3 * l], [3 * l, 4 * l**2, -3 * l, -(l**2)],
                       [-36, -3 * l, 36, -3 * l], [3 * l, -(l**2), -3 * l, 4 * l**2]])  # fmt: skip
    close(K, ECw / l**3 * bend + GIt / (30 * l) * string, "K")
    damping = nodal.T @ beam.stiffness()[1][:, :, 0] @ nodal
    close(damping, 3 / l**3 * bend + 2 / (30 * l) * string, "damping has the place of the stiffness")


def test_torsion_shortens_an_open_section() -> None:
    """e1 = 1/2 f1 times the integral of the square of the quadratic twist rate with ends w_p, w_q and mean eb2/l0^2."""
    f1, l, w = 0.02, 2.0, np.array([[0.03], [-0.01]])
    x0 = with_rates(np.array([[0.0, 0, 0, 1, 0, 0, 0, l, 0, 0, 1, 0, 0, 0]]).T, 0.0)
    beam = BeamWithWarping(group("BEAMW", x0, geometry=[(0.0, 1, 0, f1)]))
    x = x0.copy()
    x[11:15, 0] = turn((1, 0, 0), 0.05)
    x[[7, 15]] = w
    c, e, _ = evaluate(beam, x)
    mean = c.strain.raw[1, 0] / l**2
    xi = np.polynomial.legendre.leggauss(3)
    s = 0.5 * (xi[0] + 1)
    rate = (6 * mean - 3 * w.sum()) * 2 * s * (1 - s) / 2 + w[0] * (1 - s) + w[1] * s
    assert 0.5 * xi[1] @ rate == pytest.approx(mean, rel=1e-12)
    assert e[0, 0] == pytest.approx(0.5 * f1 * l * 0.5 * (xi[1] @ rate**2), rel=1e-12)


def test_inertia() -> None:
    """Centre line as BEAM, nothing on w; the warping inertia is half l0 Jw at each node."""
    rng = np.random.default_rng(1)
    em = np.zeros((N, 9))
    em[:, :6] = rng.uniform(0.5, 2.0, (N, 6))
    beams, plain, _, x = random_beams(7, em=em)
    M = mass_of(beams, x)
    close(M[np.ix_(BEAM, BEAM)], mass_of(plain, x[BEAM]), "M of BEAM", 0.0)
    close(M[[7, 15]], np.zeros((2, 16, N)), "no inertia of the centre line on w", 0.0)
    assert [row for row, _ in beams.orientation_inertia()] == [3, 11]
    for (row, J), place in zip(beams.lumped_inertia(), (7, 15), strict=True):
        assert row == place
        close(J, 0.5 * beams.length * em[:, 5], "warping inertia", 0.0)


# BEAMW in the angle measure (theory-beam-order4.md section 2.8): limits.
def test_small_deformations_are_those_of_the_sine_measure():
    """To second order in rotations and twist rates: the difference falls with the third power of their size."""
    flexible = [(1.0, 0.4, 0.7, 1.3, 0.0, 0.0, 0.05)] * N
    (sine, _, start, _), (angle, *_) = (random_beams(5, kinds, estiff=flexible) for kinds in (SINE, ANGLE))
    step = np.random.default_rng(1).normal(size=start.shape)
    differences = []
    for size in (2e-3, 1e-3):
        x = start + size * step
        for row in (3, 11):
            x[row : row + 4] /= np.linalg.norm(x[row : row + 4], axis=0)
        differences.append(np.abs(evaluate(angle, x)[1] - evaluate(sine, x)[1]).max(axis=1))
    np.testing.assert_allclose(np.log2(differences[0] / differences[1]), 3.0, atol=0.15)


def test_without_gradient_of_the_twist_it_is_the_angle_beam():
    """w_p = w_q = M_x/l0: e1 ... e6 are those of BEAM in the angle measure with A_x = 0 (GIt = 0)."""
    beams, _, _, x = random_beams(7, ANGLE, estiff=ESTIFF)
    _, plain, _, _ = random_beams(7, ANGLE, estiff=[(row[0], 0.0, *row[2:6]) for row in ESTIFF])
    e = evaluate(plain, x[BEAM])[1]
    x[[7, 15]] = e[1] / plain.length**2
    warped = evaluate(beams, x)[1]
    close(warped[:6], e, "e", 1e-14)
    close(warped[6:], np.zeros((2, N)), "warping", 1e-14)
