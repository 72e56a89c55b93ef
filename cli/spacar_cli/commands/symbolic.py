"""`spacar symbolic check|derive|export|simulate MODEL`: equations of motion by computer algebra.

SymPy is imported inside the commands only.
"""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from spacar.errors import SpacarError, UsageError
from spacar_cli import vocabulary as words
from spacar_cli.environment import Environment, tell
from spacar_cli.vocabulary import Real, Whole

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


def _derived(environment: Environment, model: SymbolicModel, strategy: str) -> SymbolicEquations:
    """The equations, checked; errors of the derivation are errors of the model. The check is told."""
    try:
        eq = model.system.derive(strategy)
        checked = eq.check()
        checked.demand()
        tell(environment, "information", f"check: {checked}")
        return eq
    except SpacarError as error:
        raise UsageError(f"{model.path.name}: {error}", error.code) from None


@command.command("check", cls=words.Command)
@MODEL
@click.pass_obj
def check(environment: Environment, model: Path) -> None:
    """Read MODEL and say what it contains; nothing is derived."""
    read = _read(model)
    from spacar_cli.symbolic_run import description

    environment.say(*description(read))


@command.command("derive", cls=words.Command)
@MODEL
@words.option("strategy", type=STRATEGY, default="held")
@words.option(
    "notation", ": vectors (held), cosines (transformed), or assignments (program).",
    type=click.Choice(["held", "transformed", "program"]),
)  # fmt: skip
@words.option("form", type=click.Choice(["text", "latex", "json"]), default="text")
@click.pass_obj
def derive(environment: Environment, model: Path, strategy: str, notation: str | None, form: str) -> None:
    """Derive the equations of MODEL and print them.

    The default is vector notation for the held strategy and the program for the recursive one.
    """
    read = _read(model)
    from spacar_cli.symbolic_run import equations_text

    notation = notation or ("held" if strategy == "held" else "program")
    environment.say(equations_text(read, _derived(environment, read, strategy), notation, form))


@command.command("export", cls=words.Command)
@MODEL
@words.option("language", type=click.Choice(["python", "c", "fortran", "latex"]))
@words.option("strategy", type=STRATEGY, default="recursive")
@words.option("jacobian")
@words.option("output", "; default MODEL with its ending.")
@words.option("shapes", ", for NAME.dat", default=2)
@words.option("duration", ", for NAME.dat of the comparison; default TIMESTEP, or 1.")
@click.pass_obj
def export(
    environment: Environment, model: Path, language: str | None, strategy: str, jacobian: bool, output: Path | None,
    shapes: int, duration: float | None,
) -> None:  # fmt: skip
    """Write the equations of MODEL as a self-contained program.

    An input file NAME.dat of the modes becomes a model file NAME.toml, or with --language a program: mechanisms of
    rigid links and joints, springs, and flexible beams by assumed shapes. Its motion is compared with mode 1.
    """
    if model.suffix.lower() == ".dat":
        from spacar_cli.deck_export import export_deck

        _demand_sympy()
        environment.wrote(*export_deck(model, language, strategy, jacobian, output, shapes, duration))
        return
    if language is None:
        raise UsageError("choose the language of the program with --language: python, c, fortran or latex")
    read = _read(model)
    from spacar_formats.safety import replacing

    from spacar.symbolic.emit import LANGUAGES

    program = _derived(environment, read, strategy).program(read.outputs)
    target = output or read.path.with_suffix(LANGUAGES[language])
    if target == read.path:
        raise UsageError(f"{target} is the model itself: choose another file with --output")
    with replacing(target) as side:
        program.write(side, language, jacobian)
    counts = program.counts()
    environment.wrote(f"{target}: {counts['step']} operations per step, {counts['once']} once")


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


@command.command("simulate", cls=words.Command)
@MODEL
@words.option("assignments", ": a parameter or start value", multiple=True, callback=_setting, metavar="NAME=VALUE")
@words.option("duration", type=Real())
@words.option("n_steps", " of the output", type=Whole())
@words.option("integrator", "; default lsoda", type=click.Choice(["lsoda", "radau", "dop853"]))
@words.option("rtol", "; default 1e-8", type=Real())
@words.option("atol", "; default rtol times the scale of each state.", type=Real())
@words.option("strategy", type=STRATEGY, default="recursive")
@words.option("compile")
@words.option(
    "plot", ": a coordinate or an output, or all; a figure (png) for each. May be repeated.", multiple=True,
    metavar="NAME",
)  # fmt: skip
@words.option("equations")
@words.option("wait")
@click.pass_obj
def simulate(
    environment: Environment, model: Path, assignments: dict[str, float], duration: float | None, n_steps: int | None,
    compile: bool, plot: tuple[str, ...], equations: bool, strategy: str, wait: bool, **wishes: Any,
) -> None:  # fmt: skip
    """Simulate MODEL; writes NAME.log and NAME.sbd beside it."""
    read = _read(model)
    from spacar_cli.symbolic_run import simulate_model

    wishes |= {"time": duration, "steps": n_steps}
    environment.wrote(*simulate_model(read, strategy, assignments, wishes, compile, plot, equations, wait))
