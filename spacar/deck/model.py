"""A model written in Python that reads like its deck: `Model`.

>>> from spacar.deck.model import Model
>>> m = Model()
>>> _ = m.node(1, (0.0, 0.0)), m.node(3, (1.0, 0.0))
>>> beam = m.plbeam(1, (1, 2), (3, 4))
>>> m.fix(1)
>>> m.fix(2)
>>> m.dyne(beam, 2, 3)
>>> m.estiff(beam, EA=1e6, EI=10.0)
>>> m.em(beam, mass=0.5)
>>> print(str(m).splitlines()[2])
PLBEAM 1 1 2 3 4
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from spacar.deck import model_methods
from spacar.deck.arguments import read_statement
from spacar.deck.deck import Deck, ModelCalls, parse
from spacar.deck.deck_writer import value_text, write_rows
from spacar.deck.findings import Findings
from spacar.deck.keyword_methods import ModelStatements, Vector
from spacar.deck.keyword_table import ELEMENT_TYPES, KEYWORDS, blocks_of
from spacar.deck.lexer import Word, integer_of, scan, split_lines
from spacar.deck.model_arguments import argument_name, in_common
from spacar.deck.outline import Outline
from spacar.deck.raw_statements import Raw
from spacar.deck.splitter import split
from spacar.deck.statement import StatementGroup, Value
from spacar.deck.table_types import Keyword, Parameter, Purpose, Variant
from spacar.errors import InputError, Message, UsageError
from spacar.modes import registered
from spacar.summary import with_picture

Place = tuple[str, int]  # file and line of the Python statement
LATER = ("input.unknown-element", "input.unknown-node")  # may be given by a statement that follows


class Model(ModelStatements, ModelCalls):
    """A deck that is written down by calls: a method for every keyword, named like it in small letters.

    Arguments stand in the order of the deck; the nodes at one end of an element, and the components of a vector, are
    one argument: `m.plbeam(1, (1, 2), (3, 4))` is PLBEAM 1 1 2 3 4. Numbers that are left out keep their defaults;
    ESTIFF, EM and XF also take them by name. Blocks need no END, each keyword knows where it belongs; INPUTX and
    INPUTE of the dynamics block are `inputx_motion` and `inpute_motion`. Elements return their number, `node` its own.

    A statement that is wrong in itself is refused at once, others by `deck`; both with the line of the Python file.
    `m.run(1)` runs it, `str(m)` is the input file.

    source   its name in messages and results

    >>> import spacar
    >>> m = spacar.Model("bar")
    >>> a, b = m.node(1, (0.0, 0.0)), m.node(2, (1.0, 0.0))
    >>> m.pltruss(1, a, b)
    1
    """

    def __init__(self, source: str = "<model>") -> None:
        if not isinstance(source, str) or "\n" in source:
            raise UsageError("Model takes a name; spacar.parse_deck reads the text of a deck", "usage.model")
        self.source = source
        self._rows: list[tuple[str, int, tuple[str, ...], Place]] = []
        self._outline = Outline()
        self._visualization: list[str] = []

    @classmethod
    def from_deck(cls, deck: Deck) -> Model:
        """A model with the statements of a deck that was read, to be continued. Comments are not kept."""
        model = cls(deck.source)
        for raw in split(scan(deck.text), Findings(deck.source)).raws:
            model.statement(raw.keyword, raw.block, *(w.text for w in raw.words))
        lines = scan(deck.text).visualization
        model._visualization = list(deck.visualization if lines is None and not deck.sections else lines or ())
        return model

    def node(self, number: int, place: Vector) -> int:
        """A position node and where it is: the statement X. Returns its number.

        place   2 coordinates of a planar model, 3 of a spatial one [m]
        """
        self.statement("X", 1, number, *place)
        return number

    def of_section(self, number: int, section: str | None, material: str | None, parts: int) -> None:
        """BEAMSEC of the element `number` from the arguments section, material and parts of its method; no statement
        when none of the three is given."""
        if section is not None or material is not None or parts != 1:
            self.statement("BEAMSEC", 1, number, section, material, *([parts] if parts != 1 else []))

    def visualization(self, *lines: str) -> None:
        """`lines` of the section VISUALIZATION, as they stand in a file: `m.visualization("BEAMVIS 0.01 0.01")`."""
        self._visualization += [line for text in lines for line in split_lines(str(text))]

    def statement(
        self, keyword: str, block: int, *values: Value | None, named: Mapping[str, Value | None] | None = None
    ) -> None:
        """Take in any statement: what all other methods call.

        keyword   in capitals;  block   1 kinematics, 2 dynamics, 3 the third block
        values    its arguments; None for one that is left out, which takes its default when a later one is given
        named     values by the names of the method's arguments, instead of those after the first ones

        Raises InputError with the line of the Python file when it is wrong in itself.
        """
        row = _row_of(keyword, block)
        given = _filled(row, values)
        by_name = {name: value for name, value in (named or {}).items() if value is not None}
        if by_name:
            given = self._named(row, given, by_name)
        words, place = tuple(value_text(v) for v in given), _place()
        self._check(row, words, place)
        self._rows.append((row.name, block, words, place))

    def deck(self, mode: Purpose = None) -> Deck:
        """The checked deck; `mode` as `spacar.read_deck`. Raises InputError with the lines of the Python file."""
        text = str(self)
        try:
            deck = parse(text, self.source, mode)
        except InputError as error:
            raise InputError(self._moved(error.messages, text)) from None
        return replace(deck, messages=tuple(self._moved(deck.messages, text))) if deck.messages else deck

    def save(self, path: str | Path) -> Path:
        """Write the input file; `.dat` is appended to a name without ending. Raises UsageError. Returns its path."""
        target = Path(path)
        target = target if target.suffix else target.with_name(target.name + ".dat")
        registered("write_text")(target, str(self))
        return target

    def __str__(self) -> str:
        blocks = [[(name, *words) for name, block, words, _ in self._rows if block == k] for k in (1, 2, 3)]
        return write_rows(blocks, self._visualization)

    def __repr__(self) -> str:
        elements = Counter(name for name, *_ in self._rows if name in ELEMENT_TYPES)
        counted = ", ".join(f"{n} {name}" for name, n in elements.items()) or "no elements"
        return f"Model {self.source}: {counted}; {len(self._rows)} statements\n  .run(1), .deck(), str()"

    def _repr_html_(self) -> str:
        """For notebooks: the model with a picture of the start position, once it is complete enough to be drawn."""
        return with_picture(repr(self), "inline_model", self)

    def _moved(self, messages: Sequence[Message], text: str) -> list[Message]:
        """Messages about the text with the places of the calls where they are about one."""
        ordered = sorted(self._rows, key=lambda row: row[1])  # the blocks; inside them the order stays
        lines: dict[int, Place] = {}
        for raw, (*_, place) in zip(split(scan(text), Findings("")).raws, ordered, strict=True):
            lines.update(dict.fromkeys((raw.line, *(w.line for w in raw.words)), place))
        places = [lines.get(m.line or 0, (m.file, m.line)) for m in messages]
        return [replace(m, file=file, line=line) for m, (file, line) in zip(messages, places, strict=True)]

    def _check(self, row: Keyword, words: tuple[str, ...], place: Place) -> None:
        """Raises InputError for what is wrong whatever follows."""
        file, line = place
        findings = Findings(file)
        raw = Raw(row.name, row.block.number, line, [Word(w, line, 1, False) for w in words])
        statement = read_statement(raw, row, self._outline, findings)
        wrong = [m for m in findings.errors if m.code not in LATER]
        if wrong:
            raise InputError(wrong)
        if statement is not None and row.name in ELEMENT_TYPES:
            self._outline.add(StatementGroup.of(statement))

    def _named(self, row: Keyword, given: list[Value], named: Mapping[str, Value]) -> list[Value]:
        """The row of the form of the statement that has all these names."""
        before = in_common(row)
        if len(given) > before:
            text = f"numbers in the order of the deck and by name ({', '.join(named)}) at once; give one"
            raise _refused(row.name, text, "value")
        fitting = [v for v in row.variants if v.fits(self._outline.space, *self._whose(row, given))]
        forms = {v: [argument_name(p) for p in v.parameters[before:]] for v in fitting}
        able = {v: names for v, names in forms.items() if named.keys() <= {*names}}
        found = [[*given, *_by_name(v, names, named)] for v, names in able.items()]
        if not found:
            known = "; or ".join(", ".join(names) for names in forms.values())
            text = f"there is no {' and '.join(sorted(named))} here; expected {known}"
            raise _refused(row.name, text, "value")
        if any(other != found[0] for other in found):
            text = f"{row.variants[0].parameters[0].meaning} {given[0]} must be known before it is given by name"
            raise _refused(row.name, f"{text}: write its element statement above", "value")
        return found[0]

    def _whose(self, row: Keyword, given: Sequence[Value]) -> tuple[str, str]:
        """Role of the node and keyword of the element that a statement is about, "" for what is not known yet."""
        number = integer_of(value_text(given[0])) if given else None
        if number is None:
            return "", ""
        if row.variants[0].parameters[0].of == "element":
            kind = self._outline.types.get(number)
            return "", kind.keyword if kind else ""
        return self._outline.roles.get(number, ""), ""


def _by_name(form: Variant, names: list[str], named: Mapping[str, Value]) -> list[Value]:
    """The values of one form in its order, up to the last that is needed; what has no name is zero, or its default."""
    rest = form.parameters[len(form.parameters) - len(names) :]
    asked = [p.default is None or name in named for p, name in zip(rest, names, strict=True)]
    needed = max(k for k, must in enumerate(asked, 1) if must)
    count = min(n for n in form.counts if n >= len(form.parameters) - len(names) + needed)
    length = count - len(form.parameters) + len(names)
    return [named.get(name, _default(p)) for name, p in zip(names[:length], rest, strict=False)]


def _filled(row: Keyword, values: Sequence[Value | None]) -> list[Value]:
    """The values up to the last that is given; those that are left out before it take their defaults."""
    given = list(values)
    while given and given[-1] is None:
        given.pop()
    filled: list[Value] = []
    for k, value in enumerate(given):
        parameter = row.longest[min(k, len(row.longest) - 1)]
        if value is None and parameter.default is None:
            text = f"{parameter.text} must be given, because a later argument is"
            raise _refused(row.name, text, "missing-argument")
        filled.append(_default(parameter) if value is None else value)
    return filled


def _default(parameter: Parameter) -> Value:
    value = parameter.default or 0.0
    return int(value) if parameter.kind == "integer" else value


def _row_of(keyword: str, block: int) -> Keyword:
    for kind in blocks_of(keyword):
        if kind.number == block:
            return KEYWORDS[keyword, kind]
    raise _refused(keyword, f"there is no keyword {keyword} in block {block}", "unknown-keyword")


def _refused(keyword: str, text: str, code: str) -> InputError:
    return InputError([Message("error", *_place(), keyword, text, f"input.{code}")])


def _place() -> Place:
    """File and line of the user's call: the innermost one outside this module and `model_methods`."""
    own = (__file__, model_methods.__file__)
    frame = sys._getframe(1)
    while frame.f_back is not None and frame.f_code.co_filename in own:
        frame = frame.f_back
    return Path(frame.f_code.co_filename).name, frame.f_lineno
