"""Rolling wheels against Newton-Euler, and wheels that do what the theory does not cover."""

import numpy as np
import pytest

import spacar
from spacar.errors import AnalysisError
from tests.elements.spatial_truth import rotation, turn
from tests.examples import DATA

G, EPS = 9.81, np.finfo(float).eps
UP = np.array([0.0, 0.0, 1.0])


def free_wheel(radius: float, rho: float) -> tuple[list[tuple], list[tuple], float, np.ndarray]:
    """One wheel alone: position of the centre and orientation by a chain of three hinges (yaw, lean, spin)."""
    height = radius
    tyre = ("TWHEEL", 4, 5, 4, 6, radius, rho, 0.0, 1.0, 0.0)
    wheel = tyre if rho else ("WHEEL", 4, 5, 4, 6, 0.0, 1.0, 0.0)
    rows = [
        ("HINGE", 1, 1, 2, 0.0, 0.0, 1.0), ("HINGE", 2, 2, 3, 1.0, 0.0, 0.0), ("HINGE", 3, 3, 4, 0.0, 1.0, 0.0), wheel,
        ("X", 5, 0.0, 0.0, height), ("FIX", 1), ("DYNE", 1, 1), ("DYNE", 2, 1), ("DYNE", 3, 1), ("KINX", 5, 1, 2),
    ]  # fmt: skip
    m, axial, transverse = 3.0, 0.04, 0.025
    dynamics = [("XM", 5, m), ("XM", 4, transverse, 0.0, 0.0, axial, 0.0, transverse), ("GRAVITY", 0.0, 0.0, -G)]
    return rows, dynamics, m, np.diag([transverse, axial, transverse])


def newton_euler(
    radius: float, rho: float, m: float, J: np.ndarray, R: np.ndarray, omega: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Acceleration of the centre, angular acceleration and contact force of a rolling torus (rho = 0: a disk).

    The contact point has the material velocity zero: v = -w x c with c(R) from centre to contact; its derivative with
    c' by the motion of the lowest point; m a = F - m g z, J w' + w x J w = c x F.
    """
    a0 = R @ [0.0, 1.0, 0.0]
    big = radius - rho

    def contact(axis: np.ndarray) -> np.ndarray:
        down = -(UP - (UP @ axis) * axis)
        return big * down / np.linalg.norm(down) - rho * UP

    c = contact(a0)
    step = 1e-30
    rate = np.imag(_contact_complex(a0 + 1j * step * np.cross(omega, a0), big, rho)) / step
    Jw = R @ J @ R.T
    # unknowns a, alpha, F: m a - F = -m g z; Jw alpha - c x F = -w x Jw w; a + alpha x c = -w x c'
    A = np.zeros((9, 9))
    skew_c = np.array([[0, -c[2], c[1]], [c[2], 0, -c[0]], [-c[1], c[0], 0]])
    A[:3, :3], A[:3, 6:] = m * np.eye(3), -np.eye(3)
    A[3:6, 3:6], A[3:6, 6:] = Jw, -skew_c
    A[6:, :3], A[6:, 3:6] = np.eye(3), -skew_c
    b = np.concatenate((-m * G * UP, -np.cross(omega, Jw @ omega), -np.cross(omega, rate)))
    x = np.linalg.solve(A, b)
    return x[:3], x[3:6], x[6:]


def _contact_complex(axis: np.ndarray, big: float, rho: float) -> np.ndarray:
    down = -(UP - (UP @ axis) * axis)
    return big * down / np.sqrt(down @ down) - rho * UP


@pytest.mark.parametrize("rho", [0.0, 0.08])
def test_a_rolling_wheel_against_newton_euler(rho: float) -> None:
    """Random yaw, lean, spin and rates: velocity, acceleration, angular acceleration, contact force to 1e-10."""
    radius = 0.35
    rows, dynamics, m, J = free_wheel(radius, rho)
    rng = np.random.default_rng(5)
    for _ in range(10):
        angles, rates = rng.uniform(-0.7, 0.7, 3) * [3.0, 1.0, 3.0], rng.normal(size=3) * [1.0, 1.0, 5.0]
        starts = [("STARTDE", k + 1, 1, float(angles[k]), float(rates[k])) for k in range(3)]
        r = spacar.run(1, spacar.Deck.build(rows, dynamics + starts))
        yaw, lean, spin = (rotation(turn(axis, a)) for axis, a in zip((UP, (1, 0, 0), (0, 1, 0)), angles, strict=True))
        R = yaw @ lean @ spin
        omega = rates[0] * UP + yaw @ (rates[1] * np.array([1.0, 0, 0]) + lean @ (rates[2] * np.array([0, 1.0, 0])))
        acceleration, alpha, force = newton_euler(radius, rho, m, J, R, omega)
        centre = r.lnp[4, :3] - 1
        contact = np.array([r.node(6, k)[0] for k in (1, 2, 3)]) - r["x"][0][centre]
        np.testing.assert_allclose(contact, np.real(_contact_complex(R[:, 1], radius - rho, rho)), atol=1e-12)
        np.testing.assert_allclose(r["xd"][0][centre], -np.cross(omega, contact), atol=1e-11)
        np.testing.assert_allclose(r["xdd"][0][centre], acceleration, atol=1e-10 * np.abs(acceleration).max())
        lam_dd = r["xdd"][0][r.lnp[3] - 1]
        lam = r["x"][0][r.lnp[3] - 1]
        s, v = lam[0], lam[1:]
        found = 2 * (s * lam_dd[1:] - lam_dd[0] * v - np.cross(lam_dd[1:], v))
        np.testing.assert_allclose(found, alpha, atol=1e-10 * np.abs(alpha).max())
        # e3 is the height of the contact point: its multiplier is minus the normal force; e4 carries nothing
        assert r.element(4, 3, "sig")[0] == pytest.approx(-force[2], rel=1e-9)
        assert r.element(4, 4, "sig")[0] == pytest.approx(0.0, abs=1e-10 * np.abs(force).max())


def test_the_spin_of_a_wheel_counts_its_turns() -> None:
    radius = 0.35
    rows, dynamics, _, _ = free_wheel(radius, 0.0)
    dynamics += [("STARTDE", 3, 1, 0.0, 20.0), ("TIMESTEP", 10.0, 40)]
    r = spacar.run(1, spacar.Deck.build(rows, dynamics))
    np.testing.assert_allclose(r.element(3, 1), 20.0 * r.t, atol=1e-8)
    np.testing.assert_allclose(r.node(5, 1), 20.0 * radius * r.t, atol=1e-8)


# -- outside of the theory -----------------------------------------------------------------------------------------
def failure(deck: spacar.Deck, **options: float) -> tuple[AnalysisError, int]:
    frames: list[float] = []
    run = spacar.frames(1, deck, **options)
    with pytest.raises(AnalysisError) as caught:
        frames.extend(f.t for f in run)
    assert "\n" not in str(caught.value)
    return caught.value, len(frames)


@pytest.mark.parametrize(("old", "new", "wheel"), [
    # steered the other way with 0.5 rad at 3 m/s: the left rear wheel would have to pull
    ("STARTDE 8 1 -0.5 0.0", "STARTDE 8 1 0.5 0.0", "element 3 (WHEEL)"),
    ("STARTDE 2 1 0.0 10.0", "STARTDE 2 1 0.0 25.0", "(WHEEL)"),
], ids=["in a turn", "by speed"])  # fmt: skip
def test_a_wheel_that_leaves_the_ground(old: str, new: str, wheel: str) -> None:
    text = (DATA / "trike3v.dat").read_text()
    assert old in text
    error, _ = failure(spacar.parse_deck(text.replace(old, new), "trike.dat", 1))
    assert error.code == "element.lift-off"
    for words in (wheel, "t = ", "leaves the ground", "pull of", " N;", "reduce speed or steering"):
        assert words in str(error)


@pytest.mark.parametrize("compiled", [True, False])
@pytest.mark.parametrize("stiffness", [66.0, 2e5, 1e9])
def test_a_tyre_without_deformation(stiffness: float, compiled: bool) -> None:
    """Its normal force is zero at the start, with the sign of rounding: no lift-off. A quarter of these starts were
    refused, for 1e-16 of the stiffness."""
    rows = [
        ("X", 1, 0.1, 0.2, 0.5), ("X", 3, 0.1, 0.2, 0.0), ("DYNX", 2, 2, 3, 4), ("KINX", 1, 1), ("DYNX", 1, 2),
        ("TWHEEL", 1, 1, 2, 3, 0.5, 0.1, 0.3, 1.0, 0.0), ("RLSE", 1, 6), ("DYNE", 1, 1),
    ]  # fmt: skip
    dynamics = [("XM", 1, 5.0), ("XM", 2, 0.4, 0.0, 0.0, 0.3, 0.0, 0.3), ("ESTIFF", 1, stiffness)]
    dynamics += [("GRAVITY", 0.02, 0.03, -1.0)]
    for turned in np.random.default_rng(1).normal(0.0, 0.06, (20, 3)).tolist():
        starts = [("STARTDX", 2, c, value, 0.1) for c, value in enumerate(turned, 2)]
        result = spacar.run(1, spacar.Deck.build(rows, [*dynamics, *starts]), compiled=compiled)
        assert abs(result.element(1, 1, "sig")[0]) < 64 * EPS * (5.0 + stiffness)  # of the weight, and of 1 m


@pytest.mark.parametrize("compiled", [True, False])
def test_a_tyre_that_is_pulled_a_little(compiled: bool) -> None:
    """A millionth of its weight is no rounding."""
    rows, dynamics, _, _ = free_wheel(0.5, 0.1)
    dynamics += [("ESTIFF", 4, 2e5), ("STARTDE", 4, 1, 3.0 * G / 2e5 * 1e-6, 0.0)]
    error, _ = failure(spacar.Deck.build([*rows, ("DYNE", 4, 1)], dynamics), compiled=compiled)
    assert error.code == "element.lift-off"
    assert "t = 0:" in str(error)


def test_a_disk_that_falls_over() -> None:
    """It stops where the disk lies flat, or the position cannot be found any more; never NaN."""
    rows, dynamics, _, _ = free_wheel(0.35, 0.0)
    dynamics += [("STARTDE", 2, 1, 0.1, 0.0), ("TIMESTEP", 3.0, 300)]
    error, frames = failure(spacar.Deck.build(rows, dynamics))
    assert frames > 10
    assert "t = " in str(error)
    assert "element 4 (WHEEL)" in str(error)


def test_tricycles_straight_ahead() -> None:
    """Normal forces published in theory-spatial.md section 14, sum = weight."""
    text = (DATA / "trike3v.dat").read_text()
    deck = spacar.parse_deck(text.replace("STARTDE 8 1 -0.5 0.0", "STARTDE 8 1 0.0 0.0"), "trike.dat", 1)
    r = spacar.run(1, deck, n_steps=5, atol=1e-8, rtol=1e-8)
    forces = np.array([r.element(w, 3, "sig") for w in (3, 6, 11)])
    np.testing.assert_allclose(forces, np.array([[-294.30], [-294.30], [-250.155]]) @ np.ones((1, 6)), atol=1e-9)
