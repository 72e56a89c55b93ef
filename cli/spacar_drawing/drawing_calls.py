"""The functions for Python users: one picture, one animation, one page of a result in memory or in a file."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from os import PathLike
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from spacar_formats.safety import write_text

from spacar.calls import Source, deck_of, has_interval, path_of, run, texts
from spacar.errors import UsageError
from spacar.mechanism.user_files import without_functions
from spacar.result import Result
from spacar_drawing.curves import evaluate, in_units
from spacar_drawing.defaults import plain
from spacar_drawing.files import FILM_DPI, film, kept
from spacar_drawing.history import history_figure
from spacar_drawing.mechanism_picture import Extras, chosen_steps, picture, series
from spacar_drawing.page_parts import png
from spacar_drawing.picture_source import PictureSource, open_source, source_of_result
from spacar_drawing.scene import check_numbers

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from spacar.stroke import Flexure
    from spacar_drawing.stress_numbers import StressResults

DPI = 150.0
MOST_FRAMES = 150


@dataclass(frozen=True)
class InlineAnimation:
    """A gif in memory, which a notebook shows: `data` its bytes, `title` that of the model."""

    data: bytes
    title: str

    def __repr__(self) -> str:
        return f"Animation of {self.title}: gif of {len(self.data) / 1000:.0f} kB, shown in a notebook"

    def _repr_html_(self) -> str:
        return f'<img alt="animation" src="data:image/gif;base64,{b64encode(self.data).decode()}">'


def source_of(given: Result | Source, at_rest: bool = False) -> PictureSource:
    """A result in memory, the `.sbd` of a name, or what a Deck or a Model gives: mode 1 with a time interval, else mode
    7; `at_rest`: its start position. Raises UsageError when there is none."""
    if isinstance(given, str | PathLike):
        return open_source(Path(given))
    if isinstance(given, Result):
        return source_of_result(given)
    if at_rest:
        return source_of_result(run(0, without_functions(deck_of(given, 0))))
    deck = deck_of(given, None)
    return source_of_result(run(1 if has_interval(deck) else 7, deck))


def _extras(given: dict[str, Any]) -> Extras:
    """Raises UsageError for an option that there is not."""
    known = [f.name for f in fields(Extras)]
    for name in given.keys() - {*known}:
        raise UsageError(f"pictures have no option '{name}'; extras are {', '.join(known)}", "usage.option")
    return Extras(**given)


def _traced(source: PictureSource, given: Sequence[int] | int) -> list[int]:
    """The position nodes whose paths are wanted. Raises UsageError for a node that is none."""
    nodes = list(given) if isinstance(given, Iterable) else [given]
    check_numbers(nodes, source.scene.position_nodes.tolist(), "traces: position node")
    return nodes


@plain
def draw(
    result: Result | Source, path: str | Path | None = None, *, steps: str | int | None = None,
    strobe: int | None = None,
    traces: Sequence[int] = (), initial: bool = False, dpi: float = DPI, **extras: Any,
) -> Figure:  # fmt: skip
    """A matplotlib figure of one or more steps; written to `path` (png, svg, pdf) when that is given.

    steps    as `spacar draw --at`: 3, "end", "2:5", "1,4,9", "all"; default the first, or the last load step
    strobe   so many evenly spread steps instead
    traces   numbers of the nodes whose paths are drawn;  initial: outline of the first step
    dpi      dots per inch of the file
    extras   node_numbers, element_numbers, supports (bool), view ("iso", "xy", "-60,25"), title, symbols ("loads",
             "reactions", "masses", "gravity", "axes"), scale (of deflections): fields of `Extras`

    Raises UsageError for steps or variables that the result has not, and for a file that cannot be written.
    """
    source = source_of(result, at_rest=True)
    nodes = _traced(source, traces)
    figure = picture(source, _extras(extras), chosen_steps(source, steps, strobe, False), nodes, initial)
    return kept(figure, path, dpi)


def animate(
    result: Result | Source, path: str | Path | None = None, *, steps: str | int | None = None,
    traces: Sequence[int] = (), initial: bool = False, frames: int = MOST_FRAMES, fps: float = 25.0,
    dpi: float = FILM_DPI, **extras: Any,
) -> Path | InlineAnimation:  # fmt: skip
    """Write an animation as gif, or as mp4 where ffmpeg is installed; returns its path. Without a path a gif that a
    notebook shows. Arguments as `draw`.

    frames   most pictures in it;  fps: pictures a second
    """
    source = source_of(result)
    if frames < 1:
        raise UsageError(f"an animation has at least one picture, not frames = {frames}", "usage.option")
    shown = series(source, _extras(extras), chosen_steps(source, steps, None, True), _traced(source, traces), initial)
    pictures, count = shown.thinned(frames)
    if path is not None:
        film(shown.moving(), pictures, count, path_of(path), fps, dpi)
        return path_of(path)
    with TemporaryDirectory() as folder:
        made = Path(folder) / "animation.gif"
        film(shown.moving(), pictures, count, made, fps, dpi)
        return InlineAnimation(made.read_bytes(), source.scene.title)


def report(
    result: Result | Source, expressions: Sequence[str] = (), *, log_lines: int = 120, view: str = "iso",
    viewer: bool = False, symbols: Sequence[str] = (),
) -> str:  # fmt: skip
    """One self-contained HTML page about a run, as text; `expressions` are plotted instead of the degrees of freedom.

    log_lines  lines of the log from its beginning and its end, where the result is a file with a log beside it
    view       of a spatial mechanism, as for `draw`;  viewer: with the moving picture of `view` in it
    symbols    in a picture of their own: "loads", "reactions", "masses", "gravity", "axes"

    Raises UsageError for an expression that cannot be evaluated, and for symbols that the result has not.
    """
    from spacar_drawing.report_page import report_page

    return report_page(source_of(result), expressions, log_lines, view, viewer, symbols)


def view(
    result: Result | Source, path: str | Path | None = None, *, frames: int = MOST_FRAMES, view: str = "iso",
    fps: float = 25.0, stress: str | None = None,
) -> str:  # fmt: skip
    """One self-contained HTML page that turns, zooms and plays the mechanism in a browser, as text.

    path  file that it is also written to;  frames: most steps that it holds
    view  with which it begins, of a spatial mechanism;  fps: pictures a second while it plays
    stress  colours of the beams: a resultant (N, Qy, Qz, T, My, Mz, B) or a stress (mises, normal, shear)

    Raises UsageError for a view or stress that is none, for a stress that the model does not have, and for a file that
    cannot be written.
    """
    from spacar_drawing.viewer_page import view_page

    return _page(view_page(source_of(result), frames, view, fps, stress), path)


@plain
def plot(
    result: Result | Source, *expressions: str, path: str | Path | None = None, against: str = "t",
    title: str | None = None, dpi: float = DPI,
) -> Figure:  # fmt: skip
    """A matplotlib figure of expressions such as 'x[6,1]' (`spacar help expressions`), a panel for each variable or
    unit; in the unit of length of the input file.

    path     file that it is also written to (png, svg, pdf);  dpi: dots per inch of the file
    against  expression of the horizontal axis;  title: text above, instead of the name of the model

    Raises UsageError for an expression that cannot be evaluated, and for a file that cannot be written.
    """
    if not expressions:
        raise UsageError("nothing to plot: give at least one expression, for instance 'x[6,1]'", "plot.nothing")
    source = source_of(result)
    metre = source.scene.metre
    curves = [in_units(evaluate(source, text), metre) for text in texts("an expression", expressions)]
    head = source.scene.title if title is None else title
    figure = history_figure(curves, in_units(evaluate(source, against), metre), head, source.scene.analysis.stationary)
    return kept(figure, path, dpi)


def stress(
    result: Result | Source, *, steps: Sequence[int] | int | None = None,
    elements: Sequence[int] | int | None = None,
    points: int = 9,
) -> StressResults:  # fmt: skip
    """Stress resultants along the beams and trusses of a result, and stresses where a cross-section is known.

    steps     stored steps from 1, default all;  elements: their numbers, default all;  points: places along each

    `found["mises"]` is (steps, elements, points), `found.largest("mises")` says where. Cross-sections are those of
    BEAMSEC, BEAMVIS and CROSSTYPE. Raises UsageError for steps and elements that the result has not.
    """
    from spacar_drawing.stress_numbers import stress_results

    return stress_results(source_of(result), steps, elements, points)


def flexure_page(study: Flexure, path: str | Path | None = None, *, view: str | None = None, body: bool = False) -> str:
    """One self-contained HTML page of `spacar.flexure`, as text; also written to `path` when that is given.

    study   what `spacar.flexure` gave
    view    of spatial pictures, as for `draw`; default: the plane of the motion, and iso for stresses
    body    stiffness along axes that turn with the node instead of the global ones
    """
    from spacar_drawing.stroke_page import stroke_page

    return _page(stroke_page(study, view, body), path)


def _page(text: str, path: str | Path | None) -> str:
    if path is not None:
        write_text(path_of(path), text)
    return text


@plain
def flexure_plot(study: Flexure, path: str | Path | None = None, *, body: bool = False, dpi: float = DPI) -> Figure:
    """A matplotlib figure of `spacar.flexure`: remaining support stiffness, errors, frequencies, stress.

    study   what `spacar.flexure` gave;  path: file that it is also written to (png, svg, pdf);  dpi: dots per inch
    body    stiffness along axes that turn with the node instead of the global ones
    """
    from spacar_drawing.stroke_figures import overview_figure

    return kept(overview_figure(study, body), path, dpi)


def inline_model(model: Source) -> str:
    """The start position of a model as an HTML image; functions of its users are not called."""
    return inline_picture(run(0, without_functions(deck_of(model, 0))))


def inline_picture(result: Result) -> str:
    """The first step, or the last load step, as an HTML image that holds its data."""
    return f'<img alt="mechanism" src="data:image/png;base64,{b64encode(png(draw(result), 80)).decode()}">'
