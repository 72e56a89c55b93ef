"""`spacar stress FILE`: stress resultants and stresses along beams as numbers."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from spacar.errors import UsageError
from spacar_cli.environment import Environment
from spacar_cli.number_types import Real, Whole
from spacar_cli.status import tell

if TYPE_CHECKING:
    from spacar_drawing.picture_source import PictureSource
    from spacar_drawing.stress_numbers import StressResults


@click.command("stress")
@click.argument("file")
@click.option("--step", type=Whole(), help="Only this stored step (from 1; -1 the last).")
@click.option("--element", "-e", "elements", type=Whole(min=1), multiple=True, help="Only this one; repeat for more.")
@click.option("--points", type=Whole(2, 1001), default=9, show_default=True, help="Places along every element.")
@click.option(
    "--csv",
    "csv_file",
    type=click.Path(path_type=Path, allow_dash=True),
    help="Write a row for every step, element and place as csv ('-': print them).",
)
@click.option("--npz", "npz_file", type=click.Path(path_type=Path), help="Write all arrays as a NumPy archive.")
@click.option(
    "--picture",
    type=click.Path(path_type=Path),
    help="Draw the section of one element (-e) at one place (--at) with its stresses: png, svg or pdf.",
)
@click.option("--at", "place", type=Real(0, 1), default=0.0, show_default=True, help="Place of the picture: 0 p, 1 q.")
@click.option(
    "--quantity",
    type=click.Choice(("normal", "shear", "mises")),
    default="normal",
    show_default=True,
    help="Stress of the picture.",
)
@click.option("--json", "as_json", is_flag=True, help="Print the largest values in JSON.")
@click.option("--stale-ok", is_flag=True, help="Use a result although its input file has changed since.")
@click.pass_obj
def command(
    environment: Environment,
    /,
    file: str,
    step: int | None,
    elements: tuple[int, ...],
    points: int,
    csv_file: Path | None,
    npz_file: Path | None,
    picture: Path | None,
    place: float,
    quantity: str,
    as_json: bool,
    stale_ok: bool,
) -> None:
    """Normal force, shear forces, torque, moments, bimoment and stresses along the beams of a result (NAME.sbd).

    Prints the largest value of every element, and where the largest of all are: step, element, place from p (0) to q
    (1), point of the section; with UNITS mm in mm and N/mm^2. Files and JSON are in SI. Stresses need cross-sections:
    BEAMSEC, or BEAMVIS or CROSSTYPE of the VISUALIZATION section.
    """
    from spacar_drawing.picture_source import open_source
    from spacar_drawing.stress_numbers import stress_results

    source = open_source(file, stale_ok=stale_ok)
    steps = None if step is None else [source.steps + 1 + step if step < 0 else step]
    if picture is not None:
        _picture(source, picture, steps, elements, place, quantity)
        environment.say(str(picture))
        return
    found = stress_results(source, steps, elements or None, points)
    if npz_file is not None:
        from spacar_formats.exports import to_npz

        to_npz(found.arrays(), npz_file)
        environment.say(str(npz_file))
    if csv_file is not None:
        from spacar_formats.safety import write_text

        text = _csv(found)
        if str(csv_file) == "-":
            environment.stdout.write(text)
            return
        write_text(csv_file, text)
        environment.say(str(csv_file))
    largest = _largest(found)
    if as_json:
        import json

        rows = [{k: v if v == v else None for k, v in asdict(one).items()} for one in largest]
        environment.say(json.dumps(rows))
        return
    if not any(one.quantity == "mises" for one in largest):
        tell(environment, "information", "no element has a cross-section: no stresses (BEAMSEC, BEAMVIS, CROSSTYPE)")
    for line in _lines(found, source.scene.metre):
        environment.say(line)


def _picture(
    source: PictureSource, path: Path, steps: list[int] | None, elements: tuple[int, ...], place: float, quantity: str
) -> None:
    """The stresses over one section; of the last step unless one is given. Raises UsageError."""
    from spacar_drawing.files import check_name, save
    from spacar_drawing.stress_section import section_figure, section_stress

    if len(elements) != 1:
        raise UsageError(f"--picture is of one element: give one -e, not {len(elements)}")
    check_name(path, film=False)
    found = section_stress(source, (steps or [source.steps])[0], elements[0], place)
    title = f"{source.scene.title}   element {found.element} at {found.xi:.4g}, step {found.step}"
    save(section_figure(found, quantity, source.scene.metre, title), path)


def _largest(found: StressResults) -> list:
    """The largest of every quantity that is known and not zero."""
    import numpy as np

    known = [name for name, value in found.values.items() if np.nan_to_num(value).any()]
    return [found.largest(name) for name in known]


def _csv(found: StressResults) -> str:
    import csv
    from io import StringIO

    out = StringIO()
    writer = csv.writer(out, lineterminator="\n")
    columns = found.table()
    writer.writerow(columns)
    writer.writerows(zip(*(c.tolist() for c in columns.values()), strict=True))
    return out.getvalue()


def _lines(found: StressResults, metre: float) -> list[str]:
    """Two tables, of the largest of every element and of all, in the unit of length of the input file, `metre` [m]."""
    import numpy as np
    from spacar_drawing.stresses import QUANTITIES
    from spacar_formats.log.text_layout import table

    from spacar.deck.length_unit import shown_in

    extremes = found.of_elements()
    used = [name for name, value in extremes.items() if np.nan_to_num(value).any()]
    shown = {name: shown_in(unit, metre) for name, (_, unit) in QUANTITIES.items()}
    heads = ["element", *(f"{name} ({shown[name][1]})" for name in used)]
    columns = [(shown[name][0] * extremes[name]).tolist() for name in used]
    rows = [
        [number, *("" if v != v else f"{v:.6g}" for v in values)]
        for number, *values in zip(found.elements.tolist(), *columns, strict=True)
    ]
    lines = ["Largest values along every element", "", *table(heads, rows), "", "Largest of all", ""]
    length = shown_in("m", metre)[1]
    heads = ["quantity", "value", "unit", "step", "element", "place", f"y ({length})", f"z ({length})"]
    largest = [
        [
            one.quantity, f"{shown[one.quantity][0] * one.value:.6g}", shown[one.quantity][1], one.step, one.element,
            f"{one.xi:.4g}",
            *("" if v != v else f"{v / metre:.6g}" for v in (one.y, one.z)),
        ]
        for one in _largest(found)
    ]  # fmt: skip
    return [*lines, *table(heads, largest)]
