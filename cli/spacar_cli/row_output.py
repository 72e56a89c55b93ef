"""What `--csv PATH` writes, a heading and rows, to a file or, for -, to standard output; and figures as files."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from spacar_formats.safety import write_text

from spacar_cli.environment import Environment

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def put_rows(environment: Environment, path: Path, heads: Sequence[str], rows: Iterable[Sequence[Any]]) -> None:
    """Write all rows; numbers have all digits that are needed to read them back."""
    out = StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(heads)
    writer.writerows(rows)
    put_text(environment, path, out.getvalue())


def put_text(environment: Environment, path: Path, text: str) -> None:
    """Write a table that is text already."""
    if str(path) == "-":
        environment.stdout.write(text)
        return
    write_text(path, text)
    environment.wrote(path)


def put_figure(environment: Environment, figure: Figure, paths: Iterable[Path], dpi: float = 150.0) -> None:
    """Write a picture under every name."""
    from spacar_drawing.files import save

    for path in paths:
        save(figure, path, dpi)
        environment.wrote(path)
