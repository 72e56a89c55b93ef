"""What an analysis states besides its frames: scalars and arrays by name (NNOM, NU, NY, condition ...).

A value that few ask for, and that costs more than a step of a small model, may be stated as the function that gives it:
it is called once, when the value is asked for, in whatever way. It must hold all that it needs.
"""

from __future__ import annotations

from collections import UserDict
from collections.abc import Callable
from typing import Any


class Later:
    """A value that is computed when it is asked for."""

    def __init__(self, compute: Callable[[], Any]) -> None:
        self.compute = compute


class Stated(UserDict[str, Any]):
    """A dictionary whose values may have been stated `later`."""

    def later(self, name: str, compute: Callable[[], Any]) -> None:
        """The value of `name` is what `compute` gives when somebody asks for it."""
        self.data[name] = Later(compute)

    def __getitem__(self, name: str) -> Any:
        value = super().__getitem__(name)
        if isinstance(value, Later):
            value = self.data[name] = value.compute()
        return value

    def __repr__(self) -> str:
        return repr(dict(self))

    def copy(self) -> Stated:
        """One of the same values; what has not been asked for is not computed."""
        other = Stated()
        other.data = self.data.copy()
        return other

    def __reduce__(self) -> Any:
        return Stated, (dict(self),)
