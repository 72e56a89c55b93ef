"""Ctrl-C that is not lost.

An exception cannot leave a destructor or the callback of a weak reference: Python prints a traceback and goes on. A
Ctrl-C that falls into one, which happens in large garbage collections, would be ignored. It is repeated soon after.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

SOON = 0.01  # seconds: such callbacks take microseconds


@contextmanager
def lasting() -> Iterator[None]:
    """Repeat interruptions that callbacks of the interpreter swallow."""
    before = sys.unraisablehook

    def again(unraisable: Any) -> None:
        if unraisable.exc_type is not KeyboardInterrupt:
            before(unraisable)
            return
        import _thread
        import threading

        timer = threading.Timer(SOON, _thread.interrupt_main)
        timer.daemon = True
        timer.start()

    sys.unraisablehook = again
    try:
        yield
    finally:
        sys.unraisablehook = before
