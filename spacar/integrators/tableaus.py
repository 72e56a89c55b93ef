"""Coefficients of the explicit Runge-Kutta codes 130, 135, 140 and 155 (853 has its own module, dop853.py).

Sources: P. Bogacki, L. F. Shampine, Appl. Math. Letters 2 (1989) 321 (130, 135); W. Kutta, Z. Math. Phys. 46 (1901) 435
(140); J. R. Dormand, P. J. Prince, J. Comput. Appl. Math. 6 (1980) 19 (155) with the continuous extension of E. Hairer,
S. P. Norsett, G. Wanner, "Solving Ordinary Differential Equations I", Springer 1993, section II.6.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np


@dataclass(frozen=True)
class Tableau:
    """c (s,), A (s, s) strictly lower triangular, b (s,) and the error weights b - b_embedded.

    `error`, shape (s + 1,), includes F at the step end as last stage; `controller` is (exponent denominator, smallest,
    largest factor of the step). `dense`, shape (s + 1,), is the quartic term of the continuous extension of 155.
    """

    c: np.ndarray
    a: np.ndarray
    b: np.ndarray
    error: np.ndarray | None = None
    controller: tuple[float, float, float] = (3.0, 0.2, 5.0)
    dense: np.ndarray | None = None

    @cached_property
    def evaluated(self) -> tuple[np.ndarray, np.ndarray]:
        """c and A with F at the step end as a last stage."""
        s = len(self.c)
        matrix = np.zeros((s + 1, s + 1))
        matrix[:s, :s], matrix[s, :s] = self.a, self.b
        return np.append(self.c, 1.0), matrix


def _lower(*rows: list[float]) -> np.ndarray:
    a = np.zeros((len(rows) + 1, len(rows) + 1))
    for i, row in enumerate(rows, 1):
        a[i, : len(row)] = row
    return a


_B3 = np.array([2 / 9, 1 / 3, 4 / 9])
BOGACKI_SHAMPINE = Tableau(
    c=np.array([0.0, 1 / 2, 3 / 4]), a=_lower([1 / 2], [0.0, 3 / 4]), b=_B3,
    error=np.append(_B3, 0.0) - np.array([7 / 24, 1 / 4, 1 / 3, 1 / 8]),
)

KUTTA = Tableau(
    c=np.array([0.0, 1 / 2, 1 / 2, 1.0]), a=_lower([1 / 2], [0.0, 1 / 2], [0.0, 0.0, 1.0]),
    b=np.array([1 / 6, 1 / 3, 1 / 3, 1 / 6]),
)

_B5 = np.array([35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84])
DORMAND_PRINCE = Tableau(
    c=np.array([0.0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0]),
    a=_lower(
        [1 / 5], [3 / 40, 9 / 40], [44 / 45, -56 / 15, 32 / 9],
        [19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729],
        [9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656],
    ),
    b=_B5,
    error=np.append(_B5, 0.0)
    - np.array([5179 / 57600, 0.0, 7571 / 16695, 393 / 640, -92097 / 339200, 187 / 2100, 1 / 40]),
    controller=(5.0, 0.2, 10.0),
    dense=np.array(
        [
            -12715105075 / 11282082432, 0.0, 87487479700 / 32700410799, -10690763975 / 1880347072,
            701980252875 / 199316789632, -1453857185 / 822651844, 69997945 / 29380423,
        ]
    ),
)
