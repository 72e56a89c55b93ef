"""What the iteration needs of a tangent, and how it gives up."""

from __future__ import annotations

from typing import Protocol

from spacar.arrays import Array
from spacar.stationary.stationary_equations import Iterate

# Displacement under forces of the size of the stiffness, 1/(50 eps), from which it is asked whether digits are left.
SINGULAR = 1e14
# Part of such a displacement, or size of a correction [model lengths or rad], that is rounding: the matrix is singular.
NO_DIGITS = 1e-4
SPREAD = 10.0  # largest effect of rounding errors over that of one sample of their signs, which are not known


class Tangent(Protocol):
    """The matrix of the corrections; unknowns x_F, then sigma / size."""

    @property
    def exact(self) -> bool: ...
    @property
    def symmetric(self) -> bool: ...
    def factor(self, point: Iterate) -> None: ...
    def solve(self, right: Array) -> Array: ...
    def along(self, dx: Array) -> Array: ...
    def dense(self) -> Array: ...
    def rounding(self, z: Array) -> Array:
        """eps |matrix| |z| of z (n,): by what rounding of the entries changes the product."""
    def sign(self) -> float:
        """Of the determinant of the tangent stiffness: -1 where the number of its negative eigenvalues is odd."""


class Astray(Exception):
    """The iteration does not converge, or not to a neighbouring state; the code of an error that says so, and what
    helps then."""

    def __init__(self, text: str, code: str = "statics.no-convergence", remedy: str = "a smaller load") -> None:
        super().__init__(text)
        self.code, self.remedy = code, remedy
