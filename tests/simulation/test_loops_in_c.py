"""The loop of a mechanism and affine blocks in C against the same in Python; the method that chooses itself."""

import numpy as np
import pytest

import spacar.simulation.stepping as stepping
from spacar.compiled.library import why_off
from spacar.simulation import (
    PID,
    Continuous,
    Diagram,
    Saturation,
    Sine,
    Spasim,
    StepSignal,
    simulate,
    transfer_function,
)

HINGES = (1, 2, 3, 5, 6, 8, 9)
# links of 0.4, 0.35 and 0.2 m behind three, two and two hinges about z, y, x, y, x, y, x; stretched along x
ARM = """
HINGE 1 1 3  0 0 1
HINGE 2 3 4  0 -1 0
HINGE 3 4 5  1 0 0
BEAM 4 2 5 6 7 0 1 0
HINGE 5 7 8  0 -1 0
HINGE 6 8 9  1 0 0
BEAM 7 6 9 10 11 0 1 0
HINGE 8 11 12  0 -1 0
HINGE 9 12 13  1 0 0
BEAM 10 10 13 14 15 0 1 0
X 2 0 0 0.
X 6 0.4 0 0.
X 10 0.75 0 0.
X 14 0.95 0 0.
FIX 1
FIX 2
DYNES
END
HALT
EM 4 17.1429 0.02 0.01 0.01
EM 7 8.57143 0.02 0.01 0.01
EM 10 4.28571 0.02 0.01 0.01
XM 6 3.0
XM 10 1.5
XM 14 0.75
XM 15 0.02 0. 0. 0.02 0. 0.02
XF 6 0. 0. -58.86
XF 10 0. 0. -29.43
XF 14 0. 0. -14.715
END
HALT
SIGNALS
END
END
"""


@pytest.fixture(scope="module")
def arm(tmp_path_factory):
    signals = [f"INPUTS {k} {h} 1" for k, h in enumerate(HINGES, 1)]
    signals += [f"OUTE {k} {h} 1" for k, h in enumerate(HINGES, 1)] + ["OUTEP 8 3 1", "OUTX 9 14 3", "OUTEDP 10 1 1"]
    text = ARM.replace("DYNES", "\n".join(f"DYNE {h} 1" for h in HINGES)).replace("SIGNALS", "\n".join(signals))
    path = tmp_path_factory.mktemp("arm") / "arm.dat"
    path.write_text(text)
    return path


def loop(arm) -> Diagram:
    """PID, a notch filter for every hinge, a saturation; the wrist turns fast enough to limit explicit steps."""
    limit = np.array([300.0, 300.0, 100.0, 150.0, 60.0, 60.0, 20.0])
    d = Diagram().add(
        Spasim(arm, "arm"),
        Sine("path", [0.5, 0.4, 0.3, 0.4, 0.3, 0.4, 0.3], [0.5, 0.7, 0.9, 0.6, 0.8, 1.0, 1.1]),
        PID("pid", [4000, 4000, 800, 1500, 300, 300, 60], [4000, 4000, 800, 1500, 300, 300, 60],
            [300, 300, 40, 80, 12, 12, 2], filter=300.0, lower=-limit, upper=limit, size=7),
        *(transfer_function(f"notch{k}", [1, 12, 14400], [1, 120, 14400]) for k in range(1, 8)),
        Saturation("limit", -0.83 * limit, 0.83 * limit, 7),
    )  # fmt: skip
    d.connect("path", "pid").connect("arm:1-7", "pid", -1.0).connect("limit", "arm")
    for k in range(1, 8):
        d.connect(f"pid:{k}", f"notch{k}").connect(f"notch{k}", f"limit:{k}")
    return d


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
    np.testing.assert_allclose(r["s"][:, 0], [0.0, 0.0, 1.0, 1.0], atol=1e-6)
