"""Angles of numbers that may carry a complex step; planar and spatial elements."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


def arc_tangent(y: NDArray[Any], x: NDArray[Any]) -> NDArray[Any]:
    """atan2(y, x); of complex arguments the first order continuation that a complex step needs."""
    if not (np.iscomplexobj(x) or np.iscomplexobj(y)):
        return np.arctan2(y, x)
    slope = (x.real * y.imag - y.real * x.imag) / (x.real**2 + y.real**2)
    return np.arctan2(y.real, x.real) + 1j * slope
