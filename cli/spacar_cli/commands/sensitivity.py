"""`spacar sensitivity FILE --parameter TARGET --of EXPRESSION`: exact derivatives of stationary quantities."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from spacar.calls import BEAMS
from spacar.errors import UsageError
from spacar_cli import vocabulary as words
from spacar_cli.environment import Environment, tell
from spacar_cli.input_files import input_file
from spacar_cli.row_output import finite, put_rows

if TYPE_CHECKING:
    from spacar.sensitivities.sensitivity import Sensitivity


@words.command("sensitivity", epilog="Parameters and quantities: `spacar help sensitivities`.")
@words.option(
    "parameters", ": 'ESTIFF.3[EI]', 'SECTION.leaf[t]', 'X.2[2] & X.5[2]'; with a value it is given that first. May be "
    "repeated.", multiple=True,
)  # fmt: skip
@words.option(
    "of", ": what is differentiated, 'x[6,1]@end', 'frequency[1]', 'lmult[1]', 'max(mises[3])'. May be repeated.",
    multiple=True, metavar="[NAME:]EXPRESSION",
)  # fmt: skip
@words.option("beams", type=click.Choice(BEAMS))
@words.option("csv_file", ": a row for every quantity and parameter.")
@words.option("as_json", ": values and derivatives")
def command(
    environment: Environment, file: Path, parameters: tuple[str, ...], of: tuple[str, ...], beams: str | None,
    csv_file: Path | None, as_json: bool,
) -> None:  # fmt: skip
    """Derivatives of positions, reactions, stresses, frequencies and load multipliers of the stationary states of FILE.

    They come from one analysis, to rounding: nothing is run again with changed numbers. Quantities are in SI,
    parameters in the unit of the file; `relative` is the change in per cent that one per cent of the parameter makes.
    """
    from spacar.sensitivities.sensitivity import COLUMNS, sensitivity

    source = input_file(file)
    if not parameters or not of:
        text = "give at least one --parameter, for instance 'ESTIFF.1[EI]', and one --of, 'frequency[1]'"
        raise UsageError(text, "usage.sensitivity")
    options: dict[str, Any] = {} if beams is None else {"beams": beams}
    names, values = _given(parameters)
    at = None
    if any(v is not None for v in values):
        now = sensitivity(source, names, [], **options).parameter_values.tolist()
        at = [n if v is None else v for n, v in zip(now, values, strict=True)]
    found = sensitivity(source, names, of, at=at, **options)
    for note in found.notes:
        severity, _, text = note.partition(": ") if note.startswith("warning: ") else ("information", "", note)
        tell(environment, severity, text)
    if csv_file is not None:
        put_rows(environment, csv_file, COLUMNS, found.rows())
    if as_json:
        environment.say_json(_record(found))
    elif csv_file is None:
        environment.say(*_lines(found))


def _given(parameters: tuple[str, ...]) -> tuple[list[str], list[float | None]]:
    """Names of the parameters, and the numbers that they are given. Raises UsageError."""
    names: list[str] = []
    values: list[float | None] = []
    for text in parameters:
        name, equals, number = text.partition("=")
        try:
            values.append(float(number) if equals else None)
        except ValueError:
            raise UsageError(f"'{number.strip()}' in '{text}' is not a number", "usage.sensitivity") from None
        names.append(name.strip())
    return names, values


def _record(found: Sensitivity) -> dict[str, Any]:
    def named(names: tuple[str, ...], values: list[float], units: tuple[str, ...]) -> list[dict[str, str | float]]:
        return [{"name": n, "value": v, "unit": u} for n, v, u in zip(names, values, units, strict=True)]

    return {
        "parameters": named(found.parameters, found.parameter_values.tolist(), found.parameter_units),
        "quantities": named(found.quantities, found.values.tolist(), found.quantity_units),
        "derivatives": finite(found.derivatives.tolist()), "notes": list(found.notes),
    }  # fmt: skip


def _lines(found: Sensitivity) -> list[str]:
    from spacar_formats.log.text_layout import table

    heads = ["quantity", "value", "unit", "parameter", "at", "unit", "derivative", "relative"]
    rows = []
    for q, value, unit, p, at, of, rate, relative in found.rows():
        numbers = f"{rate:.9g}", "" if relative != relative else f"{relative:+.5f}"
        rows.append([q, f"{value:.9g}", unit, p, f"{at:.9g}", of, *numbers])
    return table(heads, rows)
