"""`spacar ltv FILE`: response of a stored time-varying linear system."""

from __future__ import annotations

from pathlib import Path

import click

from spacar_cli.environment import Environment
from spacar_cli.number_types import Whole
from spacar_cli.scope_output import check_pictures, scope_options, show_scopes
from spacar_cli.status import tell


@click.command("ltv")
@click.argument("file")
@click.option(
    "--interpolation",
    type=click.Choice(["linear", "step"]),
    default="linear",
    show_default=True,
    help="Of matrices and inputs between the stored times.",
)
@click.option("--substeps", type=Whole(min=1), default=1, show_default=True, help="Steps per stored interval.")
@click.option("--static-start", is_flag=True, help="Start from the static answer to sigma0 instead of X0.")
@click.option("--modes", type=Whole(min=1), help="Reduce to that many modes first (see mrltv).")
@click.option("--output", "-o", type=click.Path(path_type=Path), help="Write .npz, .mat or .csv; default FILE_ltv.npz.")
@click.option("--quiet", "-q", is_flag=True, help="Print errors only.")
@scope_options
@click.pass_obj
def command(
    environment: Environment, file: str, interpolation: str, substeps: int, static_start: bool, modes: int | None,
    output: Path | None, quiet: bool, plot: bool, pictures: tuple[Path, ...],
) -> None:  # fmt: skip
    """Simulate the linear time-varying system of an .ltv file under its stresses sigma0 (perturbation method).

    The inputs are the nominal ones, undisturbed; fold in feedback with spacntrl. Writes t, z (states), dy (deviations
    of the outputs) and y (outputs with their reference and second order terms), and the same signals as
    FILE_ltv.sbd for plot. --plot and --picture show the deviations of the outputs.
    """
    from spacar_formats.histories import export_signals
    from spacar_formats.locate import result_path
    from spacar_formats.ltvfile import read_ltv
    from spacar_formats.signal_tables import panels_by_quantity, table_of_arrays, write_table

    from spacar.simulation import feedback
    from spacar.simulation.propagation import simulate_ltv
    from spacar.simulation.reduction import reduce_modes

    check_pictures(plot, pictures)
    data, warnings = read_ltv(file)
    path = result_path(file, "ltv")
    if not quiet:
        for warning in warnings:
            tell(environment, "warning", warning)
    if static_start:
        data = feedback.static_start(data)
    if modes is not None:
        reduction = reduce_modes(data, modes)
        data = reduction.system
        if not quiet:
            for line in reduction.report:
                environment.say(line)
    response = simulate_ltv(data, interpolation=interpolation, substeps=substeps)
    target = output or path.with_name(f"{path.stem}_ltv.npz")
    export_signals({"t": response.t, "z": response.z, "dy": response.dy, "y": response.y}, target)
    n, p = response.z.shape[1], response.dy.shape[1]
    names = data.outputs if len(data.outputs) == p else tuple(f"y{k + 1}" for k in range(p))
    table = table_of_arrays(
        {
            "dy": (names, response.dy),
            "y": (names, response.y),
            "z": (tuple(f"z{k + 1}" for k in range(n)), response.z),
        }
    )
    signals = write_table(target.with_suffix(""), response.t, table, path)
    if not quiet:
        environment.say(f"{path.name}: {len(response.t)} times, {n} states: {target} {signals}")
    panels = panels_by_quantity(table, "dy")
    show_scopes(environment, table, response.t, panels, path.stem, plot, pictures)
