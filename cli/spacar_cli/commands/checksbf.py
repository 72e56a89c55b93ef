"""`spacar checksbf FILE`."""

from __future__ import annotations

import json

import click

from spacar.errors import AnalysisError


@click.command("checksbf")
@click.argument("file")
@click.option("--json", "as_json", is_flag=True, help="Print the findings as JSON.")
def command(file: str, as_json: bool) -> None:
    """List the variables of a result file and verify its checksums; exit status 1 when it is damaged."""
    from spacar_formats import checksbf
    from spacar_formats.sbf import SbfError

    try:
        check = checksbf.checksbf(file)
    except SbfError as error:  # the file is what was asked about, so this is a result and no wrong use
        raise AnalysisError(str(error), error.code) from None
    if as_json:
        click.echo(json.dumps(checksbf.as_json(check)))
    else:
        click.echo("\n".join(checksbf.listing(check)))
    if not check.sound:
        raise AnalysisError(f"{check.path} is damaged: {'; '.join(check.damage)}", "files.damaged")
