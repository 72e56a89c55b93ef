"""Windows: never without being asked; slider, live picture and Abort, with matplotlib's backend that has no screen."""

import numpy as np
import pytest
from spacar_drawing import window

import spacar

from .conftest import call
from .models import DATA


@pytest.fixture
def no_screen(monkeypatch):
    monkeypatch.setenv("MPLBACKEND", "agg")
    import matplotlib.pyplot as plt

    plt.switch_backend("agg")
    yield plt
    plt.close("all")


def test_show_without_display_is_refused(results, monkeypatch):
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "MPLBACKEND"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr("sys.platform", "linux")
    for arguments in (
        ["draw", "crank", "--show"], ["plot", "crank", "t", "--show"], ["visual", "plbeam5free", "--show"]
    ):
        done = call(arguments[0], results / arguments[1], *arguments[2:])
        assert done.status == 2
        assert "no display" in done.err


def test_slider_shows_the_step(no_screen):
    from spacar_drawing.mechanism_picture import Extras, series

    from .models import result_source

    shown = series(result_source("crank", 1, 0.035, 14), Extras(), range(1, 16), [], False)
    figure = window.slider_window(shown.whole, 15, 0, shown.bounds, shown.camera, "crank", block=False)
    axes = figure.axes[0]
    assert axes.get_title(loc="left") == "crank   t = 0 s"
    slider = figure._spacar[0]
    slider.set_val(9)
    assert axes.get_title(loc="left") == "crank   t = 0.02 s"


def live_run(steps=6):
    return spacar.frames(1, DATA / "crank.dat", duration=0.01, n_steps=steps)


def test_live_plot_follows_a_run(no_screen, monkeypatch):
    monkeypatch.setattr(window, "LIVE_INTERVAL", 0.0)
    plot = window.LivePlot()
    run = live_run()
    plot.start(run)
    titles = []
    for frame in run:
        plot.frame(frame)
        titles.append(plot._moving.axes.get_title(loc="left"))
    plot.finish(None)
    assert titles[0] == "crank.dat   t = 0 s"
    assert titles[-1] == "crank.dat   t = 0.01 s"
    plot.wait()
    assert no_screen.get_fignums() == []


def test_abort_ends_the_run_like_an_interrupt(no_screen):
    plot = window.LivePlot()
    run = live_run()
    plot.start(run)
    frames = iter(run)
    plot.frame(next(frames))
    plot._button._observers.process("clicked", None)
    with pytest.raises(KeyboardInterrupt):
        plot.frame(next(frames))
    plot.finish(KeyboardInterrupt())


def test_plot_option_of_a_run(results, no_screen):
    assert call("1", results / "crank", "--show", "--quiet", "--steps", 4).status == 0
    assert (results / "crank.sbd").is_file()
    assert "No such option" in call("-1", results / "crank", "--show").err


def test_play_goes_round(no_screen):
    from spacar_drawing.drawn_shapes import Mark
    from spacar_drawing.stage import Camera

    def pictures(k):
        return [Mark(np.zeros(3))], f"picture {k}"

    figure = window.slider_window(
        pictures, 3, 2, (np.zeros(3), np.ones(3)), Camera.towards(-60, 30), "three", block=False
    )
    slider, button, timer = figure._spacar
    assert slider.val == 3
    button._observers.process("clicked", None)
    assert button.label.get_text() == "pause"
    timer.callbacks[0][0]()
    assert slider.val == 1  # after the last picture comes the first
    button._observers.process("clicked", None)
    assert button.label.get_text() == "play"


def test_dragging_turns_a_spatial_picture(no_screen):
    """100 pixels to the right turn the mechanism by 40 degrees about z: the camera goes the other way."""
    from matplotlib.backend_bases import MouseEvent
    from spacar_drawing.drawn_shapes import Mark
    from spacar_drawing.raster import Raster
    from spacar_drawing.stage import Camera

    seen = []
    start = Camera.towards(-60, 30)
    figure = window.slider_window(
        lambda k: ([Mark(np.array([1.0, 0, 0]))], ""), 3, 0, (-np.ones(3), np.ones(3)), start, "x", block=False
    )
    box = figure.axes[0].bbox
    x, y = 0.5 * (box.x0 + box.x1), 0.5 * (box.y0 + box.y1)
    for name, dx in (("button_press_event", 0), ("motion_notify_event", 100), ("button_release_event", 100)):
        figure.canvas.callbacks.process(name, MouseEvent(name, figure.canvas, x + dx, y, 1))
        (raster,) = (a for axes in figure.axes for a in axes.artists if isinstance(a, Raster))
        seen.append(raster.camera.project(raster.shapes[0].at))
    np.testing.assert_allclose(seen[0], start.project(np.array([1.0, 0, 0])), atol=1e-12)
    np.testing.assert_allclose(seen[1], Camera.towards(-100, 30).project(np.array([1.0, 0, 0])), atol=1e-12)
