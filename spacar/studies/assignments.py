"""What a study changes in a deck, and to which values.

    KEYWORD.NUMBER...[WHICH] = VALUES        ESTIFF.3[EI] = 100,200,300        INPUTX.2.1[start rate] = 50:150:11
    KEYWORD.NAME[WHICH] = VALUES             SECTION.leaf[t] = 4e-4:8e-4:5     MATERIAL.spring[Young] = 2.1e11

The numbers are the first arguments of the statement, as many as tell it apart (none: TIMESTEP[2]); `*` in the place
of the first number means every statement of that keyword. WHICH is the position of the argument, from 1 as in the
reference, or the beginning of its meaning there (EA, EI, mass, start rate); left out: the first real number. Several
targets that get the same value are joined by `&`: ESTIFF.2[EI] & ESTIFF.3[EI]. VALUES are a list a,b,c;
start:stop:count, evenly spaced with both ends; start:stop:count:log, in equal ratios; or @FILE.csv:COLUMN.
"""

import csv
import math
import re
import sys
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import chain
from operator import eq
from pathlib import Path
from typing import NamedTuple, overload

import numpy as np

from spacar.deck import ELEMENT_TYPES, Deck, Statement
from spacar.deck.cross_section import SHAPES
from spacar.deck.deck import parse
from spacar.deck.deck_writer import splice
from spacar.deck.keyword_table import KEYWORDS, BlockKind
from spacar.deck.rewrite.substitution import with_numbers
from spacar.deck.statement import Value
from spacar.deck.table_types import Parameter
from spacar.errors import UsageError

TARGET = re.compile(r"([A-Za-z]\w*)((?:[.\s]+(?:\d+|\*|[A-Za-z][\w-]*))*)\s*(?:\[\s*([^\[\]]+?)\s*\])?")
Values = tuple[float, ...]
MOST_VALUES = 1_000_000
BY_NUMBER = {block.number: block for block in BlockKind if block.number < 3}


class Target(NamedTuple):
    """One place, or with `everywhere` all places of a keyword, whose value changes."""

    keyword: str
    numbers: tuple[int | str, ...]  # names in small letters
    everywhere: bool
    which: str  # position, meaning, or empty

    def places(self, deck: Deck) -> list[tuple[Statement, int]]:
        """(statement, argument number from 1) of every value it means. Raises UsageError for none and for a choice."""
        statements = deck.of(self.keyword)
        if not self.everywhere:
            statements = [s for s in statements if _small(s.values[: len(self.numbers)]) == self.numbers]
        found = [(s, p) for s in statements if (p := _position(deck, s, self)) is not None]
        real = [(s, p) for s, p in found if parameters_of(deck, s)[p - 1].kind == "real"]
        found = real or found  # a declaration (INPUTX in the first block) has integers only
        name = " ".join([self.keyword, *map(str, self.numbers)])
        if not found:
            if not statements:
                raise UsageError(f"{deck.source}: there is no statement {name} to change", "study.set")
            meanings = [p.meaning for p in parameters_of(deck, statements[-1])]
            listed = ", ".join(f"{i} {m}" for i, m in enumerate(meanings, 1))
            raise UsageError(f"{name} has no argument '{self.which}'; its arguments are {listed}", "study.set")
        if len(found) > 1 and not self.everywhere:
            raise UsageError(
                f"{deck.source}: {len(found)} statements {name}; give more numbers, or * for all", "study.set"
            )
        return found


class Setting(NamedTuple):
    """Targets that change together; `name` is the left side as it was written and heads the column."""

    name: str
    targets: tuple[Target, ...]


class Axis(NamedTuple):
    """A setting with its values."""

    setting: Setting
    values: Values


def change(deck: Deck, settings: Sequence[Setting], numbers: Sequence[float]) -> Deck:
    """The deck with a number at all places of each setting, checked. Integers may change the statements that the deck
    needs; with these the whole text is read again. Raises UsageError, InputError."""
    edits: dict[tuple[int, int], tuple[Statement, int, float | int]] = {}
    later = []
    for given, number, found in zip(settings, numbers, _places(deck, tuple(settings)), strict=True):
        for target, statement, position, kind in found:
            value = _typed(number, kind, given.name)
            if position > len(statement.values):
                later.append((target, position, value))
                continue
            deck.require_written(statement)
            place = (statement.lines[position - 1], statement.columns[position - 1])
            if place in edits:
                raise UsageError(f"{statement.subject}: argument {position} is set twice", "study.set")
            edits[place] = (statement, position, value)
    if edits and not later and all(isinstance(value, float) for _, _, value in edits.values()):
        substituted = with_numbers(deck, tuple(edits.values()))
        if substituted is not None:
            return substituted
    text = deck.text
    for place in sorted(edits, reverse=True):  # from the end, so that earlier columns stay
        text = splice(text, *edits[place])
    if edits:
        deck = parse(text, deck.source, deck.mode, path=deck.path, visualization=deck.written_visualization)
    for target, position, value in later:  # arguments that were left out
        for k in range(len(target.places(deck))):
            deck = deck.with_value(target.places(deck)[k][0], position, value)
    return deck


def changed_statements(deck: Deck, settings: tuple[Setting, ...]) -> set[str]:
    """Keywords of the statements that settings change; of those that get an integer or a further argument, empty ones.
    Raises UsageError."""
    return {
        s.keyword if kind == "real" and position <= len(s.values) else ""
        for found in _places(deck, settings)
        for _, s, position, kind in found
    }


def changed_arguments(deck: Deck, given: Setting) -> list[tuple[str, int, int]]:
    """Keyword and first number of every statement that a setting changes, and which argument, from 1. Raises
    UsageError."""
    return [(s.keyword, s.integer(0), position) for _, s, position, _ in _places(deck, (given,))[0]]


@lru_cache(maxsize=16)
def _places(deck: Deck, settings: tuple[Setting, ...]) -> list[list[tuple[Target, Statement, int, str]]]:
    """Of every setting the targets, the statements and argument numbers that they mean, and what these are."""
    return [
        [(t, s, k, parameters_of(deck, s)[k - 1].kind) for t in given.targets for s, k in t.places(deck)]
        for given in settings
    ]


def setting(text: str) -> Setting:
    """The left side of an assignment. Raises UsageError."""
    targets = []
    for part in text.split("&"):
        match = TARGET.fullmatch(part.strip())
        if match is None:
            form = "KEYWORD.NUMBER[WHICH], for instance ESTIFF.3[EI] or INPUTX.2.1[start rate]"
            raise UsageError(f"cannot read '{part.strip()}': expected {form}", "study.set")
        keyword = match[1].upper()
        if all((keyword, block) not in KEYWORDS for block in BlockKind):
            raise UsageError(f"'{match[1]}' is not a keyword of the input language; see `spacar keywords`", "study.set")
        words = match[2].replace(".", " ").split()
        if "*" in words and words != ["*"]:
            raise UsageError(f"'{part.strip()}': * stands alone, for every statement {keyword}", "study.set")
        numbers = tuple(int(w) if w.isdigit() else w.casefold() for w in words if w != "*")
        targets.append(Target(keyword, numbers, words == ["*"], match[3] or ""))
    return Setting(text.strip(), tuple(targets))


def axis(text: str) -> Axis:
    """The axis of `TARGET = VALUES`. Raises UsageError."""
    left, equals, right = text.partition("=")
    if not equals or not right.strip():
        raise UsageError(f"'{text}' has no values; write TARGET=VALUES, for instance ESTIFF.3[EI]=100,200", "study.set")
    return Axis(setting(left), values(right.strip()))


def values(text: str) -> Values:
    """Numbers of a list, a range or a column of a csv file. Raises UsageError."""
    if text.startswith("@"):
        name, colon, column = text[1:].rpartition(":")
        if not colon:
            raise UsageError(f"'{text}' names no column; write @FILE.csv:COLUMN", "study.set")
        header, rows = table(Path(name))
        if column not in header:
            raise UsageError(f"{name} has no column '{column}'; it has {', '.join(header)}", "study.set")
        return tuple(row[header.index(column)] for row in rows)
    if ":" not in text:
        return tuple(_number(word, text) for word in text.split(","))
    words = text.split(":")
    if len(words) not in (3, 4) or (len(words) == 4 and words[3].strip() != "log"):
        raise UsageError(f"'{text}' is no range; write start:stop:count or start:stop:count:log", "study.set")
    start, stop, count = (_number(word, text) for word in words[:3])
    if count != int(count) or not 1 <= count <= MOST_VALUES:
        raise UsageError(f"'{text}': the count is a whole number from 1 to {MOST_VALUES}, not {words[2]}", "study.set")
    if len(words) == 3:
        return tuple(np.linspace(start, stop, int(count)).tolist())
    if start * stop <= 0.0:
        raise UsageError(f"'{text}': both ends of a logarithmic range have the same sign and are not zero", "study.set")
    return tuple(np.geomspace(start, stop, int(count)).tolist())


def table(path: Path) -> tuple[list[str], list[Values]]:
    """Header and rows of a csv file of numbers. Raises UsageError, OSError."""
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            rows = [row for row in csv.reader(file, skipinitialspace=True) if row and not row[0].startswith("#")]
    except (UnicodeDecodeError, csv.Error) as error:
        raise UsageError(f"{path} is no table in csv (UTF-8): {error}", "study.set") from None
    if len(rows) < 2:
        raise UsageError(f"{path} has no rows under its header", "study.set")
    header = [name.strip() for name in rows[0]]
    found = []
    for i, row in enumerate(rows[1:], 1):
        if len(row) != len(header):
            raise UsageError(f"{path}: row {i} has {len(row)} values, the header {len(header)}", "study.set")
        found.append(tuple(_number(word, f"{path}, row {i}") for word in row))
    return header, found


class Combinations(Sequence[Values]):
    """Every row of a first table joined with every row of a second, and so on; the last table runs fastest.

    Only the tables are stored, never their product. Raises UsageError for more cases than a computer can count.
    """

    def __init__(self, *tables: Sequence[Values]) -> None:
        self.tables = tables
        self.cases = math.prod(map(len, tables))
        if self.cases > sys.maxsize:
            raise UsageError(f"the values make {self.cases:.3e} combinations: more than can ever be run", "study.set")

    def __len__(self) -> int:
        return self.cases

    @overload
    def __getitem__(self, k: int) -> Values: ...
    @overload
    def __getitem__(self, k: slice) -> list[Values]: ...
    def __getitem__(self, k: int | slice) -> Values | list[Values]:
        if isinstance(k, slice):
            return [self[i] for i in range(*k.indices(len(self)))]
        rest, rows = range(len(self))[k], []
        for table in reversed(self.tables):
            rest, own = divmod(rest, len(table))
            rows.append(table[own])
        return tuple(chain.from_iterable(reversed(rows)))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Sequence) and len(self) == len(other) and all(map(eq, self, other))


def combine(axes: Sequence[Axis], together: bool = False) -> tuple[tuple[Setting, ...], Sequence[Values]]:
    """The settings and the values of every case: all combinations (the last axis fastest), or element by element."""
    settings = tuple(a.setting for a in axes)
    names = [s.name for s in settings]
    doubled = sorted({n for n in names if names.count(n) > 1})
    if doubled:
        raise UsageError(f"{', '.join(doubled)} is set twice", "study.set")
    if not together:
        return settings, Combinations(*([(v,) for v in a.values] for a in axes))
    sizes = {len(a.values) for a in axes}
    if len(sizes) > 1:
        listed = ", ".join(f"{a.setting.name} has {len(a.values)}" for a in axes)
        raise UsageError(f"values taken together must be equally many: {listed}", "study.set")
    return settings, list(zip(*(a.values for a in axes), strict=True))


def _number(word: str, text: str) -> float:
    try:
        value = float(word)
    except ValueError:
        value = float("nan")
    if not np.isfinite(value):
        raise UsageError(f"'{word.strip()}' in '{text}' is not a number", "study.set")
    return value


def _typed(value: float, kind: str, name: str) -> float | int:
    if kind == "real":
        return value
    if kind == "integer" and value == int(value):
        return int(value)
    raise UsageError(f"{name} takes {'whole numbers' if kind == 'integer' else 'a name'}, not {value:.9g}", "study.set")


def parameters_of(deck: Deck, s: Statement) -> tuple[Parameter, ...]:
    """What the arguments of a statement mean: the longest form that its node, element and model allow."""
    block = BY_NUMBER.get(s.block, deck.third)
    assert block is not None
    keyword = KEYWORDS[s.keyword, block]
    space, role, kind = "", "", ""
    elements = deck.of(*ELEMENT_TYPES, block=1)
    if elements:
        space = "planar" if ELEMENT_TYPES[elements[0].keyword].planar else "spatial"
    if keyword.subject is not None and s.keyword not in ELEMENT_TYPES and keyword.subject < len(s.values):
        number = s.values[keyword.subject]
        for element in elements:
            shape = ELEMENT_TYPES[element.keyword]
            if keyword.variants[0].parameters[keyword.subject].of == "element":
                kind = element.keyword if element.values[0] == number else kind
            else:
                nodes = zip(element.values[1:], shape.nodes, strict=False)
                role = next((r for n, r in nodes if n == number), role)
    fits = [v for v in keyword.variants if v.fits(space, role, kind)] or list(keyword.variants)
    given = [v for v in fits if len(s.values) in v.counts]
    parameters = max(given or fits, key=lambda v: len(v.parameters)).parameters
    if s.keyword != "SECTION":
        return parameters
    names = SHAPES[str(s.values[1]).upper()].dims  # that the dimensions have in its shape
    dims = [
        replace(p, meaning=name, unit="" if power == 0 else "m" if power == 1 else f"m^{power}")
        for p, (name, power) in zip(parameters[2:], names, strict=False)
    ]
    return (*parameters[:2], *dims)


def _small(values: tuple[Value, ...]) -> tuple[Value, ...]:
    return tuple(v.casefold() if isinstance(v, str) else v for v in values)


def _position(deck: Deck, s: Statement, target: Target) -> int | None:
    parameters = parameters_of(deck, s)
    if target.which.isdigit():
        return int(target.which) if 1 <= int(target.which) <= len(parameters) else None
    if not target.which:
        kinds = [p.kind for p in parameters]
        return kinds.index("real") + 1 if "real" in kinds else None
    wanted = target.which.lower()
    exact = [i for i, p in enumerate(parameters, 1) if p.meaning.lower() == wanted]
    begins = exact or [i for i, p in enumerate(parameters, 1) if p.meaning.lower().startswith(wanted)]
    if len(begins) > 1:
        names = ", ".join(parameters[i - 1].meaning for i in begins)
        raise UsageError(f"{s.subject}: '{target.which}' could be {names}", "study.set")
    return begins[0] if begins else None
