"""BEAMW in the angle measure (theory-beam-order4.md section 2.8): derivatives, limits, order 4."""

import numpy as np
import pytest

from spacar.elements.spatial.beam_angle import SpatialAngleBeam
from spacar.elements.spatial.beam_warping import BeamWithWarping
from spacar.elements.spatial.beam_warping_angle import AngleBeamWithWarping

from .derivatives import check_gravity, check_inertia, check_strain, close, evaluate, group
from .spatial_truth import G, moved, reference
from .test_beam_warping import BEAM, with_rates

N = 4
ESTIFF = [(1.0, 0.4, 0.7, 1.3, 0.1, 0.2, 0.05)] * N


def beams(seed, **values):
    """Start and moved coordinates, statement values."""
    rng = np.random.default_rng(seed)
    x0 = reference(rng, N, "xlxl")
    geometry = [(*rng.normal(size=3), rng.uniform(-0.05, 0.05)) for _ in range(N)]
    x = with_rates(moved(rng, x0, "xlxl"), 0.3 * rng.normal(size=(2, N)))
    return with_rates(x0, 0.0), x, {"geometry": geometry, "estiff": ESTIFF} | values


@pytest.mark.parametrize("linear", [(), (0, 3), range(N)])
@pytest.mark.parametrize("spread", [0.0, 0.1])
def test_derivatives(linear, spread):
    """Also off the unit sphere."""
    nonlinear = np.ones(N, bool)
    nonlinear[list(linear)] = False
    em = [(1.0, 0.1, 0.2, 0.3, 0.01, 0.02)] * N
    start, x, values = beams(3, nonlinear=nonlinear, em=em)
    family = AngleBeamWithWarping(group("BEAMW", start, **values))
    rng = np.random.default_rng(4)
    x = x + spread * rng.normal(size=x.shape)
    v, a = rng.normal(size=(2, *x.shape))
    check_strain(family, x, v, rng.normal(size=(8, N)), tolerance=1e-11)
    check_inertia(family, x, v, a)
    check_gravity(family, x, G)


def test_small_deformations_are_those_of_the_sine_measure():
    """To second order in rotations and twist rates: the difference falls with the third power of their size."""
    start, _, values = beams(5)
    values["estiff"] = [(1.0, 0.4, 0.7, 1.3, 0.0, 0.0, 0.05)] * N
    step = np.random.default_rng(1).normal(size=start.shape)
    differences = []
    for size in (2e-3, 1e-3):
        x = start + size * step
        for row in (3, 11):
            x[row : row + 4] /= np.linalg.norm(x[row : row + 4], axis=0)
        kinds = BeamWithWarping, AngleBeamWithWarping
        sine, angle = (evaluate(kind(group("BEAMW", start, **values)), x)[1] for kind in kinds)
        differences.append(np.abs(angle - sine).max(axis=1))
    np.testing.assert_allclose(np.log2(differences[0] / differences[1]), 3.0, atol=0.15)


def test_without_gradient_of_the_twist_it_is_the_angle_beam():
    """w_p = w_q = M_x/l0: e1 ... e6 are those of BEAM in the angle measure with A_x = 0 (GIt = 0)."""
    start, x, values = beams(7)
    six = [(*row[:1], 0.0, *row[2:6]) for row in ESTIFF]
    plain = SpatialAngleBeam(group("BEAM", start[BEAM], geometry=values["geometry"], estiff=six))
    e = evaluate(plain, x[BEAM])[1]
    x[[7, 15]] = e[1] / plain.length**2
    warped = evaluate(AngleBeamWithWarping(group("BEAMW", start, **values)), x)[1]
    close(warped[:6], e, "e", 1e-14)
    close(warped[6:], np.zeros((2, N)), "warping", 1e-14)
