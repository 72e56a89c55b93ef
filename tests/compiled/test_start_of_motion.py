"""The start of a motion in C: it is recorded as Python does it, and shown before the outputs behind it."""

import re

import numpy as np
import pytest

import spacar
from spacar.compiled.library import why_off
from spacar.deck import Deck
from spacar.errors import AnalysisError
from spacar.forward import motion as forward
from spacar.frame import StoredFrames

from .other_ways import OneByOne, take
from .test_output_block import SLIDER, UPRIGHT

pytestmark = pytest.mark.skipif(why_off() is not None, reason=str(why_off()))


def slider(duration, steps, *more):
    """It goes to its dead centre, 0.184 m away, with 0.1 m/s."""
    rows = [("XM", 5, 1.0), ("XM", 2, 0.1), ("STARTDX", 5, 1, UPRIGHT, 0.1), ("TIMESTEP", duration, steps)]
    return Deck.build(SLIDER, [*rows, *more], mode=1)


PENDULUM = """PLBEAM 1 1 2 3 4   X 1 0. 0.   X 3 1. 0.   FIX 1   DYNX 2 1   END HALT
EM 1 1.0   XM 3 1.0   GRAVITY 0. -9.81   USERSIG push   TIMESTEP 1. 20   END END
"""


def pushed(tmp_path, body):
    (tmp_path / "push.py").write_text(f"def push(t, ne, le, e, ep, nx, lnp, x, xp):\n    {body}\n")
    (tmp_path / "pendulum.dat").write_text(PENDULUM)
    return tmp_path / "pendulum.dat"


@pytest.mark.parametrize("options", [{}, {"integrator": 0}])
def test_the_outputs_behind_the_start_come_together(options):
    start, block = spacar.frames(1, slider(1.0, 10), **options).blocks()
    assert isinstance(block, StoredFrames)
    np.testing.assert_array_equal([start[0].t, *block.t], np.linspace(0.0, 1.0, 11))
    assert set(start[0].statistics.values()) == {0}  # nothing has been done yet
    assert block[0].statistics["rhs"] == 1 + 2 * block[0].statistics["steps"] + block[0].statistics["rejected"]


@pytest.mark.parametrize("error", [1e-3, 1e-6])
def test_a_dead_point_in_the_first_steps_is_seen(error, monkeypatch):
    """The first output lies behind it; the sentences are those of steps in Python."""
    deck, said = slider(4.0, 1, ("ERROR", error, error)), []
    for _ in range(2):
        run, ended = spacar.frames(1, deck), ""
        try:
            list(run)
        except AnalysisError as stopped:
            ended = str(stopped)
        said.append([re.sub(r"(t =|and) [\d.]+", "", text) for text in (*run.report.lines, ended)])
        take(monkeypatch, OneByOne)
    assert said[0] == said[1]
    assert any("singular position" in text for text in said[0])


@pytest.mark.parametrize("integrator", [-1, 0, 155])
@pytest.mark.parametrize(("body", "error", "said"), [
    ("return t, [], [[2, 1, 0.0 / (t == 0.0)]]", AnalysisError, "ZeroDivisionError"),
    ("if t > 0.0: raise KeyboardInterrupt\n    return t, [], []", KeyboardInterrupt, None),
], ids=["exception", "interruption"])  # fmt: skip
def test_the_frame_of_the_start_stays_when_nothing_behind_it_can_be_evaluated(body, error, said, integrator, tmp_path):
    """An exception of the user function at every later time, and an interruption, which is heard."""
    path = pushed(tmp_path, body)
    times = []
    with pytest.raises(error, match=said):
        times.extend(frame.t for frame in spacar.frames(1, path, integrator=integrator))
    assert times == [0.0]


@pytest.mark.parametrize("given", [True, False], ids=["prescribed", "free"])
def test_steps_are_watched_where_there_are_any(given, monkeypatch):
    """Outputs of a prescribed motion are placed one after the other: no step is looked at, no determinant sampled."""
    rows = [("INPUTX", 5, 1, UPRIGHT, -0.1, 0.0), ("TIMESTEP", 1.0, 10)]
    deck = Deck.build([*SLIDER[:-1], ("INPUTX", 5, 1)], rows, mode=1) if given else slider(1.0, 10)
    asked = []
    monkeypatch.setattr(forward, "singularity_monitor", lambda *of: asked.append(of))
    assert len(spacar.run(1, deck).frames) == 11
    assert len(asked) == (not given)
