"""From the name that the user gives to the input file and to the place of the results."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from spacar.errors import UsageError
from spacar_cli.environment import Environment

if TYPE_CHECKING:
    from spacar.deck import Deck

STANDARD_INPUT, PIPED = "-", Path("stdin.dat")  # the name of the file, and where it would stand


def piped_text(environment: Environment) -> str:
    """The text on standard input. Raises UsageError when it is none."""
    try:
        return environment.stdin.read()
    except UnicodeDecodeError as error:
        text = f"standard input is no text: {error.reason} at byte {error.start}"
        raise UsageError(text, "files.not-readable") from None


def parse_piped(text: str, mode: int | None) -> Deck:
    """The text as the input file PIPED: its results are stdin.* in the current folder, or in that of --output-dir.

    Raises InputError as `parse` does.
    """
    from spacar.deck.deck import parse

    return parse(text, PIPED.stem, mode, path=PIPED)


def input_file(name: Path) -> Path:
    """`crank` stands for `crank.dat`; a name that exists as it is and has no `.dat` beside it is taken as it is.

    Raises UsageError when there is no such file.
    """
    named = name.suffix.lower() == ".dat" or not name.name
    with_suffix = name if named else name.with_name(f"{name.name}.dat")
    for candidate in (with_suffix, name):
        if candidate.is_file():
            return candidate
    reason = "it is a folder" if with_suffix.is_dir() else "no such file"
    if name.exists() and not name.is_dir():  # /dev/stdin, /dev/fd/63
        with_suffix, reason = name, "it is no file but a pipe or a device; - reads standard input"
    raise UsageError(f"{with_suffix}: {reason}", "files.not-readable")


def result_stem(source: Path, folder: Path | None) -> Path:
    """Where results go, without extension; the folder is made when it does not exist. Raises UsageError."""
    name = source.name[:-4] if source.suffix.lower() == ".dat" else source.name
    if folder is None:
        return source.with_name(name)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UsageError(f"cannot use the folder {folder}: {error.strerror}", "files.open") from None
    return folder / name
