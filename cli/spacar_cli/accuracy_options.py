"""The options `--accuracy [TARGET]`, `--variable` and `--fixed-mesh` of the integrated and the stationary modes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from spacar.errors import UsageError
from spacar.modes import Mode
from spacar_cli import vocabulary as words
from spacar_cli.vocabulary import TOLERANCE

MEASURE = ""  # the value of --accuracy without a target


def of(mode: Mode) -> bool:
    """Has this mode the options?"""
    return mode.integrated or mode.stationary


def options(mode: Mode) -> list[click.Parameter]:
    """The options of a mode that has them."""
    runs = "choose method, tolerance and mesh" if mode.integrated else "choose the mesh of the beams"
    text = (
        f": several runs {runs}, estimate the error and keep it below TARGET; without it that of this run is estimated."
    )
    all_of = ", reactions, lowest frequencies and load multipliers" if mode.stationary else ""
    found: list[click.Parameter] = [
        words.parameter("accuracy", text, is_flag=False, flag_value=MEASURE, type=str),
        words.parameter("variables", f": 'x[6,1]'. Default: all free coordinates{all_of}.", multiple=True),
    ]
    if mode.integrated:
        found.append(words.parameter("fixed_mesh"))
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
