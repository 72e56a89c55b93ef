"""`spacar draw FILE`: the mechanism at one or more steps, as a picture, an animation or in a window."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from spacar.errors import UsageError
from spacar_cli.drawing_options import Choices, common, symbol_kinds
from spacar_cli.environment import Environment
from spacar_cli.number_types import Real, Whole


@click.command("draw")
@click.argument("file")
@common
@click.option(
    "--steps",
    "--step",
    "-s",
    metavar="STEPS",
    help=(
        "Steps to draw: 3, end, 2:5, 1:10:end, 1,4,9 or all. The last one is drawn in full, those before "
        "it pale. Default: the first step, of stationary modes the last; all for animations and windows."
    ),
)
@click.option("--strobe", type=Whole(min=2), metavar="N", help="N evenly spread steps in one picture.")
@click.option(
    "--trace",
    type=Whole(),
    multiple=True,
    metavar="NODE",
    help="Path of a node over all steps, instead of TRAJECTNODE. May be repeated.",
)
@click.option("--no-trace", is_flag=True, help="No paths, whatever the settings say.")
@click.option(
    "--initial", is_flag=True, help="Dashed outline of the first step behind the others, in the INITIAL COLOR."
)
@click.option("--frames", type=Whole(min=2), default=150, show_default=True, help="Most pictures in an animation.")
@click.option(
    "--scale",
    type=Real(),
    default=1.0,
    metavar="F",
    help="Draw the deflections from the start F times as large, with the start in thin grey. Default: 1.",
)
@click.option(
    "--symbols",
    metavar="KINDS",
    help="Symbols of these kinds, with commas between: loads, reactions, masses, gravity, axes; or all.",
)
@click.option(
    "--scopes/--no-scopes", default=True, show_default=True, help="Scopes of a simulation beside the mechanism."
)
@click.pass_obj
def command(
    environment: Environment,
    /,
    file: str,
    steps: str | None,
    strobe: int | None,
    trace: tuple[int, ...],
    no_trace: bool,
    initial: bool,
    frames: int,
    scale: float,
    symbols: str | None,
    scopes: bool,
    **common_options: Any,
) -> None:
    """Draw the mechanism of a result file (NAME.sbd) at one or more steps.

    Settings of the VISUALIZATION section of the input file, or of NAME.spv, are honoured; options override them.
    Without --output the picture is NAME.png beside the result.
    """
    from spacar_cli.drawing_job import draw

    choices = Choices(**common_options)
    if steps and strobe:
        raise UsageError("--steps and --strobe exclude each other")
    extras = replace(choices.extras(), scale=scale, symbols=symbol_kinds(symbols))
    drawn = () if no_trace else trace
    for path in draw(environment, file, choices, extras, steps, strobe, drawn, no_trace, initial, frames, scopes):
        _say(environment, path)


def _say(environment: Environment, path: Path) -> None:
    environment.say(str(path))
