"""The options `--accuracy [TARGET]`, `--variable` and `--fixed-mesh` of the integrated and the stationary modes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from spacar.errors import UsageError
from spacar.modes import Mode
from spacar_cli.number_types import TOLERANCE

MEASURE = ""  # the value of --accuracy without a target


def of(mode: Mode) -> bool:
    """Has this mode the options?"""
    return mode.integrated or mode.stationary


def options(mode: Mode) -> list[click.Parameter]:
    """The options of a mode that has them."""
    runs = "choose method, tolerance and mesh" if mode.integrated else "choose the mesh of the beams"
    found: list[click.Parameter] = [
        click.Option(
            ["--accuracy"],
            is_flag=False,
            flag_value=MEASURE,
            metavar="[TARGET]",
            help=f"Error of the result over the amplitude of each variable: several runs {runs}, "
            "estimate the error and keep it below TARGET. Without TARGET the error of this run is estimated.",
        ),
        click.Option(
            ["--variable", "variables"],
            multiple=True,
            metavar="EXPRESSION",
            help="Whose accuracy is meant, for instance 'x[6,1]'. Default: all free coordinates"
            + (", reactions, lowest frequencies and load multipliers." if mode.stationary else "."),
        ),
    ]
    if mode.integrated:
        text = "The accuracy is that of the integration: beams are not divided for it."
        found.append(click.Option(["--fixed-mesh"], is_flag=True, help=text))
    return found


def taken(file: Path | None, options: dict[str, Any]) -> tuple[Path | None, dict[str, Any]]:
    """The input file, and the arguments of `spacar.frames` for the accuracy, which are taken out of `options`.

    In `spacar 1 --accuracy FILE` the word is the file. Raises UsageError for a target that is no number.
    """
    word, variables = options.pop("accuracy", None), tuple(options.pop("variables", ()))
    fixed = options.pop("fixed_mesh", False)
    if word is None:
        for given, text in ((variables, "--variable says whose"), (fixed, "--fixed-mesh says whose")):
            if given:
                raise UsageError(f"{text} --accuracy is meant; give --accuracy too", "usage.accuracy")
        return file, {}
    asked = {"variables": variables} | ({"mesh": False} if fixed else {})
    if file is None and word != MEASURE:
        file, word = Path(word), MEASURE
    if word == MEASURE:
        return file, asked | {"accuracy": True}
    try:
        target = TOLERANCE.convert(word, None, None)
    except click.UsageError as error:
        raise UsageError(f"--accuracy: {error.message}", "usage.accuracy") from None
    return file, asked | {"accuracy": target}


def flags(asked: dict[str, Any]) -> dict[str, Any]:
    """The options as given, for the log."""
    if not asked:
        return {}
    target = asked["accuracy"]
    found: dict[str, Any] = {"--accuracy": "measured" if target is True else target}
    found |= {"--variable": ", ".join(asked["variables"])} if asked["variables"] else {}
    return found | ({} if asked.get("mesh", True) else {"--fixed-mesh": True})
