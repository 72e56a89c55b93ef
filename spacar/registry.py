"""What lies above the module that calls it: pictures, result files, tables, public calls. `spacar` says where.

A method such as `result.draw()` is for users of Python; the room of results knows no pictures. It asks for `draw`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

_finders: list[Callable[[str], Any]] = []


def register(find: Callable[[str], Any]) -> Callable[[str], Any]:
    """From now on `find` gives what has a name; it raises ImportError where that is not installed."""
    _finders[:] = [find]
    return find


def registered(name: str) -> Any:
    """The function of this name. Raises ImportError where its package is not installed."""
    return _finders[0](name)
