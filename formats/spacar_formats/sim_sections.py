"""Sections of the model file of a simulation, with the line of everything: `[NAME]`, `key = value`, and lines of wires.

'#', ';' and '%' begin a comment at the start of a line, '#' and '%' also behind a blank; an indented line continues the
value above it. Every complaint names file, line, section and key, what was found and what is expected.
"""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from spacar.errors import UsageError

COMMENT = re.compile(r"(^|\s)[#%].*$")


@dataclass(frozen=True)
class SimKey:
    """A key of a section: its kind (number, numbers, matrix, integer, flag, text, file), meaning, default and unit.

    default   None: needed; "": may be left out
    """

    name: str
    kind: str
    text: str
    default: str | None
    unit: str = ""


def _real(text: str) -> float:
    """A number; infinity is one (a limit that is none). Raises ValueError for what is none, NaN too."""
    value = float(text)
    if value != value:
        raise ValueError(text)
    return value


def _reals(text: str) -> list[float]:
    return [_real(v) for v in text.replace(",", " ").split()]


def _matrix(text: str) -> np.ndarray:
    return np.array([_reals(row) for row in text.split(";")])


class Section:
    """One section with typed access to its keys."""

    def __init__(self, file: Path, name: str, line: int) -> None:
        self.file, self.name, self.line = file, name, line
        self.values: dict[str, str] = {}
        self.lines: dict[str, int] = {}
        self.wires: list[tuple[int, str]] = []
        self.warnings: list[str] = []
        self._keys: dict[str, SimKey] = {}

    def error(self, text: str, key: str | None = None) -> UsageError:
        line = self.lines.get(key or "", self.line)
        return UsageError(f"{self.file.name}:{line}: [{self.name}]: {text}", "simulation.model-file")

    def expect(self, keys: Sequence[SimKey]) -> None:
        """Raises UsageError for a key that is not among these, and for one that is needed but missing."""
        self._keys = known = {key.name: key for key in keys}
        for name in self.values:
            if name != "block" and name not in known:
                raise self.error(f"unknown key '{name}'; the keys are {', '.join(known) or 'none'}", name)
        for name, key in known.items():
            if key.default is None and not self.given(name):
                raise self.error(f"'{name}' is missing: {key.text}")

    def given(self, key: str) -> bool:
        """Does the file say something for this key?"""
        return bool(self.values.get(key))

    def has(self, key: str) -> bool:
        """Is there a value, given or by default?"""
        return bool(self.text(key))

    def text(self, key: str) -> str:
        return self.values.get(key) or self._keys[key].default or ""

    def wrong(self, key: str, expected: str) -> UsageError:
        return self.error(f"{key} = {self.text(key)} {expected}", key)

    def _read(self, key: str, read: Callable[[str], Any], wrong: str) -> Any:
        try:
            return read(self.text(key))
        except ValueError:
            raise self.wrong(key, wrong) from None

    def number(self, key: str) -> float:
        return float(self._read(key, _real, "is no number"))

    def integer(self, key: str, least: int = 1) -> int:
        value = self.number(key)
        if not (np.isfinite(value) and value == int(value) and value >= least):
            kind = "positive whole number" if least == 1 else f"whole number from {least}"
            raise self.wrong(key, f"must be a {kind}")
        return int(value)

    def flag(self, key: str) -> bool:
        word = self.text(key).lower()
        if word not in ("yes", "no", "true", "false", "1", "0"):
            raise self.wrong(key, "must be yes or no")
        return word in ("yes", "true", "1")

    def matrix(self, key: str) -> np.ndarray:
        """Rows separated by ';', numbers by blanks or commas; one number gives a number."""
        found: np.ndarray = self._read(key, _matrix, "is no number and no matrix")
        return found.reshape(()) if found.size == 1 else found

    def numbers(self, key: str) -> list[float]:
        """Numbers separated by blanks, commas or ';'."""
        found: list[float] = self._read(key, lambda text: _reals(text.replace(";", " ")), "is no list of numbers")
        if not found:
            raise self.wrong(key, "is no list of numbers")
        return found

    def choice(self, key: str, known: Sequence[str]) -> str:
        word = self.text(key)
        if word not in known:
            raise self.wrong(key, f"must be one of {', '.join(known)}")
        return word

    def value(self, key: str) -> Any:
        read: dict[str, Callable[[str], Any]] = {
            "number": self.number, "numbers": self.numbers, "matrix": self.matrix, "integer": self.integer,
            "flag": self.flag, "text": self.text, "file": self.path,
        }  # fmt: skip
        return read[self._keys[key].kind](key)

    def path(self, key: str) -> Path:
        return self.file.parent / self.text(key)


def read_sections(file: Path, text: str) -> dict[str, Section]:
    """The sections by name. Raises UsageError with the line of what cannot be understood."""
    found: dict[str, Section] = {}
    section: Section | None = None
    last: str | None = None  # key whose value an indented line continues

    def bad(number: int, why: str) -> UsageError:
        text = f"{file.name}:{number}: {file.name} is no model of a simulation: {why}"
        return UsageError(text, "simulation.model-file")

    for number, raw in enumerate(text.splitlines(), 1):
        line = "" if raw.lstrip().startswith((";", "#", "%")) else COMMENT.sub("", raw)
        word = line.strip()
        if not word:
            continue
        if word.startswith("[") and word.endswith("]"):
            name, last = word[1:-1].strip(), None
            if name in found:
                raise bad(number, f"the section [{name}] stands in line {found[name].line} already")
            section = found[name] = Section(file, name, number)
        elif section is None:
            raise bad(number, f"'{word}' stands before the first section, such as [simulation]")
        elif section.name == "wires":
            section.wires.append((number, word))
        elif line[0].isspace():
            if last is None:
                raise bad(number, "an indented line follows a name without a value")
            section.values[last] += f" {word}"
        else:
            key, equals, value = (part.strip() for part in word.partition("="))
            if not equals:
                last = None
                section.values[key], section.lines[key] = "", number
                continue
            if key in section.values:
                why = f"{key} of [{section.name}] stands in line {section.lines[key]} already"
                raise bad(number, why)
            section.values[key], section.lines[key], last = value, number, key
    return found
