"""Where nothing acts, all levels have the state of the start, which is found once."""

import numpy as np
import pytest

import spacar
from spacar.stationary.continuation import Continuation

BEAM = """PLBEAM 1 1 2 3 4   X 3 1. 0.   FIX 1   FIX 2   DYNE 1 2 3   END HALT
EM 1 2.   ESTIFF 1 0. 3.   ITERSTEP 10 3 1e-10   {more}   END END
"""


def solved(mode, more=""):
    return spacar.run(mode, spacar.parse_deck(BEAM.format(more=more), mode))


@pytest.mark.parametrize("general", [False, True])
def test_it_is_the_state_that_an_iteration_finds(general, monkeypatch):
    deck = spacar.parse_deck(BEAM.format(more=""), 7)
    monkeypatch.setattr(Continuation, "is_exact", False)
    expected = spacar.run(7, deck, compiled=not general)
    monkeypatch.undo()
    monkeypatch.setattr(Continuation, "advance", None)  # no iteration
    found = spacar.run(7, deck, compiled=not general)
    x, predicted = ([f.x for f in result.frames] for result in (found, expected))
    np.testing.assert_allclose(x, predicted, rtol=1e-14)  # the prediction of the iteration rounds
    np.testing.assert_allclose(found.frequencies, expected.frequencies, rtol=1e-12)
    assert found.report == expected.report
    assert [f.statistics for f in found.frames] == [f.statistics for f in expected.frames]


@pytest.mark.parametrize("more", ["XF 3 0. 0.1\n", "ESIG 1 0. 0.1\n", "GRAVITY 0. -1.\n"])
def test_what_acts_is_walked_to(more, monkeypatch):
    walked = []
    advance = Continuation.advance
    monkeypatch.setattr(Continuation, "advance", lambda self, level: (walked.append(1), advance(self, level))[1])
    solved(7, more)
    assert walked
