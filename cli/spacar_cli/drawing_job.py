"""What `spacar draw` does once its options are read."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from spacar_drawing.files import FILM, FILM_DPI, check_name, film, save
from spacar_drawing.mechanism_picture import Extras
from spacar_drawing.picture_source import open_source
from spacar_drawing.step_pictures import chosen_steps, picture, series

from spacar_cli.drawing_options import Choices, check_elements
from spacar_cli.environment import Environment
from spacar_cli.frame_progress import frame_progress


def draw(
    environment: Environment,
    file: str,
    choices: Choices,
    extras: Extras,
    steps: str | None,
    strobe: int | None,
    trace: Sequence[int],
    no_trace: bool,
    initial: bool,
    frames: int,
) -> list[Path]:
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
    if stills:
        figure = picture(changed, extras, chosen_steps(changed, steps, strobe, False), nodes, initial)
        for path in stills:
            save(figure, path, choices.dpi)
    if films or choices.show:
        shown = series(changed, extras, chosen_steps(changed, steps, None, True), nodes, initial)
        pictures, count = shown.thinned(frames)
        for path in films:
            with frame_progress(environment.error_is_terminal, count, path.name) as tick:
                film(shown.moving(), pictures, count, path, choices.fps, min(choices.dpi, FILM_DPI), tick)
        if choices.show:
            from spacar_drawing.window import slider_window

            slider_window(shown.whole, len(shown.numbers), 0, shown.bounds, shown.camera, scene.title, choices.fps)
    return list(outputs)
