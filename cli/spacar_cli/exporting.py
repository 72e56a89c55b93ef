"""The command that exports a result file; `loadsbd` and `loadsbm` differ only in the kind of the file."""

from __future__ import annotations

import click

HELP = """Export all variables of an .{kind} file, or only those named, under their MATLAB names.

Writes FILE.{kind}.npz (.mat, .csv) beside the result, or what --output says. A .csv has a row for each step; the header
variables go to a second table, .header.csv.
"""


def export_command(kind: str) -> click.Command:
    """`spacar load<kind> FILE [ID ...]` for the kind sbd or sbm."""

    @click.command(f"load{kind}", help=HELP.format(kind=kind))
    @click.argument("file")
    @click.argument("idents", metavar="[ID]...", nargs=-1)
    @click.option("--to", "formats", multiple=True, type=click.Choice(["mat", "npz", "csv"]), help="Default npz.")
    @click.option("--output", "-o", help="Name of the new file; its extension says the format.")
    def command(file: str, idents: tuple[str, ...], formats: tuple[str, ...], output: str | None) -> None:
        from spacar_formats.exports import export_file

        written, notes = export_file(file, kind, idents, formats, output)
        for note in notes:
            click.echo(f"warning: {note}", err=True)
        for path in written:
            click.echo(path)

    return command
