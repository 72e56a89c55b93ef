"""A progress bar on terminals, for runs and animations that last: simulated time or pictures, speed, expected end."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from spacar.frame import Frame
from spacar.stream import Run
from spacar_cli.environment import Environment

if TYPE_CHECKING:
    from spacar_drawing.files import Tick

PATIENCE = 0.5  # seconds before a bar appears; a shorter run never imports rich
REFRESH = 0.1


class Bar:
    """A bar with a text beside it; it does nothing where standard error is not a terminal."""

    def __init__(self, environment: Environment) -> None:
        self._environment = environment
        self._bar: Any = None
        self._begun = time.perf_counter()
        self._due = self._begun + PATIENCE if environment.shows_progress else float("inf")

    @property
    def due(self) -> bool:
        return time.perf_counter() >= self._due

    def show(self, done: float, total: float | None, text: str) -> None:
        self._due = time.perf_counter() + REFRESH
        if self._bar is None:
            self._open()
        self._bar.update(self._task, completed=done, total=total, text=text)

    def show_time(self, t: float, done: float, total: float | None) -> None:
        """Simulated time t, `done` of `total` [s], and how fast it passes."""
        speed = done / (time.perf_counter() - self._begun)
        self.show(done, total, f"t = {t:.6g} s  {speed:.3g} s/s")

    def close(self) -> None:
        if self._bar is not None:
            self._bar.stop()

    def _open(self) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

        console = Console(file=self._environment.stderr, no_color=bool(self._environment.variables.get("NO_COLOR")))
        columns = (TextColumn("{task.fields[text]}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn())
        self._bar = Progress(*columns, console=console, transient=True)
        self._task = self._bar.add_task("", text="")
        self._bar.start()


class Progress:
    """A sink that shows how far the run is."""

    def __init__(self, environment: Environment) -> None:
        self._environment = environment
        self._steps = 0

    def start(self, run: Run) -> None:
        self._run = run
        self._bar = Bar(self._environment)

    def frame(self, frame: Frame) -> None:
        self._steps += 1
        if not self._bar.due:
            return
        total = self._run.mechanism.settings.duration
        if self._run.mode.integrated and total is not None:  # simulated time tells how far the run is
            self._bar.show_time(frame.t, frame.t, total)
        else:
            self._bar.show(self._steps, self._run.n_frames, f"step {self._steps}")

    def finish(self, error: BaseException | None) -> None:
        self._bar.close()


@contextmanager
def frame_progress(environment: Environment, count: int, label: str) -> Iterator[Tick]:
    """A function to be told the number of finished pictures of an animation."""
    bar, begun = Bar(environment), time.perf_counter()

    def tick(done: int) -> None:
        if bar.due:
            bar.show(done, count, f"{label}  {done}/{count}  {done / (time.perf_counter() - begun):.1f} frames/s")

    try:
        yield tick
    finally:
        bar.close()
