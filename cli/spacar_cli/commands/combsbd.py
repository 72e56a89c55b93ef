"""`spacar combsbd FILE FILE ... OUTPUT`."""

from __future__ import annotations

import click


@click.command("combsbd")
@click.argument("files", nargs=-1, required=True)
@click.argument("output")
@click.option("--force", is_flag=True, help="Replace OUTPUT when it exists (the original SPACAR always does).")
def command(files: tuple[str, ...], output: str, force: bool) -> None:
    """Put the steps of two or more .sbd files of one mechanism, in the given order, into OUTPUT."""
    from spacar_formats.combsbd import combsbd
    from spacar_formats.locate import notes, open_result

    remarks = []
    for name in files:
        with open_result(name, "sbd") as result:
            remarks += notes(result)
    target, steps = combsbd(files, output, force)
    for remark in remarks:
        click.echo(f"warning: {remark}", err=True)
    click.echo(f"{target}: {steps} steps")
