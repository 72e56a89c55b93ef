"""Numbers with a unit, for expressions of result variables: units are exponents of symbols such as m, s, rad, N."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from spacar.arrays import Array
from spacar.errors import UsageError

Unit = tuple[tuple[str, int], ...]  # sorted (symbol, exponent), exponents not zero

NONE: Unit = ()
DIGITS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
ORDER = ("N", "kg", "m", "rad", "deg", "s")


def unit(**exponents: int) -> Unit:
    return tuple(sorted((k, v) for k, v in exponents.items() if v))


def combine(a: Unit, b: Unit, sign: int = 1) -> Unit:
    """The unit of a product (sign 1) or quotient (sign -1)."""
    total = dict(a)
    for symbol, power in b:
        total[symbol] = total.get(symbol, 0) + sign * power
    return tuple(sorted((k, v) for k, v in total.items() if v))


def unit_text(value: Unit) -> str:
    """`m/s²`, `N m`, `1/s`; empty for a pure number."""

    def part(symbols: list[tuple[str, int]]) -> str:
        return " ".join(s + (str(p).translate(DIGITS) if p != 1 else "") for s, p in symbols)

    ranked = sorted(value, key=lambda u: ORDER.index(u[0]) if u[0] in ORDER else 99)
    above, below = [u for u in ranked if u[1] > 0], [(s, -p) for s, p in ranked if p < 0]
    if not below:
        return part(above)
    bottom = part(below)
    return f"{part(above) or '1'}/{f'({bottom})' if len(below) > 1 else bottom}"


@dataclass(frozen=True)
class Quantity:
    """Values over the steps (steps,) or one number, with the unit."""

    values: Array | float
    unit: Unit = NONE

    def plus(self, other: Quantity, sign: int, text: str) -> Quantity:
        """Sum or difference. UsageError when the units differ; a bare zero or number adds to pure numbers only."""
        if self.unit != other.unit:
            a, b = unit_text(self.unit) or "1", unit_text(other.unit) or "1"
            raise UsageError(f"{text}: cannot add {b} to {a}", "plot.unit")
        return Quantity(self.values + sign * other.values, self.unit)

    def times(self, other: Quantity, sign: int) -> Quantity:
        with np.errstate(divide="ignore", invalid="ignore"):
            values = self.values * other.values if sign > 0 else np.divide(self.values, other.values)
        return Quantity(values, combine(self.unit, other.unit, sign))

    def power(self, exponent: Quantity, text: str) -> Quantity:
        n = exponent.values
        if exponent.unit or not isinstance(n, float):
            raise UsageError(f"{text}: an exponent must be a plain number", "plot.unit")
        if self.unit and not n.is_integer():
            raise UsageError(f"{text}: only whole powers of a quantity with a unit", "plot.unit")
        with np.errstate(all="ignore"):
            values = np.asarray(self.values, float) ** n
        power = tuple((s, p * int(n)) for s, p in self.unit if int(n))
        return Quantity(values if values.ndim else float(values), power)
