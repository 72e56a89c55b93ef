"""The error of a result in one number: max |v - v_ref| / amplitude over variables and output times.

The amplitude of a variable is its span over the output times, or its largest magnitude when it hardly changes (span
below 1e-6 of it) and in the stationary modes. So 1e-6 means: a millionth of the motion of that variable.
"""

from __future__ import annotations

import numpy as np

from spacar.arrays import Array

CONSTANT = 1e-6  # a variable whose span is a smaller part of its magnitude is compared with the magnitude
STILL = 1e-9  # a variable that stays below this part of the largest one is left out
# The same for stationary solutions, which are iterated to 5e-7 (ITERSTEP): smaller values are errors of the iteration.
STILL_STATIONARY = 1e-6


def amplitudes(values: Array, stationary: bool) -> Array:
    """(variables,) amplitude of each variable of `values` (variables, times); inf for a variable that stays at zero, so
    that it does not count."""
    size = np.abs(values).max(axis=1)
    span = np.ptp(values, axis=1)
    scale = np.where((span > CONSTANT * size) & (not stationary), span, size)
    still = STILL_STATIONARY if stationary else STILL
    return np.where(size > still * size.max(initial=0.0), scale, np.inf)


def distance(a: Array, b: Array, amplitude: Array) -> float:
    """max |a - b| / amplitude of two arrays (variables, times)."""
    return float(np.max(np.abs(a - b) / amplitude[:, None], initial=0.0))
