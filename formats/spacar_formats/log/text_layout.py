"""Plain text tables: right-aligned numbers, left-aligned words, ten significant digits."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

WIDTH = 100
COLUMNS_IN_BLOCK = 4  # eigenvectors, modes and matrices are printed in blocks of so many columns


def real(value: float) -> str:
    """A number with ten significant digits, exact zeros and integers short."""
    return f"{value:.10g}"


def cell(value: object) -> str:
    return f"{value:.10g}" if isinstance(value, float) else str(value)


def table(headings: Sequence[str], rows: Iterable[Sequence[object]]) -> list[str]:
    """Lines of a table, indented by two blanks; numbers stand to the right, words to the left."""
    body = list(zip(*rows, strict=True)) or [()] * len(headings)
    columns = []
    for head, values in zip(headings, body, strict=True):  # column by column: tables of large models have 1e5 cells
        kinds = {*map(type, values)}
        plain = not any(issubclass(kind, float) for kind in kinds)
        cells = [head, *map(str if plain else cell, values)]
        width = max(map(len, cells))
        words = any(issubclass(kind, str) for kind in kinds)
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
