"""Evaluators that leave to Python what C does as well, for the factory of `spacar.forward.motion`; models for both."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from spacar.compiled import CompiledDynamics
from spacar.dynamics import Dynamics
from spacar.forward import motion
from spacar.mechanism.mechanism import Mechanism

CRANK = """PLBEAM 1 1 2 3 4   PLBEAM 2 3 5 6 7   X 1 0. 0.   X 3 0.15 0.   X 6 0.45 0.
FIX 1   FIX 6 2   {drive}   END HALT
EM 1 0.2   EM 2 0.2   XM 6 0.03   {start}   TIMESTEP {times}   END END
"""


def free_crank(times: str) -> str:
    """It begins with 30 rad/s."""
    return CRANK.format(drive="DYNX 2 1", start="STARTDX 2 1 0. 30.", times=times)


PENDULUM = """PLBEAM 1 1 2 3 4   X 1 0. 0.   X 3 1. 0.   FIX 1   DYNX 2 1   END HALT
EM 1 1.0   XM 3 1.0   GRAVITY 0. -9.81   TIMESTEP 1. 20   END END
"""


def pushed(folder: Path, body: str, deck: str = PENDULUM) -> Path:
    """The deck with a user function `push`, of which this is the body."""
    (folder / "push.py").write_text(f"def push(t, ne, le, e, ep, nx, lnp, x, xp):\n    {body}\n")
    path = folder / "model.dat"
    path.write_text(deck.replace("TIMESTEP", "USERSIG push   TIMESTEP"))
    return path


def started(mechanism: Mechanism) -> tuple[Dynamics, CompiledDynamics, np.ndarray]:
    """Both evaluators at the start of the motion, and its state."""
    general, compiled = Dynamics(mechanism), CompiledDynamics(mechanism)
    y = general.start()
    compiled.start()
    return general, compiled, y


class OneByOne(CompiledDynamics):
    """Steps are made one by one."""

    def stepper(self, *_: Any) -> None:  # type: ignore[override]
        return None


class IterationInPython(CompiledDynamics):
    """The Newton iteration of codes 553 and 595 asks for stages."""

    def newton(self, *_: Any) -> None:
        return None


def take(monkeypatch: pytest.MonkeyPatch, kind: type[CompiledDynamics]) -> None:
    """Runs follow their motion with this evaluator from now on."""
    monkeypatch.setattr(motion, "chosen", lambda run: kind(run.mechanism))
