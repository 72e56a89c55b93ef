"""Feedback for manipulators: gains folded into a linear system, and the computed torque law (theory-system.md 7.5).

Feedback du = -K_P de_a - K_D ded_a of the actuated coordinates e_a = E_a^T q, with E_a the generalized forces of unit
nominal inputs, adds E_a K_P E_a^T to the stiffness and E_a K_D E_a^T to the damping; A changes accordingly, B does not.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from spacar.arrays import Array
from spacar.errors import AnalysisError, UsageError
from spacar.simulation.propagation import disturbance
from spacar.simulation.signal_sources import Table
from spacar.simulation.time_varying import TimeVarying


def with_gain(data: TimeVarying, kp: Array, kd: Array | None = None) -> TimeVarying:
    """The system with feedback of its actuated coordinates.

    kp, kd    (n_nominal, n_nominal), or (k, n_nominal, n_nominal) one for every stored time

    Raises UsageError for another shape, gains that are not finite, or a system without nominal inputs.
    """
    A, m0, c0b, k0b = data.need("A", "m0", "c0b", "k0b")
    count, n = data.n_nominal, m0.shape[1]
    if not count:
        raise UsageError(f"{data.name} has no nominal inputs (NOMS, NOMF) to feed back to", "simulation.missing")
    E = data.distribution[:, :, :count]
    kp = _gains(kp, len(data.t), count, "K_P")
    kd = np.zeros_like(kp) if kd is None else _gains(kd, len(data.t), count, "K_D")
    stiffness = E @ kp @ np.swapaxes(E, 1, 2)
    # d(e_a)/dt = E^T qd: the change of the directions, E'^T q, is small of second order.
    damping = E @ kd @ np.swapaxes(E, 1, 2)
    changed = A.copy()
    changed[:, n:, :n] -= np.linalg.solve(m0, stiffness)
    changed[:, n:, n:] -= np.linalg.solve(m0, damping)
    return replace(data, A=changed, k0b=k0b + stiffness, c0b=c0b + damping)


def _gains(K: Array, steps: int, count: int, what: str) -> Array:
    table = np.asarray(K, float)
    if table.shape not in ((count, count), (steps, count, count)):
        every = (steps, count, count)
        text = f"{what} has the shape {table.shape}; expected {(count, count)}, or {every} with one for every step"
        raise UsageError(text, "simulation.gain")
    if not np.isfinite(table).all():
        raise UsageError(f"{what} has entries that are not finite", "simulation.gain")
    return np.array(np.broadcast_to(table, (steps, count, count)))


def static_start(data: TimeVarying) -> TimeVarying:
    """The system with the initial state that is the answer to sigma0 at the first time, at rest.

    Raises UsageError without sigma0, AnalysisError when A is singular (add a gain first).
    """
    A, B, _ = data.need("A", "B", "sigma0")
    try:
        z = np.linalg.solve(A[0], -B[0] @ disturbance(data)[0])
    except np.linalg.LinAlgError:
        text = "the stiffness at the first time is singular: there is no static answer; fold in a gain first (spacntrl)"
        raise AnalysisError(text, "simulation.no-static-start") from None
    return replace(data, x0=z)


def tracking_gains(data: TimeVarying, omega: float, damping: float) -> tuple[Array, Array]:
    """K_P = omega^2 M_a and K_D = 2 damping omega M_a, (k, n_nominal, n_nominal) each.

    M_a is the mass matrix of the actuated coordinates with all other degrees of freedom at rest.
    omega > 0 [rad/s], damping >= 0 [1].
    """
    if not (omega > 0.0 and damping >= 0.0):
        raise UsageError("omega must be positive and the damping not negative", "simulation.gain")
    (m0,) = data.need("m0")
    back = np.linalg.pinv(data.distribution[:, :, : data.n_nominal])
    mass = back @ m0 @ np.swapaxes(back, 1, 2)
    return omega**2 * mass, 2.0 * damping * omega * mass


def computed_torque(
    nominal: TimeVarying, linear: TimeVarying, omega: float, damping: float, *, positions: Sequence[int],
    rates: Sequence[int], interpolation: str = "linear", hold: bool = False,
) -> Callable[[float, Array], Array]:  # fmt: skip
    """The control law u = u0 + M0 (omega^2 (e0 - e) + 2 damping omega (ed0 - ed)) as a function (t, y) -> u.

    nominal   mode 2 result with u0 and y0;  linear: mode 3 result with M0 (its leading block is used)
    positions, rates   numbers (from 1) of the outputs that are the actuated coordinates and their rates, in y and y0
              alike
    omega [rad/s], damping [1]; interpolation, hold: of Table

    Raises UsageError for numbers of outputs that do not fit or data that are not stored.
    """
    u0, y0 = nominal.need("u0", "y0")
    (m0,) = linear.need("m0")
    n = u0.shape[1]
    if len(positions) != n or len(rates) != n:
        text = f"{n} inputs need {n} positions and {n} rates, not {len(positions)} and {len(rates)}"
        raise UsageError(text, "simulation.size")
    p, r = np.array(positions) - 1, np.array(rates) - 1
    if min(*p, *r) < 0 or max(*p, *r) >= y0.shape[1]:
        raise UsageError(f"the outputs of {nominal.name} are 1 to {y0.shape[1]}", "simulation.size")
    feedforward = Table(nominal.t, u0, interpolation, hold, f"u0 of {nominal.name}")
    reference = Table(nominal.t, y0, interpolation, hold, f"y0 of {nominal.name}")
    mass = Table(linear.t, m0[:, :n, :n], "linear" if interpolation == "spline" else interpolation, hold, "M0")

    def law(t: float, y: Array) -> Array:
        y0 = reference(t)
        return feedforward(t) + mass(t) @ (omega**2 * (y0[p] - y[p]) + 2.0 * damping * omega * (y0[r] - y[r]))

    law.breaks = tuple(sorted({*feedforward.breaks, *reference.breaks, *mass.breaks}))  # type: ignore[attr-defined]
    return law
