"""Windows: never without being asked; slider, live picture and Abort, with matplotlib's backend that has no screen.

The live window comes last: results and log are written before it is closed; rails, paths and the room follow the
motion.
"""

import numpy as np
import pytest
from spacar_drawing import window
from spacar_drawing.drawn_shapes import Line, Mark
from spacar_drawing.mechanism_picture import Extras, series
from spacar_drawing.stage import Camera
from spacar_formats.getfrsbf import getfrsbf

import spacar
from tests.examples import DATA

from .conftest import call
from .models import result_source


@pytest.fixture
def no_screen(monkeypatch):
    monkeypatch.setenv("MPLBACKEND", "agg")
    import matplotlib.pyplot as plt

    plt.switch_backend("agg")
    monkeypatch.setattr(window, "LIVE_INTERVAL", 0.0)
    yield plt
    plt.close("all")


def test_show_without_display_is_refused(results, monkeypatch):
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "MPLBACKEND"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr("sys.platform", "linux")
    for arguments in (
        ["draw", "crank", "--show"], ["plot", "crank", "t", "--show"], ["visual", "plbeam5free", "--show"]
    ):
        assert "no display" in call.refused(arguments[0], results / arguments[1], *arguments[2:])


def test_slider_shows_the_step(no_screen):
    shown = series(result_source("crank", 1, 0.035, 14), Extras(), range(1, 16), [], False)
    figure = window.slider_window(shown.whole, 15, shown.bounds, shown.camera, "crank")
    axes = figure.axes[0]
    assert axes.get_title(loc="left") == "crank   t = 0 s"
    slider = figure._spacar[0]
    slider.set_val(9)
    assert axes.get_title(loc="left") == "crank   t = 0.02 s"


def test_play_goes_round(no_screen):
    def pictures(k):
        return [Mark(np.zeros(3))], f"picture {k}"

    figure = window.slider_window(pictures, 3, (np.zeros(3), np.ones(3)), Camera.towards(-60, 30), "three")
    slider, button, timer = figure._spacar
    slider.set_val(3)
    button._observers.process("clicked", None)
    assert button.label.get_text() == "pause"
    timer.callbacks[0][0]()
    assert slider.val == 1  # after the last picture comes the first
    button._observers.process("clicked", None)
    assert button.label.get_text() == "play"


def test_dragging_turns_a_spatial_picture(no_screen):
    """100 pixels to the right turn the mechanism by 40 degrees about z: the camera goes the other way."""
    from matplotlib.backend_bases import MouseEvent
    from spacar_drawing.raster import Raster

    seen = []
    start = Camera.towards(-60, 30)
    figure = window.slider_window(
        lambda k: ([Mark(np.array([1.0, 0, 0]))], ""), 3, (-np.ones(3), np.ones(3)), start, "x"
    )
    box = figure.axes[0].bbox
    x, y = 0.5 * (box.x0 + box.x1), 0.5 * (box.y0 + box.y1)
    for name, dx in (("button_press_event", 0), ("motion_notify_event", 100), ("button_release_event", 100)):
        figure.canvas.callbacks.process(name, MouseEvent(name, figure.canvas, x + dx, y, 1))
        (raster,) = (a for axes in figure.axes for a in axes.artists if isinstance(a, Raster))
        seen.append(raster.camera.project(raster.shapes[0].at))
    np.testing.assert_allclose(seen[0], start.project(np.array([1.0, 0, 0])), atol=1e-12)
    np.testing.assert_allclose(seen[1], Camera.towards(-100, 30).project(np.array([1.0, 0, 0])), atol=1e-12)


def live_run():
    return spacar.frames(1, DATA / "crank.dat", duration=0.01, n_steps=6)


def test_live_plot_follows_a_run(no_screen):
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


def test_results_and_log_are_there_while_the_window_is_open(results, no_screen, monkeypatch):
    seen = []

    def wait(self):
        assert len(getfrsbf(results / "crank.sbd", "t")) == 5
        seen.append((not (results / "crank.sbd.part").exists(), (results / "crank.log").read_text()))
        raise KeyboardInterrupt  # what a killed window leaves behind

    (results / "crank.sbd").unlink()
    (results / "crank.log").unlink()
    monkeypatch.setattr(window.LivePlot, "wait", wait)
    call("1", results / "crank", "--show", "--quiet", "--steps", 4)
    assert "No such option" in call("-1", results / "crank", "--show").err
    assert seen == [(True, (results / "crank.log").read_text())]
    assert len(seen[0][1]) > 500


def test_an_abort_loses_no_step(no_screen):
    """What the window shows is counted and written: after an abort at step k, k frames are."""
    kept = []

    class Keep:
        def start(self, run): ...
        def frame(self, frame):
            kept.append(frame.t)

        def finish(self, error):
            kept.append("finished")

    plot = window.LivePlot()
    show = plot._draw

    def abort_at_third(frame):
        show(frame)
        if len(kept) == 3:
            plot._button._observers.process("clicked", None)

    plot._draw = abort_at_third
    outcome = live_run().consume(Keep(), window=plot)
    assert isinstance(outcome.error, KeyboardInterrupt)
    assert outcome.steps == 3
    assert kept[3:] == ["finished"]


def run_with(plot, model, **options):
    outcome = spacar.frames(1, model, **options).consume(window=plot)
    assert outcome.error is None


def test_the_rail_grows_with_the_way_of_the_slider(no_screen):
    plot = window.LivePlot()
    run_with(plot, DATA / "crank.dat", duration=0.0209, n_steps=10)  # half a turn: from 0.45 m to 0.15 m
    low, high = plot._look.ranges[5]
    np.testing.assert_allclose([low[0], high[0]], [0.15, 0.45], atol=2e-3)


def test_paths_of_the_settings_are_drawn(no_screen, tmp_path):
    model = tmp_path / "crank.dat"
    model.write_text((DATA / "crank.dat").read_text().rstrip() + "\nVISUALIZATION\nTRAJECTNODE 3 99\n")
    plot = window.LivePlot()
    run_with(plot, model, duration=0.02, n_steps=10)
    path = window.trace_lines(plot._scene, np.stack(plot._paths), plot._traces)[0].points
    np.testing.assert_allclose(np.hypot(*path[:, :2].T), 0.15, rtol=1e-9)
    drawn = [s.points for s in plot._moving.raster.shapes if isinstance(s, Line)]
    assert any(d.shape == path.shape and np.allclose(d, path) for d in drawn)


def test_room_does_not_add_up(no_screen):
    """After one turn the window is at most a tenth larger, on each side, than what was seen."""
    plot = window.LivePlot()
    run_with(plot, DATA / "crank.dat", duration=0.042, n_steps=42)
    (low, high), (left, right) = plot._seen, plot._bounds
    size = np.max(high - low)
    assert np.all(left <= low)
    assert np.all(right >= high)
    assert np.max(low - left) <= 0.1 * size
    assert np.max(right - high) <= 0.1 * size
