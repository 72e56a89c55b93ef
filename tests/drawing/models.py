"""Pictures of all example models: how each is made, for the reference images and their test."""

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from spacar_drawing.files import evenly
from spacar_drawing.mechanism_picture import Extras, draw_steps
from spacar_drawing.picture_source import PictureSource, source_of_result

import spacar
from tests.examples import DATA

REFERENCE = Path(__file__).parent / "reference"
DPI = 45  # small files; the lines are still visible


@cache
def result_source(name: str, mode: int, duration: float | None = None, n_steps: int | None = None) -> PictureSource:
    """A run of an example, shortened in time where given."""
    options = {k: v for k, v in (("duration", duration), ("n_steps", n_steps)) if v is not None}
    return source_of_result(spacar.run(mode, DATA / f"{name}.dat", **options))


def strobe(source: PictureSource, count: int, **extras: Any) -> Any:
    """Pale and full pictures of evenly spread steps, with the paths that the settings ask for."""
    xs = source.x()
    chosen = xs[[k - 1 for k in evenly(1, len(xs), count)]]
    return draw_steps(
        source.scene, chosen, source.settings, Extras(title="", **extras), every_step=xs, traces=source.settings.traces
    )


def still(name: str, mode: int = 0, **extras: Any) -> Callable[[], Any]:
    """The first step of an example."""
    return lambda: strobe(result_source(name, mode), 1, **extras)


NUMBERED = {"node_numbers": True, "element_numbers": True}
PICTURES: dict[str, Callable[[], Any]] = {
    "crank": lambda: strobe(result_source("crank", 1, 0.035, 14), 5),
    "crank2": lambda: strobe(result_source("crank2", 1, 0.02, 8), 3),
    "crankfl": lambda: strobe(result_source("crankfl", 1, 0.01, 5), 6),
    "slider": lambda: strobe(result_source("slider", 1, 3.0, 10), 5),
    "cardan": lambda: strobe(result_source("cardan", 1, 0.1, 4), 1),
    "fingersim": lambda: strobe(result_source("fingersim", 1, 0.1, 10), 4),
    "lateral4cw": still("lateral4cw", view="xz"),
    "plbeam5": still("plbeam5", 7),
    "robotflexinvlin": still("robotflexinvlin", view="xz"),
    "robotinv": lambda: strobe(result_source("robotinv", 2), 6),
    "robotsim": still("robotsim", view="-120,30"),
    "screw": lambda: strobe(result_source("screw", 1, 1.0, 10), 1),
    "trike2": lambda: strobe(result_source("trike2", 1, 0.5, 10), 3),
    "trike3v": lambda: strobe(result_source("trike3v", 1, 0.4, 6), 2),
}
for _names, _mode, _numbers in (
    ("cardansimp lateral4 leafguide plbeam5free robotflexsim shear2 trike3i", 0, {}),
    ("column2 crosshingew finger plbeam5buck robotflexinv robotinvlin", 0, NUMBERED),
    ("fourbar lever massspring", 1, NUMBERED),
):
    PICTURES |= {name: still(name, _mode, **_numbers) for name in _names.split()}


def pixels(figure: Any) -> np.ndarray:
    """(height, width) grey values 0 to 255 of a figure without its letters, whose shapes depend on the version of
    matplotlib; what they say is asked of the figure, see `words`.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.text import Text

    figure.set_dpi(DPI)
    for text in figure.findobj(Text):
        text.set_visible(False)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[:, :, :3].astype(float).mean(2)


def words(figure: Any) -> list[str]:
    """What stands in the drawing: numbers of nodes and elements; no axes, no title."""
    return [text.get_text() for axes in figure.axes for text in axes.texts]


def write_references() -> None:
    """Write all reference images anew: `python -m tests.drawing.models`; look at them before committing."""
    from PIL import Image

    for name, make in PICTURES.items():
        Image.fromarray(pixels(make()).round().astype(np.uint8)).save(REFERENCE / f"{name}.png", optimize=True)


if __name__ == "__main__":
    write_references()
