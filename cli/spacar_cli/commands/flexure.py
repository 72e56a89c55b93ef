"""`spacar flexure FILE --move 7x=0.02`: what a designer of a flexure asks over its range of motion."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from spacar.errors import UsageError
from spacar.options import BEAMS
from spacar_cli.environment import Environment
from spacar_cli.number_types import Whole
from spacar_cli.status import tell, tell_messages

if TYPE_CHECKING:
    from spacar.stroke import Flexure


@click.command("flexure", epilog="Definitions of all quantities: docs/flexures.md.")
@click.argument("file", type=click.Path(path_type=Path))
@click.option(
    "--move", metavar="COORDINATE=RANGE",
    help="What is moved and how far, from the reference position: 7x=0.02, 7x=-0.01:0.02, 7x=+-0.02, 8rz=0.3, "
    "e[3,1]=0.1. Default: what DELINPX, DELINPE or DELXF of the file move.",
)  # fmt: skip
@click.option("--force", metavar="COORDINATE=RANGE", help="The same with a force or moment instead: 7x=27.")
@click.option("--node", "-n", type=Whole(min=1), help="Whose stiffness and motion; default that of the drive.")
@click.option("--orientation", type=Whole(min=1), help="Its orientation node, where no element has both.")
@click.option("--steps", type=Whole(1, 10_000), default=10, show_default=True, help="To the farther end of the range.")
@click.option("--load", "loads", metavar="COORDINATE=FORCE", multiple=True, help="Acts all the time: 7y=-10.")
@click.option(
    "--extra", metavar="COORDINATE=FORCE", multiple=True,
    help="Does not act; its own load multiplier beside all present loads is asked for: 7y=-1. Several are one load.",
)  # fmt: skip
@click.option("--pivot", metavar="X,Y[,Z]", help="Ideal pivot, instead of the pole of the undeflected state.")
@click.option("--axes", type=click.Choice(("global", "body")), default="global", help="Directions of the stiffness.")
@click.option("--modes", type=Whole(1, 1000), default=6, show_default=True, help="How many frequencies are kept.")
@click.option("--beams", type=click.Choice(BEAMS), help="Measure of the deformations of all beams, instead of ADEFORM.")
@click.option(
    "--release", is_flag=True, help="Release over-constraints as `spacar 0 FILE --release` says, and print the lines."
)
@click.option("--report", type=click.Path(path_type=Path), metavar="PAGE.html", help="Write a self-contained page.")
@click.option("--view", help="Of its pictures: iso, xy, xz, yz or azimuth,elevation; default the plane of the motion.")
@click.option("--plot", type=click.Path(path_type=Path), metavar="PICTURE", help="Write the curves: png, svg or pdf.")
@click.option(
    "--csv", "csv_file", type=click.Path(path_type=Path, allow_dash=True),
    help="Write a row for every state as csv ('-': print them).",
)  # fmt: skip
@click.option("--npz", "npz_file", type=click.Path(path_type=Path), help="Write all arrays as a NumPy archive.")
@click.option("--json", "as_json", is_flag=True, help="Print all columns in JSON.")
@click.pass_obj
def command(
    environment: Environment,
    /,
    file: Path,
    orientation: int | None,
    pivot: str | None,
    axes: str,
    release: bool,
    report: Path | None,
    view: str | None,
    plot: Path | None,
    csv_file: Path | None,
    npz_file: Path | None,
    as_json: bool,
    **asked: Any,
) -> None:
    """Stiffness, errors, frequencies, buckling, force, energy and stress of a flexure over its range of motion.

    Every state is an equilibrium with the drive at that place (mode 10). Tables and page are in the unit of length of
    the file (UNITS), numbers of options too; csv, npz and JSON are in SI.
    """
    import spacar
    from spacar_cli.input_files import input_file

    if plot is not None:
        from spacar_drawing.files import check_name

        check_name(plot, film=False)
    deck = spacar.read_deck(input_file(file), 10)
    tell_messages(environment, deck.messages, ("warning",))
    if release:
        from spacar_cli import releasing

        done = releasing.solved(deck)
        for line in done.lines:
            tell(environment, "information", line)
        deck = done.release.deck
    study = spacar.flexure(
        deck, orientation=orientation or 0, pivot=None if pivot is None else _pivot(pivot), **asked
    )
    body = axes == "body"
    for warning in study.warnings:
        tell(environment, "warning", warning)
    if npz_file is not None:
        from spacar_formats.exports import to_npz

        to_npz(study.arrays(), npz_file)
        environment.say(str(npz_file))
    if plot is not None:
        study.plot(plot, body=body)
        environment.say(str(plot))
    if report is not None:
        study.report(report, view=view, body=body)
        environment.say(str(report))
    if csv_file is not None and str(csv_file) != "-":
        from spacar_formats.exports import to_csv

        to_csv(study.table(body), csv_file)
        environment.say(str(csv_file))
    if csv_file is not None and str(csv_file) == "-":
        _print_csv(environment, study, body)
    elif as_json:
        environment.say(_json(study, body))
    else:
        for line in _lines(study, body):
            environment.say(line)


def _pivot(text: str) -> list[float]:
    try:
        return [float(word) for word in text.split(",")]
    except ValueError:
        raise UsageError(f"--pivot {text}: expected numbers x,y or x,y,z", "flexure.pivot") from None


def _print_csv(environment: Environment, study: Flexure, body: bool) -> None:
    import csv

    table = study.table(body)
    writer = csv.writer(environment.stdout, lineterminator="\n")
    writer.writerow(table)
    writer.writerows(zip(*(c.tolist() for c in table.values()), strict=True))


def _json(study: Flexure, body: bool) -> str:
    """Facts and columns; what is not a finite number is null."""
    import json
    import math

    def plain(values: list) -> list:
        return [v if math.isfinite(v) else None for v in values]

    return json.dumps(
        {
            "source": study.source,
            "drive": study.move.text,
            "node": study.node.position,
            "orientation": study.node.orientation,
            "undeflected": study.zero,
            "turning": study.errors.turning,
            "pivot": plain(study.errors.pivot.tolist()),
            "units": {c.name: c.unit for c in study.columns(body)},
            "columns": {name: plain(values.tolist()) for name, values in study.table(body).items()},
            "warnings": study.warnings,
        }
    )


def _lines(study: Flexure, body: bool) -> list[str]:
    from spacar_drawing.stroke_tables import stroke_tables
    from spacar_formats.log.text_layout import table

    lines = []
    for part in stroke_tables(study, body):
        rows = [[_Right(cell) for cell in row] for row in part.rows]
        note = [f"  {part.note}"] if part.note else []
        lines += ["", part.title, *note, "", *table(part.heads, rows)]
    return lines[1:]


class _Right:
    """A text that stands to the right in a table, as numbers do."""

    def __init__(self, text: str) -> None:
        self.text = text

    def __str__(self) -> str:
        return self.text
