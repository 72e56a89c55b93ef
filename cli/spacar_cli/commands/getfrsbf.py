"""`spacar getfrsbf FILE ID [STEPS]`."""

from __future__ import annotations

import json

import click

from spacar.errors import UsageError


@click.command("getfrsbf")
@click.argument("file")
@click.argument("ident", metavar="ID")
@click.argument("places", required=False, metavar="[STEPS]")
@click.option("--step", "--steps", "-s", "steps", metavar="STEPS", help="The same as the argument STEPS.")
@click.option("--json", "as_json", is_flag=True, help='Print {"id", "shape", "data"}.')
def command(file: str, ident: str, places: str | None, steps: str | None, as_json: bool) -> None:
    """Print a variable of a result file.

    STEPS is 3, end, 2:5, 1:10:end or 1,4,9; without it all steps are printed. One step is printed as a
    matrix; of several steps each is a row, with the columns of a matrix one after the other.
    """
    from spacar_formats import getfrsbf
    from spacar_formats.locate import notes, open_result

    if places is not None and steps is not None:
        raise UsageError("the steps are given twice, as argument and by --step", "usage.step")
    steps = steps or places
    with open_result(file) as result:
        value = result.get(ident, None if steps is None else getfrsbf.step_numbers(steps, result.steps))
        name = "TDEF" if ident.strip().upper() == "TDEF" else result.variable(ident).id
        for note in notes(result):
            click.echo(f"warning: {note}", err=True)
    lines = [json.dumps(getfrsbf.as_json(name, value))] if as_json else getfrsbf.as_lines(value)
    for line in lines:
        click.echo(line)
