"""`spacar help 7`, `spacar help plot`: the same as `spacar 7 --help`."""

from __future__ import annotations

import click

from spacar_cli import vocabulary as words
from spacar_cli.environment import Environment


@words.command("help")
@click.argument("word", required=False, metavar="[MODE|COMMAND]")
@click.pass_context
def command(context: click.Context, word: str | None) -> None:
    """Print the help of a mode or a command; without a word that of the program."""
    program = context.find_root()
    environment: Environment = context.obj
    if word is None:
        environment.say(program.get_help())
        return
    group = program.command
    assert isinstance(group, click.Group)
    name, found, _ = group.resolve_command(program, [word])
    assert found is not None
    environment.say(found.get_help(click.Context(found, program, name)))
