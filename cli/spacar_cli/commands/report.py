"""`spacar report FILE`: one self-contained HTML page about a run."""

from __future__ import annotations

from pathlib import Path

import click

from spacar_cli.drawing_options import symbol_kinds
from spacar_cli.environment import Environment
from spacar_cli.number_types import Whole


@click.command("report")
@click.argument("file")
@click.option(
    "--output", "-o", type=click.Path(path_type=Path), help="File to write. Default: NAME.html beside the result."
)
@click.option(
    "--plot",
    "-p",
    "expressions",
    multiple=True,
    metavar="EXPR",
    help="Expression to plot, as for spacar plot, instead of the degrees of freedom. May be repeated.",
)
@click.option(
    "--log-lines",
    type=Whole(min=0),
    default=120,
    show_default=True,
    help="Lines of the log shown from its beginning and its end; 0: none.",
)
@click.option(
    "--view",
    default="iso",
    show_default=True,
    help="View of a spatial mechanism: iso, xy, xz, yz or azimuth,elevation in degrees.",
)
@click.option(
    "--viewer", is_flag=True, help="With a picture that can be turned and played, as of spacar view (a script)."
)
@click.option(
    "--symbols",
    metavar="KINDS",
    help="A picture with these, with commas between: loads, reactions, masses, gravity, axes; or all.",
)
@click.option("--stale-ok", is_flag=True, help="Report a result although its input file has changed since.")
@click.pass_obj
def command(
    environment: Environment,
    /,
    file: str,
    output: Path | None,
    expressions: tuple[str, ...],
    log_lines: int,
    view: str,
    viewer: bool,
    symbols: str | None,
    stale_ok: bool,
) -> None:
    """Write one HTML page about a run: picture of the model, degrees of freedom, key results, plots, log.

    The page holds everything it shows: it can be sent by mail and opened without a network.
    """
    from spacar_drawing.picture_source import open_source
    from spacar_drawing.report_page import report_page
    from spacar_formats.safety import write_text

    source = open_source(file, stale_ok)
    path = output or Path(source.name).parent / f"{source.scene.title}.html"
    page = report_page(source, expressions, log_lines, view, viewer, symbol_kinds(symbols))
    write_text(path, page)
    environment.say(str(path))
