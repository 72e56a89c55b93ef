"""Units of expressions: exponents of symbols such as m, s, rad, N. The unit None is not followed: no check, no text.

Units of variables are those of the keyword table; forces are dual to coordinates, stresses dual to deformations:
sig de/dt is a power in N m/s, so the stress of a deformation in m is in N, in rad in N m, without unit in N m.
"""

from __future__ import annotations

from collections.abc import Container, Sequence
from dataclasses import dataclass
from typing import Any

from spacar.deck import ELEMENT_TYPES
from spacar.errors import UsageError

Unit = tuple[tuple[str, int], ...]  # sorted (symbol, exponent), exponents not zero

NONE: Unit = ()
DIGITS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
ORDER = ("N", "kg", "m", "mm", "rad", "deg", "s")
# How often a variable is differentiated with respect to time; -1: dual; -2: coordinate divided by its dual.
ORDERS = {"x": 0, "xd": 1, "xdd": 2, "fx": -1, "fxgrav": -1, "fxtot": -1, "xcompl": -2, "xerr": 0,
          "e": 0, "ed": 1, "edd": 2, "sig": -1}  # fmt: skip


def unit(**exponents: int) -> Unit:
    return tuple(sorted((k, v) for k, v in exponents.items() if v))


def combine(a: Unit, b: Unit, sign: int = 1) -> Unit:
    """The unit of a product (sign 1) or quotient (sign -1)."""
    total = dict(a)
    for symbol, power in b:
        total[symbol] = total.get(symbol, 0) + sign * power
    return tuple(sorted((k, v) for k, v in total.items() if v))


def unit_text(value: Unit | None) -> str:
    """`m/s²`, `N m`, `1/s`; empty for a pure number and for a unit that is not followed."""

    def part(symbols: list[tuple[str, int]]) -> str:
        return " ".join(s + (str(p).translate(DIGITS) if p != 1 else "") for s, p in symbols)

    ranked = sorted(value or NONE, key=lambda u: ORDER.index(u[0]) if u[0] in ORDER else 99)
    above, below = [u for u in ranked if u[1] > 0], [(s, -p) for s, p in ranked if p < 0]
    if not below:
        return part(above)
    bottom = part(below)
    return f"{part(above) or '1'}/{f'({bottom})' if len(below) > 1 else bottom}"


RAD, DEGREE = unit(rad=1), unit(deg=1)


@dataclass(frozen=True)
class Dimensions:
    """The units of the variables of one model. keywords: type of every element, in the order of the numbers."""

    planar: bool
    stationary: bool
    position_nodes: Container[int]
    keywords: Sequence[str]

    @classmethod
    def of(cls, numbering: Any, stationary: bool) -> Dimensions:
        """Those of a mechanism, by its `Numbering`."""
        positions = frozenset(k for k, kind in numbering.kind.items() if kind == "position")
        keywords = [numbering.keyword.get(number, "") for number in range(1, len(numbering.le) + 1)]
        return cls(numbering.planar, stationary, positions, keywords)

    def __call__(self, name: str, numbers: Sequence[int]) -> Unit | None:
        """The unit of a variable that exists; None for those of the linearized equations."""
        of_model = {"frequency": unit(Hz=1), "eigval": unit(s=-1), "lmult": NONE}
        of_model["t"] = NONE if self.stationary else unit(s=1)
        if name in of_model:
            return of_model[name]
        order = ORDERS.get(name)
        if order is None:
            return None
        if name in ("e", "ed", "edd", "sig"):
            word = ELEMENT_TYPES[self.keywords[numbers[0] - 1]].modes[numbers[1] - 1][1]
            own = {"m": unit(m=1), "rad": RAD, "m^2": unit(m=2)}.get(word, NONE)
            dual = combine(unit(N=1, m=1), NONE if word == "rad" else own, -1)
        else:
            position = numbers[0] in self.position_nodes
            own = unit(m=1) if position else RAD if self.planar else NONE
            dual = unit(N=1) if position else unit(N=1, m=1)
        if order < 0:
            return dual if order == -1 else combine(own, dual, -1)
        return combine(own, unit(s=order), -1)


def of_sum(a: Unit | None, b: Unit | None, text: str) -> Unit | None:
    """Raises UsageError when the units differ."""
    if a is None or b is None or a == b:
        return a if b is None else b
    raise UsageError(f"'{text}': cannot add {unit_text(b) or '1'} to {unit_text(a) or '1'}", "expression.unit")


def of_power(base: Unit | None, exponent: Unit | None, n: float | None, text: str) -> Unit | None:
    """n: the exponent, None when it is a series or complex. Raises UsageError."""
    if exponent:
        raise UsageError(f"'{text}': an exponent must be a plain number", "expression.unit")
    if not base:
        return base
    if n is None:
        raise UsageError(f"'{text}': the exponent of a quantity with a unit must be one number", "expression.unit")
    if not n.is_integer():
        raise UsageError(f"'{text}': only whole powers of a quantity with a unit", "expression.unit")
    return tuple((s, p * int(n)) for s, p in base if int(n))
