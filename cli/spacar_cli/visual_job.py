"""What `spacar visual` does once its options are read."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from spacar_drawing.files import FILM, FILM_DPI, MovingFigure, check_name, check_stills, film, save
from spacar_drawing.look import extent_of
from spacar_drawing.mechanism_picture import camera_of, step_text
from spacar_drawing.mode_picture import PHASES, constraint_still, constraints, mode_pictures, mode_still
from spacar_drawing.mode_shapes import ModeShape, buckling_modes, open_matrices, suitable_factor, vibration_modes
from spacar_drawing.picture_source import PictureSource
from spacar_drawing.stress_picture import diagram_still, stress_still
from spacar_formats.getfrsbf import step_numbers, stored_step

from spacar.errors import UsageError
from spacar.modes import find_mode
from spacar_cli.drawing_options import Choices
from spacar_cli.environment import Environment
from spacar_cli.progress import frame_progress

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def visual(
    environment: Environment, file: str, mode: int | None, choices: Choices, numbers: str | None, factor: float | None,
    at: int, rest: bool, stress: str | None, diagram: str | None, over_section: bool, as_list: bool,
) -> list[str] | list[Path]:  # fmt: skip
    """Draw what was asked for; returns the files, or names of modes. Raises UsageError."""
    source = choices.opened(file)
    step = stored_step(at, source.steps, source.name)
    if stress or diagram:
        return _stresses(source, choices, step, stress, diagram, over_section)
    kind = _kind(source, mode)
    if kind == "constraints":
        outputs = _outputs(source, choices, kind)
        check_stills(outputs)
        return _finish(constraint_still(source, step, choices.extras(), constraints(source, step)), outputs, choices)
    with open_matrices(source) as matrices:
        modes = (vibration_modes if kind == "vibration" else buckling_modes)(source, matrices, step)
    if not modes:
        text = f"{source.name} has no {kind} modes: no dynamic degrees of freedom, or no stress"
        raise UsageError(text, "draw.modes")
    if as_list:
        return [m.label for m in modes]
    default = source.settings.vibration_mode if kind == "vibration" else source.settings.buckling_mode
    chosen = _numbers(numbers, modes, default or 1)
    return [p for m in chosen for p in _mode(environment, source, choices, step, m, factor, rest, len(chosen) > 1)]


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
        return [] if choices.show else [Path(source.name).parent / f"{source.scene.title}_{what}.png"]
    paths = [p.with_name(f"{p.stem}_{what}{p.suffix}") if several else p for p in choices.output]
    for p in paths:
        check_name(p)
    return paths


def _mode(
    environment: Environment, source: PictureSource, choices: Choices, step: int, mode: ModeShape, factor: float | None,
    rest: bool, several: bool,
) -> list[Path]:  # fmt: skip
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

            slider_window(pictures, PHASES, 0, bounds, camera, mode.label, choices.fps)
    return outputs


def _stresses(
    source: PictureSource, choices: Choices, step: int, stress: str | None, diagram: str | None, over_section: bool
) -> list[Path]:
    if stress and diagram:
        raise UsageError("--stress and --diagram exclude each other")
    quantity = stress or diagram or ""
    note = step_text(source, step).removeprefix(source.scene.title).strip()
    outputs = _outputs(source, choices, quantity)
    check_stills(outputs)
    draw = partial(stress_still, surface=over_section) if stress else diagram_still
    return _finish(draw(source, step, choices.extras(), quantity, note), outputs, choices)


def _finish(figure: Figure, outputs: list[Path], choices: Choices) -> list[Path]:
    for path in outputs:
        save(figure, path, choices.dpi)
    if choices.show:
        from spacar_drawing.window import still_window

        still_window(figure)
    return outputs
