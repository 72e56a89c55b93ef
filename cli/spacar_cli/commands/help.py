"""`spacar help 7`, `spacar help plot`: the same as `spacar 7 --help`; `spacar help studies`: a page."""

from pathlib import Path

import click

from spacar_cli import vocabulary as words
from spacar_cli.command_table import TOPICS
from spacar_cli.environment import Environment

HERE = Path(__file__).resolve().parent.parent
PLACES = (HERE / "pages", HERE.parent.parent / "docs")  # in an installed wheel, in a checkout


@words.command("help", epilog=f"Topics: {', '.join(TOPICS)}.")
@click.argument("word", required=False, metavar="[MODE|COMMAND|TOPIC]")
@click.pass_context
def command(context: click.Context, word: str | None) -> None:
    """Print the help of a mode or a command, or the page of a topic; without a word the help of the program."""
    program = context.find_root()
    environment: Environment = context.obj
    if word is None:
        environment.say(program.get_help())
        return
    if word in TOPICS:
        environment.say(next(p / TOPICS[word] for p in PLACES if p.is_dir()).read_text("utf-8").rstrip())
        return
    group = program.command
    assert isinstance(group, click.Group)
    name, found, _ = group.resolve_command(program, [word])
    assert found is not None
    environment.say(found.get_help(click.Context(found, program, name)))
