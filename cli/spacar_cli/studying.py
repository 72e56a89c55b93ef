"""What `sweep` and `trade` have in common: options of the command line, a counter on terminals, tables."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, TypeVar

import click

from spacar_cli.environment import Environment
from spacar_cli.number_types import POSITIVE, Whole

Command = TypeVar("Command", bound=Callable[..., Any])
Item = TypeVar("Item")

OPTIONS = (
    click.option("--time", "duration", type=POSITIVE, help="Length of the time interval, instead of TIMESTEP [s]."),
    click.option("--steps", "n_steps", type=Whole(min=1), help="Number of output steps, instead of TIMESTEP."),
    click.option("--jobs", "-j", type=Whole(min=1), help="Local processes; default: sweep all cores, trade one."),
    click.option("--quiet", "-q", is_flag=True, help="Print errors only."),
    click.option("--json", "as_json", is_flag=True, help="Print a summary in JSON."),
)


def common(command: Command) -> Command:
    """The options of every study."""
    for option in reversed(OPTIONS):
        command = option(command)
    return command


def counted(environment: Environment, items: Iterable[Item], total: int, quiet: bool, what: str) -> Iterator[Item]:
    """Pass items through; on a terminal one line says how many have come."""
    shown = environment.error_is_terminal and not quiet
    for number, item in enumerate(items, 1):
        if shown:
            print(f"\r{number}/{total} {what} ", end="", file=environment.stderr, flush=True)
        yield item
    if shown:
        print("\r\x1b[K", end="", file=environment.stderr, flush=True)


def say_table(
    environment: Environment, header: Sequence[str], rows: Sequence[Sequence[str]], marked: int | None = None
) -> None:
    """A table: aligned columns, on terminals in lines and with the marked row in bold."""
    if environment.output_is_terminal:
        from rich.console import Console
        from rich.table import Table

        table = Table(*header)
        for number, row in enumerate(rows):
            table.add_row(*row, style="bold" if number == marked else None)
        Console(file=environment.stdout, no_color=bool(environment.variables.get("NO_COLOR"))).print(table)
        return
    widths = [max(map(len, column)) for column in zip(header, *rows, strict=True)]
    for row in (header, *rows):
        environment.say("  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip())
