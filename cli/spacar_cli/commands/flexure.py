"""`spacar flexure FILE --move 7x=0.02`: what a designer of a flexure asks over its range of motion."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from spacar.calls import BEAMS
from spacar.errors import UsageError
from spacar_cli import vocabulary as words
from spacar_cli.environment import Environment, tell, tell_messages, tell_notes
from spacar_cli.row_output import finite, put_columns
from spacar_cli.vocabulary import Whole

if TYPE_CHECKING:
    from spacar.stroke import Flexure


@words.command("flexure", epilog="Definitions of all quantities: `spacar help flexures`.")
@words.option(
    "move", ": 7x=0.02, 7x=-0.01:0.02, 7x=+-0.02, 8rz=0.3, e[3,1]=0.1. Default: what DELINPX, DELINPE or DELXF of the "
    "file move.",
)  # fmt: skip
@words.option("force", " instead: 7x=27")
@words.option("node", ", whose stiffness and motion; default that of the drive.")
@words.option("orientation")
@words.option("n_steps", ", to the farther end of the range.", type=Whole(1, 10_000), default=10)
@words.option("loads", ": 7y=-10. May be repeated.", multiple=True)
@words.option("extra", ", beside all present loads: 7y=-1. Several are one load.", multiple=True)
@words.option("pivot")
@words.option("axes", type=click.Choice(("global", "body")), default="global")
@words.option("modes", ", whose frequencies are kept.", type=Whole(1, 1000), default=6)
@words.option("beams", type=click.Choice(BEAMS))
@words.option("releases", ", as `spacar 0 FILE --release` does, and print the lines")
@words.option(
    "output", ": PAGE.html, a self-contained page; .png, .svg or .pdf, the curves; .npz, all arrays. May be repeated.",
    multiple=True,
)  # fmt: skip
@words.option("view", ", for the pictures of the page; default the plane of the motion.")
@words.option("csv_file", ": a row for every state")
@words.option("as_json", ": all columns")
def command(
    environment: Environment, file: Path, orientation: int | None, pivot: str | None, axes: str, releases: bool,
    n_steps: int, output: tuple[Path, ...], view: str | None, csv_file: Path | None, as_json: bool, **asked: Any,
) -> None:  # fmt: skip
    """Stiffness, errors, frequencies, buckling, force, energy and stress of a flexure over its range of motion.

    Every state is an equilibrium with the drive at that place (mode 10). Tables and page are in the unit of length of
    the file (UNITS), numbers of options too; csv, npz and JSON are in SI.
    """
    import spacar
    from spacar_cli.input_files import input_file

    pictures = [path for path in output if path.suffix.lower() not in (".html", ".npz")]
    if pictures:
        from spacar_drawing.files import check_stills

        check_stills(pictures)
    deck = spacar.read_deck(input_file(file), 10)
    tell_messages(environment, deck.messages, ("warning",))
    if releases:
        from spacar_cli import releasing

        done = releasing.solved(deck)
        for line in done.lines:
            tell(environment, "information", line)
        deck = done.release.deck
    place = None if pivot is None else _pivot(pivot)
    study = spacar.flexure(deck, orientation=orientation or 0, steps=n_steps, pivot=place, **asked)
    body = axes == "body"
    tell_notes(environment, study.warnings)
    for path in output:
        ending = path.suffix.lower()
        if ending == ".html":
            study.report(path, view=view, body=body)
        elif ending == ".npz":
            from spacar_formats.exports import to_npz

            to_npz(study.arrays(), path)
        else:
            study.plot(path, body=body)
        environment.wrote(path)
    if csv_file is not None:
        put_columns(environment, csv_file, study.table(body))
    if as_json:
        environment.say_json(finite(_record(study, body)))
    elif csv_file is None or str(csv_file) != "-":
        environment.wrote(*_lines(study, body))


def _pivot(text: str) -> list[float]:
    try:
        return [float(word) for word in text.split(",")]
    except ValueError:
        raise UsageError(f"--pivot {text}: expected numbers x,y or x,y,z", "flexure.pivot") from None


def _record(study: Flexure, body: bool) -> dict[str, Any]:
    """Facts and columns."""
    return {
        "source": study.source, "drive": study.move.text, "node": study.node.position,
        "orientation": study.node.orientation, "undeflected": study.zero, "turning": study.errors.turning,
        "pivot": study.errors.pivot.tolist(), "units": {c.name: c.unit for c in study.columns(body)},
        "columns": {name: values.tolist() for name, values in study.table(body).items()},
        "warnings": study.warnings,
    }  # fmt: skip


def _lines(study: Flexure, body: bool) -> list[str]:
    from spacar_drawing.stroke_figures import stroke_tables
    from spacar_formats.log.text_layout import table

    lines = []
    for part in stroke_tables(study, body):
        note = [f"  {part.note}"] if part.note else []
        lines += ["", part.title, *note, "", *table(part.heads, part.rows, words_left=False)]
    return lines[1:]
