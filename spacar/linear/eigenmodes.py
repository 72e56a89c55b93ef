"""The record of eigenvalues and state eigenvectors, and their order: that of `spacar.linear.eigen`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class Modes:
    """values (n,), vectors (n_state, n): eigenvalues [rad/s] and state eigenvectors; n_positions rows are positions.

    motions (nx, n): displacements of the coordinates, where they are computed without transfer functions.
    """

    values: Complex
    vectors: Complex
    n_positions: int
    motions: Complex | None = None

    def lowest(self, pairs: int) -> Modes:
        """The last `pairs` pairs, conjugates never divided."""
        first = max(len(self.values) - 2 * pairs, 0)
        if first and self.values[first].imag < 0.0 and self.values[first - 1] == self.values[first].conj():
            first -= 1
        return Modes(self.values[first:], self.vectors[:, first:], self.n_positions)

    @property
    def zero(self) -> NDArray[np.bool_]:
        """Eigenvalues that are zero to working precision: below sqrt(eps) times the largest."""
        return is_zero(self.values)


def is_zero(values: Complex) -> NDArray[np.bool_]:
    """Below sqrt(eps) times the largest modulus: a multiple zero eigenvalue cannot be computed more accurately."""
    largest = float(np.max(np.abs(values), initial=0.0))
    return np.asarray(np.abs(values) <= np.sqrt(np.finfo(float).eps) * largest)


def arranged(values: Complex, vectors: Complex, n_positions: int, motions: Complex | None = None) -> Modes:
    """Norm 1, real largest position component, decreasing modulus, conjugates together; motions (nx, n) alike. What
    belongs to values that are nan is nan."""
    size = np.linalg.norm(vectors, axis=0)
    vectors = vectors / size
    motions = motions / size if motions is not None else None
    if n_positions:
        largest = np.argmax(np.abs(vectors[:n_positions]), axis=0)
        pivot = vectors[largest, np.arange(len(values))]
        phase = np.where(pivot != 0.0, np.abs(pivot) / np.where(pivot != 0.0, pivot, 1.0), 1.0)
        vectors = vectors * phase
        motions = motions * phase if motions is not None else None
    unknown = np.isnan(values)
    if unknown.any():
        vectors[:, unknown] = np.nan
        if motions is not None:
            motions[:, unknown] = np.nan
    modulus = np.abs(values)
    # conjugates have equal moduli up to rounding: compare with fewer digits, then by imaginary part
    size = 10.0 ** np.floor(np.log10(np.where(modulus > 0.0, modulus, 1.0)))
    rounded = np.round(modulus / size, 10) * size
    order = np.lexsort((-values.imag, -np.abs(values.imag), -rounded))
    return Modes(values[order], vectors[:, order], n_positions, motions[:, order] if motions is not None else None)
