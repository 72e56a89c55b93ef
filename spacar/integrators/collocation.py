"""Coefficients of the Radau IIA methods of s stages: collocation at the right Radau points, order 2s - 1.

E. Hairer, G. Wanner, "Solving Ordinary Differential Equations II", 2nd ed., Springer 1996, sections IV.5 and IV.8.
c are the roots of P_s(2c - 1) - P_{s-1}(2c - 1), a_ij = int_0^{c_i} l_j with the Lagrange polynomials l_j of c;
b is the last row of a. For odd s the inverse of a has one real eigenvalue and (s - 1)/2 complex pairs, which split the
linear system of all stages into one real and (s - 1)/2 complex systems of the size of the state.

Error estimate (IV.8.18): embedded quadrature of order s at the points 0, c_1 ... c_s, with the weight 1/lambda_0 at 0.
Between the points the state follows the polynomial through 0, c_1 ... c_s. Where positions are integrals of velocities,
the integral of the polynomial of the velocities is one order better and meets the end of the step as well.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np


@dataclass(frozen=True)
class Collocation:
    """Radau IIA with Z_i = Y_i - y, i = 1 ... s.

    c (s,), a and its inverse (s, s); real: lambda_0; pairs: lambda_k, one of each complex pair
    to (s, s)    real: row 0 transforms to the real system, rows 1, 2 and 3, 4 ... are real and imaginary parts
    back (s, s)  the columns to go with them, so that back @ to = I
    error (s,)   e with error estimate (F(y) + sum e_i Z_i / h), to be filtered by (lambda_0 / h - J)^-1
    basis (s, s) row k: coefficients of s^{k+1} of the polynomial through 0, Z_1 ... Z_s
    largest      of |(s - c_1) ... (s - c_s)| and of |s (s - c_1) ... (s - c_s)| in the step
    """

    c: np.ndarray
    a: np.ndarray
    inverse: np.ndarray
    real: float
    pairs: tuple[complex, ...]
    to: np.ndarray
    back: np.ndarray
    error: np.ndarray
    basis: np.ndarray
    largest: tuple[float, float]


@cache
def radau(s: int) -> Collocation:
    """Radau IIA with an odd number s of stages."""
    from numpy.polynomial import legendre

    difference = np.zeros(s + 1)
    difference[s - 1 :] = -1.0, 1.0
    c = 0.5 * (1.0 + np.sort(legendre.legroots(difference).real))
    c[-1] = 1.0
    a = _integrals(c, c)
    inverse = np.linalg.inv(a)  # at most 5 x 5 and once
    values, vectors = np.linalg.eig(inverse)
    order = np.argsort(np.abs(values.imag))
    i0 = int(order[0])
    upper = [int(i) for i in order[1:] if values[i].imag > 0.0]
    left = np.linalg.inv(vectors)
    to, back = [left[i0].real], [vectors[:, i0].real]
    for i in upper:
        to += [left[i].real, left[i].imag]
        back += [2.0 * vectors[:, i].real, -2.0 * vectors[:, i].imag]
    real = float(values[i0].real)
    # Weights of the embedded quadrature: 1/lambda_0 at 0, order s with the others.
    powers = np.arange(s)
    moments = 1.0 / (powers + 1.0)
    moments[0] -= 1.0 / real
    embedded = np.linalg.solve(c[None, :] ** powers[:, None], moments)
    error = real * (embedded - a[-1]) @ inverse
    basis = np.linalg.inv(c[:, None] ** (powers[None, :] + 1.0))
    inside = np.linspace(0.0, 1.0, 201)
    product = np.prod(inside[:, None] - c, axis=1)
    largest = float(np.abs(product).max()), float(np.abs(inside * product).max())
    pairs = tuple(complex(values[i]) for i in upper)
    return Collocation(c, a, inverse, real, pairs, np.array(to), np.array(back).T, error, basis, largest)


def _integrals(c: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """int_0^end of the Lagrange polynomials of the points c, by Gauss quadrature, which is exact for them."""
    from numpy.polynomial.legendre import leggauss

    nodes, weights = leggauss(len(c))
    x = 0.5 * np.multiply.outer(ends, 1.0 + nodes)
    out = np.empty((len(ends), len(c)))
    for j, point in enumerate(c):
        others = np.delete(c, j)
        values = np.prod((x[:, :, None] - others) / (point - others), axis=2)
        out[:, j] = 0.5 * ends * (values @ weights)
    return out
