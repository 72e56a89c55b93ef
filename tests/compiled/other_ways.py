"""Evaluators that leave to Python what C does as well, for the factory of `spacar.forward.motion`."""

from typing import Any

import pytest

from spacar.compiled import CompiledDynamics
from spacar.forward import motion


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
