"""Lowest eigenvalues of a descriptor system (theory-system.md 5.7), by Arnoldi's method with one sparse factorization.

With the real shift s > 0, on the far side of zero so that rigid motions do no harm, z of E dz/dt = A z belongs to

    op z = the state part of (A - s E)^-1 (z, 0),      theta = 1/(lambda - s)

s is a tenth of the wanted modulus within a factor of ten. Positions are multiplied by the
wanted modulus, so that both halves of the state compare. Doubtful pairs: `spacar.linear.lowest`.
"""

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import Array
from spacar.errors import AnalysisError, Report
from spacar.linear.eigenmodes import Modes, arranged
from spacar.linear.lowest import eigenvalues_of
from spacar.linear.subspace import SPARE, with_shift
from spacar.linearization.descriptor import MASSLESS, DescriptorSystem

SHIFT = 0.1  # of the modulus of the highest wanted eigenvalue


def lowest_modes(system: DescriptorSystem, n_positions: int, nx: int, report: Report, wanted: int) -> Modes:
    """The 2 `wanted` eigenvalues of smallest modulus with the motions of the coordinates (nx, 2 wanted). An eigenvalue
    whose conjugate would be the next one is nan.

    n_positions   rows of the state that are positions

    Raises AnalysisError where the accelerations are not unique.
    """
    n = system.n_states
    count = min(2 * wanted, n)
    start = np.random.default_rng(1).standard_normal((n, min(count + SPARE, n)))

    def better(theta: NDArray[np.complex128], shift: float) -> float:
        modulus = np.max(np.abs(shift + 1.0 / np.where(theta != 0.0, theta, 1e-300)))
        return max(SHIFT * float(modulus), 1e-12)

    _, inverse = with_shift(lambda s: _Inverse(system, n_positions, s), 1.0, better, start, count, n)
    values, z = eigenvalues_of(inverse, inverse.shift, start, count, n, report)
    motions = inverse.motions(z, nx)
    z[:n_positions] /= inverse.size
    return arranged(values, z, n_positions, motions)


class _Inverse:
    """The operator op of the module, for states with their positions multiplied by `size`."""

    def __init__(self, system: DescriptorSystem, n_positions: int, shift: float) -> None:
        from spacar.linear_systems.sparse_factors import SparseFactors

        self.system, self.shift, self.size = system, shift, shift / SHIFT
        self.scale = np.ones(system.n_states)
        self.scale[:n_positions] = self.size
        try:
            self.factors = SparseFactors(system.shifted(shift))
        except RuntimeError:
            raise AnalysisError(MASSLESS, "dynamics.singular-mass") from None

    def everything(self, z: Array) -> Array:
        """All unknowns of (A - s E)^-1 (z, 0)."""
        right = np.zeros((self.system.A.shape[0], z.shape[1]))
        right[: len(z)] = z / self.scale[:, None]
        return np.asarray(self.factors.solve(right))

    def __call__(self, z: Array) -> Array:
        return self.scale[:, None] * self.everything(z)[: len(z)]

    def motions(self, z: NDArray[np.complex128], nx: int) -> NDArray[np.complex128]:
        """dx (nx, k) of the vectors z (scaled) with op z = theta z, norm of z without the scale kept."""
        n = self.system.n_states
        image = self.everything(z.real) + 1j * self.everything(z.imag)
        factor = np.sum((image[:n] * self.scale[:, None]) * z.conj(), axis=0) / np.sum(np.abs(z) ** 2, axis=0)
        return np.asarray(image[n + nx : n + 2 * nx] / factor)
