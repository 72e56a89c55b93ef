"""`spacar ltv FILE`: response of a stored time-varying linear system."""

from pathlib import Path

import click

from spacar_cli import vocabulary as words
from spacar_cli.environment import Environment, tell_notes
from spacar_cli.row_output import show_scopes, signal_options, sorted_files


@words.command("ltv")
@words.option("interpolation", type=click.Choice(["linear", "step"]), default="linear")
@words.option("substeps", default=1)
@words.option("static_start")
@words.option("modes", ", to which the system is reduced first (see mrltv).")
@signal_options("FILE_ltv.npz")
def command(
    environment: Environment, file: str, interpolation: str, substeps: int, static_start: bool, modes: int | None,
    output: tuple[Path, ...], show: bool,
) -> None:  # fmt: skip
    """Simulate the linear time-varying system of an .ltv file under its stresses sigma0 (perturbation method).

    The inputs are the nominal ones, undisturbed; fold in feedback with spacntrl. Writes t, z (states), dy (deviations
    of the outputs) and y (outputs with their reference and second order terms), and the same signals as
    FILE_ltv.sbd for plot. Pictures show the deviations of the outputs.
    """
    from spacar_formats.locate import result_path
    from spacar_formats.ltvfile import read_ltv
    from spacar_formats.signal_tables import export_signals, panels_by_quantity, table_of_arrays, write_table

    from spacar.simulation import feedback
    from spacar.simulation.propagation import simulate_ltv
    from spacar.simulation.reduction import reduce_modes

    tables, pictures = sorted_files(output, show)
    data, warnings = read_ltv(file)
    path = result_path(file, "ltv")
    tell_notes(environment, warnings)
    if static_start:
        data = feedback.static_start(data)
    if modes is not None:
        reduction = reduce_modes(data, modes)
        data = reduction.system
        environment.wrote(*reduction.report)
    response = simulate_ltv(data, interpolation=interpolation, substeps=substeps)
    targets = tables or [path.with_name(f"{path.stem}_ltv.npz")]
    for target in targets:
        export_signals({"t": response.t, "z": response.z, "dy": response.dy, "y": response.y}, target)
    n, p = response.z.shape[1], response.dy.shape[1]
    names = data.outputs if len(data.outputs) == p else tuple(f"y{k + 1}" for k in range(p))
    table = table_of_arrays(
        {"dy": (names, response.dy), "y": (names, response.y), "z": (tuple(f"z{k + 1}" for k in range(n)), response.z)}
    )
    signals = write_table(targets[0].with_suffix(""), response.t, table, path)
    files = " ".join(map(str, (*targets, signals)))
    environment.wrote(f"{path.name}: {len(response.t)} times, {n} states: {files}")
    show_scopes(environment, table, response.t, panels_by_quantity(table, "dy"), path.stem, show, pictures)
