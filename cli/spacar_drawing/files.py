"""Pictures and animations as files. The ending of the name decides the kind; no window, no display is needed.

A series of configurations in one figure whose contents are exchanged: for animations, sliders and live windows.
"""

from __future__ import annotations

import contextlib
import itertools
import re
import shutil
import subprocess
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from spacar_formats.safety import replacing

from spacar.calls import path_of
from spacar.errors import AnalysisError, UsageError
from spacar_drawing.defaults import plain
from spacar_drawing.drawn_shapes import Faces, Shape
from spacar_drawing.paint import paint, paint_labels
from spacar_drawing.scene import Array
from spacar_drawing.stage import Camera, named, new_figure

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Pictures = Callable[[int], tuple[Sequence[Shape], str]]  # frame number from 0 -> shapes and the line above the picture


@dataclass(eq=False)  # Matplotlib 3.8 keeps callbacks by the hash of their object
class MovingFigure:
    """A figure and the picture that it shows now. `still` shapes stay in every picture.

    What does not move - axes, grid, numbers along them - is drawn once and kept as pixels, where the canvas has pixels;
    elsewhere, and for solids that one can look through, every picture is made of new artists.
    """

    figure: Figure
    axes: Axes
    camera: Camera
    artists: list[Any] = field(default_factory=list)  # of the picture that is shown, beside the raster
    beside: Sequence[Artist] = ()  # what else moves: the slider of a window, the line of scopes
    raster: Any = None
    background: Any = None
    listens: bool = False  # to the canvas: a window that was covered or made larger is drawn by others

    @classmethod
    @plain
    def create(cls, bounds: tuple[Array, Array], camera: Camera, still: Sequence[Shape] = ()) -> MovingFigure:
        figure, axes = new_figure(bounds, camera, " ")
        paint(axes, camera, still)
        return cls(figure, axes, camera)

    def show(self, shapes: Sequence[Shape], title: str) -> None:
        """Exchange the picture, to be seen with the next `draw`."""
        from spacar_drawing.raster import Raster, can_raster

        for artist in self.artists:
            artist.remove()
        quick = False
        if can_raster(self.figure.canvas):
            if self.raster is None:
                self.raster = Raster(self.axes, self.camera)
                if not self.listens:
                    self.figure.canvas.mpl_connect("draw_event", self._keep)
                    self.listens = True
            quick = self.camera.planar or all(s.alpha >= 1 for s in shapes if isinstance(s, Faces))
            self.raster.shapes = shapes if quick else ()
        self.artists = (paint_labels if quick else paint)(self.axes, self.camera, shapes)
        named(self.axes, title)

    def place(self, axes: Axes, camera: Camera) -> None:
        """Go on in new axes, instead of those that there are."""
        self.axes.remove()
        self.artists.clear()
        self.axes, self.camera, self.raster, self.background = axes, camera, None, None

    def draw(self) -> None:
        """Bring the picture to the screen, or to the pixels of a canvas without one."""
        canvas: Any = self.figure.canvas
        if self.raster is None:
            canvas.draw()
        elif self.background is None:
            for artist in (self.axes._left_title, *self.beside):  # type: ignore[attr-defined]
                artist.set_animated(True)
            canvas.draw()  # `_keep` hears of it
        else:
            canvas.restore_region(self.background)
            self._overlay()
        if hasattr(canvas, "blit"):
            canvas.blit(self.figure.bbox)

    def _keep(self, _: object) -> None:
        """The figure was drawn: keep its pixels, and add what moves."""
        if self.raster is not None and self.raster.axes is not None:
            canvas: Any = self.figure.canvas
            self.background = canvas.copy_from_bbox(self.figure.bbox)
            self._overlay()

    def _overlay(self) -> None:
        for artist in (self.raster, *self.artists, self.axes._left_title):  # type: ignore[attr-defined]
            self.axes.draw_artist(artist)
        for artist in self.beside:
            self.figure.draw_artist(artist)


def evenly(first: int, last: int, count: int) -> list[int]:
    """At most `count` whole numbers from first to last, both included, evenly spread."""
    n = min(count, last - first + 1)
    return sorted({round(v) for v in np.linspace(first, last, max(n, 1)).tolist()})


STILL, FILM = (".png", ".svg", ".pdf", ".eps"), (".gif", ".mp4")
FILM_DPI = 110.0  # most dots per inch of an animation
QUALITY = 18  # constant rate factor of H.264: no loss that can be seen
Tick = Callable[[int], None]


def check_name(path: Path, film: bool = True) -> str:
    """The ending of a picture name. Raises UsageError for one that cannot be written, and for mp4 without ffmpeg."""
    kinds = STILL + FILM if film else STILL
    ending = path.suffix.lower()
    if ending not in kinds:
        raise UsageError(f"{path}: a picture file ends in {', '.join(kinds)}", "draw.format")
    if ending == ".mp4" and shutil.which("ffmpeg") is None:
        text = f"{path}: writing mp4 needs the program ffmpeg, which was not found; gif needs nothing"
        raise UsageError(text, "draw.ffmpeg")
    if not path.parent.is_dir():
        raise UsageError(f"{path}: the folder {path.parent} does not exist", "draw.folder")
    return ending


def check_stills(paths: Sequence[Path]) -> None:
    """Raises UsageError for a name that no picture can have."""
    for path in paths:
        check_name(path, film=False)


@plain
def save(figure: Figure, path: Path, dpi: float = 150.0) -> None:
    """Write a figure as png, svg, pdf or eps; the same figure gives the same bytes. Raises UsageError."""
    import matplotlib

    ending, picture = check_name(path, film=False), BytesIO()
    metadata = {".svg": {"Date": None}, ".pdf": {"CreationDate": None, "ModDate": None}}.get(ending)
    looks: Any = {"svg.hashsalt": "spacar", "svg.fonttype": "none", "pdf.fonttype": 42, "ps.fonttype": 42}
    with matplotlib.rc_context(looks):
        figure.savefig(picture, format=ending[1:], dpi=dpi, metadata=metadata)
    data = picture.getvalue()
    if ending == ".eps":
        data = re.sub(rb"(?m)^%%CreationDate: .*\n", b"", data)
    with replacing(path) as side:
        side.write_bytes(data)


def kept(figure: Figure, path: str | Path | None, dpi: float = 150.0) -> Figure:
    if path is not None:
        save(figure, path_of(path), dpi)
    return figure


@plain
def film(
    moving: MovingFigure, pictures: Pictures, count: int, path: Path, fps: float, dpi: float, tick: Tick | None = None
) -> None:
    """Write an animation of `count` frames as gif or mp4. `tick` is told the number of frames done.

    Raises UsageError for a name that cannot be written, AnalysisError when ffmpeg fails.
    """
    ending = check_name(path)
    if ending not in FILM:
        raise UsageError(f"{path}: an animation ends in {' or '.join(FILM)}", "draw.format")
    moving.figure.set_dpi(dpi)
    with replacing(path) as side:
        (_gif if ending == ".gif" else _mp4)(_frames(moving, pictures, count, tick), side, path, fps)


def _frames(moving: MovingFigure, pictures: Pictures, count: int, tick: Tick | None) -> Iterator[NDArray[np.uint8]]:
    """(height, width, 3) pixels of every frame, with even sides (most video codecs need them)."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    canvas = FigureCanvasAgg(moving.figure)
    for k in range(count):
        moving.show(*pictures(k))
        moving.draw()
        pixels = np.asarray(canvas.buffer_rgba())[:, :, :3]
        yield np.ascontiguousarray(pixels[: pixels.shape[0] // 2 * 2, : pixels.shape[1] // 2 * 2])
        if tick is not None:
            tick(k + 1)


def _gif(frames: Iterator[NDArray[np.uint8]], side: Path, path: Path, fps: float) -> None:
    """One palette for all frames, taken from the first, so that still parts do not flicker."""
    from PIL import Image

    first = Image.fromarray(next(frames))
    palette = first.quantize(128, method=Image.Quantize.MEDIANCUT)
    colours = np.array(palette.getpalette() or []).reshape(-1, 3)
    colours[np.argmax(colours.sum(axis=1))] = 255  # paper stays white
    palette.putpalette(colours.ravel().tolist())
    rest = (Image.fromarray(f).quantize(palette=palette, dither=Image.Dither.NONE) for f in frames)
    duration = max(20, 10 * round(100.0 / fps))  # ms in whole hundredths; faster is not shown by browsers
    palette.save(side, "GIF", save_all=True, append_images=rest, duration=duration, loop=0, optimize=False)


def _mp4(frames: Iterator[NDArray[np.uint8]], side: Path, path: Path, fps: float) -> None:
    first = next(frames)
    height, width, _ = first.shape
    given = f"-f rawvideo -pix_fmt rgb24 -s {width}x{height} -r {fps:g} -i -"
    made = f"-an -vcodec libx264 -pix_fmt yuv420p -crf {QUALITY}"
    command = ["ffmpeg", "-y", "-loglevel", "error", *given.split(), *made.split(), str(side)]
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE)
    assert process.stdin is not None
    try:
        with contextlib.suppress(BrokenPipeError):
            for frame in itertools.chain([first], frames):
                process.stdin.write(frame.tobytes())
        _, complaint = process.communicate()
    except BaseException:
        process.kill()
        process.wait()
        raise
    if process.returncode:
        text = complaint.decode("utf-8", "replace").strip().splitlines()
        raise AnalysisError(f"ffmpeg could not write {path}: {text[-1] if text else process.returncode}", "draw.ffmpeg")
