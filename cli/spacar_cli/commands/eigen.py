"""`spacar eigen FILE`: frequency table, root locus, Campbell diagram."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from spacar_drawing.curves import evaluate, in_units
from spacar_drawing.files import check_stills
from spacar_drawing.history import axis_text
from spacar_drawing.picture_source import open_source

from spacar.errors import UsageError
from spacar_cli import vocabulary as words
from spacar_cli.drawing_options import PICTURES
from spacar_cli.environment import Environment, tell_notes
from spacar_cli.row_output import put_figure, put_rows

if TYPE_CHECKING:
    from spacar_formats.vibration import Vibration

HEADS = (
    "step", "mode", "real [1/s]", "imag [rad/s]", "modulus [rad/s]", "frequency [Hz]", "damping", "largest in",
    "stored as",
)  # fmt: skip


@words.command("eigen")
@words.option("at", "Default: all of them.")
@words.option("lowest")
@words.option("against", " in the Campbell diagram, as in `spacar plot`.")
@words.option("as_json")
@words.option("csv_file")
@words.option("output", PICTURES, multiple=True)
def command(
    environment: Environment, /, file: str, at: int | None, lowest: int | None, against: str | None, as_json: bool,
    csv_file: Path | None, output: tuple[Path, ...],
) -> None:  # fmt: skip
    """Frequencies of a result (NAME.sbm) of mode 7 or 10, or of the matrices of mode 3, 4 or 9.

    Prints real and imaginary part, modulus, frequency, damping ratio and the degree of freedom with the largest
    component: growing motions first, then by rising frequency, zero modes last. The number of a mode is that of `spacar
    visual --mode-number`; conjugate eigenvalues are one mode. With --output a picture: the frequencies over the steps,
    or over the expression --against (the speed of a rotor: Campbell diagram), and the root locus. Of a large model in
    mode 4 or 9, whose equations are stored sparse, the N lowest are computed, without --lowest 20.
    """
    from spacar_formats.vibration import read_vibrations, without_rounding

    found, names, warnings = read_vibrations(file, *([] if lowest is None else [lowest]))
    tell_notes(environment, warnings)
    if not found:
        raise UsageError(f"{file} contains no steps: the run stopped before the first one", "eigen.empty")
    chosen = range(1, len(found) + 1)
    if at is not None:
        number = len(found) + 1 + at if at < 0 else at
        if number not in chosen:
            raise UsageError(f"step {at} does not exist: {file} has steps 1 to {len(found)}", "files.step")
        chosen = range(number, number + 1)
    rows = [row for k in chosen for row in _rows(k, found[k - 1], names, lowest)]
    if as_json:
        keys = ("step", "mode", "real", "imag", "modulus", "frequency", "damping", "dof", "stored")
        environment.say(json.dumps([dict(zip(keys, row, strict=True)) for row in rows]))
    elif csv_file is not None:
        put_rows(environment, csv_file, HEADS, rows)
    else:
        from spacar_formats.log.text_layout import table

        clean = {k: without_rounding(found[k - 1].values) for k in chosen}
        printed = [
            (*row[:2], float(clean[row[0]][row[8] - 1].real), float(clean[row[0]][row[8] - 1].imag), *row[4:8])
            for row in rows
        ]
        for line in table(HEADS[:8], printed):
            environment.say(line)
    if output:
        _pictures(environment, file, [found[k - 1] for k in chosen], list(chosen), against, output)


def _rows(step: int, vibration: Vibration, names: list[str], lowest: int | None) -> list[tuple]:
    """Rows of the table in the order in which modes are shown; the last column is where the value is stored."""
    from spacar_formats.vibration import mode_numbers, shown_order

    values, damping, dominant = vibration.values, vibration.damping, vibration.dominant(names)
    order = shown_order(values)
    numbers = mode_numbers(values, order)
    return [
        (
            step, number, float(values[i].real), float(values[i].imag), float(abs(values[i])),
            float(abs(values[i])) / 6.283185307179586, float(damping[i]), dominant[i] if dominant else "", i + 1,
        )
        for i, number in list(zip(order, numbers, strict=True))[:lowest]
    ]


def _pictures(
    environment: Environment, file: str, steps: list[Vibration], numbers: list[int], against: str | None,
    output: tuple[Path, ...],
) -> None:  # fmt: skip
    from spacar_drawing.frequency_pictures import root_figure

    check_stills(output)
    across: np.ndarray = np.array([s.t for s in steps])
    text = "load step" if np.array_equal(across, np.round(across)) else "time (s)"
    if against is not None:
        source = open_source(file)
        curve = in_units(evaluate(source, against), source.scene.metre)
        across, text = np.ravel(curve.values)[np.array(numbers) - 1], axis_text(curve)
    put_figure(environment, root_figure(steps, across, text, Path(file).stem), output)
