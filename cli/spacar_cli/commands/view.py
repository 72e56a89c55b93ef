"""`spacar view FILE`: a page that turns, zooms and plays a result in a browser."""

from pathlib import Path

import click
from spacar_drawing.stresses import QUANTITIES

from spacar_cli import vocabulary as words
from spacar_cli.environment import Environment


@words.command("view")
@words.option("output", "; default NAME_view.html beside the result.")
@words.option("frames", default=150)
@words.option("view", ", the first one", default="iso")
@words.option("fps", default=25.0)
@words.option("stress", ", as spacar visual does", type=click.Choice(tuple(QUANTITIES), case_sensitive=False))
@words.option("show", ": here the page in the browser")
@words.option("stale_ok")
@words.option("watch", ": the start position of the input file, and its result where it has one")
@words.option("no_browser", ", with --watch")
def command(
    environment: Environment, file: str, output: Path | None, frames: int, view: str, fps: float, stress: str | None,
    show: bool, stale_ok: bool, watch: bool, no_browser: bool,
) -> None:  # fmt: skip
    """Write one HTML page with the moving mechanism: turn it, zoom, play, click a node or an element for its numbers.

    The page holds everything it shows, needs no network and any browser with WebGL 2; thousands of beams move smoothly.
    With --watch nothing is written: the page shows FILE.dat while it is changed in any editor, with its errors.
    """
    if watch:
        from spacar_cli.editor.page_server import serve
        from spacar_cli.input_files import input_file

        serve(environment, input_file(Path(file)), True, not no_browser)
        return
    from spacar_drawing.picture_source import open_source
    from spacar_drawing.viewer_page import view_page
    from spacar_formats.safety import write_text

    source = open_source(file, stale_ok)
    path = output or source.beside("_view.html")
    write_text(path, view_page(source, frames, view, fps, stress))
    environment.wrote(path)
    if show:
        import webbrowser

        webbrowser.open(path.resolve().as_uri())
