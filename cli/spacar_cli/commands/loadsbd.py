"""`spacar loadsbd FILE [ID ...]`; `loadsbm` differs only in the kind of the file."""

from pathlib import Path

import click

from spacar_cli import vocabulary as words
from spacar_cli.environment import Environment, tell_notes

HELP = """Export all variables of an .{kind} file, or only those named, under their MATLAB names.

Writes FILE.{kind}.npz (.mat, .csv) beside the result, or what --output says. A .csv has a row for each step; the header
variables go to a second table, .header.csv.
"""


def export_command(kind: str) -> click.Command:
    """`spacar load<kind> FILE [ID ...]` for the kind sbd or sbm."""

    @words.command(f"load{kind}", help=HELP.format(kind=kind))
    @click.argument("idents", metavar="[ID]...", nargs=-1)
    @words.option("formats", "; default npz. May be repeated.", multiple=True, type=click.Choice(["mat", "npz", "csv"]))
    @words.option("output", "; its ending says the kind")
    def command(
        environment: Environment, file: str, idents: tuple[str, ...], formats: tuple[str, ...], output: Path | None
    ) -> None:
        from spacar_formats.exports import export_file

        written, notes = export_file(file, kind, idents, formats, output)
        tell_notes(environment, notes)
        environment.wrote(*written)

    return command


command = export_command("sbd")
