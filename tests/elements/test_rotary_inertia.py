"""Rotary inertia of planar beams: consistent in the angle measure (theory-beam-order4.md section 1.3, table 3.13)."""

import numpy as np
import pytest
from scipy.linalg import eigvalsh
from scipy.optimize import brentq

import spacar
from spacar.deck import Deck
from spacar.elements.planar.plbeam import PlanarBeam
from spacar.elements.planar.plbeam_angle import PlanarAngleBeam

from .derivatives import group

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
    rows, dynamics = [("FIX", 1), ("FIX", 2)], [("XF", 2 * n + 1, 0.0, force), ("ITERSTEP", 50, 4, 1e-12)]
    for k in range(1, n + 1):
        p = 2 * k - 1
        rows += [("PLBEAM", k, p, p + 1, p + 2, p + 3), ("DYNE", k, 2, 3), ("X", p + 2, k / n, 0.0)]
        dynamics += [("ESTIFF", k, 0.0, 1.0), ("EM", k, 1.0, J)]
    return 2.0 * np.pi * spacar.run(7, Deck.build(rows, dynamics), beams=beams).frequencies[-1][:2]


def orders(found, truth):
    error = np.abs(np.array(found) / truth - 1.0)
    return np.log2(error[:-1] / error[1:])


def test_lumped_inertia_limits_frequencies_to_order_two():
    """The sine measure, straight: 36 parts in a million with 32 beams, second frequency."""
    found = [frequencies(n, "sine") for n in (16, 32)]
    assert orders(found, rayleigh())[0, 1] == pytest.approx(1.95, abs=0.05)
    assert abs(found[1][1] / rayleigh()[1] - 1.0) == pytest.approx(3.6e-5, rel=0.02)


def test_consistent_inertia_is_of_order_four():
    found = [frequencies(n, "angle") for n in (4, 8, 16)]
    np.testing.assert_allclose(orders(found, rayleigh()), 3.97, atol=0.15)


def test_consistent_inertia_is_of_order_four_about_a_bent_state():
    """The tip turns by 45 degrees; the truth from 16 and 32 beams, extrapolated."""
    found = [frequencies(n, "angle", 2.0) for n in (4, 8, 16, 32)]
    truth = found[3] + (found[3] - found[2]) / 15.0
    np.testing.assert_allclose(orders(found[:3], truth), 3.97, atol=0.15)


def test_a_rigid_turn_has_all_of_the_inertia():
    """All angles turn at 1 rad/s about node p: the rotary part of 2 T is J l0."""
    x0 = np.array([[0.0, 0.0, 0.0, 1.5, 0.8, 0.0]]).T
    beam = PlanarAngleBeam(group("PLBEAM", x0, em=[(0.0, 0.7)]))
    e, V, M = np.zeros((3, 1)), np.zeros((3, 6, 1)), np.zeros((6, 6, 1))
    beam.mass(beam.strain(x0, e, e, V), M)
    v = np.array([0.0, 0.0, 1.0, -0.8, 1.5, 1.0])
    assert v @ M[:, :, 0] @ v == pytest.approx(0.7 * 1.7, rel=1e-14)


@pytest.mark.parametrize(("kind", "size"), [(PlanarBeam, "lumped"), (PlanarAngleBeam, "consistent")])
def test_dispersion_of_waves(kind, size):
    """An endless row of beams, wave number k: the closed forms of section 1.3 for the error of omega^2."""
    h, k, r = 0.25, 1.0, 0.7  # next terms: a hundredth of the first ones
    x0 = np.array([[0.0, 0.0, 0.0, h, 0.0, 0.0]]).T
    beam = kind(group("PLBEAM", x0, em=[(1.0, r * r)], estiff=[(1.0, 1.0)]))
    e, V, M = np.zeros((3, 1)), np.zeros((3, 6, 1)), np.zeros((6, 6, 1))
    beam.mass(beam.strain(x0, e, e, V), M)
    K = np.einsum("ai,ab,bj->ij", V[:, :, 0], beam.stiffness()[0][:, :, 0], V[:, :, 0])
    z = np.exp(1j * k * h)
    P = np.zeros((6, 2), complex)  # transverse displacement and angle of p, and of q a phase later
    P[[1, 2], [0, 1]], P[[4, 5], [0, 1]] = 1.0, z
    found = eigvalsh(P.conj().T @ K @ P, P.conj().T @ M[:, :, 0] @ P)[0] * (1.0 + (r * k) ** 2) / k**4 - 1.0
    square = (r * k) ** 2
    exact = {"lumped": -(square**2) * (k * h) ** 2 / (12.0 * (1.0 + square) ** 2), "consistent": (k * h) ** 4 / 720.0}
    assert found == pytest.approx(exact[size], rel=0.05)
