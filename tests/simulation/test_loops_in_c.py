"""The loop of a mechanism and affine blocks in C against the same in Python; the method that chooses itself."""

import numpy as np
import pytest
from spacar_formats.simfile import read_model

import spacar.simulation.stepping as stepping
from benchmarks.loops import write_arm
from spacar.compiled.library import why_off
from spacar.simulation import Continuous, Diagram, StepSignal, simulate


@pytest.fixture(scope="module")
def arm(tmp_path_factory):
    return write_arm(tmp_path_factory.mktemp("arm"))


def loop(arm) -> Diagram:
    return read_model(arm).diagram


@pytest.mark.skipif(why_off() is not None, reason=str(why_off()))
@pytest.mark.parametrize("method", [155, 595])
def test_stages_in_c_are_those_of_python(arm, method, monkeypatch):
    """The sums of a stage are rounded in another order; eight events are located from them."""
    times = np.linspace(0.0, 0.08, 9)
    in_c = simulate(loop(arm), times, method=method)
    monkeypatch.setattr(stepping, "loop_of", lambda *_: None)
    in_python = simulate(loop(arm), times, method=method)
    assert in_c.statistics == in_python.statistics
    assert len(in_c.events) == 8
    np.testing.assert_allclose([t for t, _ in in_c.events], [t for t, _ in in_python.events], rtol=1e-9)
    np.testing.assert_allclose(in_c.x, in_python.x, rtol=1e-8, atol=1e-8)


@pytest.mark.skipif(why_off() is not None, reason=str(why_off()))
def test_numpy_goes_on_where_c_cannot(arm, monkeypatch):
    """Every third call of C is refused."""
    from spacar.compiled.loop_stages import LoopStages

    times, whole, calls = np.linspace(0.0, 0.02, 3), LoopStages.__call__, []

    def refused(self, done, *step):
        calls.append(done)
        return whole(self, done, *step) if len(calls) % 3 else done

    expected = simulate(loop(arm), times, method=155)
    monkeypatch.setattr(LoopStages, "__call__", refused)
    np.testing.assert_allclose(simulate(loop(arm), times, method=155).x, expected.x, rtol=1e-8, atol=1e-8)


def test_a_fast_wrist_is_passed_over(arm):
    """After the events the automatic method goes on with 595: the same motion with fewer evaluations."""
    times = np.linspace(0.0, 0.5, 6)
    chosen, explicit = simulate(loop(arm), times), simulate(loop(arm), times, method=155)
    assert any("method 595" in text for text in chosen.notes)
    assert chosen.statistics["rhs"] < 0.9 * explicit.statistics["rhs"]
    # 1e-6 a step, events at the same times; the last output is an acceleration
    np.testing.assert_allclose(chosen["arm:1-9"], explicit["arm:1-9"], atol=2e-6)


def test_a_stiff_loop_is_found():
    """x' = -1e5 (x - u), u a step at 0.5 s: 155 alone would take 2e5/3.3 steps. x = u but for 1e-5 s."""
    stiff = Continuous("s", lambda t, x, u: -1e5 * (x - u), lambda t, x, u: x, [0.0], 1, 1, direct=False)
    d = Diagram().add(stiff, StepSignal("u", 0.5)).connect("u", "s")
    r = simulate(d, [0.0, 0.25, 0.75, 2.0])
    assert r.statistics["steps"] < 2000
    assert not r.hint
    assert "decay of 1e+05 rad/s" in simulate(d, [0.0, 0.51], method=155).hint
    np.testing.assert_allclose(r["s"][:, 0], [0.0, 0.0, 1.0, 1.0], atol=1e-6)
