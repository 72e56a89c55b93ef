"""Blocks that act at sampling times only: hold, delay, linear system, transfer function in z, rate limiter, PID.

With T the period, k the number of the sampling time, and everything held in between (zero-order hold):

    zero-order hold    y_k = u_k                         unit delay   y_k = u_(k-1), y_0 given
    linear system      x_(k+1) = A x_k + B u_k, y_k = C x_k + D u_k
    transfer function  y = (b0 z^m + ... + bm) / (a0 z^n + ... + an) u, m <= n, from rest
    rate limiter       y_k = y_(k-1) + (u_k - y_(k-1) limited to [-falling T, rising T])
    PID                v_k = kp e_k + I_k + D_k, y_k = v_k limited, I_0 = D_(-1) = 0 and e_(-1) = e_0
                       D_k = (D_(k-1) + kd N (e_k - e_(k-1))) / (1 + N T)
                       I_(k+1) = I_k + T ki e_k + T/Tt (y_k - v_k)

The derivative is the backward difference of the filtered one of control_blocks, the integral the forward one; Tt and
the methods of anti-windup are those of control_blocks. A block whose output does not depend on the present input (a
delay, a linear system with D = 0) breaks an algebraic loop.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from spacar.arrays import Array
from spacar.errors import UsageError
from spacar.simulation.blocks import Sampled, fitting
from spacar.simulation.control_blocks import PID, canonical
from spacar.simulation.switching_blocks import Numbers, limits, spread


def zero_order_hold(name: str, period: float, size: int = 1, offset: float = 0.0) -> Sampled:
    """y_k = u_k."""
    return Sampled(name, lambda t, x, u: (x, u), period, size, size, offset=offset)


def unit_delay(name: str, period: float, size: int = 1, initial: Numbers = 0.0, offset: float = 0.0) -> Sampled:
    """y_k = u_(k-1), at first `initial`. Raises UsageError for another number of these."""
    (start,) = spread(name, "initial values", "simulation.size", size, initial)
    return Sampled(name, lambda t, x, u: (x, u), period, size, size, y0=start, offset=offset, delay=True)  # type: ignore[arg-type]


def sampled_linear(
    name: str, period: float, A: Any, B: Any, C: Any, D: Any = None, x0: Sequence[float] | None = None,
    offset: float = 0.0,
) -> Sampled:  # fmt: skip
    """x_(k+1) = A x_k + B u_k, y_k = C x_k + D u_k. Raises UsageError for shapes that do not fit."""
    A, B, C, D = fitting(name, A, B, C, D)
    n, m, p = len(A), B.shape[1], len(C)
    start = np.zeros(n) if x0 is None else np.asarray(x0, float)
    if start.shape != (n,):
        raise UsageError(f"{name}: {start.size} start values for {n} states", "simulation.size")
    if D.any():
        return Sampled(name, lambda t, x, u: (A @ x + B @ u, C @ x + D @ u), period, m, p, x0=start, offset=offset)

    def ahead(t: float, x: Array, u: Array) -> tuple[Array, Array]:
        new = A @ x + B @ u
        return new, C @ new

    y0 = (C @ start).tolist()
    return Sampled(name, ahead, period, m, p, x0=start, y0=y0, offset=offset, delay=True)


def sampled_transfer_function(
    name: str, period: float, numerator: Sequence[float], denominator: Sequence[float], offset: float = 0.0
) -> Sampled:
    """One input, one output, coefficients by falling powers of z, from rest. Raises UsageError."""
    return sampled_linear(name, period, *canonical(name, numerator, denominator), offset=offset)


def sampled_rate_limiter(
    name: str, period: float, rising: Numbers, falling: Numbers | None = None, initial: Numbers = 0.0, size: int = 1,
    offset: float = 0.0,
) -> Sampled:  # fmt: skip
    """The output changes by at most rising T upwards and falling T downwards at a sampling time; rates per second.

    Raises UsageError for rates that are not positive, or another number of rates or initial values.
    """
    down, up = limits(name, -np.asarray(rising if falling is None else falling, float), rising, size)
    if not (np.all(down < 0.0) and np.all(up > 0.0)):
        raise UsageError(f"{name}: the rates must be positive", "simulation.limits")
    (start,) = spread(name, "initial values", "simulation.size", size, initial)

    def follow(t: float, y: Array, u: Array) -> tuple[Array, Array]:
        new = y + np.clip(u - y, down * period, up * period)
        return new, new

    return Sampled(name, follow, period, size, size, x0=start, y0=start.tolist(), offset=offset)


def sampled_pid(
    name: str, period: float, kp: Numbers, ki: Numbers = 0.0, kd: Numbers = 0.0, *, filter: float | None = None,
    lower: Numbers = -np.inf, upper: Numbers = np.inf, anti_windup: str = "back-calculation",
    tracking_time: float | None = None, size: int = 1, offset: float = 0.0,
) -> Sampled:  # fmt: skip
    """PID controller of errors e (size,); arguments as of control_blocks.PID, formulas above. Raises UsageError."""
    of = PID(name, kp, ki, kd, filter=filter, lower=lower, upper=upper, anti_windup=anti_windup,
             tracking_time=tracking_time, size=size)  # fmt: skip

    def law(t: float, memory: tuple[Array, Array, Array | None], e: Array) -> tuple[tuple[Array, Array, Array], Array]:
        integral, slope, old = memory
        slope = (slope + of.kd * of.N * (e - (e if old is None else old))) / (1.0 + of.N * period)
        v = of.kp * e + integral + slope
        y = np.clip(v, of.lower, of.upper)
        held = of.clamps & ((v - y) * of.ki * e > 0.0)
        growth = np.where(held, 0.0, of.ki * e) + of.tracking * (y - v)
        return (integral + period * growth, slope, e), y

    zero = np.zeros(size)
    return Sampled(name, law, period, size, size, x0=(zero, zero.copy(), None), offset=offset)
