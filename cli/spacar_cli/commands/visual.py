"""`spacar visual FILE [MODE]`: vibration and buckling modes, constraints, stresses."""

from __future__ import annotations

from typing import Any

import click

from spacar.errors import UsageError
from spacar_cli.drawing_options import Choices, common
from spacar_cli.environment import Environment
from spacar_cli.number_types import Real, Whole

QUANTITIES = ("N", "Qy", "Qz", "T", "My", "Mz", "B", "mises", "normal", "shear")


@click.command("visual")
@click.argument("file")
@click.argument("mode", type=Whole(), required=False)
@common
@click.option(
    "--mode-number",
    "-m",
    "mode_numbers",
    metavar="N",
    help="Vibration or buckling mode: 1, 2:4, 1,3 or all; instead of VIBRATIONMODE, BUCKLINGMODE. Default 1.",
)
@click.option(
    "--factor",
    type=Real(),
    help=(
        "Enlargement of the mode, whose degrees of freedom have norm 1, instead of ENLARGEFACTOR. "
        "Default: such that the largest displacement is an eighth of the mechanism."
    ),
)
@click.option("--step", type=Whole(min=1), help="Stored step. Default: the last one.")
@click.option("--rest/--no-rest", default=True, show_default=True, help="Dashed outline of the position at rest.")
@click.option(
    "--stress",
    type=click.Choice(QUANTITIES, case_sensitive=False),
    help=(
        "Colour the beams by a stress resultant (N, Qy, Qz, T, My, Mz, B) or a stress (mises, normal, "
        "shear; these need cross-sections)."
    ),
)
@click.option(
    "--diagram",
    type=click.Choice(QUANTITIES, case_sensitive=False),
    help="The same quantities as ordinates beside the beams.",
)
@click.option(
    "--over-section",
    is_flag=True,
    help="With --stress mises, normal or shear: the stress at every point of the surface, instead of the largest.",
)
@click.option("--list", "as_list", is_flag=True, help="Print the modes instead of drawing them.")
@click.pass_obj
def command(
    environment: Environment,
    /,
    file: str,
    mode: int | None,
    mode_numbers: str | None,
    factor: float | None,
    step: int | None,
    rest: bool,
    stress: str | None,
    diagram: str | None,
    over_section: bool,
    as_list: bool,
    **common_options: Any,
) -> None:
    """Show what a result means: vibration modes (results of the modes 3, 4, 7, 9, 10), buckling modes (8, 10), over-
    and under-constraints (0), stress resultants and stresses along beams (all modes).

    MODE chooses the kind of picture where a result has several: 7 vibration, 8 buckling after a run of mode 10.
    Without --output the picture is NAME_WHAT.png beside the result; gif and mp4 show a period of the mode.
    """
    from spacar_cli.visual_job import StressWish, visual

    choices = Choices(**common_options)
    if over_section and stress not in ("mises", "normal", "shear"):
        raise UsageError("--over-section shows a stress: give --stress mises, normal or shear")
    wanted = StressWish(stress, diagram, over_section)
    for line in visual(environment, file, mode, choices, mode_numbers, factor, step, rest, wanted, as_list):
        environment.say(line)
