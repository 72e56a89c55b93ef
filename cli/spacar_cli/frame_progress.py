"""A bar for long animations: frames, speed, expected end. On terminals only, unless quiet."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from spacar_drawing.files import Tick

SHORT = 20  # fewer frames need no bar


@contextmanager
def frame_progress(shown: bool, count: int, label: str) -> Iterator[Tick | None]:
    """A function to be told the number of finished frames, or None where no bar is wanted."""
    if not shown or count < SHORT:
        yield None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (
        TextColumn(label), BarColumn(), MofNCompleteColumn(), TextColumn("{task.fields[rate]}"), TimeRemainingColumn()
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(label, total=count, rate="")

        def tick(done: int) -> None:
            speed = bar.tasks[0].speed
            bar.update(task, completed=done, rate=f"{speed:.1f} frames/s" if speed else "")

        yield tick
