"""`spacar view FILE`: a page that turns, zooms and plays a result in a browser."""

from __future__ import annotations

from pathlib import Path

import click

from spacar_cli.commands.visual import QUANTITIES
from spacar_cli.environment import Environment
from spacar_cli.number_types import Real, Whole


@click.command("view")
@click.argument("file")
@click.option(
    "--output", "-o", type=click.Path(path_type=Path), help="File to write. Default: NAME_view.html beside the result."
)
@click.option("--frames", type=Whole(min=2), default=150, show_default=True, help="Most steps that the page holds.")
@click.option(
    "--view",
    default="iso",
    show_default=True,
    help="First view of a spatial mechanism: iso, xy, xz, yz or azimuth,elevation in degrees.",
)
@click.option("--fps", type=Real(1, 100), default=25.0, show_default=True, help="Pictures per second while it plays.")
@click.option(
    "--stress",
    type=click.Choice(QUANTITIES, case_sensitive=False),
    help="Colour beams and trusses by a stress resultant or a stress, as of spacar visual.",
)
@click.option("--show", is_flag=True, help="Open the page in the browser.")
@click.option("--stale-ok", is_flag=True, help="Show a result although its input file has changed since.")
@click.pass_obj
def command(
    environment: Environment,
    /,
    file: str,
    output: Path | None,
    frames: int,
    view: str,
    fps: float,
    stress: str | None,
    show: bool,
    stale_ok: bool,
) -> None:
    """Write one HTML page with the moving mechanism: turn it, zoom, play, click a node or an element for its numbers.

    The page holds everything it shows, needs no network and any browser with WebGL 2; thousands of beams move smoothly.
    """
    from spacar_drawing.picture_source import open_source
    from spacar_drawing.viewer_page import view_page
    from spacar_formats.safety import write_text

    source = open_source(file, stale_ok)
    path = output or Path(source.name).parent / f"{source.scene.title}_view.html"
    write_text(path, view_page(source, frames, view, fps, stress))
    environment.say(str(path))
    if show:
        import webbrowser

        webbrowser.open(path.resolve().as_uri())
