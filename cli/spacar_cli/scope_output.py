"""What `spacar sim` and `spacar ltv` show of the signals: pictures of the scopes, and a window when asked."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from spacar_formats.signal_tables import Panel, SignalTable

from spacar.errors import UsageError
from spacar_cli import vocabulary as words
from spacar_cli.environment import Environment
from spacar_cli.row_output import put_figure

SIGNALS = (".npz", ".mat", ".csv")


def signal_options(default: str) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
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
    """Write the pictures, then open the window."""
    if show or pictures:
        from spacar_drawing.history import scope_figure

        put_figure(environment, scope_figure(table, t, panels, title), pictures, show=show)
