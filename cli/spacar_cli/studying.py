"""What `sweep` and `trade` have in common: options of the command line, a counter on terminals, tables."""

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TypeVar

import click

from spacar_cli import vocabulary as words
from spacar_cli.environment import Environment

Item = TypeVar("Item")

ROWS = click.Path(path_type=Path, dir_okay=False)
common = words.options((
    words.option("duration", ", instead of TIMESTEP"), words.option("n_steps", " of the output, instead of TIMESTEP"),
    words.option("jobs", "; default sweep all cores, trade one."), words.option("as_json", ": a summary"),
))  # fmt: skip


def counted(environment: Environment, items: Iterable[Item], total: int, what: str) -> Iterator[Item]:
    """Pass items through; on a terminal one line says how many have come."""
    shown = environment.shows_progress
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
    cells = ([cell.ljust(width) for cell, width in zip(row, widths, strict=True)] for row in (header, *rows))
    environment.say(*("  ".join(row).rstrip() for row in cells))
