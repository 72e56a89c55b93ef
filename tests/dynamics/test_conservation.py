"""The virtual power of reactions, and bodies that turn freely: energy and momentum over many turns."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import spacar
from spacar.dynamics import Dynamics
from spacar.kinematics.transfer import velocity_transfer
from spacar.mechanism import build
from tests.elements.spatial_truth import rotation, turn
from tests.examples import DATA

from .reduced_form import random_state

G = 9.81


@pytest.mark.parametrize(
    "name", ["crank", "crankfl", "fourbar", "trike3v", "screw", "fingersim", "robotsim", "lateral4"]
)
def test_virtual_power_of_the_reactions_vanishes(name: str) -> None:
    """For every virtual velocity W dq that the constraints allow: dx.(f - M xdd - h) - de.sigma = 0 on dynamic q."""
    d = Dynamics(build(spacar.read_deck(DATA / f"{name}.dat", 1)))
    y = random_state(d, 1e-3, 0.1)
    d.place(0.0, y)
    f = d.frame(0.0, y)
    n = d.numbering
    W = velocity_transfer(d.kinematics)
    reactions = f.fxtot - f.fx - f.fxgrav
    dyn = n.dynamic
    fixed = np.arange(n.nx)[n.x_class["fixed"]]
    assert not W[fixed].any()
    power = W[:, dyn].T @ reactions
    assert np.abs(power).max(initial=0.0) < 1e-9 * max(np.abs(f.fxtot).max(), np.abs(f.sig).max(), 1e-12)
    # multipliers of fixed deformations do no work either
    We = d.kinematics.sweep_rates(W)
    assert np.abs(We[: n.e_class["input"].start, dyn]).max(initial=0.0) < 1e-10


# Free rigid body and heavy top over 10 s against body-frame Euler equations integrated by another program.
T, STEPS = 10.0, 100


def skew(v: np.ndarray) -> np.ndarray:
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def reference(
    J: np.ndarray, omega: np.ndarray, moment: Callable[[np.ndarray], np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """R (n, 3, 3) and body rates (n, 3): J w' = -w x J w + moment(R), R' = R w~, rotation matrix as nine unknowns."""
    inverse = np.linalg.inv(J)

    def rhs(_: float, y: np.ndarray) -> np.ndarray:
        R, w = y[:9].reshape(3, 3), y[9:]
        return np.concatenate(((R @ skew(w)).ravel(), inverse @ (moment(R) - np.cross(w, J @ w))))

    t = np.linspace(0, T, STEPS + 1)
    y0 = np.concatenate((np.eye(3).ravel(), omega))
    solution = solve_ivp(rhs, (0, T), y0, "DOP853", t, rtol=1e-13, atol=1e-14)
    return solution.y[:9].T.reshape(-1, 3, 3), solution.y[9:].T


def rotations(lam: np.ndarray) -> np.ndarray:
    """(n, 3, 3) of unit Euler parameters (n, 4)."""
    return np.array([rotation(one) for one in lam])


def turns(axis: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """(n, 3, 3) rotations about a fixed axis."""
    return rotations([turn(axis, a) for a in angles])


def body_rates(lam: np.ndarray, lam_d: np.ndarray) -> np.ndarray:
    """2 vec(conj(lam) lam_d), (n, 3)."""
    s, v, sd, vd = lam[:, :1], lam[:, 1:], lam_d[:, :1], lam_d[:, 1:]
    return 2 * (s * vd - sd * v - np.cross(v, vd))


def gimbal(
    axes: np.ndarray, omega: np.ndarray, rows: list[tuple], dynamics: list[tuple], tolerance: float = 1e-13
) -> spacar.Result:
    """A body (node 4) on three hinges with these axes, started with the rate omega."""
    rows = [
        *[("HINGE", k + 1, k + 1, k + 2, *map(float, axes[k])) for k in range(3)],
        ("FIX", 1), *[("DYNE", k, 1) for k in (1, 2, 3)], *rows,
    ]  # fmt: skip
    rates = np.linalg.solve(axes.T, omega)
    dynamics = [
        *dynamics, *[("STARTDE", k + 1, 1, 0.0, float(rates[k])) for k in range(3)],
        ("TIMESTEP", T, STEPS), ("ERROR", tolerance, tolerance),
    ]  # fmt: skip
    return spacar.run(1, spacar.Deck.build(rows, dynamics))


def far_from_singular(R: np.ndarray) -> np.ndarray:
    """Hinge axes: the body-fixed third axis never comes near the space-fixed first one during the motion."""
    rng = np.random.default_rng(0)
    best, axes = -1.0, np.eye(3)
    for _ in range(300):
        a, b = rng.normal(size=(2, 3))
        a, b = a / np.linalg.norm(a), b / np.linalg.norm(b)
        distance = np.linalg.norm(np.cross(R @ b, a), axis=1).min()
        if distance > best:
            middle = np.cross(b, a)
            best, axes = distance, np.array([a, middle / np.linalg.norm(middle), b])
    assert best > 0.1
    return axes


def test_tumbling_about_the_intermediate_axis() -> None:
    J = np.diag([1.0, 2.0, 3.0])
    omega = np.array([0.05, 3.0, 0.02])
    R, w = reference(J, omega, lambda _: np.zeros(3))
    # It does tumble: the intermediate axis turns over in space.
    assert w[:, 1].min() < -2.5
    r = gimbal(far_from_singular(R), omega, [], [("XM", 4, 1.0, 0.0, 0.0, 2.0, 0.0, 3.0)])
    lam = r["x"][:, r.lnp[3] - 1]
    rates = body_rates(lam, r["xd"][:, r.lnp[3] - 1])
    np.testing.assert_allclose(rotations(lam), R, atol=1e-9)
    np.testing.assert_allclose(rates, w, atol=3e-9)  # 1e-9 of the rate of 3 rad/s
    momentum = np.einsum("nij,nj->ni", rotations(lam), rates @ J)
    np.testing.assert_allclose(momentum, np.broadcast_to(J @ omega, momentum.shape), atol=1e-9)
    energy = 0.5 * np.einsum("ni,ni->n", rates, rates @ J)
    np.testing.assert_allclose(energy / energy[0], 1.0, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(lam, axis=1), 1.0, atol=1e-14)


@pytest.mark.slow
def test_fast_heavy_top() -> None:
    """Spin 40 rad/s, tilted by 0.5 rad, with an inclined push: precession and nutation; angles to 400 rad."""
    m, arm, J = 2.0, 0.3, np.array([0.05, 0.05, 0.02])
    tilt = 0.5
    axis = np.array([0.0, -np.sin(tilt), np.cos(tilt)])
    side = np.array([1.0, 0.0, 0.0])
    third = np.cross(axis, side)
    frame = np.column_stack((side, third, axis))
    tensor = frame @ np.diag(J) @ frame.T
    about_point = tensor + m * arm**2 * (np.eye(3) - np.outer(axis, axis))
    omega = 40.0 * axis + 0.5 * side + 0.3 * third
    R, _w = reference(about_point, omega, lambda R: np.cross(m * arm * axis, R.T @ [0.0, 0.0, -G]))
    rows = [("RBEAM", 4, 5, 4, 6, 1.0, 0.0, 0.0), ("X", 6, *map(float, arm * axis)), ("FIX", 5)]
    six = [tensor[i] for i in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))]
    dynamics = [("XM", 6, m), ("XM", 4, *map(float, six)), ("GRAVITY", 0.0, 0.0, -G)]
    r = gimbal(np.array([[0.0, 0.0, 1.0], side, axis]), omega, rows, dynamics, 1e-11)
    lam = r["x"][:, r.lnp[3] - 1]
    rates = body_rates(lam, r["xd"][:, r.lnp[3] - 1])
    tip = r["x"][:, r.lnp[5, :3] - 1]
    np.testing.assert_allclose(tip, R @ (arm * axis), atol=1e-9)
    np.testing.assert_allclose(rotations(lam), R, atol=1e-8)  # 400 rad of spin: 2e-11 relative phase
    energy = 0.5 * np.einsum("ni,ij,nj->n", rates, about_point, rates) + m * G * tip[:, 2]
    np.testing.assert_allclose(energy / energy[0], 1.0, atol=1e-10)
    momentum = np.einsum("nij,nj->ni", rotations(lam), rates @ about_point)[:, 2]
    np.testing.assert_allclose(momentum / momentum[0], 1.0, atol=1e-10)
    np.testing.assert_allclose(rates @ axis, 40.0, rtol=1e-11)
    # The hinge angles give the rotation, and the spin angle counts its turns.
    angles = np.array([r.element(k, 1) for k in (1, 2, 3)])
    product = turns([0.0, 0.0, 1.0], angles[0]) @ turns(side, angles[1]) @ turns(axis, angles[2])
    np.testing.assert_allclose(product, R, atol=1e-8)
    assert angles[2, -1] > 300
    spin = r.element(3, 1, "ed")
    assert angles[2, -1] == pytest.approx(np.sum(0.5 * (spin[1:] + spin[:-1]) * np.diff(r.t)), abs=3.0)
    # The force of the support is m (a - g), its moment vanishes.
    force = (r["fxtot"])[:, r.lnp[4, :3] - 1]
    acceleration = r["xdd"][:, r.lnp[5, :3] - 1]
    np.testing.assert_allclose(force, m * (acceleration + np.array([0.0, 0.0, G])), atol=1e-9 * np.abs(force).max())
