"""`spacar getfrsbf FILE ID [STEPS]`."""

import json

import click

from spacar.errors import UsageError
from spacar_cli import vocabulary as words
from spacar_cli.environment import Environment, tell_notes


@words.command("getfrsbf")
@click.argument("ident", metavar="ID")
@click.argument("steps", required=False, metavar="[STEPS]")
@words.option("at", ": the same as the argument STEPS.", metavar="STEPS", type=str)
@words.option("as_json", ': {"id", "shape", "data"}.')
def command(environment: Environment, file: str, ident: str, steps: str | None, at: str | None, as_json: bool) -> None:
    """Print a variable of a result file.

    STEPS is 3, end, 2:5, 1:10:end or 1,4,9; without it all steps are printed. One step is printed as a
    matrix; of several steps each is a row, with the columns of a matrix one after the other.
    """
    from spacar_formats import getfrsbf
    from spacar_formats.locate import notes, open_result

    if steps is not None and at is not None:
        raise UsageError("the steps are given twice, as argument and by --at", "usage.step")
    steps = steps or at
    with open_result(file) as result:
        value = result.get(ident, None if steps is None else getfrsbf.step_numbers(steps, result.steps))
        name = "TDEF" if ident.strip().upper() == "TDEF" else result.variable(ident).id
        tell_notes(environment, notes(result))
    environment.say(*([json.dumps(getfrsbf.as_json(name, value))] if as_json else getfrsbf.as_lines(value)))
