"""Natural frequencies of the eigenvalues that results store."""

from typing import Any

import numpy as np
from numpy.typing import NDArray


def frequency_order(values: NDArray[Any]) -> NDArray[np.int64]:
    """Places of the eigenvalues (n,), complex, that have a frequency of their own, from low to high: of a pair of
    complex ones the one with the positive imaginary part; real ones do not come in pairs."""
    own = np.flatnonzero(values.imag >= 0.0)
    return np.asarray(own[np.argsort(np.abs(values[own]), kind="stable")])


def frequencies(every: NDArray[Any]) -> NDArray[np.float64]:
    """(steps, n) |eigenvalue| / 2 pi [Hz] from low to high of stored eigenvalues (steps, m, 2); nan fills up steps
    with fewer."""
    rows = []
    for pair in every:
        values = pair[:, 0] + 1j * pair[:, 1]
        rows.append(np.abs(values[frequency_order(values)]) / (2.0 * np.pi))
    longest = max(map(len, rows))
    return np.array([np.pad(row, (0, longest - len(row)), constant_values=np.nan) for row in rows])
