"""`spacar draw FILE`: the mechanism at one or more steps, as a picture, an animation or in a window."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from spacar_drawing.files import FILM, FILM_DPI, check_name, evenly, film, save
from spacar_drawing.history import TimeLine, beside
from spacar_drawing.mechanism_picture import chosen_steps, picture, series
from spacar_drawing.scene import check_numbers

from spacar.errors import UsageError
from spacar_cli import vocabulary as words
from spacar_cli.drawing_options import Choices, common, symbol_kinds
from spacar_cli.environment import Environment
from spacar_cli.progress import frame_progress


@words.command("draw")
@common
@words.option(
    "at", "; also several: 2:5, 1:10:end, 1,4,9 or all; the last one is drawn in full, those before it pale. Default: "
    "the first step, of stationary modes the last; all for animations and windows.", metavar="STEPS", type=str,
)  # fmt: skip
@words.option("strobe")
@words.option("trace", "May be repeated.", multiple=True)
@words.option("no_trace")
@words.option("initial")
@words.option("frames", default=150)
@words.option("scale", "The start is in thin grey. Default: 1.", default=1.0)
@words.option("symbols")
@words.option("scopes", default=True)
def command(
    environment: Environment, file: str, at: str | None, strobe: int | None, trace: tuple[int, ...], no_trace: bool,
    initial: bool, frames: int, scale: float, symbols: str | None, scopes: bool, **common_options: Any,
) -> None:  # fmt: skip
    """Draw the mechanism of a result file (NAME.sbd) at one or more steps.

    Settings of the VISUALIZATION section of the input file, or of NAME.spv, are honoured; options override them.
    Without --output the picture is NAME.png beside the result.
    """
    choices = Choices(**common_options)
    if at and strobe:
        raise UsageError("--at and --strobe exclude each other")
    extras = replace(choices.extras(), scale=scale, symbols=symbol_kinds(symbols))
    source = choices.opened(file)
    scene = source.scene
    outputs = choices.output or (() if choices.show else (source.beside(".png"),))
    for path in outputs:
        check_name(path)
    nodes = [] if no_trace else list(trace or source.settings.traces)
    check_numbers(nodes, scene.position_nodes.tolist(), "--trace: position node")
    films = [p for p in outputs if p.suffix.lower() in FILM]
    stills = [p for p in outputs if p not in films]
    table = source.signals if scopes and source.signals is not None and source.signals.panels else None
    t = np.ravel(source.get("t"))
    if stills:
        numbers = chosen_steps(source, at, strobe, False)
        figure = picture(source, extras, numbers, nodes, initial)
        if table is not None:
            beside(figure, table, t).show(source.time(numbers[-1]))
        for path in stills:
            save(figure, path, choices.dpi)
    if films or choices.show:
        shown = series(source, extras, chosen_steps(source, at, None, True), nodes, initial)
        for path in films:
            pictures, count = shown.thinned(frames)
            with frame_progress(environment, count, path.name) as tick:
                moving = shown.moving()
                if table is not None:
                    line = beside(moving.figure, table, t)
                    moving.beside = [*moving.beside, *line.lines]
                    few = evenly(0, len(shown.numbers) - 1, frames)
                    pictures = _with_line(line, pictures, [source.time(shown.numbers[i]) for i in few])
                film(moving, pictures, count, path, choices.fps, min(choices.dpi, FILM_DPI), tick)
        if choices.show:
            from spacar_drawing.window import open_window, slider_window

            whole: Callable[[int], Any] = shown.whole
            if table is not None:
                line = TimeLine(open_window(f"{scene.title}: scopes"), table, t)
                whole = _with_line(line, whole, [source.time(k) for k in shown.numbers])
            slider_window(whole, len(shown.numbers), shown.bounds, shown.camera, scene.title, choices.fps)
    environment.wrote(*outputs)


def _with_line(line: TimeLine, pictures: Callable[[int], Any], at: Sequence[float]) -> Callable[[int], Any]:
    """The pictures, each with the line of the scopes at its time."""

    def show(i: int) -> Any:
        line.show(at[i])
        return pictures(i)

    return show
