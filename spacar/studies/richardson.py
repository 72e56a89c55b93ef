"""Richardson's extrapolation over meshes with n, 2n and 4n elements a beam.

For an error c h^p + d h^(p+2) + ... two steps of extrapolation are made, with the factors 2^p and 2^(p+2) (Romberg).
The order is observed, 2^p = |u_n - u_2n| / |u_2n - u_4n| in the norm of the study, and taken as 2 or 4, the orders of
beams of this kind, if it is close to one of them. The error estimate is the last step of the extrapolation, the
difference between one step and two: an upper estimate while the expansion holds. Otherwise the finest mesh is taken
with the last difference as error. `extrapolate_rows` looks at every variable by itself, since one model has quantities
of both orders; what an accidental order could gain is bounded by GAINED.

Four meshes give two extrapolated values. Where both show the same order it is no accident, and their difference, the
error of the first one, is an upper estimate too; what it could gain is bounded by the square of GAINED.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from spacar.arrays import Array

ORDERS = (2, 4)
CLOSE = 0.6  # between observed and theoretical order
ROUNDING = 1e-13  # differences below cannot tell an order
GAINED = 0.02  # error of an extrapolated variable over the last difference, at least


@dataclass(frozen=True)
class Extrapolation:
    """Values, estimated error (in the norm of the study), observed order (nan when there is none) and how, in words."""

    values: Array
    error: float
    order: float
    text: str


def extrapolate(coarse: Array, middle: Array, fine: Array, amplitude: Array) -> Extrapolation:
    """Values of n, 2n, 4n elements, each (variables, steps); amplitude (variables,) scales the norm."""

    def norm(v: Array) -> float:
        return float(np.max(np.abs(v) / amplitude[:, None], initial=0.0))

    first, second = norm(coarse - middle), norm(middle - fine)
    if second <= ROUNDING:
        return Extrapolation(fine, second, float("nan"), f"which differ by {second:.2e}")
    order = float(np.log2(max(first, 1e-300) / second))
    p = min(ORDERS, key=lambda k: abs(k - order))
    if abs(p - order) > CLOSE:
        return Extrapolation(
            fine, second, order, f"not extrapolated (observed order {order:.2f}), the last two differ by {second:.2e}"
        )
    once = [(2**p * b - a) / (2**p - 1) for a, b in ((coarse, middle), (middle, fine))]
    q = 2 ** (p + 2)
    twice = (q * once[1] - once[0]) / (q - 1)
    error = norm(twice - once[1])
    return Extrapolation(
        twice, error, order, f"extrapolated with order {p} (observed {order:.2f}), estimated error {error:.2e}"
    )


@dataclass(frozen=True)
class ExtrapolatedRows:
    """values (variables, steps), errors (variables,) in amplitudes, order (variables,) that was used: 0, 2 or 4."""

    values: Array
    errors: Array
    order: Array


def extrapolate_rows(
    coarse: Array, middle: Array, fine: Array, amplitude: Array, before: ExtrapolatedRows | None = None
) -> ExtrapolatedRows:
    """As `extrapolate`, every variable with the order that it shows, or with the values of the finest mesh. `before`:
    the same of the meshes n/2, n, 2n."""

    def size(v: Array) -> Array:
        return np.asarray(np.max(np.abs(v), axis=1, initial=0.0) / amplitude)

    first, second = size(coarse - middle), size(middle - fine)
    told = (second > ROUNDING) & (first > 0.0)
    seen = np.log2(np.where(told, first, 1.0) / np.where(told, second, 1.0))
    order, values, errors = np.zeros(len(fine)), fine.copy(), second.copy()
    for p in ORDERS:
        rows = told & (np.abs(seen - p) <= CLOSE)
        once = [(2**p * b[rows] - a[rows]) / (2**p - 1) for a, b in ((coarse, middle), (middle, fine))]
        q = 2 ** (p + 2)
        twice = (q * once[1] - once[0]) / (q - 1)
        order[rows], values[rows] = p, twice
        step = np.max(np.abs(twice - once[1]), axis=1, initial=0.0) / amplitude[rows]
        errors[rows] = np.maximum(step, GAINED * second[rows])
    if before is not None:
        again = (order > 0) & (order == before.order)
        twice = np.maximum(size(values - before.values), GAINED**2 * second)
        errors = np.where(again, np.minimum(errors, twice), errors)
    return ExtrapolatedRows(values, errors, order)
