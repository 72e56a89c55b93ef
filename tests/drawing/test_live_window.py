"""The live window comes last: results and log are written before it is closed; rails, paths and the room follow the
motion."""

import numpy as np
import pytest
from spacar_drawing import window
from spacar_drawing.drawn_shapes import Line
from spacar_formats.getfrsbf import getfrsbf

import spacar

from .conftest import call
from .models import DATA


@pytest.fixture
def no_screen(monkeypatch):
    monkeypatch.setenv("MPLBACKEND", "agg")
    import matplotlib.pyplot as plt

    plt.switch_backend("agg")
    monkeypatch.setattr(window, "LIVE_INTERVAL", 0.0)
    yield plt
    plt.close("all")


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
            plot._abort(None)

    plot._draw = abort_at_third
    run = spacar.frames(1, DATA / "crank.dat", duration=0.01, n_steps=6)
    outcome = run.consume(Keep(), window=plot)
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
