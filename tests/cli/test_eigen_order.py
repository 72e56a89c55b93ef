"""`spacar eigen` shows physical modes by rising frequency, zero modes last, with the numbers of `spacar visual -m`."""

import numpy as np
from spacar_formats.vibration import mode_numbers, shown_order


def test_order_and_numbers():
    """1 mrad/s beside 10 000 rad/s is a mode of its own: sqrt(n eps) of the largest is 0.3 mrad/s."""
    values = np.array([50j, -50j, 3e-9j, -3e-9j, -1 + 5j, -1 - 5j, 2.0, -2.0])
    order = shown_order(values)
    assert [complex(values[i]) for i in order[:6]] == [2.0, -2.0, -1 + 5j, -1 - 5j, 50j, -50j]
    assert mode_numbers(values, order) == [1, 2, 3, 3, 4, 4, 5, 5]
    values = np.array([1e4j, -1e4j, 1e-3j, -1e-3j])
    assert [abs(values[i]) for i in shown_order(values)] == [1e-3, 1e-3, 1e4, 1e4]
