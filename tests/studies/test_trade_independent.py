"""The recommended runs of `spacar trade` against solutions that know nothing of beam elements.

crankfl: the rod is an inextensible elastica, theta(s, t) a sum of Legendre polynomials, with r(s) = p(t) +
int_0^s (cos theta, sin theta) ds, kinetic energy of line and slider, EI/2 int theta'^2, and the guide as a constraint.
robotflexsim: both arms stand and hang straight, so it is an eigenvalue problem of two lateral displacements,
polynomials of degree 8, with bending, weight and damping; in the plane and out of it.
"""

import time

import numpy as np
import pytest
from numpy.polynomial import legendre
from scipy.integrate import solve_ivp
from scipy.linalg import null_space

import spacar
from tests.examples import DATA

TARGET = 1e-4
SECONDS = 60.0  # of processor time that a trade may take


def recommended(name, mode):
    """The result of the recommended run, and what trade took [s]."""
    begun = time.process_time()
    answer = spacar.trade(DATA / f"{name}.dat", mode=mode, target=TARGET)
    seconds = time.process_time() - begun
    return spacar.run(mode, DATA / f"{name}.dat", **answer.options), seconds


# -- crankfl -------------------------------------------------------------------------------------------------------
RADIUS, SPEED, LENGTH, MASS, SLIDER, EI = 0.15, 150.0, 0.3, 0.2225, 0.033375, 13.359623


def elastica(t, degree=8, points=14, rtol=1e-6):
    """theta at s = 0, L/2, L, r at L/2, L, of the rod of crankfl: (times, 3), (times, 2, 2)."""
    z, w = legendre.leggauss(points)
    P, Q = legendre.legvander(z, degree), legendre.legvander(np.array([-1.0, 0.0, 1.0]), degree)
    D = np.array([legendre.legval(z, legendre.legder(row)) for row in np.eye(degree + 1)]).T * 2.0 / LENGTH
    w = 0.5 * LENGTH * w
    stiffness = EI * D.T @ (w[:, None] * D)

    def integrals(to):
        """(len(to), points): weights of int_-1^to f."""
        basis = np.linalg.inv(legendre.legvander(z, points - 1))
        whole = np.array([legendre.legval(to, legendre.legint(row, lbnd=-1)) for row in np.eye(points)]).T
        return 0.5 * LENGTH * whole @ basis

    J, ends = integrals(z), integrals(np.array([0.0, 1.0]))

    def rate(t, y):
        a, v = np.split(y, 2)
        theta, turning = P @ a, P @ v
        u = np.stack((np.cos(theta), np.sin(theta)))
        n = np.stack((-u[1], u[0]))
        dr = np.einsum("js,is,sk->jik", J, n, P)
        tip = np.einsum("s,is,sk->ik", ends[1], n, P)
        crank = -(SPEED**2) * RADIUS * np.array((np.cos(SPEED * t), np.sin(SPEED * t)))
        free = crank + (-(turning**2) * u @ J.T).T
        of_tip = crank - (turning**2 * u) @ ends[1]
        M = MASS * np.einsum("j,jik,jil->kl", w, dr, dr) + SLIDER * np.outer(tip[0], tip[0])
        h = MASS * np.einsum("j,jik,ji->k", w, dr, free) + SLIDER * tip[0] * of_tip[0] + stiffness @ a
        KKT = np.block([[M, tip[1][:, None]], [tip[1][None], np.zeros((1, 1))]])
        return np.concatenate((v, np.linalg.solve(KKT, np.append(-h, -of_tip[1]))[:-1]))

    y = np.zeros(2 * degree + 2)
    y[degree + 1] = -SPEED * RADIUS / LENGTH  # straight, and without deformation rates
    run = solve_ivp(rate, (0.0, t[-1]), y, "Radau", t_eval=t, rtol=rtol, atol=rtol)
    a = run.y[: degree + 1].T
    theta = a @ P.T
    u = np.stack((np.cos(theta), np.sin(theta)), axis=-1)
    crank = RADIUS * np.stack((np.cos(SPEED * t), np.sin(SPEED * t)), axis=-1)
    return a @ Q.T, crank[:, None] + np.einsum("es,tsi->tei", ends, u)


@pytest.mark.slow
def test_crankfl():
    result, seconds = recommended("crankfl", 1)
    theta, r = elastica(result.t)
    finer = elastica(result.t[:21], degree=9, points=16, rtol=1e-7)
    angles = [result.node(n, 1) for n in (5, 7, 9)]
    places = [result.node(6, 1), result.node(6, 2), result.node(8, 1)]
    found = np.stack((*angles, *places))
    truth, check = (np.stack((*th.T, p[:, 0, 0], p[:, 0, 1], p[:, 1, 0])) for th, p in ((theta, r), finer))
    span = np.ptp(truth, axis=1)[:, None]
    error, own = np.max(np.abs(found - truth) / span), np.max(np.abs(truth[:, :21] - check) / span)
    print(f"crankfl: error {error:.3g}, of the elastica {own:.2g}, trade {seconds:.3g} s")
    assert own < 3e-2 * TARGET
    assert error + own <= TARGET
    assert seconds < SECONDS


# -- robotflexsim --------------------------------------------------------------------------------------------------
ARM = np.hypot(0.268, 0.6467)
ARMS = ((4.0, 4e4, 20.0), (2.0, 2e4, 10.0))  # mass, bending stiffness, damping of upper arm and forearm, per length
G = 10.0


def eigenvalues(in_plane, degree=8):
    """Of the linear motion about the upper arm standing and the forearm hanging, by rising modulus."""
    z, w = legendre.leggauss(40)
    s, w = 0.5 * ARM * (z + 1.0), 0.5 * ARM * w
    n = degree + 1
    bases = [legendre.legder(np.eye(n), k, axis=1) for k in range(3)]

    def at(points, k):
        return np.array([legendre.legval(points, row) for row in bases[k]]).T * (2.0 / ARM) ** k

    def ends(k):
        return at(np.array([-1.0, 1.0]), k)

    M, C, K = np.zeros((3, 2 * n, 2 * n))
    forces = -G * (40.0 + 2.0 * ARM + 4.0 * (ARM - s)), G * (30.0 + 2.0 * (ARM - s))
    for k, ((mass, stiffness, damping), N) in enumerate(zip(ARMS, forces, strict=True)):
        u, du, ddu = (at(z, d) for d in range(3))
        here = slice(k * n, (k + 1) * n)
        M[here, here] += mass * u.T @ (w[:, None] * u)
        C[here, here] += damping * ddu.T @ (w[:, None] * ddu)
        K[here, here] += stiffness * ddu.T @ (w[:, None] * ddu) + du.T @ ((w * N)[:, None] * du)
    place, slope = ends(0), ends(1)
    rows = np.zeros((2, 2, 2, 2 * n))  # displacement or slope; arm; end
    for k in (0, 1):
        rows[0, k, :, k * n : (k + 1) * n], rows[1, k, :, k * n : (k + 1) * n] = place, slope
    for mass, row in ((10.0, rows[0, 0, 1]), (30.0, rows[0, 1, 1])):
        M += mass * np.outer(row, row)
    for inertia, row in zip((0.4, 0.3, 0.3, 0.8), rows[1].reshape(4, -1), strict=True):
        M += inertia * np.outer(row, row)
    held = [rows[0, 0, 0], rows[0, 1, 0] - rows[0, 0, 1]]  # the shoulder; both arms at the elbow
    if not in_plane:  # the hinges turn in the plane only
        held += [rows[1, 0, 0], rows[1, 0, 1] + rows[1, 1, 0]]
    T = null_space(np.array(held))
    M, C, K = (T.T @ A @ T for A in (M, C, K))
    one = np.eye(len(M))
    inverse = np.block([[-np.linalg.solve(K, C), -np.linalg.solve(K, M)], [one, 0 * one]])  # exact for the low ones
    found = 1.0 / np.linalg.eigvals(inverse)
    return found[np.argsort(np.abs(found))]


@pytest.mark.slow
def test_robotflexsim():
    """The six lowest pairs (the first one, of the turn about the vertical, is zero), positions and reactions."""
    result, seconds = recommended("robotflexsim", 7)
    both = np.concatenate((eigenvalues(True)[:10], eigenvalues(False)[:10]))
    truth = both[np.argsort(np.abs(both))][:10]
    other = np.concatenate((eigenvalues(True, 9)[:10], eigenvalues(False, 9)[:10]))
    own = np.abs(np.sort(np.abs(other))[:10] / np.abs(truth) - 1.0).max()
    rows = result["eigval"][-1]
    found = rows[:, 0] + 1j * rows[:, 1]
    found = found[np.argsort(np.abs(found))][2:12]
    error = max(np.abs(found - value).min() / abs(value) for value in truth)
    weight = G * (40.0 + 6.0 * ARM)
    forces = sum(sign * np.array([result.node(4, k, name)[-1] for k in (1, 2, 3)])
                 for sign, name in ((1.0, "fxtot"), (-1.0, "fx"), (-1.0, "fxgrav")))  # fmt: skip
    places = np.array([[result.node(n, k)[-1] for k in (1, 2, 3)] for n in (5, 8)])
    moved = np.abs(places - ((0, 0, ARM), (0, 0, 0))).max() / ARM
    still = max(np.abs(forces - (0.0, 0.0, weight)).max() / weight, moved)
    print(f"robotflexsim: eigenvalues {error:.3g}, the rest {still:.2g}, Ritz {own:.2g}, trade {seconds:.3g} s")
    assert own < 1e-2 * TARGET
    assert error <= TARGET
    assert still <= TARGET
    assert seconds < SECONDS
