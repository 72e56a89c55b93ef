"""Planar rods by shooting: an independent truth for large deflections, with extension, shear and distributed loads.

Clamped along x at s = 0; at s the internal force F(s) = tip force + q (L - s) (dead loads), with the tangent t at the
angle theta and its normal n:

    r' = (1 + F.t/EA) t + (F.n/GAk) n,   theta' = kappa0 + M/EI,   M' = -(r' x F),   M(L) = 0

`line`: an inextensible line (Engesser), r' = (cos, sin)(theta + gamma) with gamma = F.n(theta + gamma)/GAk.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import root_scalar


def cantilever_tip(
    force: tuple[float, float],
    *,
    L: float = 1.0,
    EI: float = 1.0,
    EA: float = np.inf,
    GAk: float = np.inf,
    q: tuple[float, float] = (0.0, 0.0),
    kappa0: float = 0.0,
    line: bool = False,
) -> NDArray[np.float64]:
    """x, y, theta of the free end, to about 1e-12 L."""
    tip, load = np.array(force), np.array(q)

    def slope(s: float, z: NDArray[np.float64]) -> list[float]:
        F = tip + load * (L - s)
        c, n = np.cos(z[2]), np.sin(z[2])
        stretch, shear = 1.0 + (F[0] * c + F[1] * n) / EA, (-F[0] * n + F[1] * c) / GAk
        dx, dy = stretch * c - shear * n, stretch * n + shear * c
        if line:
            gamma = 0.0
            for _ in range(40):  # contracts with |F|/GAk
                a = z[2] + gamma
                gamma = (-F[0] * np.sin(a) + F[1] * np.cos(a)) / GAk
            dx, dy = np.cos(z[2] + gamma), np.sin(z[2] + gamma)
        return [dx, dy, kappa0 + z[3] / EI, -(dx * F[1] - dy * F[0])]

    def end(moment: float) -> NDArray[np.float64]:
        run = solve_ivp(slope, (0.0, L), [0.0, 0.0, 0.0, moment], method="DOP853", rtol=1e-13, atol=1e-14 * L)
        return np.asarray(run.y[:, -1])

    guess = L * tip[1] + load[1] * L * L / 2
    found = root_scalar(lambda m: end(m)[3], x0=0.5 * guess, x1=0.6 * guess, xtol=1e-14 * max(abs(guess), 1.0))
    return end(found.root)[:3]
