"""Motions that come to a dead point of their degree of freedom and do not get past it: they end, in few evaluations."""

import numpy as np
import pytest

import spacar
from spacar.dynamics.motion_equations import EquationsOfMotion
from spacar.errors import AnalysisError
from spacar.kinematics.kinematics import Kinematics

from .test_singular_positions import free_slider

FALLING = """
PLBEAM 1 1 2 3 4   PLBEAM 2 3 5 6 7   X 3 0.15 0.1   X 6 0.45 0.   FIX 1   FIX 6 2   DYNX 6 1
END HALT
XM 6 0.03   EM 1 0.2   EM 2 0.2   GRAVITY 0. -9.81   STARTDX 6 1 0.45 1.   TIMESTEP 1. 10   END END
"""


class Work:
    """Counts right-hand sides and Newton iterations of the general path."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.rhs = self.newton = 0
        rhs, newton = EquationsOfMotion.rhs, Kinematics._newton

        def counted_rhs(*given):
            self.rhs += 1
            return rhs(*given)

        def counted_newton(*given):
            self.newton += 1
            return newton(*given)

        monkeypatch.setattr(EquationsOfMotion, "rhs", counted_rhs)
        monkeypatch.setattr(Kinematics, "_newton", counted_newton)


def test_a_falling_slider_crank_does_not_creep_at_its_dead_points(monkeypatch: pytest.MonkeyPatch) -> None:
    """It passes two dead points with warnings and on most processors comes to stand at a later one, which the slider
    reaches at R + L; steps of 1e-6 s and less made it creep there for more than a minute. Each passage loses digits, so
    rounding decides where it stands, or whether it passes them all."""
    work = Work(monkeypatch)
    run = spacar.frames(1, spacar.parse_deck(FALLING, mode=1), compiled=False)
    failure: AnalysisError | None = None
    try:
        list(run)
    except AnalysisError as error:
        failure = error
    assert failure is None or failure.code == "position.singular"
    assert any("dead point" in line for line in (*run.report.lines, str(failure)))
    assert work.rhs < 3000
    assert work.newton < 2 * work.rhs


@pytest.mark.parametrize("tolerance", [1e-5, 1e-9])
def test_a_slider_at_its_dead_centre_ends_with_few_positions(tolerance: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every stage beyond the dead point asked for eleven positions of twenty iterations; a way shorter than rounding is
    not halved now."""
    work = Work(monkeypatch)
    with pytest.raises(AnalysisError, match="dead point") as found:
        spacar.run(1, free_slider(0.4, 1e-2, tolerance, 155, 0.1, 1.0), compiled=False)
    assert found.value.code == "position.singular"
    assert work.newton < 1.5 * work.rhs + 100
    t = float(str(found.value).split("t = ")[1].split(":")[0])
    assert np.isclose(t, 0.4, atol=2e-4)  # the crank turns with -1 rad/s from 0.4


STRETCHED = """
PLTRUSS 1 1 3  PLTRUSS 2 2 3  PLTRUSS 3 3 4
X 1 0. 0.  X 2 1.5 0.  X 3 0.75 0.6614378277661477  X 4 0.75 1.5
FIX 1  FIX 2  INPUTE 2 1  DYNE 3 1  DYNX 4 1  END HALT
XM 3 1.  XM 4 1.  ESTIFF 3 100.  INPUTE 2 1 0. 1.  TIMESTEP 2. 20  END END
"""


@pytest.mark.parametrize("code", [-1, 0, 155, 853])
@pytest.mark.parametrize("compiled", [True, False])
def test_bars_that_are_driven_to_their_whole_length(code: int, compiled: bool) -> None:
    """Two bars of 1 m between supports 1.5 m apart, one of them 1 + t long: in line at t = 1.5 s. The velocity is
    infinite there; the error is that of the dead point, not of a stiff model."""
    with pytest.raises(AnalysisError, match="dead point of the degrees of freedom, where the integration") as found:
        spacar.run(1, spacar.parse_deck(STRETCHED, mode=1), integrator=code, compiled=None if compiled else False)
    assert found.value.code == "position.singular"
    assert np.isclose(found.value.data["t"], 1.5, rtol=0, atol=1e-6)
