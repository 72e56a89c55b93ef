"""Where beams in the angle measure keep order 4, where they do not, and what restores it (theory-beam-order4.md
section 2.2, tables 3.10 and 3.11)."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve

import spacar

from .test_spatial_angle_beam import cantilever, tip

FORCE, MOMENT, GIT = np.array((0.0, 0.8, 0.6)), np.array((0.1, 0.0, 0.0)), 0.5  # EIz = L = 1


@pytest.fixture(scope="module")
def rod():
    """Tip of an inextensible rod that does not bend about y', clamped, under dead force and moment: x' = R e_x,
    R' = R [kappa], kappa = (T/GIt, 0, Mz/EIz) of m = MOMENT + (x_tip - x) x FORCE; shooting on the tip."""

    def swept(x_tip):
        def rate(_, y):
            x, R = y[:3], y[3:].reshape(3, 3)
            m = R.T @ (MOMENT + np.cross(x_tip - x, FORCE))
            kx, kz = m[0] / GIT, m[2]
            K = np.array([[0.0, -kz, 0.0], [kz, 0.0, -kx], [0.0, kx, 0.0]])
            return np.concatenate((R[:, 0], (R @ K).ravel()))

        start = np.concatenate((np.zeros(3), np.eye(3).ravel()))
        return solve_ivp(rate, (0.0, 1.0), start, "DOP853", rtol=1e-12, atol=1e-13).y[:3, -1]

    return fsolve(lambda x: swept(x) - x, np.array((0.9, 0.25, 0.05)), xtol=1e-13)


def errors(rod, EIy, meshes, beams="angle"):
    """EIy = 0: the modes of the plane are fixed."""
    modes = (2, 3, 4, 5, 6) if EIy else (2, 5, 6)
    decks = [cantilever(n, 1.0, EIy, GIT, FORCE, MOMENT, modes=modes, em=(1.0,)) for n in meshes]
    results = [spacar.run(8, deck, beams=beams) for deck in decks]
    return np.array([np.abs(tip(r, n) - rod).max() for r, n in zip(results, meshes, strict=True)])


def orders(found):
    return np.log2(found[:-1] / found[1:])


@pytest.mark.parametrize(("EIy", "order", "atol", "error", "rtol"), [
    # the twist gradient needs the moment of the rigid plane, which is a multiplier: it is left out
    (0.0, (1.87, 1.97), 0.03, (2.48e-3, 6.77e-4, 1.73e-4), 5e-3),
    # EIy = 1e7 EIz instead, 1.6e-8 from the rigid plane: 300 times more accurate with eight beams
    (1e7, (3.88, 3.97), 0.05, (1.99e-4, 1.35e-5, 8.6e-7), 3e-2),
], ids=["fixed plane", "stiff plane"])  # fmt: skip
def test_the_order_with_a_plane_that_does_not_bend(rod, EIy, order, atol, error, rtol):
    found = errors(rod, EIy, (2, 4, 8))
    np.testing.assert_allclose(orders(found), order, atol=atol)
    np.testing.assert_allclose(found, error, rtol=rtol)


def test_a_stiff_plane_tends_to_the_rigid_one(rod):
    """Its own compliance is all that is left: 0.16/EIy of the length here."""
    soft, stiff = errors(rod, 1e3, (16,)), errors(rod, 1e4, (16,))
    assert soft[0] == pytest.approx(1.64e-4, rel=0.02)
    assert stiff[0] == pytest.approx(1.64e-5, rel=0.02)


J = 0.02  # torsional inertia per length


def twisted(n, consistent, mode=1):
    """n beams that only twist, with the rates of the first torsional mode sin(pi x/2); lumped torsional inertia, or the
    consistent one by MEE -J/(12 l0) on mode 2."""
    rows, dynamics = [("FIX", 1), ("FIX", 2)], []
    for k in range(1, n + 1):
        p = 2 * k - 1
        rows += [("BEAM", k, p, p + 1, p + 2, p + 3, 0.0, 1.0, 0.0), ("DYNE", k, 2), ("X", p + 2, k / n, 0.0, 0.0)]
        dynamics += [("ESTIFF", k, 0.0, GIT, 0.0, 0.0), ("EM", k, 1.0, J, 0.0, 0.0)]
        rate = np.sin(np.pi / 2 * k / n) - np.sin(np.pi / 2 * (k - 1) / n)
        dynamics.append(("STARTDE", k, 2, 0.0, float(rate / n)))
        dynamics += [("MEE", k, 2, -J * n / 12.0)] if consistent else []
    dynamics += [("TIMESTEP", 2.0, 20), ("ERROR", 1e-10, 1e-10), ("INTEGRAT", 853)]
    return spacar.Deck.build(rows, dynamics, mode=mode)


@pytest.mark.parametrize(("consistent", "order"), [(False, 2.0), (True, 4.0)])
def test_torsion_in_time_and_its_frequencies(consistent, order):
    """phi(L, t) = sin(w t)/w and w_k = (k - 1/2) pi sqrt(GIt/J)."""
    w = np.pi / 2.0 * np.sqrt(GIT / J)
    found, lowest = [], []
    for n in (4, 8, 16):
        result = spacar.run(1, twisted(n, consistent), beams="angle")
        angle = 2.0 * np.arcsin(result.node(2 * n + 2, 2))
        found.append(np.abs(angle - np.sin(w * result.t) / w).max() * w)
        modes = 2 * np.pi * spacar.run(7, twisted(n, consistent, 7), beams="angle").frequencies[-1]
        lowest.append(np.abs(modes[:2] / (w * np.array((1.0, 3.0))) - 1.0))
    np.testing.assert_allclose(orders(np.array(found)), order, atol=0.05)
    np.testing.assert_allclose(orders(np.array(lowest)), order, atol=0.15)
