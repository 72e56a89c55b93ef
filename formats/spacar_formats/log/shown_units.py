"""Numbers of the log in the unit of length of the input (UNITS): the power of the metre of every quantity.

Coordinates and deformations have the powers of their units; what is dual to them follows from virtual work, f x and
sigma e are energies, N m. Transfer functions, matrices and modes stay in SI, in which they belong together.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from spacar.arrays import Array
from spacar.deck import ELEMENT_TYPES, Statement
from spacar.deck.length_unit import COORDINATE_POWER, length_power, metres, shown_in
from spacar.deck.statement import Value
from spacar.deck.table_types import Parameter, Variant
from spacar.mechanism.numbering import Numbering


@dataclass(frozen=True)
class ShownUnits:
    """metre: unit of length of the input in metres;  x (nx,), e (ne,): powers of the metre."""

    metre: float
    x: Array
    e: Array

    @classmethod
    def of(cls, n: Numbering, metre: float) -> ShownUnits:
        x, e = np.zeros(n.nx), np.zeros(n.ne)
        if metre != 1.0:
            x[:] = [COORDINATE_POWER[n.kind[n.x_owner(i)[0]]] for i in range(n.nx)]
            for i in range(n.ne):
                element, mode = n.e_owner(i)
                if element > 0:
                    e[i] = metres(ELEMENT_TYPES[n.keyword[element]].modes[mode - 1][1])
        return cls(metre, x, e)

    def coordinates(self, values: Array) -> Array:
        """x and its rates."""
        return values * self.metre**-self.x

    def forces(self, values: Array) -> Array:
        """Dual to x."""
        return values * self.metre ** (self.x - 1.0)

    def deformations(self, values: Array) -> Array:
        """e and its rates."""
        return values * self.metre**-self.e

    def stresses(self, values: Array) -> Array:
        """Dual to e."""
        return values * self.metre ** (self.e - 1.0)

    def compliances(self, values: Array) -> Array:
        """Coordinates by their own forces."""
        return values * self.metre ** (1.0 - 2.0 * self.x)

    def unit(self, text: str) -> str:
        return shown_in(text, self.metre)[1]


def shown_values(s: Statement, variant: Variant, n: Numbering, metre: float) -> tuple[Value, ...]:
    """The values of a statement as the file gives them."""
    if metre == 1.0:
        return s.values
    pairs = list(zip(s.values, variant.parameters, strict=False))
    kinds = [ELEMENT_TYPES[n.keyword[v]] for v, p in pairs if p.of == "element" and isinstance(v, int)]
    role = next((n.kind.get(v, "") for v, p in pairs if p.of.endswith("node") and isinstance(v, int)), "")
    return tuple(
        v * metre ** -length_power(s.keyword, k, p, s.values, kinds, role) if isinstance(v, float) else v
        for k, (v, p) in enumerate(pairs)
    )


def shown_head(p: Parameter, metre: float) -> str:
    """The meaning of a parameter with its unit."""
    if metre == 1.0 or not p.unit or p.unit.startswith("coefficient"):
        return p.text
    return f"{p.meaning} ({shown_in(p.unit, metre)[1]})"
