"""BEAMW in the angle measure in whole analyses: order 4 (theory-beam-order4.md section 2.8, table 3.12)."""

import numpy as np
import pytest
from scipy.integrate import solve_bvp

import spacar

from .warped_bars import bar

ECW = 0.02


def rod(EIz, EIy, GIt, force, moment):
    """Tip of a clamped inextensible rod of length 1 under dead force and moment, w = 0 at the clamp: x' = R e_x,
    R' = R [kappa], EIy ky = m_y, EIz kz = m_z, GIt kx - ECw kx'' = m_x, kx(0) = kx'(1) = 0; EIy = 0: ky = 0."""

    def frame(q):
        a, b, c, d = q
        return np.array([[a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)],
                         [2 * (b * c + a * d), a * a - b * b + c * c - d * d, 2 * (c * d - a * b)],
                         [2 * (b * d - a * c), 2 * (c * d + a * b), a * a - b * b - c * c + d * d]])  # fmt: skip

    def rates(part):
        def rate(_, y):
            x, q, kx, slope, tip = y[:3], y[3:7], y[7], y[8], y[9:]
            R = frame(q)
            m = np.array(moment)[:, None] + np.cross((tip - x).T, force).T
            m = np.einsum("ijn,in->jn", R, part * m)
            ky, kz = (m[1] / EIy if EIy else 0.0 * kx), m[2] / EIz
            a, b, c, d = q
            turn = 0.5 * np.array((-b * kx - c * ky - d * kz, a * kx + c * kz - d * ky,
                                   a * ky + d * kx - b * kz, a * kz + b * ky - c * kx))  # fmt: skip
            return np.vstack((R[:, 0], turn, slope, (GIt * kx - m[0]) / ECW, 0.0 * tip))

        return rate

    def ends(a, b):
        return np.concatenate((a[:3], a[3:7] - (1, 0, 0, 0), a[7:8], b[8:9], b[:3] - b[9:]))

    s = np.linspace(0.0, 1.0, 41)
    y = np.zeros((12, 41))
    y[0], y[3], y[9] = s, 1.0, 1.0
    for part in (0.5, 1.0):
        found = solve_bvp(rates(part), ends, s, y, tol=1e-3 if part < 1.0 else 1e-9, max_nodes=20000)
        assert found.status == 0
        s, y = found.x, found.y
    return y[:7, -1]


def cantilever(n, mode, EIy, GIt, force, moment, mass=(), fixed_plane=False):
    stiffness = {"GIt": GIt, "EIy": EIy, "EIz": 1.0, "ECw": ECW}
    end = 3 * n + 1
    loads = [("XF", end, *force), ("XF", end + 1, *moment), ("ITERSTEP", 50, 8, 1e-12)]
    return bar(n, mode, stiffness, dynamic=(2, 5, 6) if fixed_plane else (2, 3, 4, 5, 6), mass=mass, loads=loads)


def errors(meshes, truth, *load, **values):
    found = []
    for n in meshes:
        result = spacar.run(8, cantilever(n, 8, *load, **values), beams="angle")
        tip = [result.node(3 * n + 1, k)[-1] for k in (1, 2, 3)] + [result.node(3 * n + 2, k)[-1] for k in (1, 2, 3, 4)]
        found.append(np.abs(np.array(tip) - truth).max())
    return np.array(found)


def orders(found):
    return np.log2(found[:-1] / found[1:])


@pytest.mark.parametrize(
    ("EIy", "GIt", "force", "moment", "first", "order"),
    [
        pytest.param(0.1, 0.05, (0.0, 0.2, 0.1), (0.05, 0.0, 0.0), 3.78e-4, (3.90, 3.97), marks=pytest.mark.slow),
        pytest.param(0.5, 0.4, (0.0, 2.0, 1.0), (0.5, 0.0, 0.0), 2.19e-3, (3.91, 4.0), marks=pytest.mark.slow),
        (0.0, 0.4, (0.0, 0.8, 0.6), (0.1, 0.0, 0.0), 9.60e-4, (3.58, 3.87)),
    ],
    ids=["two loads and torque", "large", "a fixed plane"],
)
def test_large_deflections_are_of_fourth_order(EIy, GIt, force, moment, first, order):
    """Also where a plane of bending is fixed, which for BEAM is of order 2."""
    truth = rod(1.0, EIy, GIt, force, moment)
    found = errors((2, 4, 8), truth, EIy, GIt, force, moment, fixed_plane=not EIy)
    assert found[0] == pytest.approx(first, rel=0.01)
    np.testing.assert_allclose(orders(found), order, atol=0.05)


def test_torsion_is_linear_in_the_angle():
    """u = kL = 4, one end without warping: theta = T L/GIt (1 - tanh u/u) = 90 degrees."""
    u, found = 4.0, []
    torque = np.pi / 2 / (1.0 - np.tanh(u) / u)
    for n in (4, 8):
        loads = [("XF", 3 * n + 2, torque, 0.0, 0.0), ("ITERSTEP", 50, 8, 1e-12)]
        stiffness = {"GIt": 1.0, "EIy": 1.0, "EIz": 1.0, "ECw": 1.0 / u**2}
        result = spacar.run(8, bar(n, 8, stiffness, dynamic=(2, 3, 4, 5, 6), loads=loads), beams="angle")
        found.append(abs(2.0 * np.arcsin(abs(result.node(3 * n + 2, 2)[-1])) / (np.pi / 2) - 1.0))
    assert found[1] == pytest.approx(1.4e-5, rel=0.02)
    assert np.log2(found[0] / found[1]) == pytest.approx(3.9, abs=0.1)


@pytest.mark.slow
def test_frequencies_about_a_bent_state_are_of_fourth_order():
    """Three lowest; the truth from 16 and 32 beams, extrapolated."""
    load = (0.1, 0.05, (0.0, 0.2, 0.1), (0.05, 0.0, 0.0))
    found = []
    for n in (4, 8, 16, 32):
        result = spacar.run(7, cantilever(n, 7, *load, mass=(1.0, 1e-6, 0.0, 0.0, 0.0, 1e-9)), beams="angle")
        found.append(result.frequencies[-1][:3])
    truth = found[3] + (found[3] - found[2]) / 15.0
    error = np.abs(np.array(found[:3]) / truth - 1.0)
    np.testing.assert_allclose(orders(error), 4.0, atol=0.15)


def test_load_multipliers_are_those_of_the_sine_measure():
    """To second order the measures are the same, and a straight state needs no more (table E3)."""
    deck = bar(2, 8, {"GIt": 1.0, "EIz": 1.0, "ECw": 0.25}, dynamic=(2, 5, 6), loads=[("XF", 7, 0.0, 0.0, 1.0)])
    value = np.min(np.abs(spacar.run(8, deck, beams="angle")["lmult"][-1]))
    assert value == pytest.approx(9.84195546, abs=5e-9)
