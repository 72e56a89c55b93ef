"""Inputs whose column of B is zero are named, with what to write instead; inputs that act need no word."""

import numpy as np
import pytest

import spacar

QUARTER_CAR = """PLTRUSS 1 1 3   PLTRUSS 2 3 5   X 1 0 0   X 3 {c} {s}   X 5 {c2} {s2}
INPUTX 1 1   FIX 1 2   {wheel}   RLSE 1 1   RLSE 2 1   END HALT
XM 3 40   XM 5 300   ESTIFF 1 2e5   ESTIFF 2 2e4   EDAMP 2 1000   {tyre}   TIMESTEP 0.1 2   END HALT
{signal}   OUTX 1 5 1   END END
"""
ALONG_X = "FIX 3 2\nFIX 5 2\nDYNX 3 1\nDYNX 5 1"


def car(signal: str, tyre: str = "", mode: int = 9) -> spacar.Result:
    text = QUARTER_CAR.format(signal=signal, tyre=tyre, wheel=ALONG_X, c=1, s=0, c2=2, s2=0)
    return spacar.run(mode, spacar.parse_deck(text, mode=mode))


def told(result: spacar.Result) -> list[str]:
    return [line for line in result.report if "column of B" in line]


@pytest.mark.parametrize("mode", [4, 9])
@pytest.mark.parametrize(
    ("signal", "tyre", "advice"),
    [
        ("INXP 1 1 1", "", "no damper couples its rate"),
        ("INXDP 1 1 1", "", "no mass couples its acceleration"),
        ("INXDP 1 1 1", "EDAMP 1 50", "write INX and INXP 1 ..."),
    ],
)
def test_road_input_that_does_not_act(mode, signal, tyre, advice):
    result = car(signal, tyre, mode)
    assert not result["B"][0].any()
    (line,) = told(result)
    assert line.startswith(f"warning: input 1 ({signal.split()[0]} node 1 x)")
    assert advice in line
    assert "INX" in line
    assert "DYNX" in line


@pytest.mark.parametrize(
    ("signal", "tyre", "column"),
    [
        ("INX 1 1 1", "", [0, 0, 2e5 / 40, 0]),
        ("INXP 1 1 1", "EDAMP 1 50", [0, 0, 50 / 40, 0]),
        ("INXDP 1 1 1", "EM 1 12", [0, 0, -12 / 6 / (40 + 12 / 3), 0]),
        ("INPUTF 1 5 1", "", [0, 0, 0, 1 / 300]),
        ("INPUTS 1 2 1", "", [0, 0, -1 / 40, 1 / 300]),
    ],
)
def test_inputs_that_act(signal, tyre, column):
    """Closed forms of the wheel (40 kg) and the body (300 kg); the truss of 12 kg has the consistent mass 4, 2, 4."""
    result = car(signal, tyre)
    assert told(result) == []
    assert result["B"][0][:, 0] == pytest.approx(column, rel=1e-12, abs=1e-15)


def test_a_force_on_a_coordinate_that_does_not_move():
    """The middle of a rigid beam on a pivot: its tip moves, the pivot of its other end does not."""
    text = (
        "PLRBEAM 1 1 2 3\nPLRBEAM 2 1 2 4\nX 3 1 0\nX 4 0 0.5\nFIX 1\nDYNX 2\nEND\nHALT\nXM 3 1\nXM 4 1\nEND\nHALT\n"
        "INPUTF 1 3 1\nINPUTF 2 3 2\nOUTX 1 2 1\nEND\nEND\n"
    )
    result = spacar.run(9, spacar.parse_deck(text, mode=9))
    (line,) = told(result)
    assert line.startswith("warning: input 1 (INPUTF node 3 x)")
    assert "DYNX" in line
    assert np.count_nonzero(result["B"][0][:, 1]) == 1
