"""`spacar report FILE`: one self-contained HTML page about a run."""

from pathlib import Path

from spacar_cli import vocabulary as words
from spacar_cli.drawing_options import symbol_kinds
from spacar_cli.environment import Environment


@words.command("report")
@words.option("output", "; default NAME.html beside the result.")
@words.option("plot", ", as for spacar plot, instead of the degrees of freedom. May be repeated.", multiple=True)
@words.option("log_lines", default=120)
@words.option("view", default="iso")
@words.option("viewer")
@words.option("symbols")
@words.option("stale_ok")
def command(
    environment: Environment, file: str, output: Path | None, plot: tuple[str, ...], log_lines: int, view: str,
    viewer: bool, symbols: str | None, stale_ok: bool,
) -> None:  # fmt: skip
    """Write one HTML page about a run: picture of the model, degrees of freedom, key results, plots, log.

    The page holds everything it shows: it can be sent by mail and opened without a network.
    """
    from spacar_drawing.picture_source import open_source
    from spacar_drawing.report_page import report_page
    from spacar_formats.safety import write_text

    source = open_source(file, stale_ok)
    path = output or source.beside(".html")
    write_text(path, report_page(source, plot, log_lines, view, viewer, symbol_kinds(symbols)))
    environment.wrote(path)
