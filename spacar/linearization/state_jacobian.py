"""Jacobian of the equations of motion for the implicit integrators: the exact state matrix, dense or sparse, and dF/dt.

dF/dy = A at the current accelerations (theory-system.md (15)). F depends on time through prescribed motion and user
functions only; dF/dt is zero without them. It is a forward difference of order 4, as F may jump where a step begins.
Its steps are eps^(1/5) of the output interval: errors of the formula and of rounding are both near eps^(4/5) of F.
"""

from typing import Any

import numpy as np

from spacar.arrays import EPS, Array
from spacar.dynamics.evaluator import Evaluator
from spacar.dynamics.loaded_mechanism import LoadedMechanism
from spacar.kinematics.kinematics import CONVERGED
from spacar.linearization.coefficients import coefficients
from spacar.linearization.matrices import chosen_rows, linearize, state_matrix
from spacar.linearization.sparse_linearization import SparseLinearization
from spacar.mechanism.mechanism import Polynomial

# Degrees of freedom above which the sparse form is used. With a Jacobian a step (310 to 430) it costs less from 170 to
# 220 on, with few of them and the iteration in C (553, 595) from 300 to 450 on; chains and frames, plane and space.
LARGE = 300
FORWARD = np.array((-25.0, 48.0, -36.0, 16.0, -3.0)) / 12.0  # weights of F at t, t + h, ..., of the order 4


def state_jacobian(evaluator: Evaluator, t: float, y: Array, within: float = CONVERGED) -> tuple[Any, Array]:
    """dF/dy (n, n), of more than LARGE degrees of freedom its sparse form, and dF/dt (n,) at the time t [s] and state
    y (n,); `within` as for `Evaluator.rhs`."""
    F_t = np.zeros(len(y))
    if depends_on_time(evaluator.model):
        settings = evaluator.model.mechanism.settings
        interval = (settings.duration or 1.0) / max(settings.n_steps, 1)
        h = EPS**0.2 * interval
        F_t = sum(w * evaluator.rhs(t + k * h, y, within) for k, w in enumerate(FORWARD)) / h
    dynamics = evaluator.numpy_evaluator()
    found = dynamics.accelerate(t, dynamics.place(t, y, within))
    if dynamics.numbering.nddof > LARGE:
        return SparseLinearization(dynamics, (), ()).once(coefficients(dynamics, found.xdd, found.sigma, t=t)), F_t
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
