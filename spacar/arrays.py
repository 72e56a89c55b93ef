"""Types of arrays in annotations, and the rounding of their numbers."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]  # of float64; NumPy annotates some float results too widely
Index = NDArray[np.int64]
Complex = NDArray[np.complex128]
EPS = float(np.finfo(float).eps)
