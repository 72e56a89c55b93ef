"""The deck: an input file as typed statements, with its text, its visualization section and its messages."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from os import PathLike
from os.path import isfile
from pathlib import Path
from typing import Any

from spacar.deck.cross_section import BeamSection
from spacar.deck.deck_reader import NOT_UTF8, Span, read_text
from spacar.deck.deck_writer import Row, rows, splice, write_rows
from spacar.deck.lexer import scan, visualization_of
from spacar.deck.statement import Statement, StatementIndex, Value, grouped
from spacar.deck.table_elements import ELEMENT_TYPES
from spacar.deck.table_kinematics import UNITS
from spacar.deck.table_types import BlockKind, Purpose
from spacar.errors import Message, UsageError
from spacar.modes import registered
from spacar.summary import LINES, with_picture


class ModelCalls:
    """The public calls of spacar with a deck or a Model: `model.run(7)` is `spacar.run(7, model)`.

    >>> import spacar
    >>> cantilever = spacar.read_deck("data/plbeam5.dat")
    >>> print(f"{cantilever.run(7).frequencies[0, 0]:.4f} Hz")
    0.1251 Hz
    """

    def run(self, mode: int, **options: Any) -> Any:
        """`spacar.run(mode, self, ...)`: a `Result`."""
        return registered("run")(mode, self, **options)

    def flexure(self, **options: Any) -> Any:
        """`spacar.flexure(self, ...)`: a `Flexure`."""
        return registered("flexure")(self, **options)

    def sensitivity(self, parameters: Sequence[str], quantities: Sequence[str], **options: Any) -> Any:
        """`spacar.sensitivity(self, ...)`: a `Sensitivity`."""
        return registered("sensitivity")(self, parameters, quantities, **options)

    def sweep(self, change: Mapping[str, Any], results: str | Sequence[str], **options: Any) -> Any:
        """`spacar.sweep(self, ...)`: its rows."""
        return registered("sweep")(self, change, results, **options)

    def trade(self, target: float = 1e-4, **options: Any) -> Any:
        """`spacar.trade(self, ...)`: a `TradeAnswer`."""
        return registered("trade")(self, target, **options)


@dataclass(frozen=True, eq=False, repr=False)
class Deck(ModelCalls):
    """A read and checked input file.

    `statements` in file order; `source` names the file in messages; `path` is the file that was read (None for a deck
    built in code); `text` the whole text; `visualization` the raw lines of that section or of NAME.spv; `messages`
    warnings and information; `mode` the mode it was checked for; `third` the kind of its third block; `spans` where
    each block begins and ends in the text (line, column). `shorthand` are the statements UNITS, SECTION, MATERIAL and
    BEAMSEC as given: `statements` has what they stand for, in SI, and `sections` the constants. `divided` has the parts
    of every beam of the file that became several; `origin` is the deck of the file where this one was made of it.

    >>> import spacar
    >>> deck = spacar.read_deck("data/crank.dat").set("INPUTX", 2, 4, 300.0, block=2)
    >>> deck.first("INPUTX", block=2).values[3]
    300.0
    """

    statements: tuple[Statement, ...]
    source: str
    path: Path | None
    text: str
    data: bytes = field(repr=False)
    visualization: tuple[str, ...] = ()
    messages: tuple[Message, ...] = ()
    mode: Purpose = None
    third: BlockKind | None = None
    spans: dict[int, Span] = field(default_factory=dict, repr=False)
    shorthand: tuple[Statement, ...] = ()
    sections: tuple[BeamSection, ...] = ()
    drawn: int = 0  # lines of `visualization` that follow from the sections; they come first
    divided: Mapping[int, tuple[int, ...]] = field(default_factory=dict, repr=False)
    origin: Deck | None = field(default=None, repr=False)

    def __repr__(self) -> str:
        elements = Counter(s.keyword for s in self.statements if s.keyword in ELEMENT_TYPES)
        purpose = "all modes" if self.mode is None else f"mode {self.mode}"
        lines = [f"Deck {self.source}, checked for {purpose}", f"  elements    {_counted(elements)}"]
        for block, name in ((1, "kinematics"), (2, "dynamics"), (3, "third")):
            rest = Counter(s.keyword for s in self.statements if s.block == block and s.keyword not in ELEMENT_TYPES)
            if rest:
                lines.append(f"  {name:<11} {_counted(rest)}")
        return "\n".join([*lines, *(f"  {message}" for message in self.messages[: LINES - len(lines)])])

    def _repr_html_(self) -> str:
        """The summary with a picture of the start position, for notebooks; without it where it cannot be drawn."""
        return with_picture(repr(self), "inline_model", self)

    @cached_property
    def sha256(self) -> str:
        """Digest of the bytes of the file (or of the text) in hexadecimal."""
        from hashlib import sha256

        return sha256(self.data).hexdigest()

    @cached_property
    def index(self) -> StatementIndex:
        """Where the statements of each keyword are."""
        return StatementIndex(grouped((*self.statements, *self.shorthand)))

    @property
    def metre(self) -> float:
        """The unit of length of the file in metres (UNITS); everything in `statements` is in SI."""
        units = self.first("UNITS")
        return 1.0 if units is None else UNITS[str(units.values[0]).lower()]

    @property
    def written_visualization(self) -> tuple[str, ...]:
        """`visualization` without the lines that follow from the sections."""
        return self.visualization[self.drawn :]

    def block(self, number: int) -> Mapping[str, Sequence[Statement]]:
        """The statements of block `number` (1, 2 or 3) by keyword, in file order; only keywords that have any."""
        return self.index.block(number)

    def of(self, *keywords: str, block: int | None = None) -> list[Statement]:
        """All statements with one of the keywords (and in the block), in file order."""
        return self.index.of(*keywords, block=block)

    def first(self, keyword: str, block: int | None = None) -> Statement | None:
        """First statement with the keyword (and in the block), None when there is none."""
        return next(iter(self.of(keyword, block=block)), None)

    def last(self, keyword: str, block: int | None = None) -> Statement | None:
        """Last statement with the keyword (and in the block), None when there is none."""
        return next(iter(reversed(self.of(keyword, block=block))), None)

    def where(self, statement: Statement, value_index: int | None = None) -> str:
        """Place and subject of a statement or of one of its values (value_index from 0): `crank.dat:12: DYNE 7`."""
        return f"{self.source}:{statement.line_of(value_index)}: {statement.subject}"

    def message(
        self, severity: str, statement: Statement, text: str, value_index: int | None = None, code: str = "input"
    ) -> Message:
        """A message about a statement or one of its values (value_index from 0), for checks beyond the deck.

        `severity` is "error", "warning" or "information"; `text` says what is wrong, `code` is its stable short name.
        """
        return Message(severity, self.source, statement.line_of(value_index), statement.subject, text, code)

    def to_text(self) -> str:
        """Canonical text, one statement a line, that reads back to the same statements."""
        return write_rows(rows(self.statements), self.visualization)

    def set(
        self, keyword: str, number: int | str | None, position: int, value: Value, block: int | None = None
    ) -> Deck:
        """A new deck with one `value` of a `keyword` changed, checked again.

        `number` is the first value of the statement, a name for SECTION (None: the keyword occurs once); `position`
        counts the arguments from 1 as in the reference (1 is the number itself); `block` is needed when the keyword
        occurs in two blocks with the same number. Raises UsageError when there is not exactly one such statement,
        InputError when the new value is refused.
        """
        found = [s for s in self.of(keyword.upper(), block=block) if number is None or s.values[:1] == (number,)]
        what = keyword.upper() if number is None else f"{keyword.upper()} {number}"
        if len(found) != 1:
            how = "no" if not found else f"{len(found)}"
            raise UsageError(f"{self.source}: {how} statement{'s' * (len(found) > 1)} {what} to change", "usage.set")
        return self.with_value(found[0], position, value)

    def with_value(self, statement: Statement, position: int, value: Value) -> Deck:
        """A new deck in which argument `position` (from 1) of the statement has another `value`; see `set`."""
        self.require_written(statement)
        text = splice(self.text, statement, position, value)
        return parse(text, self.source, self.mode, path=self.path, visualization=self.written_visualization)

    def require_written(self, statement: Statement) -> None:
        """Raises UsageError for a statement that does not stand in the text, as it follows from BEAMSEC."""
        if statement.values and not statement.columns:
            text = f"{self.where(statement)} follows from the statement at this line (BEAMSEC, or a beam that it"
            raise UsageError(f"{text} divides); change that one, its SECTION or its MATERIAL", "usage.set")

    def for_mode(self, mode: Purpose) -> Deck:
        """The same text read for another `mode`."""
        drawn = self.written_visualization
        return parse(self.text, self.source, mode, path=self.path, data=self.data, visualization=drawn)

    @classmethod
    def build(
        cls,
        kinematics: Iterable[Sequence[Value]],
        dynamics: Iterable[Sequence[Value]] = (),
        third: Iterable[Sequence[Value]] = (),
        *,
        mode: Purpose = None,
        source: str = "<deck>",
        path: Path | None = None,
    ) -> Deck:
        """A deck from rows such as `("PLBEAM", 1, 1, 2, 3, 4)`, checked like a file; raises InputError.

        kinematics, dynamics, third   statements of the three blocks;  mode   as `read_deck`
        source   its name in messages;  path   where it would stand: functions of the user are looked for beside it
        """
        return parse(write_rows([kinematics, dynamics, third]), source, mode, path=path)


def statements(deck: Deck) -> tuple[Statement, ...]:
    """Those of a deck that was read: it has its index from the start, and most runs ask for columns only."""
    return deck.index.statements()


# In the place of the field, which stands in the dictionary of a deck where it was given (`replace`, `parse`)
_lazily = cached_property(statements)
_lazily.__set_name__(Deck, "statements")
Deck.statements = _lazily  # type: ignore[assignment]


def _counted(found: Counter[str]) -> str:
    words = [f"{n} {name}" if n > 1 else name for name, n in found.most_common()]
    return ", ".join(words[:12]) + (", ..." if len(words) > 12 else "") or "none"


def read_deck(path: str | Path, mode: Purpose = None) -> Deck:
    """Read and check the input file `path`; `.dat` is appended when there is no such file.

    `mode` is the mode that it shall be run in: what this mode does not use is checked less strictly; None: for all.
    Raises UsageError with the reason of the operating system, InputError with all errors of the file.

    >>> import spacar
    >>> spacar.read_deck("data/crank.dat").first("XM").values
    (6, 0.033375)
    """
    if not isinstance(path, str | PathLike):
        raise UsageError(f"the path of an input file is a text or a Path, not {path!r:.60}", "usage.model")
    file = Path(path)
    if not file.name:
        raise UsageError(f"'{path}' is not the name of an input file", "files.not-readable")
    if file.suffix.lower() != ".dat" and not isfile(file):  # `Path.is_file` raises where it may not look
        file = file.with_name(file.name + ".dat")
    data, beside = _bytes(file), file.with_suffix(".spv")
    text = data.decode("utf-8", "surrogateescape")
    visualization = visualization_of(_bytes(beside).decode("utf-8", "replace")) if isfile(beside) else None
    return parse(text, file.name, mode, path=file, data=data, visualization=visualization)


def parse_deck(text: str, source: str = "<deck>", mode: Purpose = None) -> Deck:
    """Check an input text; `source` names it in messages, `mode` as `read_deck`. Raises InputError with all errors.

    >>> import spacar
    >>> deck = spacar.parse_deck("PLTRUSS 1 1 2 X 2 1. 0. FIX 1 FIX 2 2 END END")
    >>> len(deck.statements)
    4
    """
    if not isinstance(text, str):
        raise UsageError(f"parse_deck takes the text of a deck, not {text!r:.60}", "usage.model")
    return parse(text, source, mode)


def parse(
    text: str,
    source: str,
    mode: Purpose = None,
    *,
    path: Path | None = None,
    data: bytes | None = None,
    visualization: tuple[str, ...] | None = None,
) -> Deck:
    """The common path of all readers; `visualization` is used when the text has no such section."""
    contents = read_text(text, source, mode)
    lines = visualization or () if contents.visualization is None else contents.visualization
    expansion = contents.expansion
    drawn = expansion.visualization
    drawn = () if lines[: len(drawn)] == drawn else drawn  # a deck that is read again brings them along
    deck = Deck(
        statements=expansion.statements,
        source=source,
        path=path,
        text=text if text.isascii() else NOT_UTF8.sub("\ufffd", text),
        data=text.encode("utf-8", "surrogateescape") if data is None else data,
        visualization=tuple([NOT_UTF8.sub("\ufffd", line) for line in (*drawn, *lines)]),
        messages=contents.messages,
        mode=mode,
        third=contents.third,
        spans=contents.spans,
        shorthand=contents.shorthand,
        sections=expansion.sections,
        drawn=len(drawn),
        divided={s.element: s.parts for s in expansion.sections if len(s.parts) > 1},
    )
    if not contents.shorthand:
        own = vars(deck)
        own["index"] = contents.found  # the checks have made it
        del own["statements"]  # made from the index when somebody asks
    return deck


KEPT = ("data", "visualization", "drawn", "shorthand", "sections", "divided")


def rebuilt(deck: Deck, *blocks: Iterable[Row], what: str = "") -> Deck:
    """The deck with other statements, rows (keyword, values ...) of each block, read and checked as a text: the common
    end of all programs that rewrite a deck. `what` follows its name.

    Unit of length, sections, pictures and the digest of the file stay. Raises InputError.
    """
    made = parse(write_rows(blocks), f"{deck.source}{what}", deck.mode, path=deck.path)
    same: dict[str, Any] = {k: getattr(deck, k) for k in KEPT}
    return replace(made, origin=deck.origin or deck, **same)


def _bytes(file: Path) -> bytes:
    try:
        return file.read_bytes()
    except (OSError, ValueError) as problem:
        reason = getattr(problem, "strerror", None) or str(problem)
        raise UsageError(f"cannot read {file}: {reason}", "files.not-readable") from None


_BLANKS = " \t\r\f\v"


def echo(deck: Deck, block: int) -> list[str]:
    """Lines of block 1, 2 or 3 with its closing END HALT or END END; empty when there is no such block."""
    if block not in deck.spans:
        return []
    start, end = deck.spans[block]
    lines = scan(deck.text).lines[: end[0]]
    if len(lines) == end[0]:
        lines[-1] = lines[-1][: end[1] - 1]
    lines = lines[start[0] - 1 :]
    if lines:
        lines[0] = lines[0][start[1] - 1 :]
    return [bare.upper() for line in lines if (bare := line.strip(_BLANKS))]
