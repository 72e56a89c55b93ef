"""`spacar repinsbf FILE ID VALUE [--at K]`."""

import json

import click

from spacar.errors import UsageError
from spacar_cli import vocabulary as words
from spacar_cli.environment import Environment, tell_notes


def _refuse(word: str) -> None:
    raise UsageError(f"{word} is no value for a result file: finite numbers are needed")


@words.command("repinsbf", context_settings={"ignore_unknown_options": True})  # a value may begin with a minus sign
@click.argument("ident", metavar="ID")
@click.argument("value")
@words.option("at", "; required for variables that have one value a step.")
def command(environment: Environment, /, file: str, ident: str, value: str, at: int | None) -> None:
    """Replace the value of one variable of a result file; the size must be the stored one.

    VALUE is JSON: a number, a list such as [1,2,3], a list of rows such as [[1,2],[3,4]], or text in
    quotation marks; - reads it from standard input.
    """
    from spacar_formats.locate import notes, open_result
    from spacar_formats.repinsbf import repinsbf

    try:
        new = json.loads(environment.stdin.read() if value == "-" else value, parse_constant=_refuse)
    except (ValueError, RecursionError):
        raise UsageError(f"VALUE is not JSON: {value}; write for example 2.5 or [1,2] or '\"text\"'") from None
    with open_result(file) as result:
        path = result.path
        tell_notes(environment, notes(result))
    repinsbf(path, ident, new, at)
