"""`spacar eigen FILE`: frequency table, root locus, Campbell diagram."""

import math
from pathlib import Path

import numpy as np
from spacar_drawing.curves import evaluate, in_units
from spacar_drawing.files import check_stills
from spacar_drawing.frequency_pictures import root_figure
from spacar_drawing.history import axis_text
from spacar_drawing.picture_source import open_source
from spacar_formats.getfrsbf import stored_step
from spacar_formats.log.text_layout import table
from spacar_formats.vibration import Vibration, mode_numbers, read_vibrations, shown_order, without_rounding

from spacar.errors import UsageError
from spacar_cli import vocabulary as words
from spacar_cli.drawing_options import PICTURES
from spacar_cli.environment import Environment, tell_notes
from spacar_cli.row_output import put_figure, put_rows

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
    environment: Environment, file: str, at: int | None, lowest: int | None, against: str | None, as_json: bool,
    csv_file: Path | None, output: tuple[Path, ...],
) -> None:  # fmt: skip
    """Frequencies of a result (NAME.sbm) of mode 7 or 10, or of the matrices of mode 3, 4 or 9.

    Prints real and imaginary part, modulus, frequency, damping ratio and the degree of freedom with the largest
    component: growing motions first, then by rising frequency, zero modes last. The number of a mode is that of `spacar
    visual --mode-number`; conjugate eigenvalues are one mode. With --output a picture: the frequencies over the steps,
    or over the expression --against (the speed of a rotor: Campbell diagram), and the root locus. Of a large model in
    mode 4 or 9, whose equations are stored sparse, the N lowest are computed, without --lowest 20.
    """
    found, names, warnings = read_vibrations(file, *([] if lowest is None else [lowest]))
    tell_notes(environment, warnings)
    if not found:
        raise UsageError(f"{file} contains no steps: the run stopped before the first one", "eigen.empty")
    chosen = list(range(1, len(found) + 1)) if at is None else [stored_step(at, len(found), file)]
    rows = [row for k in chosen for row in _rows(k, found[k - 1], names, lowest)]
    if as_json:
        keys = ("step", "mode", "real", "imag", "modulus", "frequency", "damping", "dof", "stored")
        environment.say_json([dict(zip(keys, row, strict=True)) for row in rows])
    elif csv_file is not None:
        put_rows(environment, csv_file, HEADS, rows)
    else:
        clean = {k: without_rounding(found[k - 1].values) for k in chosen}
        exact = [complex(clean[row[0]][row[8] - 1]) for row in rows]
        printed = [(*row[:2], v.real, v.imag, *row[4:8]) for row, v in zip(rows, exact, strict=True)]
        environment.say(*table(HEADS[:8], printed))
    if not output:
        return
    check_stills(output)
    steps = [found[k - 1] for k in chosen]
    across = np.array([s.t for s in steps])
    text = "load step" if np.array_equal(across, np.round(across)) else "time (s)"
    if against is not None:
        source = open_source(file)
        curve = in_units(evaluate(source, against), source.scene.metre)
        across, text = np.ravel(curve.values)[np.array(chosen) - 1], axis_text(curve)
    put_figure(environment, root_figure(steps, across, text, Path(file).stem), output)


def _rows(step: int, vibration: Vibration, names: list[str], lowest: int | None) -> list[tuple]:
    """Rows of the table in the order in which modes are shown; the last column is where the value is stored."""
    values, damping, dominant = vibration.values, vibration.damping, vibration.dominant(names)
    order = shown_order(values)
    numbers = mode_numbers(values, order)
    rows = []
    for i, number in list(zip(order, numbers, strict=True))[:lowest]:
        re, im, size = float(values[i].real), float(values[i].imag), float(abs(values[i]))
        dof = dominant[i] if dominant else ""
        rows.append((step, number, re, im, size, size / (2 * math.pi), float(damping[i]), dof, i + 1))
    return rows
