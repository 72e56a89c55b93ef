"""`spacar mrltv FILE N`: modal reduction of a time-varying linear system."""

from pathlib import Path

import click

from spacar_cli import vocabulary as words
from spacar_cli.environment import Environment, tell_notes
from spacar_cli.vocabulary import Whole


@words.command("mrltv")
@click.argument("modes", type=Whole(min=1))
@words.option("quasi_static", "; default all")
@words.option("output", "; default FILEmr.ltv")
def command(environment: Environment, file: str, modes: int, quasi_static: int | None, output: Path | None) -> None:
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
    tell_notes(environment, warnings)
    environment.wrote(*reduction.report, target)
