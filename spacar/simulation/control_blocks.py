"""Continuous blocks of a controller: transfer function, integrator with limits, rate limiter, PID with anti-windup.

    transfer function  y = (b0 s^m + ... + bm) / (a0 s^n + ... + an) u, m <= n, in controller canonical form, from rest
    integrator         x' = gain u, y = x; with limits x stays at one of them as long as u drives it beyond
    rate limiter       y' = w (u - y) limited to [-falling, rising]: an actuator of bandwidth w [rad/s]
    PID                v = kp e + I + D,  I' = ki e + (y - v)/Tt,  D = kd N (e - xf), xf' = N (e - xf)
                       y = v limited to [lower, upper]

N is the bandwidth [rad/s] of the filter of the derivative. Anti-windup acts while y is not v: "back-calculation" (the
term with the tracking time Tt, Astrom and Hagglund, Advanced PID Control, 2006, section 3.5), "clamping" (I' = 0 while
ki e has the sign of the limit that is met) or "none". Tt is sqrt(kp/ki kd/kp) = sqrt(kd/ki) when not given, without
derivative kp/ki, and without proportional part 1/ki.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import Array, Index
from spacar.errors import UsageError
from spacar.simulation.blocks import Affine, Linear
from spacar.simulation.switching_blocks import Limited, Numbers, Piecewise, limits, spread

ANTI_WINDUP = ("back-calculation", "clamping", "none")


def canonical(name: str, numerator: Sequence[float], denominator: Sequence[float]) -> tuple[Array, Array, Array, Array]:
    """A, B, C, D of the controller canonical form; coefficients by falling powers of s or z. Raises UsageError."""
    a = np.trim_zeros(np.asarray(denominator, float).ravel(), "f")
    b = np.trim_zeros(np.asarray(numerator, float).ravel(), "f")
    if not len(a) or len(b) > len(a) or not np.isfinite([*a, *b]).all():
        text = (
            f"{name}: a transfer function needs a denominator that is not zero and of no lower degree than the"
            f" numerator, found {np.ravel(numerator).tolist()} over {np.ravel(denominator).tolist()}"
        )
        raise UsageError(text, "simulation.transfer-function")
    n = len(a) - 1
    b = np.concatenate((np.zeros(n + 1 - len(b)), b)) / a[0]
    a = a / a[0]
    A = np.zeros((n, n))
    if n:
        A[0], A[range(1, n), range(n - 1)] = -a[1:], 1.0
    return A, np.eye(n, 1), (b[1:] - b[0] * a[1:])[None, :], np.array([[b[0]]])


def transfer_function(name: str, numerator: Sequence[float], denominator: Sequence[float]) -> Linear:
    """One input, one output, coefficients by falling powers of s, from rest. Raises UsageError."""
    return Linear(name, *canonical(name, numerator, denominator))


class Integrator(Piecewise):
    """y = x, x' = gain u, x held at a limit as long as u drives it beyond."""

    def __init__(
        self, name: str, initial: Numbers = 0.0, gain: Numbers = 1.0, lower: Numbers = -np.inf,
        upper: Numbers = np.inf, size: int = 1,
    ) -> None:  # fmt: skip
        self.lower, self.upper = limits(name, lower, upper, size)
        super().__init__(name, size, int(np.isfinite([self.lower, self.upper]).any()))
        self.direct[:] = False
        self.gain, self.x0 = spread(name, "gains and initial values", "simulation.gain", size, gain, initial)
        if np.any((self.x0 < self.lower) | (self.x0 > self.upper)):
            raise UsageError(f"{name}: the initial value is not between the limits", "simulation.limits")

    def state_outputs(self, t: float, x: Array) -> Array:
        return self.capped(x)

    def derivative(self, t: float, x: Array, u: Array) -> Array:
        return np.where(self.mode == 0, self.gain * u, 0.0)

    def affine(self) -> Affine:
        zero, limit = np.zeros((self.n_out, self.n_out)), self.capped(0.0)
        return Affine(zero, self.free * self.gain, self.free, zero, np.zeros(self.n_out), limit)

    def events(self, t: float, x: Array, u: Array) -> Array:
        rate = self.gain * u
        free = np.minimum(np.maximum(self.upper - x, -rate), np.maximum(x - self.lower, rate))
        return np.where(self.mode == 0, free, self.mode * rate)

    def piece(self, t: float, x: Array, u: Array) -> Index:
        rate = self.gain * u
        at_upper, at_lower = (x >= self.upper) & (rate > 0.0), (x <= self.lower) & (rate < 0.0)
        return at_upper.astype(np.int64) - at_lower


class RateLimiter(Limited):
    """y' = bandwidth (u - y) limited to [-falling, rising]: it follows u with the time constant 1/bandwidth, but never
    faster than the limits [unit of u per s].
    """

    def __init__(
        self, name: str, rising: Numbers, falling: Numbers | None = None, bandwidth: float = 1000.0,
        initial: Numbers = 0.0, size: int = 1,
    ) -> None:  # fmt: skip
        super().__init__(name, -np.asarray(rising if falling is None else falling, float), rising, size)
        self.direct[:] = False
        if not (bandwidth > 0.0 and np.all(self.lower < 0.0) and np.all(self.upper > 0.0)):
            raise UsageError(f"{name}: the rates and the bandwidth must be positive", "simulation.limits")
        self.bandwidth = float(bandwidth)
        (self.x0,) = spread(name, "initial values", "simulation.size", size, initial)

    def state_outputs(self, t: float, x: Array) -> Array:
        return x.copy()

    def limited(self, x: Array, u: Array) -> Array:
        return self.bandwidth * (u - x)

    def derivative(self, t: float, x: Array, u: Array) -> Array:
        return self.capped(self.limited(x, u))

    def affine(self) -> Affine:
        one, zero, slope = np.eye(self.n_out), np.zeros((self.n_out, self.n_out)), self.bandwidth * self.free
        return Affine(-slope, slope, one, zero, self.capped(0.0), np.zeros(self.n_out))


class PID(Limited):
    """PID controller of errors e (size,) with a filtered derivative, limits and anti-windup; the formulas are above.

    kp, ki, kd      gains, one number or one for each signal [output/e, output/(e s), output s/e]
    filter          N [rad/s], needed with kd;  lower, upper: limits of the output
    tracking_time   Tt [s], for back-calculation
    """

    def __init__(
        self, name: str, kp: Numbers, ki: Numbers = 0.0, kd: Numbers = 0.0, *, filter: float | None = None,
        lower: Numbers = -np.inf, upper: Numbers = np.inf, anti_windup: str = "back-calculation",
        tracking_time: float | None = None, size: int = 1,
    ) -> None:  # fmt: skip
        self.kp, self.ki, self.kd = found = spread(name, "gains", "simulation.gain", size, kp, ki, kd)
        if not np.isfinite(found).all():
            raise UsageError(f"{name}: the gains must be finite", "simulation.gain")
        super().__init__(name, lower, upper, size)
        self.clamps = anti_windup == "clamping"
        self.n_events = (2 + self.clamps) * size * int(np.isfinite([self.lower, self.upper]).any())
        if self.kd.any() and (filter is None or not 0.0 < filter < np.inf):
            text = f"{name}: a derivative (kd) needs `filter`, the bandwidth of its filter in rad/s, positive"
            raise UsageError(text, "simulation.gain")
        self.N = float(filter or 0.0)
        self.tracking = tracking_rate(name, anti_windup, tracking_time, self.kp, self.ki, self.kd)
        self.direct[:] = np.any(self.kp != 0.0) or np.any(self.kd != 0.0)
        self.x0 = np.zeros(2 * size if self.kd.any() else size)
        self.start()

    def start(self) -> Array:
        self.held: NDArray[np.bool_] = np.zeros(self.n_out, bool)
        return super().start()

    def limited(self, x: Array, u: Array) -> Array:
        """v, the output without limits."""
        n = self.n_out
        v = self.kp * u + x[:n]
        return v + self.kd * self.N * (u - x[n:]) if self.kd.any() else v

    def outputs(self, t: float, x: Array, u: Array) -> Array:
        return self.capped(self.limited(x, u))

    def derivative(self, t: float, x: Array, u: Array) -> Array:
        v = self.limited(x, u)
        back = self.capped(v) - v
        rate = np.where(self.held, 0.0, self.ki * u) + self.tracking * back
        return np.concatenate((rate, self.N * (u - x[self.n_out :]))) if self.kd.any() else rate

    def affine(self) -> Affine:
        free, sharp = (self.mode == 0).astype(float), self.kd * self.N
        limit = self.capped(0.0)
        back = self.tracking * (1.0 - free)
        A, C = np.diag(-back), np.diag(free)
        B = np.diag(np.where(self.held, 0.0, self.ki) - back * (self.kp + sharp))
        a = back * limit
        if self.kd.any():
            filtered = self.N * np.eye(self.n_out)
            A = np.block([[A, np.diag(back * sharp)], [np.zeros_like(A), -filtered]])
            B, C, a = np.vstack((B, filtered)), np.hstack((C, np.diag(-free * sharp))), np.concatenate((a, 0.0 * a))
        return Affine(A, B, C, np.diag(free * (self.kp + sharp)), a, limit)

    def events(self, t: float, x: Array, u: Array) -> Array:
        margins = super().events(t, x, u)
        if not self.clamps:
            return margins
        push = self.mode * self.ki * u
        return np.concatenate((margins, np.where(self.held, push, -push)))

    def switch(self, t: float, x: Array, u: Array) -> bool:
        changed, held = super().switch(t, x, u), self.held
        if self.clamps:
            self.held = self.mode * self.ki * u > 0.0
        return changed or not np.array_equal(held, self.held)


def tracking_rate(name: str, method: str, given: float | None, kp: Array, ki: Array, kd: Array) -> Array:
    """1/Tt (size,) [1/s], zero when it is not used. Raises UsageError."""
    if method not in ANTI_WINDUP:
        text = f"{name}: anti_windup is one of {', '.join(ANTI_WINDUP)}, not {method}"
        raise UsageError(text, "simulation.anti-windup")
    if given is not None and not given > 0.0:
        raise UsageError(f"{name}: the tracking time must be positive, not {given:g}", "simulation.anti-windup")
    if method != "back-calculation" or not ki.any():
        return np.zeros(len(ki))
    if given is not None:
        return np.where(ki != 0.0, 1.0 / given, 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        rate = np.where(kd != 0.0, np.sqrt(np.abs(ki / kd)), np.where(kp != 0.0, np.abs(ki / kp), np.abs(ki)))
    return np.where(ki != 0.0, rate, 0.0)
