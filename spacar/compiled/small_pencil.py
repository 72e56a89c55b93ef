"""The symmetric definite problem and the compliances of small dense matrices in C (pencil.c), around LAPACK's
eigenvalues: the counterpart of `spacar.linear.buckling`, `eigen` and `backward_error`."""

from __future__ import annotations

import ctypes

import numpy as np

from spacar.arrays import Array
from spacar.compiled.library import DOUBLES, NUMBER, address_of, element_functions

LARGEST = 50  # unknowns; from there on LAPACK is as fast (compliances from 36 on, load multipliers later)
WHOLE = ctypes.c_int64


class CPencil(ctypes.Structure):
    """`Pencil` of pencil.c."""

    _fields_ = [
        *((name, DOUBLES) for name in ("a", "b", "scale", "A", "B", "U", "reduced")),
        ("n", WHOLE), ("symmetric", NUMBER), ("least", NUMBER),
    ]  # fmt: skip


class CCompliances(ctypes.Structure):
    """`Compliances` of pencil.c."""

    _fields_ = [
        *((name, DOUBLES) for name in ("K", "W", "out")), ("n", WHOLE), ("nx", WHOLE), ("small", NUMBER),
        ("most", NUMBER),
    ]  # fmt: skip


class SmallPencil:
    """A z = value B z, of symmetric A (n, n) and positive definite B (n, n), both scaled with `scale` (n,) from both
    sides.

    `symmetric`: relative asymmetry, `least`: square of a pivot of B, scaled, up to which they count as rounding. Raises
    NotSmall where NumPy has to decide.
    """

    def __init__(self, A: Array, B: Array, scale: Array, symmetric: float, least: float = 0.0) -> None:
        n = len(A)
        if n > LARGEST:
            raise NotSmall
        self._call = element_functions()
        room = np.empty((4, n, n))
        self._keep = given = *map(np.ascontiguousarray, (A, B, scale)), room
        self._reduced = room[3]
        *addresses, first = map(address_of, given)
        c = CPencil(*addresses, *range(first, first + 32 * n * n, 8 * n * n), n, symmetric, least)
        self._c, self._at = c, ctypes.addressof(c)
        if self._call.pencil_reduce(self._at):
            raise NotSmall

    def pairs(self) -> tuple[Array, Array]:
        """Values (n,), ascending, and vectors z (n, n) with z^T B z = 1. Raises LinAlgError."""
        values, vectors = np.linalg.eigh(self._reduced)
        self._call.pencil_back(self._at, address_of(vectors))
        return values, vectors

    def error(self, values: Array, vectors: Array) -> Array:
        """Backward error of values (m,), vectors (n, m)."""
        error = np.empty(len(values))
        values, vectors = map(np.ascontiguousarray, (values, vectors))
        if self._call.pencil_error(self._at, *map(address_of, (values, vectors, error)), len(values)):
            raise MemoryError
        return error


class NotSmall(Exception):
    """Python has to decide, or is as fast."""


def compliances(K: Array, W: Array, small: float, most: float) -> Array | None:
    """(nx,) diagonal of W K^-1 W^T, W (nx, n). None: for NumPy.

    small: part of the largest size of an unknown that counts as none; most: condition of K, of the norms of it and its
    inverse, up to which no singular values are needed.
    """
    n, nx = len(K), len(W)
    if n > LARGEST:
        return None
    K, W, found = np.ascontiguousarray(K), np.ascontiguousarray(W), np.empty(nx)
    c = CCompliances(*map(address_of, (K, W, found)), n, nx, small, most)
    return None if element_functions().compliances(ctypes.addressof(c)) else found
