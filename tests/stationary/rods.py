"""Exact planar rods by shooting: the independent truth for flexures. No code of the program.

A rod with axial strain and bending (no shear), force (Fx, Fy) on the cut, constant along it:
x' = (1 + N/EA) cos, y' = (1 + N/EA) sin, theta' = M/EI, M' = -(x' Fy - y' Fx), N = Fx cos + Fy sin.
"""

from collections.abc import Callable

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve

Array = np.ndarray


def rod(z: Array, force: Array, length: float, EA: float, EI: float) -> Array:
    """x, y, theta, M at the end from those at the start."""

    def slope(_: float, z: Array) -> list[float]:
        c, s = np.cos(z[2]), np.sin(z[2])
        stretch = 1.0 + (force[0] * c + force[1] * s) / EA
        x, y = stretch * c, stretch * s
        return [x, y, z[3] / EI, y * force[0] - x * force[1]]

    return solve_ivp(slope, (0.0, length), z, method="DOP853", rtol=1e-11, atol=1e-13).y[:, -1]


def follow(residual: Callable[[Array, float], Array], u: Array, values: Array) -> Array:
    """The root u along a list of values of the parameter, predicted linearly."""
    last = u
    for k, value in enumerate(values):
        start = u if k < 2 else 2.0 * u - last
        last = u
        u, _, found, text = fsolve(residual, start, args=(value,), xtol=1e-13, full_output=True)
        assert found == 1 or np.abs(residual(u, value)).max() < 1e-9, text
    return u


def two_leaves(
    ends: tuple[tuple[float, float], ...], body: tuple[float, float], EA: float, EI: float, values: Array, turned: bool
) -> float:
    """Force along x at `body` moved to the last value of x; `turned`: moment that turns the body to the last angle."""
    _, force, moment = _two_leaves(ends, body, EA, EI, values, turned)
    return moment if turned else force


def clamps(
    ends: tuple[tuple[float, float], ...], body: tuple[float, float], EA: float, EI: float, values: Array
) -> Array:
    """Fx, Fy, M on the cut at the clamp of both leaves, (2, 3), with the body moved to the last value of x."""
    u = _two_leaves(ends, body, EA, EI, values, False)[0]
    return u[:6].reshape(2, 3) * [EI / 0.01, EI / 0.01, EI / 0.1]


def _two_leaves(
    ends: tuple[tuple[float, float], ...], body: tuple[float, float], EA: float, EI: float, values: Array, turned: bool
) -> tuple[Array, float, float]:
    """Forces and moments at the clamps of both leaves, and two of x, y, angle of the body (the unknowns); the force
    and the moment on the body."""
    p1, q1, p2, q2, b = map(np.array, (*ends, body))
    force, moment, length = EI / 0.01, EI / 0.1, 0.1

    def equations(u: Array, value: float) -> tuple[Array, float, float]:
        x, y, phi = (u[6] * length, u[7] * length, value) if turned else (value, u[6] * length, u[7])
        R, at = np.array([[np.cos(phi), -np.sin(phi)], [np.sin(phi), np.cos(phi)]]), np.array([x, y])
        out, total, torque = [], np.zeros(2), 0.0
        for p, q, F, M in ((p1, q1, u[:2] * force, u[2] * moment), (p2, q2, u[3:5] * force, u[5] * moment)):
            start = np.arctan2(*(q - p)[::-1])
            z = rod(np.array([*p, start, M]), F, float(np.hypot(*(q - p))), EA, EI)
            arm = R @ (q - b)
            out += [*(z[:2] - at - arm) / length, z[2] - start - phi]
            total += F
            torque -= z[3] + arm[0] * F[1] - arm[1] * F[0]
        rest = list(total / force) if turned else [total[1] / force, torque / moment]
        return np.array(out + rest), float(total[0]), -torque

    u = np.zeros(8)
    u[6:] = (b / length) if turned else (b[1] / length, 0.0)
    u = follow(lambda u, value: equations(u, value)[0], u, values)
    return u, *equations(u, values[-1])[1:]


def lee(load: float, base: Array) -> Array:
    """Lee's frame: vertical displacement of the loaded point; `base` (Fx, Fy, theta) starts the search."""
    EA, EI = 4320.0, 1440.0

    def shoot(u: Array) -> tuple[Array, Array]:
        z = rod(np.array([0.0, 0.0, u[2], 0.0]), u[:2], 120.0, EA, EI)
        z[2] -= 0.5 * np.pi
        p = rod(z, u[:2], 24.0, EA, EI)
        z = rod(p, u[:2] + np.array([0.0, load]), 96.0, EA, EI)
        return np.array([z[0] / 120.0 - 1.0, z[1] / 120.0 - 1.0, z[3] / 100.0]), p

    u = fsolve(lambda u: shoot(u)[0], base, xtol=1e-13)
    assert np.abs(shoot(u)[0]).max() < 1e-9
    return shoot(u)[1]
