"""Pictures are drawn under the defaults of Matplotlib, not under the matplotlibrc of a user or of a foreign folder."""

from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")
_within: list[None] = []  # calls under way


def plain(function: Callable[P, R]) -> Callable[P, R]:
    """The function under the defaults; only the backend, with which windows open, stays that of the user."""

    @wraps(function)
    def called(*args: P.args, **options: P.kwargs) -> R:
        if _within:
            return function(*args, **options)
        import matplotlib

        defaults = {name: value for name, value in matplotlib.rcParamsDefault.items() if name not in OF_WINDOWS}
        _within.append(None)
        try:
            with matplotlib.rc_context(defaults):
                return function(*args, **options)
        finally:
            _within.pop()

    return called


OF_WINDOWS = ("backend", "backend_fallback", "interactive", "toolbar", "webagg.address", "webagg.port")
