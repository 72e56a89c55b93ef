"""Plain text tables: right-aligned numbers, left-aligned words, ten significant digits, lengths in the unit of input.

Coordinates and deformations have the powers of the metre of their units; what is dual to them follows from virtual
work, f x and sigma e are energies, N m. Transfer functions, matrices and modes stay in SI, in which they belong
together.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import Array
from spacar.deck import ELEMENT_TYPES, Statement
from spacar.deck.length_unit import COORDINATE_POWER, length_power, metres, shown_in
from spacar.deck.statement import Value
from spacar.deck.table_types import Parameter, Variant
from spacar.mechanism.numbering import Numbering

WIDTH = 100
COLUMNS_IN_BLOCK = 4  # eigenvectors, modes and matrices are printed in blocks of so many columns


def real(value: float) -> str:
    """A number with ten significant digits, exact zeros and integers short."""
    return f"{value:.10g}"


def cell(value: object) -> str:
    return real(value) if isinstance(value, float) else str(value)


def table(headings: Sequence[str], rows: Iterable[Sequence[object]], words_left: bool = True) -> list[str]:
    """Lines of a table, indented by two blanks; numbers stand to the right, words to the left, if `words_left`."""
    body = list(zip(*rows, strict=True)) or [()] * len(headings)
    columns = []
    for head, values in zip(headings, body, strict=True):  # column by column: tables of large models have 1e5 cells
        kinds = {*map(type, values)}
        plain = not any(issubclass(kind, float) for kind in kinds)
        cells = [head, *map(str if plain else cell, values)]
        width = max(map(len, cells))
        words = words_left and any(issubclass(kind, str) for kind in kinds)
        columns.append([c.ljust(width) for c in cells] if words else [c.rjust(width) for c in cells])
    return [("  " + "  ".join(line)).rstrip() for line in zip(*columns, strict=True)]


def heading(title: str) -> list[str]:
    """A chapter of the log."""
    return ["", title.upper(), "=" * len(title), ""]


def matrix(
    values: NDArray[np.float64], names: Sequence[str] = (), columns: Sequence[str] = (), width: int = COLUMNS_IN_BLOCK
) -> list[str]:
    """A matrix in blocks of a few columns; rows and columns carry their numbers and, when given, names."""
    rows, count = values.shape
    labels = [f"{i + 1:>5}  {names[i] if i < len(names) else ''}".rstrip() for i in range(rows)]
    room = max(map(len, labels), default=5)
    lines = []
    for first in range(0, count, width):
        block = range(first, min(first + width, count))
        heads = [columns[k] if k < len(columns) else str(k + 1) for k in block]
        lines.append(" " * room + "".join(f"  {h:>17}" for h in heads))
        form = f"%-{room}s" + "  % 17.9e" * len(block)
        lines += [
            form % (label, *row) for label, row in zip(labels, values[:, first : first + width].tolist(), strict=True)
        ]
        lines.append("")
    return lines


@dataclass(frozen=True)
class ShownUnits:
    """Factors that show numbers in SI in the unit of length of the input.

    coordinates (nx,)   of x and its rates;  forces, compliances (nx,)  dual to x, and x by its own force
    deformations (ne,)  of e and its rates;  stresses (ne,)  dual to e
    """

    coordinates: Array
    forces: Array
    compliances: Array
    deformations: Array
    stresses: Array

    @classmethod
    def of(cls, n: Numbering, metre: float) -> ShownUnits:
        x, e = np.zeros(n.nx), np.zeros(n.ne)  # powers of the metre
        if metre != 1.0:
            x[:] = [COORDINATE_POWER[n.kind[n.x_owner(i)[0]]] for i in range(n.nx)]
            for i in range(n.ne):
                element, mode = n.e_owner(i)
                if element > 0:
                    e[i] = metres(ELEMENT_TYPES[n.keyword[element]].modes[mode - 1][1])
        return cls(metre**-x, metre ** (x - 1.0), metre ** (1.0 - 2.0 * x), metre**-e, metre ** (e - 1.0))


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
