"""PLBEAM and PLTUBE in the angle measure (theory-beam-order4.md section 1): derivatives, digits, order 4."""

from __future__ import annotations

import numpy as np
import pytest

import spacar
from spacar import Deck
from spacar.elements.plbeam import PlanarBeam
from spacar.elements.plbeam_angle import PlanarAngleBeam, PlanarAngleTube
from tests.elements.derivatives import check_inertia, check_strain, close, evaluate, group

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
def cantilever(nodes, load: float = 14.0, extra=(), EI: float = 102.0, EA: float = 0.0, **values) -> Deck:
    """Clamped at nodes[0], EA = 0: inextensible; dead force -load along y at the end."""
    rows: list[tuple] = [("FIX", 1), ("FIX", 2), ("X", 1, float(nodes[0]), 0.0), *extra]
    modes = (1, 2, 3) if EA else (2, 3)
    dynamics: list[tuple] = []
    for k, x in enumerate(nodes[1:], 1):
        p = 2 * k - 1
        rows += [("PLBEAM", k, p, p + 1, p + 2, p + 3), ("DYNE", k, *modes), ("X", p + 2, float(x), 0.0)]
        dynamics += [("ESTIFF", k, EA, EI), ("EM", k, 1.0), *((name, k, *v) for name, v in values.items())]
    dynamics += [("XF", 2 * len(nodes) - 1, 0.0, -load), ("ITERSTEP", 50, 10, 1e-12)]
    return Deck.build(rows, dynamics)


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
    nodes = np.linspace(0, 1, n + 1)
    rows = cantilever(nodes, 0.0, EI=1.0)
    deck = Deck.build(
        [(s.keyword, *s.values) for s in rows.statements if s.block == 1],
        [(s.keyword, *s.values) for s in rows.statements if s.block == 2 and s.keyword in ("ESTIFF", "EM")]
        + [("XF", 2 * n + 2, 2 * np.pi), ("ITERSTEP", 50, 20, 1e-13)],
    )
    result = spacar.run(7, deck, beams="angle")
    np.testing.assert_allclose(tip(result, n), 0.0, atol=1e-11)
    np.testing.assert_allclose(result.node(2 * n + 2, 1)[-1], 2 * np.pi, rtol=1e-12)
