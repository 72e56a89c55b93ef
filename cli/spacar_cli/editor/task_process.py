"""The other side of `task_worker`: asks a process, and replaces it when it does not answer in time or dies."""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import sys
from collections.abc import Sequence
from queue import Empty, Queue
from threading import Lock, Thread
from typing import Any

from spacar.errors import UsageError

COMMAND = (sys.executable, "-m", "spacar_cli.editor.task_worker")
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "PYTHONIOENCODING": "utf-8"}


class TaskProcess:
    """One process, started when it is first asked; questions wait for each other."""

    def __init__(self, command: Sequence[str] = COMMAND) -> None:
        self._command = command
        self._lock = Lock()
        self._process: subprocess.Popen[str] | None = None
        self._lines: Queue[str | None] = Queue()

    def ask(self, task: str, arguments: dict[str, Any], seconds: float) -> str:
        """The answer as the worker wrote it, JSON. Raises UsageError with the reason why there is none; the process is
        another one after a death and after `seconds` without an answer."""
        with self._lock:
            process = self._running()
            assert process.stdin is not None
            try:
                process.stdin.write(json.dumps({"task": task, "arguments": arguments}) + "\n")
                process.stdin.flush()
                line = self._lines.get(timeout=seconds)
            except Empty:
                self._end()
                text = f"{task}: no answer within {seconds:g} s; the process was stopped and another one is started"
                raise UsageError(text, "edit.hung") from None
            except OSError:
                line = None
            if line is None:
                self._end()
                raise UsageError(f"{task}: the process ended without an answer; another one is started", "edit.died")
        return line

    def _running(self) -> subprocess.Popen[str]:
        if self._process is None or self._process.poll() is not None:
            self._end()
            self._lines = Queue()
            self._process = subprocess.Popen(
                self._command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, encoding="utf-8",
                errors="backslashreplace", env={**os.environ, **ONE_THREAD},
            )  # fmt: skip
            Thread(target=_read, args=(self._process, self._lines), daemon=True).start()
        return self._process

    def _end(self) -> None:
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            for stream in (self._process.stdin, self._process.stdout):
                with contextlib.suppress(OSError):
                    if stream is not None:
                        stream.close()
            self._process = None

    def close(self) -> None:
        """End the process; a question that waits gets no answer."""
        process = self._process
        if process is not None:
            process.kill()
        with self._lock:
            self._end()


def _read(process: subprocess.Popen[str], lines: Queue[str | None]) -> None:
    assert process.stdout is not None
    with contextlib.suppress(ValueError, OSError):
        for line in process.stdout:
            lines.put(line)
    lines.put(None)
