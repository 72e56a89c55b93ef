"""The Newton iteration of codes 553 and 595 in C makes the steps of the one in Python, with the same counts."""

from typing import Any

import numpy as np
import pytest

import spacar
from spacar.compiled import CompiledDynamics
from spacar.compiled.library import why_off
from spacar.integrators import radau
from tests.examples import DATA

from .other_ways import IterationInPython, take

COUNTS = ("steps", "rhs", "jacobians", "rejected", "iterations")

pytestmark = pytest.mark.skipif(why_off() is not None, reason=str(why_off()))


def both(monkeypatch: pytest.MonkeyPatch, source: object, code: int, **options: float) -> list[spacar.Result]:
    """Results with the iteration in C, and in Python, which it leaves without a trace."""
    calls = []

    class Counted(CompiledDynamics):
        def newton(self, *arguments: Any) -> tuple[bool, float, float] | None:
            calls.append(super().newton(*arguments))
            return calls[-1]

    found = []
    for kind in (Counted, IterationInPython):
        take(monkeypatch, kind)
        found.append(spacar.run(1, source, integrator=code, **options))  # type: ignore[arg-type]
    assert calls
    assert None not in calls
    return found


FREE = """PLTRUSS 1 1 2   X 2 1 0   DYNX 1   DYNX 2   RLSE 1 1   END HALT
XM 1 2   XM 2 1   ESTIFF 1 50   STARTDX 2 2 0 3   END END"""


@pytest.mark.parametrize("code", [553, 595])
@pytest.mark.parametrize("name", ["crankfl", "fingersim", "trike2", "trike3v", "free"])
def test_the_same_steps(monkeypatch: pytest.MonkeyPatch, name: str, code: int) -> None:
    """Flexible; belts; wheels, whose kinematic coordinates leave no positions that are integrals; Euler parameters; no
    coordinate but degrees of freedom."""
    options = {"duration": 0.01 if name == "crankfl" else 0.1, "n_steps": 4, "atol": 1e-6, "rtol": 1e-6}
    source = spacar.parse_deck(FREE, "free", 1) if name == "free" else DATA / f"{name}.dat"
    in_c, in_python = both(monkeypatch, source, code, **options)
    for a, b in zip(in_c.frames, in_python.frames, strict=True):
        assert [a.statistics.get(k) for k in COUNTS] == [b.statistics.get(k) for k in COUNTS]
    for what, within in (("x", 1e-9), ("xd", 1e-7), ("e", 1e-9)):
        size = max(1.0, float(np.abs(in_python[what]).max()))
        np.testing.assert_allclose(in_c[what], in_python[what], rtol=0, atol=within * size)


def test_steps_that_do_not_converge(monkeypatch: pytest.MonkeyPatch) -> None:
    """A first step that is far too long: the iteration fails, with the same words in both; shorter steps are tried."""
    failed = []
    slow = radau.slow_newton

    def spy(*arguments: object) -> object:
        failure = slow(*arguments)  # type: ignore[arg-type]
        failed.append(str(failure))
        return failure

    monkeypatch.setattr(radau, "slow_newton", spy)
    options = {"duration": 0.05, "n_steps": 2, "step": 0.05, "atol": 1e-4, "rtol": 1e-4}
    in_c, in_python = both(monkeypatch, DATA / "crankfl.dat", 595, **options)
    half = len(failed) // 2
    assert half > 0
    assert [text[:60] for text in failed[:half]] == [text[:60] for text in failed[half:]]
    np.testing.assert_allclose(in_c["x"], in_python["x"], rtol=0, atol=1e-8)
