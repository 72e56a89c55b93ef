"""`spacar draw FILE`: the mechanism at one or more steps, as a picture, an animation or in a window."""

from dataclasses import replace
from typing import Any

from spacar.errors import UsageError
from spacar_cli import vocabulary as words
from spacar_cli.drawing_options import Choices, common, symbol_kinds
from spacar_cli.environment import Environment


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
    environment: Environment, /, file: str, at: str | None, strobe: int | None, trace: tuple[int, ...], no_trace: bool,
    initial: bool, frames: int, scale: float, symbols: str | None, scopes: bool, **common_options: Any,
) -> None:  # fmt: skip
    """Draw the mechanism of a result file (NAME.sbd) at one or more steps.

    Settings of the VISUALIZATION section of the input file, or of NAME.spv, are honoured; options override them.
    Without --output the picture is NAME.png beside the result.
    """
    from spacar_cli.drawing_job import draw

    choices = Choices(**common_options)
    if at and strobe:
        raise UsageError("--at and --strobe exclude each other")
    extras = replace(choices.extras(), scale=scale, symbols=symbol_kinds(symbols))
    drawn = () if no_trace else trace
    for path in draw(environment, file, choices, extras, at, strobe, drawn, no_trace, initial, frames, scopes):
        environment.wrote(path)
