"""`spacar symbolic check|derive|export|simulate MODEL`: equations of motion by computer algebra.

SymPy is imported inside the commands only.
"""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from spacar.errors import SpacarError, UsageError
from spacar_cli.number_types import Real, Whole

if TYPE_CHECKING:
    from spacar.symbolic.script import SymbolicModel
    from spacar.symbolic.symbolic_equations import SymbolicEquations

MODEL = click.argument("model", type=click.Path(path_type=Path))
STRATEGY = click.Choice(["held", "recursive"])


@click.group("symbolic")
def command() -> None:
    """Equations of motion in vector notation, from a model file (NAME.toml, or a Python script NAME.py).

    check reads a model; derive prints its equations; export writes a program; simulate runs it.
    """


def _demand_sympy() -> None:
    if find_spec("sympy") is None:
        raise UsageError('spacar symbolic needs SymPy: pip install "spacar[symbolic]"', "sympy")


def _read(path: Path) -> SymbolicModel:
    """The model; UsageError without SymPy."""
    if path.suffix.lower() == ".dat":
        raise UsageError(f"{path} is an input file of the modes: spacar symbolic export {path} makes a model of it")
    _demand_sympy()
    from spacar.symbolic.model_reader import read_model

    return read_model(path)


def _derived(model: SymbolicModel, strategy: str) -> SymbolicEquations:
    """The equations, checked; errors of the derivation are errors of the model. The check is printed on stderr."""
    try:
        eq = model.system.derive(strategy)
        checked = eq.check()
        checked.demand()
        click.echo(f"check: {checked}", err=True)
        return eq
    except SpacarError as error:
        raise UsageError(f"{model.path.name}: {error}", error.code) from None


@command.command("check")
@MODEL
def check(model: Path) -> None:
    """Read MODEL and say what it contains; nothing is derived."""
    from spacar_cli.symbolic_text import description

    click.echo("\n".join(description(_read(model))))


@command.command("derive")
@MODEL
@click.option("--strategy", type=STRATEGY, default="held", show_default=True, help="Readable or lean.")
@click.option(
    "--show", type=click.Choice(["held", "transformed", "program"]), help="Vector notation, cosines, or assignments."
)
@click.option("--format", "form", type=click.Choice(["text", "latex", "json"]), default="text", show_default=True)
def derive(model: Path, strategy: str, show: str | None, form: str) -> None:
    """Derive the equations of MODEL and print them.

    The default is vector notation for the held strategy and the program for the recursive one.
    """
    from spacar_cli.symbolic_text import equations_text

    read = _read(model)
    show = show or ("held" if strategy == "held" else "program")
    click.echo(equations_text(read, _derived(read, strategy), show, form))


@command.command("export")
@MODEL
@click.option("--language", type=click.Choice(["python", "c", "fortran", "latex"]), help="Language of the program.")
@click.option("--strategy", type=STRATEGY, default="recursive", show_default=True, help="Readable or lean.")
@click.option("--jacobian", is_flag=True, help="Also the exact Jacobian (python, c, fortran).")
@click.option("-o", "--output", type=click.Path(path_type=Path), help="File to write (default: MODEL with its ending).")
@click.option("--shapes", type=Whole(min=2), default=2, show_default=True, help="Of NAME.dat: shapes of a beam.")
@click.option("--time", type=Real(), help="Of NAME.dat: end of the comparison [s] (default: TIMESTEP, or 1).")
def export(
    model: Path, language: str | None, strategy: str, jacobian: bool, output: Path | None, shapes: int,
    time: float | None,
) -> None:  # fmt: skip
    """Write the equations of MODEL as a self-contained program.

    An input file NAME.dat of the modes becomes a model file NAME.toml, or with --language a program: mechanisms of
    rigid links and joints, springs, and flexible beams by assumed shapes. Its motion is compared with mode 1.
    """
    if model.suffix.lower() == ".dat":
        from spacar_cli.deck_export import export_deck

        _demand_sympy()
        click.echo("\n".join(export_deck(model, language, strategy, jacobian, output, shapes, time)))
        return
    if language is None:
        raise UsageError("choose the language of the program with --language: python, c, fortran or latex")
    read = _read(model)
    from spacar_formats.safety import replacing

    from spacar.symbolic.emit import LANGUAGES

    program = _derived(read, strategy).program(read.outputs)
    target = output or read.path.with_suffix(LANGUAGES[language])
    if target == read.path:
        raise UsageError(f"{target} is the model itself: choose another file with --output")
    with replacing(target) as side:
        program.write(side, language, jacobian)
    counts = program.counts()
    click.echo(f"{target}: {counts['step']} operations per step, {counts['once']} once")


def _setting(ctx: click.Context, parameter: click.Parameter, values: tuple[str, ...]) -> dict[str, float]:
    result = {}
    for text in values:
        name, equal, number = text.partition("=")
        try:
            result[name.strip()] = float(number)
        except ValueError:
            equal = ""
        if not equal:
            raise click.BadParameter(f"'{text}' is not NAME=VALUE")
    return result


@command.command("simulate")
@MODEL
@click.option(
    "--set", "changes", multiple=True, callback=_setting, metavar="NAME=VALUE", help="Parameter or start value."
)
@click.option("--time", type=Real(), help="End of the simulation [s].")
@click.option("--steps", type=Whole(), help="Number of output steps.")
@click.option("--integrator", type=click.Choice(["lsoda", "radau", "dop853"]), help="Default lsoda.")
@click.option("--rtol", type=Real(), help="Relative tolerance (default 1e-8).")
@click.option("--atol", type=Real(), help="Absolute tolerance (default: rtol times the scale of each state).")
@click.option("--strategy", type=STRATEGY, default="recursive", show_default=True)
@click.option("--compile", "compiled", is_flag=True, help="Build the C program with the system compiler.")
@click.option("--plot", is_flag=True, help="Also one figure (png) for each coordinate and output.")
@click.option("--show", is_flag=True, help="Write all equations in vector notation into the log.")
@click.option("--wait", is_flag=True, help="Wait when another run is writing the same results.")
@click.option("--quiet", is_flag=True, help="No summary.")
def simulate(
    model: Path,
    changes: dict[str, float],
    compiled: bool,
    plot: bool,
    show: bool,
    strategy: str,
    wait: bool,
    quiet: bool,
    **wishes: Any,
) -> None:
    """Simulate MODEL; writes NAME.log and NAME.sbd beside it."""
    from spacar_cli.symbolic_run import simulate_model

    lines = simulate_model(_read(model), strategy, changes, wishes, compiled=compiled, plot=plot, show=show, wait=wait)
    if not quiet:
        click.echo("\n".join(lines))
