"""`spacar fmu FILE`: the mechanism as a functional mock-up unit for other simulators."""

from pathlib import Path

from spacar_cli import vocabulary as words
from spacar_cli.environment import Environment
from spacar_cli.input_files import input_file


@words.command("fmu")
@words.option("output", "; default FILE.fmu")
@words.option("rtol", default=1e-6)
@words.option("atol", default=1e-8)
def command(environment: Environment, file: Path, output: Path | None, rtol: float, atol: float) -> None:
    """Export the mechanism with its INPUTS, INPUTF and OUT... as FILE.fmu (FMI 2.0, co-simulation).

    Between two communication points the inputs are held and the motion is integrated with the tolerances. Needs
    pythonfmu (pip install 'spacar[fmu]'); the Python that opens the unit needs spacar.
    """
    from spacar_formats.fmu import export_fmu

    source = input_file(file)
    target = output or source.with_suffix(".fmu")
    plant = export_fmu(source, target, rtol, atol)
    environment.wrote(f"{target}: {plant.n_in} inputs, {plant.n_out} outputs, FMI 2.0 for co-simulation")
