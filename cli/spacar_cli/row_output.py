"""What several commands write: rows (`--csv PATH`, - for standard output), tables, figures, scopes of signals."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click
from spacar_formats.safety import write_text

from spacar.errors import UsageError
from spacar_cli import vocabulary as words
from spacar_cli.environment import Environment

if TYPE_CHECKING:
    import numpy as np
    from matplotlib.figure import Figure
    from spacar_formats.signal_tables import Panel, SignalTable

Item = TypeVar("Item")
SIGNALS = (".npz", ".mat", ".csv")
ROWS = click.Path(path_type=Path, dir_okay=False)
of_studies = words.options((
    words.option("duration", ", instead of TIMESTEP"), words.option("n_steps", " of the output, instead of TIMESTEP"),
    words.option("jobs", "; default sweep all cores, trade one."), words.option("as_json", ": a summary"),
))  # fmt: skip


def csv_text(heads: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """A heading and rows; numbers have all digits that are needed to read them back."""
    out = StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(heads)
    writer.writerows(rows)
    return out.getvalue()


def finite(value: Any) -> Any:
    """Tables and lists for JSON, which has no nan and no infinite numbers: None."""
    if isinstance(value, dict):
        return {name: finite(v) for name, v in value.items()}
    if isinstance(value, list):
        return [finite(v) for v in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def put_rows(environment: Environment, path: Path, heads: Sequence[str], rows: Iterable[Sequence[Any]]) -> None:
    text = csv_text(heads, rows)
    if str(path) == "-":
        environment.stdout.write(text)
        return
    write_text(path, text)
    environment.wrote(path)


def put_columns(environment: Environment, path: Path, columns: Mapping[str, np.ndarray]) -> None:
    put_rows(environment, path, list(columns), zip(*(c.tolist() for c in columns.values()), strict=True))


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


def signal_options(default: str) -> words.Decorator:
    """Add --output and --show."""
    text = f": signals as .npz, .mat or .csv, default {default}; scopes as .png, .svg or .pdf. May be repeated."
    return words.options((words.option("output", text, multiple=True), words.option("show", ": the scopes")))


def sorted_files(output: Sequence[Path], show: bool) -> tuple[list[Path], list[Path]]:
    """Files of signals and pictures. Raises UsageError before a long run for those that cannot be written."""
    tables = [path for path in output if path.suffix.lower() in SIGNALS]
    pictures = [path for path in output if path not in tables]
    if pictures:
        from spacar_drawing.files import STILL, check_name
    for path in pictures:
        if path.suffix.lower() not in STILL:
            raise UsageError(f"{path}: its name must end with {', '.join((*SIGNALS, *STILL))}", "files.export")
        check_name(path, film=False)
    if show:
        from spacar_drawing.window import check_display

        check_display()
    return tables, pictures


def show_scopes(
    environment: Environment, table: SignalTable, t: np.ndarray, panels: Sequence[Panel], title: str, show: bool,
    pictures: Sequence[Path],
) -> None:  # fmt: skip
    if show or pictures:
        from spacar_drawing.history import scope_figure

        put_figure(environment, scope_figure(table, t, panels, title), pictures, show=show)


def counted(environment: Environment, items: Iterable[Item], total: int, what: str) -> Iterator[Item]:
    """Pass items through; on a terminal one line says how many have come."""
    for number, item in enumerate(items, 1):
        environment.progress(f"{number}/{total} {what} ")
        yield item
    environment.progress("")


def say_table(
    environment: Environment, header: Sequence[str], rows: Sequence[Sequence[str]], marked: int | None
) -> None:
    """A table: aligned columns, on terminals in lines and with the marked row in bold."""
    if environment.output_is_terminal:
        from rich.console import Console
        from rich.table import Table

        table = Table(*header)
        for number, row in enumerate(rows):
            table.add_row(*row, style="bold" if number == marked else None)
        Console(file=environment.stdout, no_color=bool(environment.variables.get("NO_COLOR"))).print(table)
        return
    widths = [max(map(len, column)) for column in zip(header, *rows, strict=True)]
    cells = ([cell.ljust(width) for cell, width in zip(row, widths, strict=True)] for row in (header, *rows))
    environment.say(*("  ".join(row).rstrip() for row in cells))
