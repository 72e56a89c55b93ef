"""What `spacar draw` does once its options are read."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from spacar_drawing.files import FILM, FILM_DPI, check_name, evenly, film, save
from spacar_drawing.history import TimeLine, beside
from spacar_drawing.mechanism_picture import Extras, chosen_steps, picture, series
from spacar_drawing.picture_source import open_source

from spacar_cli.drawing_options import Choices, check_elements
from spacar_cli.environment import Environment
from spacar_cli.progress import frame_progress


def draw(
    environment: Environment, file: str, choices: Choices, extras: Extras, at: str | None, strobe: int | None,
    trace: Sequence[int], no_trace: bool, initial: bool, frames: int, scopes: bool = True,
) -> list[Path]:  # fmt: skip
    """Write all files and open the window that were asked for; returns the files. Raises UsageError."""
    source = open_source(file, choices.stale_ok)
    scene = source.scene
    outputs = choices.output or (() if choices.show else (Path(source.name).parent / f"{scene.title}.png",))
    for path in outputs:
        check_name(path)
    changed = replace(source, settings=choices.overridden(source.settings))
    check_elements(choices.hide, [e.number for e in scene.elements], "--hide: element")
    nodes = list(trace) or ([] if no_trace else list(changed.settings.traces))
    check_elements(nodes, scene.position_nodes.tolist(), "--trace: position node")
    stills = [p for p in outputs if p.suffix.lower() not in FILM]
    films = [p for p in outputs if p.suffix.lower() in FILM]
    table = source.signals if scopes and source.signals is not None and source.signals.panels else None
    if stills:
        numbers = chosen_steps(changed, at, strobe, False)
        figure = picture(changed, extras, numbers, nodes, initial)
        if table is not None:
            beside(figure, table, np.ravel(source.get("t")), table.panels).show(source.time(numbers[-1]))
        for path in stills:
            save(figure, path, choices.dpi)
    if films or choices.show:
        shown = series(changed, extras, chosen_steps(changed, at, None, True), nodes, initial)
        for path in films:
            pictures, count = shown.thinned(frames)
            with frame_progress(environment, count, path.name) as tick:
                moving = shown.moving()
                if table is not None:
                    line = beside(moving.figure, table, np.ravel(source.get("t")), table.panels)
                    moving.beside = [*moving.beside, *line.lines]
                    few = evenly(0, len(shown.numbers) - 1, frames)
                    pictures = _with_line(line, pictures, [source.time(shown.numbers[i]) for i in few])
                film(moving, pictures, count, path, choices.fps, min(choices.dpi, FILM_DPI), tick)
        if choices.show:
            from spacar_drawing.window import open_window, slider_window

            whole: Callable[[int], Any] = shown.whole
            if table is not None:
                t = np.ravel(source.get("t"))
                line = TimeLine(open_window(f"{scene.title}: scopes"), table, t, table.panels)
                whole = _with_line(line, whole, [source.time(k) for k in shown.numbers])
            slider_window(whole, len(shown.numbers), 0, shown.bounds, shown.camera, scene.title, choices.fps)
    return list(outputs)


def _with_line(line: TimeLine, pictures: Callable[[int], Any], at: Sequence[float]) -> Callable[[int], Any]:
    """The pictures, each with the line of the scopes at its time."""

    def show(i: int) -> Any:
        line.show(at[i])
        return pictures(i)

    return show
