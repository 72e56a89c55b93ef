"""`spacar keywords [NAME]`: the reference of the input language, printed from the keyword table."""

import json

import click

from spacar.errors import UsageError
from spacar_cli import vocabulary as words
from spacar_cli.environment import Environment
from spacar_cli.keyword_help import explanation, keywords_json, overview, textmate_grammar


@words.command("keywords")
@click.argument("name", required=False)
@words.option("formats", ": all of them in JSON, or a grammar for editors", type=click.Choice(["json", "textmate"]))
def command(environment: Environment, name: str | None, formats: str | None) -> None:
    """List all keywords by block, or explain NAME: its arguments, units, defaults and forms.

    The blocks of a simulation (.sim files) are listed and explained too.
    """
    if formats is not None:
        if name is not None:
            raise UsageError("--to writes the whole table: without NAME", "usage")
        environment.say(json.dumps(keywords_json() if formats == "json" else textmate_grammar(), indent=1))
        return
    environment.say(*(overview() if name is None else explanation(name)))
