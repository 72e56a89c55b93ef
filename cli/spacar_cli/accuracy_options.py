"""The options `--accuracy [TARGET]` and `--variable` of the integrated modes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from spacar.errors import UsageError
from spacar_cli.number_types import TOLERANCE

MEASURE = ""  # the value of --accuracy without a target


def options() -> list[click.Parameter]:
    """Both options."""
    return [
        click.Option(
            ["--accuracy"],
            is_flag=False,
            flag_value=MEASURE,
            metavar="[TARGET]",
            help="Error of the result over the amplitude of the motion: several runs choose method and tolerance, "
            "estimate the error and keep it below TARGET. Without TARGET the error of this run is estimated.",
        ),
        click.Option(
            ["--variable", "variables"],
            multiple=True,
            metavar="EXPRESSION",
            help="Whose accuracy is meant, for instance 'x[6,1]'. Default: all free coordinates.",
        ),
    ]


def taken(file: Path | None, options: dict[str, Any]) -> tuple[Path | None, dict[str, Any]]:
    """The input file, and the arguments of `spacar.frames` for the accuracy, which are taken out of `options`.

    In `spacar 1 --accuracy FILE` the word is the file. Raises UsageError for a target that is no number.
    """
    word, variables = options.pop("accuracy", None), tuple(options.pop("variables", ()))
    if word is None:
        if variables:
            raise UsageError("--variable says whose --accuracy is meant; give --accuracy too", "usage.accuracy")
        return file, {}
    if file is None and word != MEASURE:
        file, word = Path(word), MEASURE
    if word == MEASURE:
        return file, {"accuracy": True, "variables": variables}
    try:
        target = TOLERANCE.convert(word, None, None)
    except click.UsageError as error:
        raise UsageError(f"--accuracy: {error.message}", "usage.accuracy") from None
    return file, {"accuracy": target, "variables": variables}


def flags(asked: dict[str, Any]) -> dict[str, Any]:
    """The options as given, for the log."""
    if not asked:
        return {}
    target = asked["accuracy"]
    found: dict[str, Any] = {"--accuracy": "measured" if target is True else target}
    return found | ({"--variable": ", ".join(asked["variables"])} if asked["variables"] else {})
