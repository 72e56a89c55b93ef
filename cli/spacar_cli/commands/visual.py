"""`spacar visual FILE [MODE]`: vibration and buckling modes, constraints, stresses."""

from functools import partial
from pathlib import Path
from typing import Any

import click
from spacar_drawing.files import FILM, FILM_DPI, MovingFigure, check_name, check_stills, film, save
from spacar_drawing.look import extent_of
from spacar_drawing.mechanism_picture import camera_of, step_text
from spacar_drawing.mode_picture import PHASES, constraint_still, constraints, mode_pictures, mode_still
from spacar_drawing.mode_shapes import ModeShape, modes_of, suitable_factor
from spacar_drawing.picture_source import PictureSource
from spacar_drawing.stress_picture import diagram_still, stress_still
from spacar_drawing.stresses import QUANTITIES, STRESSES
from spacar_formats.getfrsbf import step_numbers, stored_step

from spacar.errors import UsageError
from spacar.modes import find_mode
from spacar_cli import vocabulary as words
from spacar_cli.drawing_options import Choices, common
from spacar_cli.environment import Environment
from spacar_cli.progress import frame_progress
from spacar_cli.row_output import put_figure
from spacar_cli.vocabulary import Whole

QUANTITY = click.Choice(tuple(QUANTITIES), case_sensitive=False)


@words.command("visual")
@click.argument("mode", type=Whole(), required=False)
@common
@words.option("mode_numbers", ": 1, 2:4, 1,3 or all; instead of VIBRATIONMODE, BUCKLINGMODE. Default 1.")
@words.option(
    "factor", "The degrees of freedom of a mode have norm 1. Default: such that the largest displacement is an eighth "
    "of the mechanism.",
)  # fmt: skip
@words.option("at", "Default: the last one.", default=-1)
@words.option("rest", default=True)
@words.option(
    "stress", ": resultants N, Qy, Qz, T, My, Mz, B; stresses, which need cross-sections: mises, normal, shear.",
    type=QUANTITY,
)  # fmt: skip
@words.option("diagram", type=QUANTITY)
@words.option("over_section", "; with --stress mises, normal or shear.")
@words.option("as_list")
def command(
    environment: Environment, file: str, mode: int | None, mode_numbers: str | None, factor: float | None, at: int,
    rest: bool, stress: str | None, diagram: str | None, over_section: bool, as_list: bool, **common_options: Any,
) -> None:  # fmt: skip
    """Show what a result means: vibration modes (results of the modes 3, 4, 7, 9, 10), buckling modes (8, 10), over-
    and under-constraints (0), stress resultants and stresses along beams (all modes).

    MODE chooses the kind of picture where a result has several: 7 vibration, 8 buckling after a run of mode 10.
    Without --output the picture is NAME_WHAT.png beside the result; gif and mp4 show a period of the mode.
    """
    choices = Choices(**common_options)
    if over_section and stress not in STRESSES:
        raise UsageError("--over-section shows a stress: give --stress mises, normal or shear")
    if as_list and (choices.output or choices.show or stress or diagram):
        raise UsageError("--list prints modes and draws nothing: without --output, --show, --stress, --diagram")
    source = choices.opened(file)
    step = stored_step(at, source.steps, source.name)
    if stress and diagram:
        raise UsageError("--stress and --diagram exclude each other")
    if quantity := stress or diagram:
        outputs = _outputs(source, choices, quantity)
        check_stills(outputs)
        draw = partial(stress_still, surface=over_section) if stress else diagram_still
        figure = draw(source, step, choices.extras(), quantity, step_text(source, step))
        put_figure(environment, figure, outputs, choices.dpi, choices.show)
        return
    kind = _kind(source, mode)
    if kind == "constraints":
        outputs = _outputs(source, choices, kind)
        check_stills(outputs)
        figure = constraint_still(source, step, choices.extras(), constraints(source, step))
        put_figure(environment, figure, outputs, choices.dpi, choices.show)
        return
    modes = modes_of(source, kind, step)
    if not modes:
        text = f"{source.name} has no {kind} modes: no dynamic degrees of freedom, no stress, or a dead point"
        raise UsageError(text, "draw.modes")
    if as_list:
        environment.say(*(m.label for m in modes))
        return
    default = source.settings.vibration_mode if kind == "vibration" else source.settings.buckling_mode
    chosen = _numbers(mode_numbers, modes, default or 1)
    for m in chosen:
        _mode(environment, source, choices, step, m, factor, rest, len(chosen) > 1)


def _kind(source: PictureSource, mode: int | None) -> str:
    """vibration, buckling or constraints. Raises UsageError when the result does not have what MODE asks for."""
    ran = source.scene.analysis
    wanted = ran if mode is None else find_mode(mode)
    if not wanted.forces and not ran.forces:
        return "constraints"
    if wanted.buckling and ran.buckling and not (wanted.linearized and ran.linearized):
        return "buckling"
    if wanted.linearized and ran.linearized:
        return "vibration"
    if mode is None or wanted == ran:
        advice = ", which has no modes of vibration or buckling; use spacar draw, or --stress or --diagram"
    else:
        advice = f"; for pictures of mode {wanted.number} run: spacar {wanted.number} {source.scene.title}"
    raise UsageError(f"{source.name} is a result of mode {ran.number}{advice}", "draw.modes")


def _numbers(text: str | None, modes: list[ModeShape], default: int) -> list[ModeShape]:
    """The modes with these numbers. Raises UsageError."""
    if text is not None and text.lower() == "all":
        return modes
    known = {m.number: m for m in modes}
    last = max(known)
    found = default if text is None else step_numbers(text, last)
    wanted = [found] if isinstance(found, int) else found
    for n in wanted:
        if n not in known:
            finite = " with a finite load multiplier" if modes[0].kind == "buckling" else ""
            text = f"{modes[0].kind} mode {n} does not exist; there are {len(known)} modes{finite}"
            raise UsageError(text, "draw.modes")
    return [known[n] for n in wanted]


def _outputs(source: PictureSource, choices: Choices, what: str, several: bool = False) -> list[Path]:
    """The files to write; with several modes the kind of picture is added to the given names."""
    if not choices.output:
        return [] if choices.show else [source.beside(f"_{what}.png")]
    for p in choices.output:
        check_name(p)
    return [p.with_name(f"{p.stem}_{what}{p.suffix}") if several else p for p in choices.output]


def _mode(
    environment: Environment, source: PictureSource, choices: Choices, step: int, mode: ModeShape, factor: float | None,
    rest: bool, several: bool,
) -> None:  # fmt: skip
    extras = choices.extras()
    if factor is None:
        factor = source.settings.enlarge
    if factor is None:
        factor = suitable_factor(source.scene, mode.motion, extent_of(source, step))
    outputs = _outputs(source, choices, f"{mode.kind}{mode.number}", several)
    films = [p for p in outputs if p.suffix.lower() in FILM]
    for path in outputs:
        if path not in films:
            save(mode_still(source, step, extras, mode, factor, rest), path, choices.dpi)
    if choices.show or films:
        pictures, bounds = mode_pictures(source, step, extras, mode, factor, rest)
        camera = camera_of(source.scene, choices.view)
        for path in films:
            with frame_progress(environment, PHASES, path.name) as tick:
                moving = MovingFigure.create(bounds, camera)
                film(moving, pictures, PHASES, path, choices.fps, min(choices.dpi, FILM_DPI), tick)
        if choices.show:
            from spacar_drawing.window import slider_window

            slider_window(pictures, PHASES, bounds, camera, mode.label, choices.fps)
    environment.wrote(*outputs)
