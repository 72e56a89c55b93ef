"""Spatial beams: large bending and frequencies converge to independent solutions with the order of the theory."""

from itertools import pairwise

import models
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


def line(n: int) -> np.ndarray:
    """Ends of n elements on 1 m of the x axis."""
    return np.linspace((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), n + 1)


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
        moment = (f"XF {node} {turn!r}", "ITERSTEP 30 10 1e-9")
        deck = spacar.parse_deck(models.cantilever(n, mass=0.0, EI=1.0, length=1.0, dynamics=moment), mode=8)
    else:
        rows, dynamics = chain(line(n), (2, 3, 4, 5, 6), ESTIFF=(0.0, 1.0, 1.0, 1.0))
        # y' of the chain is the global z axis: bending in the x'z' plane turns about y'
        deck = Deck.build(rows, [*dynamics, ("XF", node, 0.0, 0.0, turn), ("ITERSTEP", 30, 10, 1e-9)])
    r = spacar.run(8, deck)
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
    r = spacar.run(7, Deck.build(*chain(line(n), modes, **values)))
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


# Flow in tubes (divergence, flutter) and belts over many turns, against closed forms.
def tube(n: int, ends: str, u: float, ratio: float) -> spacar.Result:
    """n tube elements on 1 m with EI = 1, mass 1 kg/m in all, fluid part `ratio`; u = U sqrt(m_f/EI) L; mode 7."""
    flow = ratio * u / np.sqrt(ratio)  # m_f U
    rows: list[tuple] = [("FIX", 1)]
    dynamics: list[tuple] = []
    for k in range(1, n + 1):
        p = 2 * k - 1
        end = 2.0 if k == n else 0.0  # the fluid leaves as a jet: no wall tension in a tube with a sliding end
        em = (1 - ratio, ratio, flow, 1.0, end)
        rows += [("X", p + 2, k / n), ("PLTUBE", k, p, p + 1, p + 2, p + 3), ("DYNE", k, 2, 3)]
        dynamics += [("EM", k, *em), ("ESTIFF", k, 0.0, 1.0)]
    last = 2 * n + 1
    if ends == "pinned":
        # the start angle is free; the transverse position of the end is fixed: one bending mode follows
        rows += [("DYNX", 2), ("FIX", last, 2)]
        rows = [r if r != ("DYNE", n, 2, 3) else ("DYNE", n, 3) for r in rows]
        rows.append(("RLSE", n, 2))
    elif ends == "clamped":
        rows += [("FIX", 2), ("FIX", last, 2), ("FIX", last + 1)]
        rows = [r for r in rows if r != ("DYNE", n, 2, 3)]
        rows.append(("RLSE", n, 2, 3))
    else:
        rows.append(("FIX", 2))
    return spacar.run(7, Deck.build(rows, dynamics, mode=7))


def stiffness(r: spacar.Result) -> float:
    """Smallest eigenvalue of K0 + N0 + G0."""
    K = r["k0"][0] + r["n0"][0] + r["g0"][0]
    return float(np.linalg.eigvalsh(0.5 * (K + K.T))[0])


@pytest.mark.parametrize(
    ("ends", "critical", "published"),
    [
        ("pinned", np.pi, {4: 1.00026, 8: 1.000016}),
        pytest.param("clamped", 2 * np.pi, {4: 1.0038, 8: 1.00026}, marks=pytest.mark.slow),
    ],
)
def test_divergence(ends: str, critical: float, published: dict[int, float]) -> None:
    """Buckling under the momentum of the flow, u = pi and 2 pi, from above with order four."""
    for n, factor in published.items():
        u = brentq(lambda u, n=n: stiffness(tube(n, ends, u, 0.3)), 0.9 * critical, 1.1 * critical, xtol=1e-6)
        assert u / critical == pytest.approx(factor, abs=0.6 * 10.0 ** -(5 if factor < 1.001 else 4))


@pytest.mark.parametrize(
    ("ratio", "exact", "twelve", "omega"),
    [(0.1, 4.7502, None, None), (0.2, 5.59149, 5.59156, 13.7156), (0.5, 9.32238, 9.3245, 26.510)],
)
def test_flutter_of_a_discharging_cantilever(ratio: float, exact: float, twelve: float, omega: float) -> None:
    """Galerkin solutions of the beam equation (theory-spatial.md section 14): 5e-4 with 12 elements, whose speed and
    frequency [rad/s] theory-planar.md section 9 has."""

    def growing(u: float) -> np.ndarray:
        values = tube(12, "jet", u, ratio)["eigval"][0]
        return values[np.argmax(values[:, 0])]

    u = brentq(lambda u: float(growing(u)[0]), 0.9 * exact, 1.1 * exact, xtol=1e-6)
    assert u == pytest.approx(exact, rel=5e-4)
    if twelve is not None:
        assert u == pytest.approx(twelve, rel=1e-5)
        assert abs(growing(u)[1]) == pytest.approx(omega, rel=2e-5)


# -- belts ---------------------------------------------------------------------------------------------------------
def pulleys(rp: float, rq: float) -> list[tuple]:
    return [
        ("PLBELT", 1, 1, 2, 3, 4, rp, rq), ("X", 3, 1.0), ("FIX", 1), ("FIX", 3), ("INPUTX", 2),
    ]  # fmt: skip


@pytest.mark.parametrize(("rp", "rq"), [(0.1, 0.1), (-0.1, -0.25), (0.2, 0.05), (0.1, -0.3), (-0.2, 0.1)])
def test_belt_ratio_over_many_turns(rp: float, rq: float) -> None:
    """r_p phi_p = r_q phi_q: open belts turn the same way, crossed ones opposite; 50 turns."""
    dynamics = [("INPUTX", 2, 1, 0.0, 2 * np.pi, 0.0), ("TIMESTEP", 50.0, 200), ("XM", 4, 0.3)]
    r = spacar.run(1, Deck.build(pulleys(rp, rq), dynamics))
    np.testing.assert_allclose(r.node(4, 1), rp / rq * r.node(2, 1), atol=1e-10 * abs(rp / rq))


def test_hinge_angles_over_many_turns_with_acceleration() -> None:
    """A spatial hinge driven through 100 turns each way, and a second hinge that turns back."""
    rows = [("HINGE", 1, 1, 2, 0.3, 0.4, 0.5), ("HINGE", 2, 2, 3, 0.3, 0.4, 0.5), ("HINGE", 3, 1, 3, 0.3, 0.4, 0.5),
            ("FIX", 1), ("INPUTE", 1, 1), ("RLSE", 2, 1), ("INPUTE", 3, 1), ("RLSE", 3, 2, 3)]  # fmt: skip
    dynamics = [("INPUTE", 1, 1, 0.0, 0.0, 10.0), ("INPUTE", 3, 1, 0.0, -1.0, -5.0), ("TIMESTEP", 11.0, 1100)]
    r = spacar.run(1, Deck.build(rows, dynamics))
    np.testing.assert_allclose(r.element(2, 1), r.element(3, 1) - r.element(1, 1), atol=1e-9)
    assert r.element(1, 1)[-1] == pytest.approx(5 * 11.0**2)
    assert r.element(2, 1)[-1] < -900
