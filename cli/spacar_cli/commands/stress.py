"""`spacar stress FILE`: stress resultants and stresses along beams as numbers."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from spacar.errors import UsageError
from spacar_cli import vocabulary as words
from spacar_cli.environment import Environment, tell
from spacar_cli.row_output import finite, put_columns
from spacar_cli.vocabulary import Whole

if TYPE_CHECKING:
    from spacar_drawing.stress_numbers import StressResults


@words.command("stress")
@words.option("at", "Default: all of them.")
@words.option("element", ": only this one; repeat for more", multiple=True)
@words.option("points", " along every element", type=Whole(2, 1001), default=9)
@words.option("csv_file", ": a row for every step, element and place.")
@words.option(
    "output", ": FILE.npz, all arrays; .png, .svg or .pdf, the section of one element (-e) at --place with its "
    "stresses.", multiple=True,
)  # fmt: skip
@words.option("place", ", of the picture. Default: 0.")
@words.option(
    "of", ": a stress of the picture. Default: normal.", type=click.Choice(("normal", "shear", "mises")),
    metavar="STRESS",
)  # fmt: skip
@words.option("as_json", ": the largest values")
@words.option("stale_ok")
def command(
    environment: Environment, file: str, at: int | None, element: tuple[int, ...], points: int,
    csv_file: Path | None, output: tuple[Path, ...], place: float | None, of: str | None, as_json: bool, stale_ok: bool,
) -> None:  # fmt: skip
    """Normal force, shear forces, torque, moments, bimoment and stresses along the beams of a result (NAME.sbd).

    Prints the largest value of every element, and where the largest of all are: step, element, place from p (0) to q
    (1), point of the section; with UNITS mm in mm and N/mm^2. Files and JSON are in SI. Stresses need cross-sections:
    BEAMSEC, or BEAMVIS or CROSSTYPE of the VISUALIZATION section.
    """
    from spacar_drawing.picture_source import open_source
    from spacar_drawing.stress_numbers import stress_results
    from spacar_drawing.stresses import GIVEN_BY

    pictures = [path for path in output if path.suffix.lower() != ".npz"]
    if not pictures and (place is not None or of is not None):
        raise UsageError(f"{'--of' if place is None else '--place'} is for a picture: give -o FILE.png and one -e")
    source = open_source(file, stale_ok=stale_ok)
    steps = None if at is None else [source.steps + 1 + at if at < 0 else at]
    for path in pictures:  # the stresses over one section, of the last step unless one is given
        from spacar_drawing.files import check_name, save
        from spacar_drawing.stress_picture import section_figure, section_stress

        check_name(path, film=False)
        if len(element) != 1:
            raise UsageError(f"-o {path}: a picture is of one element: give one -e, not {len(element)}")
        drawn = section_stress(source, (steps or [source.steps])[0], element[0], place or 0.0)
        title = f"{source.scene.title}   element {drawn.element} at {drawn.xi:.4g}, step {drawn.step}"
        save(section_figure(drawn, of or "normal", source.scene.metre, title), path)
        environment.wrote(path)
    if pictures and len(pictures) == len(output) and csv_file is None and not as_json:
        return
    found = stress_results(source, steps, element or None, points)
    for path in output:
        if path not in pictures:
            from spacar_formats.exports import to_npz

            to_npz(found.arrays(), path)
            environment.wrote(path)
    if csv_file is not None:
        put_columns(environment, csv_file, found.table())
        if str(csv_file) == "-":
            return
    largest = _largest(found)
    if as_json:
        environment.say_json(finite([asdict(one) for one in largest]))
        return
    if not any(one.quantity == "mises" for one in largest):
        tell(environment, "information", f"no element has a cross-section: no stresses ({GIVEN_BY})")
    environment.say(*_lines(found, source.scene.metre))


def _largest(found: StressResults) -> list:
    """The largest of every quantity that is known and not zero."""
    import numpy as np

    known = [name for name, value in found.values.items() if np.nan_to_num(value).any()]
    return [found.largest(name) for name in known]


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
