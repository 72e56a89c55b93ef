"""A progress bar on terminals, for runs that last: simulated time, speed, expected end."""

from __future__ import annotations

import time
from typing import Any

from spacar.frame import Frame
from spacar.stream import Run
from spacar_cli.environment import Environment

PATIENCE = 0.5  # seconds before a bar appears; a shorter run never imports rich
REFRESH = 0.1


class Progress:
    """A sink that shows how far the run is; it does nothing where standard error is not a terminal."""

    def __init__(self, environment: Environment) -> None:
        self._environment = environment
        self._active = environment.error_is_terminal
        self._bar: Any = None
        self._task: Any = None
        self._due = 0.0
        self._steps = 0

    def start(self, run: Run) -> None:
        self._run = run
        self._begun = time.perf_counter()
        self._due = self._begun + PATIENCE

    def frame(self, frame: Frame) -> None:
        self._steps += 1
        if not self._active or time.perf_counter() < self._due:
            return
        self._due = time.perf_counter() + REFRESH
        if self._bar is None:
            self._open()
        total = self._run.mechanism.settings.duration
        done = frame.t if self._timed else self._steps
        speed = done / (time.perf_counter() - self._begun)
        text = f"t = {frame.t:.6g} s  {speed:.3g} s/s" if self._timed else f"step {self._steps}"
        self._bar.update(self._task, completed=done, total=total if self._timed else self._run.n_frames, text=text)

    def finish(self, error: BaseException | None) -> None:
        if self._bar is not None:
            self._bar.stop()

    @property
    def _timed(self) -> bool:
        """Does simulated time tell how far the run is?"""
        return self._run.mode.integrated and self._run.mechanism.settings.duration is not None

    def _open(self) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

        console = Console(file=self._environment.stderr, no_color=bool(self._environment.variables.get("NO_COLOR")))
        columns = (
            TextColumn("{task.fields[text]}"),
            BarColumn(),
            TaskProgressColumn(),
            TimeRemainingColumn(),
        )
        self._bar = Progress(*columns, console=console, transient=True)
        self._task = self._bar.add_task("", text="")
        self._bar.start()
