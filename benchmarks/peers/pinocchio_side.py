"""The scenarios in Pinocchio with the Adams code of LSODA (scipy.integrate.odeint), as its users integrate in Python.

Rigid trees need `aba` only. The slider-crank is reduced by hand to its crank angle: Pinocchio closes no loops in it.
"""

from __future__ import annotations

from collections.abc import Callable
from math import asin, cos, sin, sqrt
from typing import Any

import numpy as np
import pinocchio as pin
from mechanisms import ARM, CRANK, PENDULUM, TORQUES
from scipy.integrate import odeint

Rod = tuple[float, list[float], list[float]]
Torque = Callable[[float], np.ndarray]


def _joint(model: Any, parent: int, joint: Any, offset: list[float], bodies: list[Rod]) -> int:
    """A joint at `offset` that carries rods and points: mass, from, to."""
    number = model.addJoint(parent, joint, pin.SE3(np.eye(3), np.array(offset)), f"j{model.njoints}")
    for mass, a, b in bodies:
        first, last = np.array(a), np.array(b)
        r = last - first
        I = mass / 12 * (r @ r * np.eye(3) - np.outer(r, r))
        model.appendBodyToJoint(number, pin.Inertia(mass, (first + last) / 2, I), pin.SE3.Identity())
    return int(number)


def _solved(model: Any, q0: list[float], torque: Torque, times: np.ndarray, tolerance: float) -> Any:
    """The model's data at the last time."""
    data = model.createData()
    n = model.nv
    aba = pin.aba

    def rate(y: np.ndarray, t: float) -> np.ndarray:
        v = y[n:]
        return np.concatenate((v, aba(model, data, y[:n], v, torque(t))))

    y = odeint(rate, np.concatenate((q0, np.zeros(n))), times, rtol=tolerance, atol=tolerance, mxstep=100000)
    q = y[-1, :n]
    pin.forwardKinematics(model, data, q)
    return data


def pendulum(tolerance: float) -> np.ndarray:
    """S3a: the tip at the end."""
    p = PENDULUM
    model = pin.Model()
    model.gravity.linear = np.array([0.0, -p.gravity, 0.0])
    rod = [(p.mass, [0.0] * 3, [p.length, 0.0, 0.0])]
    first = _joint(model, 0, pin.JointModelRZ(), [0.0] * 3, rod)
    last = _joint(model, first, pin.JointModelRZ(), [p.length, 0.0, 0.0], rod)
    none = np.zeros(2)
    data = _solved(model, [-np.pi / 4, 0.0], lambda t: none, np.linspace(0.0, p.time, 11), tolerance)
    return np.asarray(data.oMi[last].act(np.array([p.length, 0.0, 0.0])))[:2]


def arm(tolerance: float, constant: bool) -> np.ndarray:
    """S4, S4c: the tip at the end."""
    a = ARM
    model = pin.Model()
    model.gravity.linear = np.array([0.0, 0.0, -a.gravity])
    length = float(np.linalg.norm(a.first))
    parts = [
        [(density * length, [0.0] * 3, end), (mass, end, end)]
        for density, end, mass in ((a.density_1, a.first, a.mass_1), (a.density_2, a.second, a.mass_2))
    ]
    down = np.array([0.0, -1.0, 0.0])
    turn = _joint(model, 0, pin.JointModelRZ(), [0.0] * 3, [])
    lower = _joint(model, turn, pin.JointModelRevoluteUnaligned(down), [0.0] * 3, parts[0])
    upper = _joint(model, lower, pin.JointModelRevoluteUnaligned(down), a.first, parts[1])
    steady, mean, swing = np.array(a.torques), np.array(TORQUES["mean"]), np.array(TORQUES["swing"])

    def torque(t: float) -> np.ndarray:
        return steady if constant else mean + swing * sin(TORQUES["omega"] * t)

    data = _solved(model, [0.0] * 3, torque, np.linspace(0.0, a.time, 15), tolerance)
    return np.asarray(data.oMi[upper].act(np.array(a.second)))


def crank(tolerance: float) -> np.ndarray:
    """S1b: the crank angle at t = 1 ... 10 s; forces of the open chain, the angle of the rod from the loop by hand."""
    c = CRANK
    model = pin.Model()
    model.gravity.linear = np.array([0.0, -c.gravity, 0.0])
    arm = [(c.crank_density * c.crank, [0.0] * 3, [c.crank, 0.0, 0.0])]
    first = _joint(model, 0, pin.JointModelRZ(), [0.0] * 3, arm)
    end = [c.rod, 0.0, 0.0]
    _joint(model, first, pin.JointModelRZ(), [c.crank, 0.0, 0.0],
           [(c.rod_density * c.rod, [0.0] * 3, end), (c.slider, end, end)])  # fmt: skip
    data = model.createData()
    ratio, crba, rnea = c.crank / c.rod, pin.crba, pin.rnea
    q, J, bend = np.zeros(2), np.array([1.0, 0.0]), np.zeros(2)

    def rate(y: np.ndarray, t: float) -> tuple[float, float]:
        phi, w = y
        s = ratio * sin(phi)
        root = sqrt(1.0 - s * s)
        slope = -ratio * cos(phi) / root
        q[0], q[1] = phi, -asin(s) - phi
        J[1] = slope - 1.0
        bend[1] = s * (1.0 - slope * slope) / root * w * w
        bias = J @ rnea(model, data, q, J * w, bend)
        M = crba(model, data, q)
        mass = M[0, 0] + J[1] * (2.0 * M[0, 1] + J[1] * M[1, 1])
        return w, (c.torque - bias) / mass

    times = np.linspace(0.0, c.free_time, 11)
    return odeint(rate, [0.0, c.start], times, rtol=tolerance, atol=tolerance, mxstep=1000000)[1:, 0]
