"""`spacar bode FILE`: frequency response of a linearized system."""

from pathlib import Path

from spacar.errors import UsageError
from spacar_cli import vocabulary as words
from spacar_cli.drawing_options import PICTURES
from spacar_cli.environment import Environment, told_path
from spacar_cli.row_output import put_figure, put_rows


@words.command("bode")
@words.option("at", default=1)
@words.option("inputs", ": number (from 1) or part of the name; default all.", multiple=True)
@words.option("of", ": an output by number (from 1) or part of the name; default all.", multiple=True, metavar="NAME")
@words.option("low")
@words.option("high")
@words.option("points", default=400)
@words.option("csv_file", ": frequency, amplitude and phase; no picture then, unless --output is given.")
@words.option("output", PICTURES, multiple=True)
def command(
    environment: Environment, file: str, at: int, inputs: tuple[str, ...], of: tuple[str, ...], low: float | None,
    high: float | None, points: int, csv_file: Path | None, output: tuple[Path, ...],
) -> None:  # fmt: skip
    """Bode diagram of the state space matrices of a result (NAME.ltv) of mode 3, 4 or 9.

    Without --output the picture is NAME_bode.png beside the result. The frequencies reach from a tenth of the lowest to
    ten times the highest eigenfrequency, and are denser at lightly damped ones; of a large model, whose system is
    stored sparse, to the highest of its 20 lowest.
    """
    import numpy as np
    from spacar_formats.getss import frequencies, frequency_response, linear_system

    path = told_path(environment, file, "ltv")
    system = linear_system(file, at)
    if low is not None and high is not None and low >= high:
        raise UsageError(f"--low {low:g} is not below --high {high:g}", "bode.range")
    pairs = [(i, j) for i in _chosen(system.outputs, of, "output") for j in _chosen(system.inputs, inputs, "input")]
    turn = 2 * np.pi
    omega = frequencies(system, low and low * turn, high and high * turn, points)
    response = frequency_response(system, omega)
    if csv_file is not None:
        names = [f"{system.outputs[i]} / {system.inputs[j]}" for i, j in pairs]
        heads = ["frequency [Hz]", *(f"{what} {n}" for n in names for what in ("amplitude", "phase [deg]"))]
        cells = np.array([response[:, i, j] for i, j in pairs])
        columns = np.stack([np.abs(cells), np.degrees(np.angle(cells))], axis=1).reshape(-1, len(omega))
        put_rows(environment, csv_file, heads, np.vstack([omega / turn, columns]).T.tolist())
        if not output:
            return
    from spacar_drawing.files import check_stills
    from spacar_drawing.frequency_pictures import bode_figure

    targets = output or (path.with_name(f"{path.name.split('.ltv')[0]}_bode.png"),)
    check_stills(targets)
    put_figure(environment, bode_figure(system, omega, response, pairs, path.stem), targets)


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
