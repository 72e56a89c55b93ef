"""A model in other units: every number of a deck multiplied by its dimension, read from the keyword table.

A `System` gives the size of the new units: kg, m, s are how many new units one kilogram, metre, second is. A
mechanism does not change by this, so every result must be the old one times its dimension.
"""

import re
from dataclasses import dataclass, replace

import numpy as np

from spacar.deck import ELEMENT_TYPES, Deck, parse_deck
from spacar.deck.keyword_table import KEYWORDS
from spacar.deck.statement import Statement
from spacar.deck.table_types import Variant
from spacar.frame import Frame
from spacar.mechanism.mechanism import Mechanism

ENERGY = (1, 2, -2)
_BASE = {"kg": (1, 0, 0), "m": (0, 1, 0), "s": (0, 0, 1), "N": (1, 1, -2), "rad": (0, 0, 0)}


@dataclass(frozen=True)
class System:
    kg: float = 1.0
    m: float = 1.0
    s: float = 1.0

    def factor(self, dimension: tuple[int, int, int]) -> float:
        a, b, c = dimension
        return float(self.kg**a * self.m**b * self.s**c)


def dimension(unit: str) -> tuple[int, int, int]:
    """Powers of kg, m, s of a unit such as `N m^2 s` or `kg/m`; other words count as numbers."""
    total = np.zeros(3, int)
    for sign, part in zip((1, -1), unit.split("/"), strict=False):
        for name, power in re.findall(r"([A-Za-z]+)(?:\^(\d))?", part):
            total += sign * int(power or 1) * np.array(_BASE.get(name, (0, 0, 0)))
    return tuple(int(k) for k in total)  # type: ignore[return-value]


def per(a: tuple[int, int, int], *others: tuple[int, int, int]) -> tuple[int, int, int]:
    return tuple(np.array(a) - sum(np.array(o) for o in others))  # type: ignore[return-value]


class Dimensions:
    """Dimension of every number of a deck and of every result of its mechanism."""

    def __init__(self, deck: Deck) -> None:
        elements = [s for s in deck.of(*ELEMENT_TYPES, block=1)]
        self.kind = {int(s.values[0]): s.keyword for s in elements}
        self.role = {
            int(n): role
            for s in elements
            for n, role in zip(s.values[1:], ELEMENT_TYPES[s.keyword].nodes, strict=False)
        }
        self.space = "planar" if ELEMENT_TYPES[elements[0].keyword].planar else "spatial"

    def mode(self, element: int, mode: int) -> tuple[int, int, int]:
        return dimension(ELEMENT_TYPES[self.kind[element]].modes[mode - 1][1])

    def node(self, number: int) -> tuple[int, int, int]:
        return {"position": (0, 1, 0), "orientation": (0, 0, 0), "warping": (0, -1, 0)}[self.role[number]]

    def of(self, s: Statement) -> list[tuple[int, int, int]]:
        """One per value of the statement."""
        name, values = s.keyword, s.values
        first = int(values[0]) if values and isinstance(values[0], int) else 0
        zero, second = (0, 0, 0), (0, 0, 1)
        if name in ("INPUTX", "STARTDX", "DELINPX", "INPUTE", "STARTDE", "DELINPE") and s.block == 2:
            own = self.node(first) if name.endswith("X") else self.mode(first, int(values[1]))
            return [zero, zero, *(per(own, *(second,) * k) for k in range(len(values) - 2))]
        if name in ("ESIG", "DELESIG"):
            return [zero, *(per(ENERGY, self.mode(first, k)) for k in range(1, len(values)))]
        if name == "TRVMAX":  # of a path of positions; rise time, speed
            return [zero, second, per(self.node(first), second)][: len(values)]
        if name == "MEE":
            a = self.mode(first, int(values[1]))
            b = self.mode(int(values[2]), int(values[3])) if len(values) == 5 else a
            return [zero] * (len(values) - 1) + [per((1, 2, 0), a, b)]
        parameters = self.variant(s, first).parameters
        found = [dimension(p.unit) for p in parameters[: len(values)]]
        if name in ("ESTIFF", "EDAMP"):
            for k, p in enumerate(parameters[: len(values)]):
                if p.meaning.startswith("S"):
                    own = self.mode(first, k)
                    found[k] = per((1, 2, -2 if name == "ESTIFF" else -1), own, own)
        return found

    def variant(self, s: Statement, first: int) -> Variant:
        keyword = next(k for k in KEYWORDS.values() if k.name == s.keyword and k.block.number == s.block)
        about = keyword.variants[0].parameters
        is_element = bool(about) and about[0].of == "element"
        kind = self.kind.get(first, "") if is_element and s.keyword not in ELEMENT_TYPES else ""
        role = self.role.get(first, "") if about and about[0].of.endswith("node") and not is_element else ""
        fits = [v for v in keyword.variants if v.fits(self.space, role, kind)]
        return next(v for v in fits if len(s.values) in v.counts)

    # -- results ---------------------------------------------------------------------------------------------
    def results(self, mechanism: Mechanism) -> tuple[list[tuple[int, int, int]], list[tuple[int, int, int]]]:
        """Of all coordinates and of all deformations."""
        n = mechanism.numbering
        x = [self.node(n.x_owner(i)[0]) for i in range(n.nx)]
        # the rows of normalizations belong to no element; they have no dimension
        e = [self.mode(*n.e_owner(i)) if n.e_owner(i)[0] > 0 else (0, 0, 0) for i in range(n.ne)]
        return x, e


def convert(deck: Deck, to: System) -> Deck:
    """The deck in other units."""
    dimensions = Dimensions(deck)
    statements = []
    for s in deck.statements:
        values = tuple(
            v * to.factor(d) if isinstance(v, float) else v for v, d in zip(s.values, dimensions.of(s), strict=True)
        )
        statements.append(s._replace(values=values))
    return parse_deck(replace(deck, statements=tuple(statements)).to_text(), mode=deck.mode)


def back(frame: Frame, mechanism: Mechanism, units: System) -> dict[str, np.ndarray]:
    """x, xd, xdd, e, ed, edd, sig, fxtot of a frame of a converted deck, in SI units."""
    x, e = Dimensions(mechanism.deck).results(mechanism)
    second = (0, 0, 1)
    scale = {
        "x": x, "xd": [per(d, second) for d in x], "xdd": [per(d, second, second) for d in x],
        "e": e, "ed": [per(d, second) for d in e], "edd": [per(d, second, second) for d in e],
        "sig": [per(ENERGY, d) for d in e], "fxtot": [per(ENERGY, d) for d in x],
    }  # fmt: skip
    return {
        name: getattr(frame, name) / np.array([units.factor(d) for d in dimensions])
        for name, dimensions in scale.items()
    }
