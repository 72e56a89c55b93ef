"""What `--csv PATH` writes, a heading and rows, to a file or, for -, to standard output; and figures as files."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Mapping, Sequence
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from spacar_formats.safety import write_text

from spacar_cli.environment import Environment

if TYPE_CHECKING:
    import numpy as np
    from matplotlib.figure import Figure


def csv_text(heads: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """A heading and rows; numbers have all digits that are needed to read them back."""
    out = StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(heads)
    writer.writerows(rows)
    return out.getvalue()


def put_rows(environment: Environment, path: Path, heads: Sequence[str], rows: Iterable[Sequence[Any]]) -> None:
    """Write all rows."""
    put_text(environment, path, csv_text(heads, rows))


def put_columns(environment: Environment, path: Path, columns: Mapping[str, np.ndarray]) -> None:
    """Write named columns of one length."""
    put_rows(environment, path, list(columns), zip(*(c.tolist() for c in columns.values()), strict=True))


def put_text(environment: Environment, path: Path, text: str) -> None:
    """Write a table that is text already."""
    if str(path) == "-":
        environment.stdout.write(text)
        return
    write_text(path, text)
    environment.wrote(path)


def put_figure(
    environment: Environment, figure: Figure, paths: Iterable[Path], dpi: float = 150.0, show: bool = False
) -> None:
    """Write a picture under every name; `show` opens a window, which stays until the user closes it."""
    from spacar_drawing.files import save

    for path in paths:
        save(figure, path, dpi)
        environment.wrote(path)
    if show:
        from spacar_drawing.window import still_window

        still_window(figure)
