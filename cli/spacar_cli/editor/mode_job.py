"""A run that the page asked for: `spacar MODE FILE --json` in a process of its own, as a user would type it."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from pathlib import Path
from threading import Lock, Thread, Timer
from typing import Any

from spacar.errors import UsageError
from spacar.modes import find_mode

PATIENCE = 5.0  # seconds after which a run that was asked to end is killed
# Ctrl-C at the server does not reach a run before the server has ended it
OWN_GROUP: Any = {"start_new_session": True}
STOP = signal.SIGINT
if sys.platform == "win32":
    OWN_GROUP = {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP}
    STOP = signal.CTRL_BREAK_EVENT
MOST_TOLD = 4000  # letters of what a run says


class ModeJob:
    """At most one run at a time of one file."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._lock = Lock()
        self._process: subprocess.Popen[str] | None = None
        self._begun = 0.0
        self._state: dict[str, Any] = {"running": False, "mode": None}

    def start(self, mode: int) -> None:
        """Raises UsageError for a mode that there is not, and while another run goes on."""
        number = find_mode(mode).number
        with self._lock:
            if self._state["running"]:
                raise UsageError("a run goes on; abort it, or wait", "edit.running")
            words = [sys.executable, "-m", "spacar_cli.main", str(number), self._path.name, "--json"]
            self._begun = time.monotonic()
            self._process = subprocess.Popen(
                words, cwd=self._path.parent, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                text=True, encoding="utf-8", errors="backslashreplace", **OWN_GROUP,
            )  # fmt: skip
            self._state = {"running": True, "mode": number}
            Thread(target=self._wait, args=(self._process,), daemon=True).start()

    def _wait(self, process: subprocess.Popen[str]) -> None:
        out, told = process.communicate()
        try:
            summary = json.loads(out.splitlines()[-1])
        except (ValueError, IndexError):
            summary = {}
        ended = {"running": False, "status": process.returncode, "told": told[-MOST_TOLD:],
                 "seconds": time.monotonic() - self._begun}  # fmt: skip
        with self._lock:
            self._state |= ended | {name: summary.get(name) for name in ("steps", "error", "code")}

    def state(self) -> dict[str, Any]:
        """running, mode, and when it has ended status, told, steps, seconds, error, code."""
        with self._lock:
            return dict(self._state)

    def abort(self) -> None:
        """As Ctrl-C: what is stored so far is kept."""
        if self._process is not None and self._process.poll() is None:
            self._process.send_signal(STOP)
            kill = Timer(PATIENCE, self._process.kill)
            kill.daemon = True
            kill.start()

    def close(self) -> None:
        """End a run that goes on."""
        self.abort()
        if self._process is not None:
            self._process.wait()
