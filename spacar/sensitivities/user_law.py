"""The derivatives of a function of the user (USERSIG), which is a program of its own: by differences.

    df/du = (f(u - 2h) - 8 f(u - h) + 8 f(u + h) - f(u + 2h))/(12 h),     h = eps^(1/5) times the size of u

for every deformation and coordinate u: 4 (ne + nx) calls a stored step. The error is about eps^(4/5) = 3e-13 of f over
the size of u where the function is smooth; at a corner the result is the mean of both sides. The stiffness and damping
that the function states itself (its fourth and fifth column) are not used: they may be left out, or be approximate.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from spacar.arrays import Array
from spacar.mechanism.mechanism import Mechanism, UserForces

STEP_SHARE = float(np.finfo(float).eps) ** 0.2


class UserLawDerivatives(NamedTuple):
    """Of the stresses sigma (ne,) of active rows and the forces f (nx,) at rest, by e and by x."""

    sigma_e: Array  # (ne, ne)
    sigma_x: Array  # (ne, nx)
    force_e: Array  # (nx, ne)
    force_x: Array  # (nx, nx)

    def along(self, de: Array, dx: Array) -> tuple[Array, Array]:
        """Changes of sigma and f with changes of e (ne,) and x (nx,)."""
        return self.sigma_e @ de + self.sigma_x @ dx, self.force_e @ de + self.force_x @ dx


def user_law_derivatives(mechanism: Mechanism, e: Array, x: Array, active: Array) -> UserLawDerivatives:
    """At the deformations e (ne,) and coordinates x (nx,) of a state at rest; `active` (ne,): rows on which its stress
    acts. Raises AnalysisError where the function fails."""
    law = mechanism.user_signal
    assert law is not None
    still = np.zeros(len(e)), np.zeros(len(x))

    def answer(u: Array) -> Array:
        found: UserForces = law(0.0, u[: len(e)], still[0], u[len(e) :], still[1])
        return np.concatenate((found.sigma * active, found.force))

    at = np.concatenate((e, x))
    size = np.maximum(np.abs(at), np.concatenate((mechanism.deformation_scale, mechanism.scale)))
    J = np.zeros((len(at), len(at)))
    for k, h in enumerate(STEP_SHARE * size):
        total = np.zeros(len(at))
        for steps, weight in ((-2, 1.0), (-1, -8.0), (1, 8.0), (2, -1.0)):
            u = at.copy()
            u[k] += steps * h
            total += weight * answer(u)
        J[:, k] = total / (12.0 * h)
    n = len(e)
    return UserLawDerivatives(J[:n, :n], J[:n, n:], J[n:, :n], J[n:, n:])
