"""`spacar visual FILE [MODE]`: vibration and buckling modes, constraints, stresses."""

from typing import Any

import click

from spacar.errors import UsageError
from spacar_cli import vocabulary as words
from spacar_cli.drawing_options import Choices, common
from spacar_cli.environment import Environment
from spacar_cli.vocabulary import Whole

QUANTITIES = ("N", "Qy", "Qz", "T", "My", "Mz", "B", "mises", "normal", "shear")


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
    type=click.Choice(QUANTITIES, case_sensitive=False),
)  # fmt: skip
@words.option("diagram", type=click.Choice(QUANTITIES, case_sensitive=False))
@words.option("over_section", "; with --stress mises, normal or shear.")
@words.option("as_list")
def command(
    environment: Environment, /, file: str, mode: int | None, mode_numbers: str | None, factor: float | None, at: int,
    rest: bool, stress: str | None, diagram: str | None, over_section: bool, as_list: bool, **common_options: Any,
) -> None:  # fmt: skip
    """Show what a result means: vibration modes (results of the modes 3, 4, 7, 9, 10), buckling modes (8, 10), over-
    and under-constraints (0), stress resultants and stresses along beams (all modes).

    MODE chooses the kind of picture where a result has several: 7 vibration, 8 buckling after a run of mode 10.
    Without --output the picture is NAME_WHAT.png beside the result; gif and mp4 show a period of the mode.
    """
    from spacar_cli.visual_job import visual

    choices = Choices(**common_options)
    if over_section and stress not in ("mises", "normal", "shear"):
        raise UsageError("--over-section shows a stress: give --stress mises, normal or shear")
    wanted = mode_numbers, factor, at, rest, stress, diagram, over_section
    found = visual(environment, file, mode, choices, *wanted, as_list)
    environment.say(*map(str, found)) if as_list else environment.wrote(*found)
