"""Jacobian of the equations of motion for the implicit integrators: the exact state matrix, and dF/dt.

dF/dy = A at the current accelerations (theory-system.md (15)). F depends on time through prescribed motion and user
functions only; dF/dt is zero without them. It is a forward difference of order 4, as F may jump where a step begins.
Its steps are eps^(1/5) of the output interval: errors of the formula and of rounding are both near eps^(4/5) of F.
"""

from __future__ import annotations

import numpy as np

from spacar.arrays import Array
from spacar.dynamics.evaluator import Evaluator
from spacar.dynamics.loaded_mechanism import LoadedMechanism
from spacar.kinematics.kinematics import CONVERGED
from spacar.linearization.matrices import chosen_rows, linearize, state_matrix
from spacar.mechanism.mechanism import Polynomial

FORWARD = np.array((-25.0, 48.0, -36.0, 16.0, -3.0)) / 12.0  # weights of F at t, t + h, ..., of the order 4


def state_jacobian(
    evaluator: Evaluator, t: float, y: Array, within: float = CONVERGED
) -> tuple[Array, Array]:
    """dF/dy (n, n) and dF/dt (n,) at the time t [s] and state y (n,); `within` as for `Evaluator.rhs`."""
    F_t = np.zeros(len(y))
    if depends_on_time(evaluator.model):
        settings = evaluator.model.mechanism.settings
        interval = (settings.duration or 1.0) / max(settings.n_steps, 1)
        h = np.finfo(float).eps ** 0.2 * interval
        F_t = sum(w * evaluator.rhs(t + k * h, y, within) for k, w in enumerate(FORWARD)) / h
    dynamics = evaluator.numpy_evaluator()
    found = dynamics.accelerate(t, dynamics.place(t, y, within))
    L = linearize(dynamics, found.xdd, found.sigma, t=t)
    return state_matrix(L, *chosen_rows(dynamics.numbering)), F_t


def depends_on_time(model: LoadedMechanism) -> bool:
    """Does F depend on time explicitly?"""
    if model.mechanism.user_signal is not None:
        return True
    if not len(model.mechanism.numbering.rheonomic):
        return False
    drive = model.drive
    return not (isinstance(drive, Polynomial) and not drive.x[:, 1:].any() and not drive.e[:, 1:].any())
