"""`spacar combsbd FILE FILE ... OUTPUT`."""

import click

from spacar_cli import vocabulary as words
from spacar_cli.environment import Environment, tell_notes


@words.command("combsbd")
@click.argument("files", nargs=-1, required=True)
@click.argument("output")
@words.option("overwrite", "; the original SPACAR always does.")
def command(environment: Environment, files: tuple[str, ...], output: str, overwrite: bool) -> None:
    """Put the steps of two or more .sbd files of one mechanism, in the given order, into OUTPUT."""
    from spacar_formats.combsbd import combsbd
    from spacar_formats.locate import notes, open_result

    remarks = []
    for name in files:
        with open_result(name, "sbd") as result:
            remarks += notes(result)
    target, steps = combsbd(files, output, overwrite)
    tell_notes(environment, remarks)
    environment.wrote(f"{target}: {steps} steps")
