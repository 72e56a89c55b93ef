"""`spacar bode FILE`: frequency response of a linearized system."""

from __future__ import annotations

import csv
from pathlib import Path

import click

from spacar.errors import UsageError
from spacar_cli.drawing_options import OUTPUT
from spacar_cli.environment import Environment
from spacar_cli.number_types import Real, Whole


@click.command("bode")
@click.argument("file")
@click.option("--step", type=Whole(), default=1, show_default=True, help="Stored step, from 1.")
@click.option("--input", "inputs", multiple=True, metavar="NAME", help="Number (from 1) or part of the name; all.")
@click.option("--to", "outputs", multiple=True, metavar="NAME", help="The same for outputs.")
@click.option("--low", type=Real(min=0, min_open=True), help="Lowest frequency [Hz].")
@click.option("--high", type=Real(min=0, min_open=True), help="Highest frequency [Hz].")
@click.option("--points", type=Whole(2, 100000), default=400, show_default=True, help="Frequencies.")
@click.option("--csv", "as_csv", is_flag=True, help="Print frequency, amplitude and phase as csv; no picture then.")
@OUTPUT
@click.pass_obj
def command(
    environment: Environment,
    /,
    file: str,
    step: int,
    inputs: tuple[str, ...],
    outputs: tuple[str, ...],
    low: float | None,
    high: float | None,
    points: int,
    as_csv: bool,
    output: tuple[Path, ...],
) -> None:
    """Bode diagram of the state space matrices of a result (NAME.ltv) of mode 3, 4 or 9.

    Without --output the picture is NAME_bode.png beside the result. The frequencies reach from a tenth of the lowest to
    ten times the highest eigenfrequency, and are denser at lightly damped ones; of a large model, whose system is
    stored sparse, to the highest of its 20 lowest.
    """
    import numpy as np
    from spacar_formats.frequency import frequencies, frequency_response
    from spacar_formats.getss import linear_system
    from spacar_formats.locate import notes, open_result

    with open_result(file, "ltv") as result:
        path = result.path
        for note in notes(result):
            environment.tell(f"warning: {note}")
    system = linear_system(file, step)
    if low is not None and high is not None and low >= high:
        raise UsageError(f"--low {low:g} is not below --high {high:g}", "bode.range")
    pairs = [
        (i, j) for i in _chosen(system.outputs, outputs, "output") for j in _chosen(system.inputs, inputs, "input")
    ]
    turn = 2 * np.pi
    omega = frequencies(system, low and low * turn, high and high * turn, points)
    response = frequency_response(system, omega)
    if as_csv:
        writer = csv.writer(environment.stdout, lineterminator="\n")
        names = [f"{system.outputs[i]} / {system.inputs[j]}" for i, j in pairs]
        writer.writerow(["frequency [Hz]", *(f"{what} {n}" for n in names for what in ("amplitude", "phase [deg]"))])
        for k, w in enumerate(omega):
            cells = [response[k, i, j] for i, j in pairs]
            writer.writerow([repr(float(w / turn))] + [
                repr(float(v)) for c in cells for v in (abs(c), np.degrees(np.angle(c)))
            ])  # fmt: skip
        if not output:
            return
    from spacar_drawing.files import check_name, save
    from spacar_drawing.frequency_pictures import bode_figure

    targets = output or (path.with_name(f"{path.name.split('.ltv')[0]}_bode.png"),)
    for target in targets:
        check_name(target, film=False)
    figure = bode_figure(system, omega, response, pairs, path.stem)
    for target in targets:
        save(figure, target)
        environment.tell(str(target)) if as_csv else environment.say(str(target))


def _chosen(names: tuple[str, ...], wanted: tuple[str, ...], what: str) -> list[int]:
    """Indices of the signals; all without a wish. Raises UsageError naming the signals that exist."""
    if not wanted:
        return list(range(len(names)))
    found = []
    for word in wanted:
        if word.isdigit() and 1 <= int(word) <= len(names):
            found.append(int(word) - 1)
            continue
        hits = [k for k, name in enumerate(names) if word.lower() in name.lower()]
        if not hits or word.isdigit():
            known = ", ".join(f"{k} ({name})" for k, name in enumerate(names, 1))
            raise UsageError(f"no {what} {word}; there are {known or 'none'}", "bode.signal")
        found += hits
    return list(dict.fromkeys(found))
