"""What `spacar draw` does once its options are read."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from spacar.errors import UsageError
from spacar_cli.drawing.files import FILM, check_name, film, save
from spacar_cli.drawing.look import GHOST, Look, look_of
from spacar_cli.drawing.mechanism_picture import (
    camera_of,
    draw_steps,
    mechanism_shapes,
    outline_shapes,
    series_bounds,
)
from spacar_cli.drawing.moving import Moving, Pictures, evenly
from spacar_cli.drawing.options import Choices, check_elements
from spacar_cli.drawing.progress import frame_progress
from spacar_cli.drawing.scene import Array
from spacar_cli.drawing.shapes import Shape, merge_bounds
from spacar_cli.drawing.source import Source, open_source
from spacar_cli.drawing.supports import trace_lines
from spacar_cli.environment import Environment

SAMPLES = 60  # configurations that decide the range of an animation


def draw(
    environment: Environment,
    file: str,
    choices: Choices,
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
        _still(changed, choices, stills, steps, strobe, nodes, initial)
    if films or choices.show:
        _film(environment, changed, choices, films, steps, nodes, initial, frames)
    return list(outputs)


def chosen_steps(source: Source, steps: str | None, strobe: int | None, moving: bool) -> list[int]:
    """Step numbers from 1. Raises UsageError for steps that do not exist."""
    from spacar_formats.getfrsbf import step_numbers

    if strobe:
        return evenly(1, source.steps, strobe)
    if steps is None:
        if moving:
            return list(range(1, source.steps + 1))
        return [source.steps if source.scene.analysis.stationary else 1]
    if steps.strip().lower() == "all":
        return list(range(1, source.steps + 1))
    found = step_numbers(steps, source.steps)
    numbers = [found] if isinstance(found, int) else found
    wrong = [k for k in numbers if not 1 <= k <= source.steps]
    if wrong:
        raise UsageError(f"step {wrong[0]} does not exist: {source.name} has steps 1 to {source.steps}", "files.step")
    return numbers


def configurations(source: Source, numbers: Sequence[int]) -> Array:
    """(steps, nx) coordinates, reading only these steps."""
    if len(numbers) == source.steps:
        return source.x()
    return np.stack([source.x(k) for k in numbers])


def step_text(source: Source, k: int) -> str:
    """What stands above the picture of a step."""
    t = source.time(k)
    if source.scene.analysis.stationary:
        return f"{source.scene.title}   load step {k}" if source.steps > 1 else source.scene.title
    return f"{source.scene.title}   t = {t:.6g} s" if source.steps > 1 else source.scene.title


def _still(
    source: Source,
    choices: Choices,
    outputs: Sequence[Path],
    steps: str | None,
    strobe: int | None,
    nodes: Sequence[int],
    initial: bool,
) -> None:
    numbers = chosen_steps(source, steps, strobe, False)
    xs = configurations(source, numbers)
    every = source.x() if nodes else None
    title = choices.title if choices.title is not None else step_text(source, numbers[-1])
    if len(numbers) > 1 and choices.title is None:
        first, last = source.time(numbers[0]), source.time(numbers[-1])
        title = f"{source.scene.title}   {len(numbers)} steps, t = {first:.4g} to {last:.4g} s"
    behind = source.x(1) if initial else None
    figure = draw_steps(
        source.scene,
        xs,
        source.settings,
        replace(choices.extras(), title=title),
        every_step=every,
        traces=nodes,
        behind=behind,
    )
    for path in outputs:
        save(figure, path, choices.dpi)


def _film(
    environment: Environment,
    source: Source,
    choices: Choices,
    outputs: Sequence[Path],
    steps: str | None,
    nodes: Sequence[int],
    initial: bool,
    frames: int,
) -> None:
    numbers = chosen_steps(source, steps, None, True)
    scene, extras = source.scene, choices.extras()
    sample = configurations(source, [numbers[i] for i in evenly(0, len(numbers) - 1, SAMPLES)])
    look = look_of(scene, sample, source.settings)
    camera = camera_of(scene, choices.view)
    low, high = series_bounds(scene, sample, look, extras, SAMPLES)
    still: list[Shape] = trace_lines(scene, source.x(), nodes) if nodes else []
    if initial:
        still += outline_shapes(scene, source.x(1), look, source.settings.initial_colour or GHOST)
    box = merge_bounds(still)
    if box is not None:
        low, high = np.minimum(low, box[0]), np.maximum(high, box[1])
    if outputs:
        few = [numbers[i] for i in evenly(0, len(numbers) - 1, frames)]
        for path in outputs:
            moving = Moving.create((low, high), camera, still)
            with frame_progress(environment.error_is_terminal, len(few), path.name) as tick:
                film(
                    moving,
                    pictures_of(source, few, look, choices, []),
                    len(few),
                    path,
                    choices.fps,
                    min(choices.dpi, 110.0),
                    tick,
                )
    if choices.show:
        from spacar_cli.drawing.window import slider_window

        slider_window(
            pictures_of(source, numbers, look, choices, still),
            len(numbers),
            0,
            (low, high),
            camera,
            scene.title,
            choices.fps,
        )


def pictures_of(
    source: Source, numbers: Sequence[int], look: Look, choices: Choices, still: Sequence[Shape]
) -> Pictures:
    """Frame number -> shapes and title; reads the step when it is asked for."""
    extras = choices.extras()

    def picture(i: int) -> tuple[Sequence[Shape], str]:
        k = numbers[i]
        shapes = [*still, *mechanism_shapes(source.scene, source.x(k), look, extras)]
        return shapes, choices.title if choices.title is not None else step_text(source, k)

    return picture
