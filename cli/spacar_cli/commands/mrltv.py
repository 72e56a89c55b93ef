"""`spacar mrltv FILE N`: modal reduction of a time-varying linear system."""

from __future__ import annotations

from pathlib import Path

import click

from spacar_cli.environment import Environment
from spacar_cli.number_types import Whole
from spacar_cli.status import tell


@click.command("mrltv")
@click.argument("file")
@click.argument("modes", type=Whole(min=1))
@click.option(
    "--quasi-static", type=Whole(min=0), help="Number of next modes that answer statically; default all."
)
@click.option("--output", "-o", type=click.Path(path_type=Path), help="Name of the reduced file; default FILEmr.ltv.")
@click.option("--quiet", "-q", is_flag=True, help="Print errors only.")
@click.pass_obj
def command(
    environment: Environment, file: str, modes: int, quasi_static: int | None, output: Path | None, quiet: bool
) -> None:
    """Reduce the system of an .ltv file to MODES low-frequency modes.

    The next modes answer quasi-statically, the remaining ones are dropped. Prints which mode is in which group, with
    the range of its frequency, and writes another .ltv file.
    """
    from spacar_formats.locate import result_path
    from spacar_formats.ltvfile import read_ltv, write_ltv

    from spacar.simulation.reduction import reduce_modes

    data, warnings = read_ltv(file)
    path = result_path(file, "ltv")
    reduction = reduce_modes(data, modes, quasi_static)
    target = output or path.with_name(f"{path.stem}mr.ltv")
    write_ltv(reduction.system, target, path)
    if not quiet:
        for warning in warnings:
            tell(environment, "warning", warning)
        for line in reduction.report:
            environment.say(line)
        environment.say(str(target))
