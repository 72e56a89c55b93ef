"""`spacar getss FILE [STEP]`."""

from __future__ import annotations

import json
from pathlib import Path

import click

from spacar.errors import UsageError
from spacar_cli.number_types import Whole


@click.command("getss")
@click.argument("file")
@click.argument("place", type=Whole(), required=False, metavar="[STEP]")
@click.option("--step", type=Whole(), help="The same as the argument STEP: from 1, -1 the last; default the first.")
@click.option("--output", "-o", help="Write a .mat, .npz or .json file instead of printing.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(file: str, place: int | None, step: int | None, output: str | None, as_json: bool) -> None:
    """Print or export the state space matrices A, B, C, D of one step (default the first) of an .ltv file."""
    from spacar_formats import getss
    from spacar_formats.getfrsbf import as_lines
    from spacar_formats.locate import notes, open_result

    if place is not None and step is not None:
        raise UsageError("the step is given twice, as argument and by --step", "usage.step")
    step = step or place or 1
    with open_result(file, "ltv") as result:
        for note in notes(result):
            click.echo(f"warning: {note}", err=True)
    system = getss.getss(file, step)
    if output is not None:
        getss.export_getss(system, Path(output))
        click.echo(output)
    elif as_json:
        click.echo(json.dumps(getss.as_json(system)))
    else:
        for name, matrix in system.arrays().items():
            click.echo("\n".join([f"{name} ({matrix.shape[0]} x {matrix.shape[1]}):", *as_lines(matrix)]))
        if system.D is None:
            click.echo("D: none, no direct feedthrough")
