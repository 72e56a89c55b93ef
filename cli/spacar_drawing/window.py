"""Windows: a slider over the steps, and the picture of a run that is going on. Only opened when the user asks."""

import os
import sys
import time
from dataclasses import replace
from typing import Any

import numpy as np
from spacar_formats.result_files import sbd_header

from spacar.errors import UsageError
from spacar.frame import Frame
from spacar.stream import Run
from spacar_drawing.drawn_shapes import merge_bounds
from spacar_drawing.files import MovingFigure, Pictures
from spacar_drawing.look import look_of
from spacar_drawing.mechanism_picture import Extras, camera_of, mechanism_shapes
from spacar_drawing.scene import Array, Scene, positions
from spacar_drawing.settings import parse_settings
from spacar_drawing.stage import Camera, furnish
from spacar_drawing.supports import trace_lines

MOST_HEIGHT = 850  # pixels of a window without its title and buttons, for screens of 1000
FOOT = 0.65  # inches below the axes for the slider and the buttons
LIVE_INTERVAL = 0.1  # s between two pictures of a run
ROOM = 0.1  # beyond a side that the mechanism left, of the extent seen so far


def check_display() -> None:
    """Raises UsageError where there is no display to open a window on."""
    known = any(os.environ.get(v) for v in ("DISPLAY", "WAYLAND_DISPLAY", "MPLBACKEND"))
    if sys.platform.startswith("linux") and not known:
        raise UsageError("no window can be opened here (no display); write a file with --output instead", "draw.window")


def open_window(title: str) -> Any:
    """An empty window figure. Raises UsageError where no window can be opened."""
    check_display()
    import matplotlib.pyplot as plt

    figure = plt.figure(figsize=(8.4, 7.0))
    if plt.get_backend().lower() == "agg" and os.environ.get("MPLBACKEND", "").lower() != "agg":
        plt.close(figure)
        text = "no window can be opened: matplotlib found no window toolkit (install python3-tk or PyQt)"
        raise UsageError(text, "draw.window")
    manager = figure.canvas.manager
    if manager is not None:
        manager.set_window_title(title)
    return figure


def _on_screen() -> bool:
    import matplotlib.pyplot as plt

    return plt.get_backend().lower() != "agg"


def slider_window(
    pictures: Pictures, count: int, bounds: tuple[Array, Array], camera: Camera, title: str, fps: float = 25.0
) -> Any:
    """A window with a time slider and a play button; dragging in a spatial picture turns it. Blocks until it is closed.

    `pictures(k)` gives frame k from 0, the first one at the start. Returns the figure.
    """
    import matplotlib.pyplot as plt
    from matplotlib.widgets import Button, Slider

    figure = open_window(title)
    moving = MovingFigure(figure, furnish(figure, bounds, camera, " ", FOOT), camera)
    slider = Slider(
        figure.add_axes((0.18, 0.03, 0.62, 0.03)), "step ", 1, max(count, 2), valinit=1, valstep=1, color="#2f74b5"
    )
    button = Button(figure.add_axes((0.86, 0.02, 0.10, 0.05)), "play")
    state: dict[str, Any] = {"drag": None, "playing": False}

    slider.drawon = False  # it is drawn with the picture
    moving.beside = [slider.ax]

    def refresh(_: object = None) -> None:
        moving.show(*pictures(min(int(slider.val), count) - 1))
        moving.draw()

    def tick() -> None:
        slider.set_val(int(slider.val) % count + 1)

    def play(_: object) -> None:
        state["playing"] = not state["playing"]
        (timer.start if state["playing"] else timer.stop)()
        button.label.set_text("pause" if state["playing"] else "play")
        figure.canvas.draw_idle()

    def press(event: Any) -> None:
        if event.inaxes is moving.axes and not camera.planar:
            state["drag"] = (event.x, event.y, moving.camera)

    def turn(event: Any) -> None:
        if state["drag"] is None or event.x is None:
            return
        x, y, start = state["drag"]
        azimuth = np.degrees(np.arctan2(start.near[1], start.near[0])) - 0.4 * (event.x - x)
        elevation = np.degrees(np.arcsin(np.clip(start.near[2], -1, 1))) - 0.4 * (event.y - y)
        camera = Camera.towards(float(azimuth), float(np.clip(elevation, -89.0, 89.0)))
        moving.place(furnish(figure, bounds, camera, " ", FOOT), camera)
        refresh()

    def release(_: object) -> None:
        state["drag"] = None

    slider.on_changed(refresh)
    button.on_clicked(play)
    figure.canvas.mpl_connect("button_press_event", press)
    figure.canvas.mpl_connect("motion_notify_event", turn)
    figure.canvas.mpl_connect("button_release_event", release)
    timer = figure.canvas.new_timer(interval=int(1000 / fps))
    timer.add_callback(tick)
    figure.canvas.mpl_connect("close_event", lambda _: timer.stop())
    figure._spacar = (slider, button, timer)  # keep the widgets alive as long as the window
    refresh()
    if _on_screen():
        plt.show()
    return figure


class LivePlot:
    """A sink (start, frame, finish) that shows the mechanism while it runs, with an Abort button.

    Abort, and closing the window, raise KeyboardInterrupt in `frame`: the run ends as after Ctrl-C, results are kept.
    It belongs behind the sinks that write: they then have what the window shows. `wait`, when all is written, keeps
    the last picture on the screen until the user closes it.
    """

    def __init__(self) -> None:
        self._figure = open_window("spacar")
        self._aborted = False
        self._waits = False
        self._last = 0.0
        self._latest: Frame | None = None
        self._seen: tuple[Array, Array] | None = None
        self._bounds: tuple[Array, Array] | None = None
        self._paths: list[Array] = []

    def start(self, run: Run) -> None:
        from matplotlib.widgets import Button

        deck = run.mechanism.deck
        self._scene = Scene.of_header(sbd_header(run), deck.source)
        self._settings = parse_settings(deck.visualization)
        known = set(self._scene.position_nodes.tolist())
        self._traces = [n for n in self._settings.traces if n in known]
        self._camera = camera_of(self._scene, Extras().view)
        self._button = Button(
            self._figure.add_axes((0.84, 0.02, 0.13, 0.05)), "Abort", color="#f3d4d4", hovercolor="#eebcbc"
        )
        self._button.on_clicked(self._abort)
        self._figure.canvas.mpl_connect("close_event", self._abort)
        self._moving: MovingFigure | None = None
        if _on_screen():
            import matplotlib.pyplot as plt

            plt.show(block=False)

    def _abort(self, _: object) -> None:
        self._aborted = True

    def frame(self, frame: Frame) -> None:
        if self._aborted:
            raise KeyboardInterrupt
        self._latest = frame
        self._note(frame)
        now = time.monotonic()
        if self._moving is not None and now - self._last < LIVE_INTERVAL:
            return
        self._draw(frame)
        if self._moving is not None:
            self._moving.draw()
        self._last = time.monotonic()
        self._figure.canvas.flush_events()  # the Abort button is heard here
        if self._aborted:
            raise KeyboardInterrupt

    def _note(self, frame: Frame) -> None:
        """Where the nodes have been: the rail of a guide is as long as the way on it, a path has every step."""
        if self._moving is None:
            self._look = look_of(self._scene, frame.x[None], self._settings)
        else:
            place, old = positions(self._scene, frame.x), self._look.ranges
            ranges = np.stack((np.minimum(old[:, 0], place), np.maximum(old[:, 1], place)), axis=1)
            self._look = replace(self._look, ranges=ranges)
        if self._traces:
            self._paths.append(np.array(frame.x, float))

    def _draw(self, frame: Frame) -> None:
        shapes = mechanism_shapes(self._scene, frame.x, self._look, Extras())
        if self._traces:
            shapes += trace_lines(self._scene, np.stack(self._paths), self._traces)
        box = merge_bounds(shapes)
        shown = self._bounds
        if box is not None and (shown is None or np.any(box[0] < shown[0]) or np.any(box[1] > shown[1])):
            self._enlarge(box)
        assert self._moving is not None
        self._moving.show(shapes, f"{self._scene.title}   t = {frame.t:.6g} s")

    def _enlarge(self, box: tuple[Array, Array]) -> None:
        """New axes that hold what was seen so far, with room on those sides only that the mechanism has left.

        The room is a part of what was seen, not of earlier room: it does not add up while the picture grows.
        """
        old, shown = self._seen or box, self._bounds
        low, high = self._seen = np.minimum(old[0], box[0]), np.maximum(old[1], box[1])
        room = ROOM * np.max(high - low) * (np.array([1, 1, 0]) if self._scene.planar else np.ones(3))
        if shown is not None:
            low = np.where(low < shown[0], low - room, shown[0])
            high = np.where(high > shown[1], high + room, shown[1])
        self._bounds = low, high
        axes = furnish(self._figure, self._bounds, self._camera, " ", FOOT)
        if self._moving is not None:
            self._moving.place(axes, self._camera)
        else:
            self._moving = MovingFigure(self._figure, axes, self._camera)

    def finish(self, error: BaseException | None) -> None:
        """Show the last state of a run that came to its end; close the window of another one."""
        self._waits = error is None and not self._aborted and self._latest is not None
        if self._waits and self._latest is not None:
            self._button.label.set_text("done")
            self._draw(self._latest)
            self._figure.canvas.draw_idle()  # all of it: the word on the button has changed
        else:
            self._close()

    def wait(self) -> None:
        """Leave the last picture on the screen until the user closes it (or presses Ctrl-C)."""
        import matplotlib.pyplot as plt

        try:
            if self._waits and not self._aborted and _on_screen():
                plt.show()
        except KeyboardInterrupt:
            pass  # the run has ended, all is written: nothing is interrupted but the looking
        self._close()

    def _close(self) -> None:
        import matplotlib.pyplot as plt

        plt.close(self._figure)


def still_window(figure: Any) -> None:
    """Show a finished figure and wait until its window is closed; smaller where it is higher than most screens."""
    import matplotlib.pyplot as plt

    figure.set_dpi(min(figure.dpi, MOST_HEIGHT / figure.get_size_inches()[1]))
    shown = open_window("spacar")
    manager = shown.canvas.manager
    shown.canvas.figure = figure
    figure.set_canvas(shown.canvas)
    if manager is not None:
        manager.resize(*(int(v) for v in figure.get_size_inches() * figure.dpi))
    if _on_screen():
        plt.show()
