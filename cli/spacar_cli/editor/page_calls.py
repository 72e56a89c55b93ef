"""What the page may ask its server: the file, the tasks of `model_tasks`, runs; every call gives JSON."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from threading import Event
from typing import Any

from spacar.errors import UsageError
from spacar_cli.editor.edited_file import EditedFile, result_file
from spacar_cli.editor.mode_job import ModeJob
from spacar_cli.editor.task_process import TaskProcess

TYPED = ("check", "picture")  # tasks that follow the keys
SECONDS = 120.0, 20.0  # for what a click asks for, and for what follows the keys
READING = ("state", "open", "task", "log", "end")  # what a page that watches may ask


class PageCalls:
    """The calls of one page; `ended` is set when it wants the server to end."""

    def __init__(self, path: Path, watch: bool = False) -> None:
        self.file = EditedFile(path)
        self.watch = watch
        self.ended = Event()
        self._processes = TaskProcess(), TaskProcess()  # as SECONDS
        self._job = ModeJob(path)
        self._calls: dict[str, Callable[..., Any]] = {
            "open": self.file.read, "save": self.file.save, "state": self._state, "run": self._job.start,
            "abort": self._job.abort, "log": self._log, "end": self.ended.set,
        }  # fmt: skip

    def call(self, name: str, arguments: dict[str, Any]) -> str:
        """The answer to one call, {"result": ...} or of a task {"error": text}. Raises SpacarError; TypeError and
        KeyError for what is no call."""
        if self.watch and name not in READING:
            raise UsageError("this page only watches", "edit.watch")
        if name == "task":
            return self._task(arguments["task"], arguments["arguments"])
        return json.dumps({"result": self._calls[name](**arguments)})

    def _state(self, progress: bool = False) -> dict[str, Any]:
        """What may change by itself: the digest of the file, the inode of its result (each is a new file), the run."""
        found = self._job.state() | {"digest": self.file.digest()}
        written = result_file(self.file.path, "sbd")
        found["result"] = written.stat().st_ino if written.is_file() else 0
        if progress and found["running"]:
            found["progress"] = json.loads(self._task("progress", {})).get("result")
        return found

    def _log(self) -> str:
        """The log of the last run, empty without one."""
        path = result_file(self.file.path, "log")
        return path.read_text("utf-8", "replace") if path.is_file() else ""

    def _task(self, task: str, arguments: dict[str, Any]) -> str:
        typed = task in TYPED
        return self._processes[typed].ask(task, {**arguments, "file": str(self.file.path)}, SECONDS[typed])

    def close(self) -> None:
        """End the processes."""
        self._job.close()
        for process in self._processes:
            process.close()
