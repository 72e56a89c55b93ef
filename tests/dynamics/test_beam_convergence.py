"""Spatial beams: large bending and frequencies converge to independent solutions with the order of the theory."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.optimize import brentq

import spacar
from spacar import Deck


def orders(errors: list[float]) -> np.ndarray:
    """Observed order between meshes that double."""
    return np.log2(np.array(errors[:-1]) / np.array(errors[1:]))


def chain(points: np.ndarray, modes: tuple[int, ...], **values: tuple[float, ...]) -> tuple[list[tuple], list[tuple]]:
    """BEAMs through these points, clamped at the first; nodes 1, 2 (orientation), 3, 4, ...; values: EM=...,
    ESTIFF=...
    """
    rows: list[tuple] = [("FIX", 1), ("FIX", 2)]
    dynamics: list[tuple] = []
    for k, (a, b) in enumerate(pairwise(points), 1):
        p = 2 * k - 1
        rows += [("BEAM", k, p, p + 1, p + 2, p + 3, 0.0, 0.0, 1.0), ("DYNE", k, *modes)]
        rows += [("X", p, *map(float, a))] if k == 1 else []
        rows.append(("X", p + 2, *map(float, b)))
        dynamics += [(name, k, *v) for name, v in values.items()]
    return rows, dynamics


# -- 45 degree bend ------------------------------------------------------------------------------------------------
# Exact rod solution by shooting (theory-spatial.md section 14): radius 100, section 1 x 1, E = 1e7, nu = 0, J = 0.1408.
EXACT_BEND = {
    300.0: (58.53947, 22.11451, 40.47490), 450.0: (51.97385, 18.37130, 48.69997), 600.0: (46.89617, 15.55968, 53.60296),
}  # fmt: skip


def bend(n: int, load: float, linear: bool = False) -> np.ndarray:
    angle = np.linspace(0, np.pi / 4, n + 1)
    points = 100.0 * np.column_stack((np.sin(angle), 1 - np.cos(angle), 0 * angle))
    stiffness = (1e7, 5e6 * 0.1408, 1e7 / 12, 1e7 / 12)
    rows, dynamics = chain(points, (1, 2, 3, 4, 5, 6), ESTIFF=stiffness)
    if linear:
        rows += [("LDEFORM", k) for k in range(1, n + 1)]
    tip = 2 * n + 1
    dynamics += [("XF", tip, 0.0, 0.0, load), ("ITERSTEP", 30, 6, 1e-6)]
    r = spacar.run(8, Deck.build(rows, dynamics))
    return np.array([r.node(tip, k)[-1] for k in (1, 2, 3)])


def test_bend_converges_with_order_two() -> None:
    """Published distances to the exact rod 1.13, 0.273, 0.0677, 0.0169 at n = 4, 8, 16, 32."""
    errors = [float(np.linalg.norm(bend(n, 600.0) - EXACT_BEND[600.0])) for n in (4, 8, 16, 32)]
    assert errors == pytest.approx([1.13, 0.273, 0.0677, 0.0169], rel=5e-3)
    np.testing.assert_allclose(orders(errors), 2.0, atol=0.08)


def test_bend_with_eight_elements() -> None:
    """To all published digits; without second-order terms far away."""
    for load, tip in (
        (600.0, (46.68514, 15.51222, 53.76955)), (300.0, (58.47240, 22.10825, 40.54785)),
        (450.0, (51.83049, 18.34257, 48.82979)),
    ):  # fmt: skip
        np.testing.assert_allclose(bend(8, load), tip, atol=6e-6)
    assert np.linalg.norm(bend(8, 600.0, linear=True) - EXACT_BEND[600.0]) == pytest.approx(0.338, abs=6e-4)


# -- roll-up to a full circle --------------------------------------------------------------------------------------
def roll_up(n: int, turn: float, planar: bool = False) -> float:
    """Distance of the tip from the exact arc of an inextensible rod of length 1 under the end moment turn * EI."""
    tip, node = 2 * n + 1, 2 * n + 2
    if planar:
        rows = [("FIX", 1), ("FIX", 2)]
        dynamics: list[tuple] = []
        for k in range(1, n + 1):
            p = 2 * k - 1
            rows += [("PLBEAM", k, p, p + 1, p + 2, p + 3), ("X", p + 2, k / n, 0.0), ("DYNE", k, 2, 3)]
            dynamics.append(("ESTIFF", k, 0.0, 1.0))
        dynamics.append(("XF", node, turn))
    else:
        points = np.column_stack((np.linspace(0, 1, n + 1), np.zeros((n + 1, 2))))
        rows, dynamics = chain(points, (2, 3, 4, 5, 6), ESTIFF=(0.0, 1.0, 1.0, 1.0))
        # y' of the chain is the global z axis: bending in the x'z' plane turns about y'
        dynamics.append(("XF", node, 0.0, 0.0, turn))
    dynamics.append(("ITERSTEP", 30, 10, 1e-9))
    r = spacar.run(8, Deck.build(rows, dynamics))
    exact = np.array([np.sin(turn) / turn, (1 - np.cos(turn)) / turn])
    return float(np.hypot(r.node(tip, 1)[-1] - exact[0], r.node(tip, 2)[-1] - exact[1]))


@pytest.mark.parametrize("planar", [pytest.param(False, marks=pytest.mark.slow), True])
def test_roll_up_to_a_full_circle(planar: bool) -> None:
    errors = [roll_up(n, 2 * np.pi, planar) for n in (8, 16, 32, 64)]
    assert errors == pytest.approx([1.3e-1, 2.7e-2, 6.5e-3, 1.6e-3], rel=0.05)
    np.testing.assert_allclose(orders(errors)[1:], 2.0, atol=0.08)


def test_half_and_quarter_circle() -> None:
    for turn, published in ((np.pi, [3.3e-2, 7.7e-3, 1.9e-3]), (np.pi / 2, [4.8e-3, 1.2e-3, 2.9e-4])):
        errors = [roll_up(n, turn) for n in (8, 16, 32)]
        assert errors == pytest.approx(published, rel=0.05)


# -- frequencies ---------------------------------------------------------------------------------------------------
def frequencies(n: int, modes: tuple[int, ...], **values: tuple[float, ...]) -> np.ndarray:
    points = np.column_stack((np.linspace(0, 1, n + 1), np.zeros((n + 1, 2))))
    r = spacar.run(7, Deck.build(*chain(points, modes, **values)))
    return np.unique(np.abs(r["eigval"][0][:, 1]).round(12))


def test_bending_frequencies_converge_with_order_four_from_above() -> None:
    root = [brentq(lambda b: np.cosh(b) * np.cos(b) + 1, a, c, xtol=1e-14) for a, c in ((1.5, 2.5), (4, 5))]
    first, second = [], []
    for n in (1, 2, 4, 8):
        w = frequencies(n, (3, 4), EM=(1.0,), ESTIFF=(0.0, 0.0, 1.0, 1.0))
        first.append(w[0] / root[0] ** 2 - 1)
        if n > 1:
            second.append(w[1] / root[1] ** 2 - 1)
    assert first == pytest.approx([4.8e-3, 4.8e-4, 3.3e-5, 2.1e-6], rel=0.03)
    assert second == pytest.approx([8.5e-3, 1.2e-3, 8.0e-5], rel=0.03)
    assert orders(first)[-1] == pytest.approx(4.0, abs=0.1)
    assert orders(second)[-1] == pytest.approx(4.0, abs=0.15)


def test_both_bending_planes_agree() -> None:
    a = frequencies(4, (3, 4), EM=(1.0,), ESTIFF=(0.0, 0.0, 2.0, 3.0))
    b = frequencies(4, (5, 6), EM=(1.0,), ESTIFF=(0.0, 0.0, 3.0, 2.0))
    np.testing.assert_allclose(a, b, rtol=1e-9)


@pytest.mark.parametrize(
    ("mode", "values", "published", "rel"),
    [
        (2, {"EM": (1.0, 1.0, 0.5, 0.5), "ESTIFF": (0.0, 1.0)}, [-1.0e-1, -2.6e-2, -6.4e-3, -1.6e-3], 0.03),
        # The cubic line is quadratic at best along the axis when the tangents keep their length.
        (1, {"EM": (1.0,), "ESTIFF": (1.0,)}, [4.5e-2, 1.3e-2, 3.5e-3, 8.7e-4], 0.04),
    ],
    ids=["torsion from below", "axial from above"],
)
def test_frequencies_converge_with_order_two(mode, values, published, rel) -> None:
    errors = [frequencies(n, (mode,), **values)[0] / (np.pi / 2) - 1 for n in (1, 2, 4, 8)]
    assert errors == pytest.approx(published, rel=rel)
    assert orders(np.abs(errors))[-1] == pytest.approx(2.0, abs=0.05)


# -- torsion and elongation ----------------------------------------------------------------------------------------
def test_a_twisted_bar_shortens() -> None:
    """f1 = 0.02 m^2, moment 0.05 GIt on 1 m: strain -f1 e2^2/2 with e2 = sin(twist), sin(twist) cos(twist) = 0.05."""
    rows = [("BEAM", 1, 1, 2, 3, 4, 0.0, 1.0, 0.0, 0.02), ("X", 3, 1.0), ("FIX", 1), ("FIX", 2), ("DYNE", 1)]
    dynamics = [("ESTIFF", 1, 1e3, 1.0, 1.0, 1.0), ("XF", 4, 0.05, 0.0, 0.0), ("ITERSTEP", 20, 1, 1e-13)]
    r = spacar.run(8, Deck.build(rows, dynamics))
    assert r.node(3, 1)[-1] - 1 == pytest.approx(-0.01 * (1 - np.sqrt(0.99)) / 2, abs=1e-13)
    rows[0] = rows[0][:-1]
    assert spacar.run(8, Deck.build(rows, dynamics)).node(3, 1)[-1] == pytest.approx(1.0, abs=1e-12)
