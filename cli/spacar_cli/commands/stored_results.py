"""The commands about result files, by their names in MATLAB: what is in one, and its variables as lines or files.

`spacar_formats` has what they do; it is imported when they run.
"""

import json
from pathlib import Path

import click

from spacar.errors import AnalysisError, UsageError
from spacar_cli import vocabulary as words
from spacar_cli.environment import Environment, tell_notes, told_path
from spacar_cli.vocabulary import StepNumber

EXPORT_HELP = """Export all variables of an .{kind} file, or only those named, under their MATLAB names.

Writes FILE.{kind}.npz (.mat, .csv) beside the result, or what --output says. A .csv has a row for each step; the header
variables go to a second table, .header.csv.
"""


@words.command("checksbf")
@words.option("as_json", ": the findings")
def checksbf(environment: Environment, file: str, as_json: bool) -> None:
    """List the variables of a result file and verify its checksums; exit status 1 when it is damaged."""
    from spacar_formats import checksbf
    from spacar_formats.sbf import SbfError

    try:
        check = checksbf.checksbf(file)
    except SbfError as error:  # the file is what was asked about, so this is a result and no wrong use
        raise AnalysisError(str(error), error.code) from None
    if as_json:
        environment.say_json(checksbf.as_json(check))
    else:
        environment.say(*checksbf.listing(check))
    if not check.sound:
        raise AnalysisError(f"{check.path} is damaged: {'; '.join(check.damage)}", "files.damaged")


@words.command("getfrsbf")
@click.argument("ident", metavar="ID")
@click.argument("steps", required=False, metavar="[STEPS]")
@words.option("at", ": the same as the argument STEPS.", metavar="STEPS", type=str)
@words.option("as_json", ': {"id", "shape", "data"}.')
def getfrsbf(environment: Environment, file: str, ident: str, steps: str | None, at: str | None, as_json: bool) -> None:
    """Print a variable of a result file.

    STEPS is 3, end, 2:5, 1:10:end or 1,4,9; without it all steps are printed. One step is printed as a
    matrix; of several steps each is a row, with the columns of a matrix one after the other.
    """
    from spacar_formats import getfrsbf
    from spacar_formats.locate import notes, open_result

    if steps is not None and at is not None:
        raise UsageError("the steps are given twice, as argument and by --at", "usage.step")
    steps = steps or at
    with open_result(file) as result:
        value = result.get(ident, None if steps is None else getfrsbf.step_numbers(steps, result.steps))
        name = "TDEF" if ident.strip().upper() == "TDEF" else result.variable(ident).id
        tell_notes(environment, notes(result))
    if as_json:
        environment.say_json(getfrsbf.as_json(name, value))
    else:
        environment.say(*getfrsbf.as_lines(value))


def _refuse(word: str) -> None:
    raise UsageError(f"{word} is no value for a result file: finite numbers are needed")


@words.command("repinsbf", context_settings={"ignore_unknown_options": True})  # a value may begin with a minus sign
@click.argument("ident", metavar="ID")
@click.argument("value")
@words.option("at", "; required for variables that have one value a step.")
def repinsbf(environment: Environment, file: str, ident: str, value: str, at: int | None) -> None:
    """Replace the value of one variable of a result file; the size must be the stored one.

    VALUE is JSON: a number, a list such as [1,2,3], a list of rows such as [[1,2],[3,4]], or text in
    quotation marks; - reads it from standard input.
    """
    from spacar_formats.repinsbf import repinsbf

    try:
        new = json.loads(environment.stdin.read() if value == "-" else value, parse_constant=_refuse)
    except (ValueError, RecursionError):
        raise UsageError(f"VALUE is not JSON: {value}; write for example 2.5 or [1,2] or '\"text\"'") from None
    repinsbf(told_path(environment, file), ident, new, at)


def _export_command(kind: str) -> click.Command:
    @words.command(f"load{kind}", help=EXPORT_HELP.format(kind=kind))
    @click.argument("idents", metavar="[ID]...", nargs=-1)
    @words.option("formats", "; default npz. May be repeated.", multiple=True, type=click.Choice(["mat", "npz", "csv"]))
    @words.option("output", "; its ending says the kind")
    def command(
        environment: Environment, file: str, idents: tuple[str, ...], formats: tuple[str, ...], output: Path | None
    ) -> None:
        from spacar_formats.exports import export_file

        written, notes = export_file(file, kind, idents, formats, output)
        tell_notes(environment, notes)
        environment.wrote(*written)

    return command


loadsbd, loadsbm = map(_export_command, ("sbd", "sbm"))


@words.command("combsbd")
@click.argument("files", nargs=-1, required=True)
@click.argument("output")
@words.option("overwrite", "; the original SPACAR always does.")
def combsbd(environment: Environment, files: tuple[str, ...], output: str, overwrite: bool) -> None:
    """Put the steps of two or more .sbd files of one mechanism, in the given order, into OUTPUT."""
    from spacar_formats.combsbd import combsbd
    from spacar_formats.locate import notes, open_result

    remarks = []
    for name in files:
        with open_result(name, "sbd") as result:
            remarks += notes(result)
    target, steps = combsbd(files, output, overwrite)
    tell_notes(environment, remarks)
    environment.wrote(f"{target}: {steps} steps")


@words.command("getss")
@click.argument("step", type=StepNumber(), required=False, metavar="[STEP]")
@words.option("at", ": the same as the argument STEP; default the first.")
@words.option("output", ": a .mat, .npz or .json file, instead of printing.")
@words.option("as_json")
def getss(
    environment: Environment, file: str, step: int | None, at: int | None, output: Path | None, as_json: bool
) -> None:
    """Print or export the state space matrices A, B, C, D of one step (default the first) of an .ltv file."""
    from spacar_formats import getss
    from spacar_formats.getfrsbf import as_lines

    if step is not None and at is not None:
        raise UsageError("the step is given twice, as argument and by --at", "usage.step")
    step = step or at or 1
    told_path(environment, file, "ltv")
    system = getss.getss(file, step)
    if output is not None:
        getss.export_getss(system, output)
        environment.wrote(output)
    elif as_json:
        environment.say_json(getss.as_json(system))
    else:
        for name, matrix in system.arrays().items():
            environment.say(f"{name} ({matrix.shape[0]} x {matrix.shape[1]}):", *as_lines(matrix))
        if system.D is None:
            environment.say("D: none, no direct feedthrough")
