"""The error of a result in one number: max |v - v_ref| / amplitude over variables and output times.

The amplitude of a variable is its span over the output times, or its largest magnitude in the stationary modes and when
it hardly changes: span below CONSTANT of it, and below CONSTANT of the largest span or ROUNDED of it. So 1e-6 means: a
millionth of the motion of that variable, also where all that moves moves by 1e-9 m.
"""

import numpy as np

from spacar.arrays import Array

CONSTANT = 1e-6  # a variable whose span is a smaller part of its magnitude may be constant
ROUNDED = 1e6 * float(np.finfo(float).eps)  # a smaller span may be rounding, or left by iterations
STILL = 1e-9  # a variable that stays below this part of the largest one is left out
# The same for stationary solutions, which are iterated to 5e-7 (ITERSTEP): smaller values are errors of the iteration.
STILL_STATIONARY = 1e-6


def amplitudes(values: Array, stationary: bool) -> Array:
    """(variables,) amplitude of each variable of `values` (variables, times); inf for a variable that stays at zero, so
    that it does not count."""
    size = np.abs(values).max(axis=1)
    span = np.ptp(values, axis=1)
    moves = (span > CONSTANT * size) | (span > np.maximum(CONSTANT * span.max(initial=0.0), ROUNDED * size))
    scale = np.where(moves & (not stationary), span, size)
    still = STILL_STATIONARY if stationary else STILL
    return np.where(size > still * size.max(initial=0.0), scale, np.inf)


def distance(a: Array, b: Array, amplitude: Array) -> float:
    """max |a - b| / amplitude of two arrays (variables, times)."""
    return float(np.max(np.abs(a - b) / amplitude[:, None], initial=0.0))
