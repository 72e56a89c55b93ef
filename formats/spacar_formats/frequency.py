"""Frequency response C (j omega - A)^-1 B + D of a step of an `.ltv` result; of a large model by
`spacar.linearization.sparse_response`."""

import numpy as np

from spacar.errors import Report
from spacar.linear.lowest import WANTED, lowest_modes
from spacar.linearization.sparse_response import response
from spacar_formats.getss import SparseStep, StateSpaceStep


def frequency_response(system: StateSpaceStep | SparseStep, omega: np.ndarray) -> np.ndarray:
    """(len(omega), outputs, inputs) complex; infinite where j omega is an eigenvalue. omega [rad/s]."""
    if isinstance(system, SparseStep):
        return response(system.system, omega)
    n = len(system.A)
    out = np.empty((len(omega), len(system.C), system.B.shape[1]), complex)
    for k, w in enumerate(omega):
        try:
            out[k] = system.C @ np.linalg.solve(1j * w * np.eye(n) - system.A, system.B) + system.feedthrough
        except np.linalg.LinAlgError:
            out[k] = np.inf
    return out


def frequencies(system: StateSpaceStep | SparseStep, low: float | None, high: float | None, points: int) -> np.ndarray:
    """Angular frequencies [rad/s]: a decade around the non-zero eigenvalues, denser at lightly damped ones.

    Of a large model the 20 lowest eigenvalues, and no decade beyond them.
    """
    beyond = 10.0
    if isinstance(system, SparseStep):
        n, beyond = system.system.n_states, 1.0
        poles = lowest_modes(system.system, n // 2, 0, Report(), min(WANTED, n // 2)).values
        poles = poles[~np.isnan(poles)]
    else:
        poles = np.linalg.eigvals(system.A)
    size = np.abs(poles)
    size = size[size > 1e-6 * size.max(initial=0.0)]
    low = low if low is not None else (0.1 * float(size.min()) if len(size) else 0.1)
    high = high if high is not None else (beyond * float(size.max()) if len(size) else 100.0)
    grid = [np.geomspace(low, max(high, low * (1 + 1e-9)), points)]
    for pole in poles[poles.imag > 0.0]:
        width = max(abs(pole.real) / abs(pole), 1e-4)
        near = pole.imag * (1.0 + width * np.linspace(-6.0, 6.0, 25))
        grid.append(near[(near > low) & (near < high)])
    return np.unique(np.concatenate(grid))
