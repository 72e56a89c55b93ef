"""The page spacar(1) of `man`, made from the help of all modes and commands.

`python -m spacar_cli.man_page > docs/man/spacar.1`. Wheels put it into share/man/man1. Format: man(7).
"""

import re
from collections.abc import Iterator

import click

import spacar
from spacar.modes import MODES
from spacar_cli.command_table import COMMANDS
from spacar_cli.main import CommandGroup, program


def escaped_text(text: str) -> str:
    """Text without requests and escapes of roff."""
    plain = text.replace("\\", "\\e").replace("-", "\\-")
    return "\n".join(f"\\&{line}" if line.startswith((".", "'")) else line for line in plain.splitlines())


def paragraphs(text: str) -> Iterator[str]:
    """The paragraphs of a help text, lines joined but for those of a literal block."""
    for part in re.split(r"\n\s*\n", text.strip()):
        if part.startswith("\b"):
            yield ".nf\n" + escaped_text(part.removeprefix("\b").lstrip("\n")) + "\n.fi"
        else:
            yield escaped_text(" ".join(part.split()))


def command_section(name: str, command: click.Command, context: click.Context) -> list[str]:
    inner = click.Context(command, context, name)
    usage = " ".join([f"spacar {name}", *command.collect_usage_pieces(inner)])
    lines = [f'.SS "spacar {name}"', f".B {escaped_text(usage)}"]
    for part in paragraphs(command.help or ""):
        lines += [".PP", part]
    for parameter in command.get_params(inner):
        record = parameter.get_help_record(inner) if isinstance(parameter, click.Option) else None
        if record is not None and "--help" not in parameter.opts:
            lines += [".TP", f".B {escaped_text(record[0])}", escaped_text(" ".join(record[1].split()))]
    if isinstance(command, click.Group):
        for word in command.list_commands(inner):
            below = command.get_command(inner, word)
            assert below is not None
            lines += command_section(f"{name} {word}", below, context)
    return lines


def page() -> str:
    assert isinstance(program, CommandGroup)
    context = click.Context(program, info_name="spacar")
    lines = [
        '.\\" Made by python -m spacar_cli.man_page; do not edit.',
        f'.TH SPACAR 1 "" "spacar {spacar.__version__}" "User Commands"',
        ".SH NAME", "spacar \\- analysis of planar and spatial mechanisms with rigid and flexible links",
        ".SH SYNOPSIS", ".B spacar", "MODE FILE [OPTIONS]", ".br", ".B spacar", "COMMAND ...", ".SH DESCRIPTION",
    ]  # fmt: skip
    for k, part in enumerate(paragraphs(program.help or "")):
        lines += [*([".PP"] if k else []), part]
    lines += [".PP", *paragraphs((program.epilog or "").replace("`", ""))]
    for title, names in (("MODES", map(str, MODES)), ("COMMANDS", COMMANDS)):
        lines.append(f".SH {title}")
        for name in names:
            found = program.get_command(context, name)
            assert found is not None
            lines += command_section(name, found, context)
    lines += [
        ".SH EXIT STATUS",
        "0 done, 1 the analysis failed, 2 wrong usage or input, 130 interrupted.",
        ".SH FILES",
        "NAME.dat is the input file, NAME.log is for reading, NAME.sbd, NAME.sbm and NAME.ltv hold all numbers.",
    ]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    print(page(), end="")
