"""`spacar getss FILE [STEP]`."""

import json
from pathlib import Path

import click

from spacar.errors import UsageError
from spacar_cli import vocabulary as words
from spacar_cli.environment import Environment, tell_notes
from spacar_cli.vocabulary import StepNumber


@words.command("getss")
@click.argument("step", type=StepNumber(), required=False, metavar="[STEP]")
@words.option("at", ": the same as the argument STEP; default the first.")
@words.option("output", ": a .mat, .npz or .json file, instead of printing.")
@words.option("as_json")
def command(
    environment: Environment, file: str, step: int | None, at: int | None, output: Path | None, as_json: bool
) -> None:
    """Print or export the state space matrices A, B, C, D of one step (default the first) of an .ltv file."""
    from spacar_formats import getss
    from spacar_formats.getfrsbf import as_lines
    from spacar_formats.locate import notes, open_result

    if step is not None and at is not None:
        raise UsageError("the step is given twice, as argument and by --at", "usage.step")
    step = step or at or 1
    with open_result(file, "ltv") as result:
        tell_notes(environment, notes(result))
    system = getss.getss(file, step)
    if output is not None:
        getss.export_getss(system, output)
        environment.wrote(output)
    elif as_json:
        environment.say(json.dumps(getss.as_json(system)))
    else:
        for name, matrix in system.arrays().items():
            environment.say(f"{name} ({matrix.shape[0]} x {matrix.shape[1]}):", *as_lines(matrix))
        if system.D is None:
            environment.say("D: none, no direct feedthrough")
