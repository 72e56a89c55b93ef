"""Truncated power series in one parameter s: derivatives of formulas along a line, exact to rounding.

A `Taylor` holds the coefficients c0, c1(, c2) of c0 + c1 s + c2 s^2, arrays that broadcast against each other. Written
with the operators and functions of this module, a formula works for arrays and for series alike: of arrays it gives
the value, of series x + v s the value and its derivatives along v (first c1, second 2 c2). Products are Cauchy's,

    (a b)_k = sum_j a_j b_k-j,     f(a)_1 = f' a1,   f(a)_2 = f' a2 + f'' a1^2/2.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from spacar.arrays import Array
from spacar.elements.family import arc_tangent


class Taylor:
    """Coefficients c, one to three arrays."""

    __array_ufunc__ = None  # array * series is for the series to compute
    __slots__ = ("c",)

    def __init__(self, c: Sequence[Array]) -> None:
        self.c = tuple(c)

    def __getitem__(self, key: Any) -> Taylor:
        return Taylor([a[key] for a in self.c])

    def __neg__(self) -> Taylor:
        return Taylor([-a for a in self.c])

    def __add__(self, other: Any) -> Taylor:
        if isinstance(other, Taylor):
            return Taylor([a + b for a, b in zip(self.c, other.c, strict=True)])
        return Taylor([self.c[0] + other, *self.c[1:]])

    __radd__ = __add__

    def __sub__(self, other: Any) -> Taylor:
        return self + (-other)

    def __rsub__(self, other: Any) -> Taylor:
        return -self + other

    def __mul__(self, other: Any) -> Taylor:
        if isinstance(other, Taylor):
            return _cauchy(self, other, lambda a, b: a * b)
        return Taylor([a * other for a in self.c])

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Taylor:
        if isinstance(other, Taylor):
            a0 = 1.0 / other.c[0]
            return self * composed(other, a0, -a0 * a0, 2.0 * a0 * a0 * a0)
        return Taylor([a / other for a in self.c])

    def __rtruediv__(self, other: Any) -> Taylor:
        return Taylor([np.asarray(other), *(np.zeros(1) for _ in self.c[1:])]) / self


def _cauchy(a: Taylor, b: Taylor, product: Callable[[Array, Array], Any]) -> Taylor:
    out = []
    for k in range(len(a.c)):
        total = product(a.c[0], b.c[k])
        for j in range(1, k + 1):
            total = total + product(a.c[j], b.c[k - j])
        out.append(total)
    return Taylor(out)


def composed(a: Taylor, *derivatives: Array) -> Taylor:
    """f(a) from f, f', f'' at the value of a (as many as a has coefficients)."""
    c = [derivatives[0]]
    if len(a.c) > 1:
        c.append(derivatives[1] * a.c[1])
    if len(a.c) > 2:
        c.append(derivatives[1] * a.c[2] + 0.5 * derivatives[2] * a.c[1] * a.c[1])
    return Taylor(c)


def value_of(a: Any) -> Array:
    return a.c[0] if isinstance(a, Taylor) else a


def root(a: Any) -> Any:
    if not isinstance(a, Taylor):
        return np.sqrt(a)
    value = np.sqrt(a.c[0])
    first = 0.5 / value
    return composed(a, value, first, -0.5 * first / a.c[0])


def angle(y: Any, x: Any) -> Any:
    """atan2(y, x); its derivative is (x y' - y x')/(x^2 + y^2)."""
    if not isinstance(x, Taylor):
        return arc_tangent(y, x)
    c = [arc_tangent(y.c[0], x.c[0])]
    if len(x.c) > 1:
        square = x.c[0] * x.c[0] + y.c[0] * y.c[0]
        first = (x.c[0] * y.c[1] - y.c[0] * x.c[1]) / square
        c.append(first)
    if len(x.c) > 2:
        along = x.c[0] * x.c[1] + y.c[0] * y.c[1]
        c.append((x.c[0] * y.c[2] - y.c[0] * x.c[2] - along * first) / square)
    return Taylor(c)


def contracted(subscripts: str, a: Any, b: Any) -> Any:
    """einsum of two factors."""
    if not isinstance(a, Taylor) and not isinstance(b, Taylor):
        return np.einsum(subscripts, a, b)
    if not isinstance(a, Taylor):
        return Taylor([np.einsum(subscripts, a, c) for c in b.c])
    if not isinstance(b, Taylor):
        return Taylor([np.einsum(subscripts, c, b) for c in a.c])
    return _cauchy(a, b, lambda x, y: np.einsum(subscripts, x, y))


def stacked(parts: Sequence[Any]) -> Any:
    """Parts of one kind and shape behind each other along a new first axis."""
    if not isinstance(parts[0], Taylor):
        return np.stack(parts)
    return Taylor([np.stack(c) for c in zip(*(p.c for p in parts), strict=True)])
