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

QUICK = 10.0  # seconds for messages and pictures while typing
SLOW = 120.0  # for everything that a click asks for
TYPED = ("check", "picture")
READING = ("state", "open", "task", "log", "end")  # what a page that watches may ask


class PageCalls:
    """The calls of one page; `ended` is set when it wants the server to end."""

    def __init__(self, path: Path, watch: bool = False, seconds: tuple[float, float] = (QUICK, SLOW)) -> None:
        self.file = EditedFile(path)
        self.watch = watch
        self.ended = Event()
        self._seconds = seconds
        self._processes = TaskProcess(), TaskProcess()  # for what is typed, for what may take long
        self._job = ModeJob(path)
        self._calls: dict[str, Callable[..., Any]] = {
            "open": self.open, "state": self.state, "save": self.save, "run": self.run, "abort": self.abort,
            "log": self.log, "end": self.end,
        }  # fmt: skip

    def call(self, name: str, arguments: dict[str, Any]) -> str:
        """The answer to one call, {"result": ...} or of a task {"error": text}. Raises SpacarError; TypeError and
        KeyError for what is no call."""
        if self.watch and name not in READING:
            raise UsageError("this page only watches", "edit.watch")
        if name == "task":
            return self._task(arguments["task"], arguments["arguments"])
        return json.dumps({"result": self._calls[name](**arguments)})

    def open(self) -> dict[str, Any]:
        """The file as it is now."""
        found = self.file.read()
        return {"text": found.text, "digest": found.digest, "newline": found.newline, "marked": found.marked}

    def state(self, progress: bool = False) -> dict[str, Any]:
        """What may change by itself: the digest of the file, the inode of its result (each is a new file), the run."""
        found = self._job.state() | {"digest": self.file.digest()}
        written = result_file(self.file.path, "sbd")
        found["result"] = written.stat().st_ino if written.is_file() else 0
        if progress and found["running"]:
            found["progress"] = json.loads(self._task("progress", {})).get("result")
        return found

    def save(self, text: str, digest: str, newline: str, marked: bool, force: bool = False) -> str:
        """Its new digest."""
        return self.file.save(text, digest, newline, marked, force)

    def run(self, mode: int) -> None:
        """Start a run of the file as it is saved; its user functions are executed."""
        self._job.start(mode)

    def abort(self) -> None:
        """End the run; what is stored is kept."""
        self._job.abort()

    def log(self) -> str:
        """The log of the last run, empty without one."""
        path = result_file(self.file.path, "log")
        return path.read_text("utf-8", "replace") if path.is_file() else ""

    def end(self) -> None:
        """The server ends."""
        self.ended.set()

    def _task(self, task: str, arguments: dict[str, Any]) -> str:
        typed = task in TYPED
        told = {**arguments, "file": str(self.file.path)}
        return self._processes[not typed].ask(task, told, self._seconds[not typed])

    def close(self) -> None:
        """End the processes."""
        self._job.close()
        for process in self._processes:
            process.close()
