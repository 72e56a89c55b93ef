"""What `spacar sim` and `spacar ltv` show of the signals: pictures of the scopes, and a window when asked."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import click
import numpy as np
from spacar_formats.signal_tables import Panel, SignalTable

from spacar_cli.environment import Environment

OPTIONS = (
    click.option("--plot", is_flag=True, help="Show the scopes in a window. Without this option no window is opened."),
    click.option(
        "--picture",
        "pictures",
        type=click.Path(path_type=Path),
        multiple=True,
        help="Write the scopes as a picture: png, svg or pdf. May be repeated.",
    ),
)


def scope_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """Add --plot and --picture."""
    for option in reversed(OPTIONS):
        function = option(function)
    return function


def check_pictures(plot: bool, pictures: Sequence[Path]) -> None:
    """Before a long run: can they be written? Raises UsageError."""
    from spacar_drawing.files import check_name
    from spacar_drawing.window import check_display

    for path in pictures:
        check_name(path, film=False)
    if plot:
        check_display()


def show_scopes(
    environment: Environment, table: SignalTable, t: np.ndarray, panels: Sequence[Panel], title: str, plot: bool,
    pictures: Sequence[Path],
) -> None:  # fmt: skip
    """Write the pictures, then open the window, which stays until the user closes it."""
    if not (plot or pictures):
        return
    from spacar_drawing.files import save
    from spacar_drawing.scope_panels import scope_figure
    from spacar_drawing.window import still_window

    figure = scope_figure(table, t, panels, title)
    for path in pictures:
        save(figure, path)
        environment.say(str(path))
    if plot:
        still_window(figure)
