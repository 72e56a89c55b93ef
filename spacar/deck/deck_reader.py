"""Reading: text to words, words to statements, statements to the checked contents of a deck."""

import re
from itertools import chain
from operator import attrgetter
from typing import NamedTuple

from spacar.deck.arguments import read_statement
from spacar.deck.cross_section import Expansion
from spacar.deck.deck_checks import check
from spacar.deck.findings import Findings
from spacar.deck.keyword_table import KEYWORDS, BlockKind, Keyword, blocks_of
from spacar.deck.lexer import LONGEST_LINE, SourceText, integer_of, scan, without_comments
from spacar.deck.outline import Outline
from spacar.deck.raw_statements import PlainLines, Raw, raws_of, take_plain
from spacar.deck.splitter import split, third_kind
from spacar.deck.statement import Statement, StatementGroup, StatementIndex, grouped
from spacar.deck.table_elements import ELEMENT_TYPES
from spacar.deck.table_kinematics import UNITS, WORDS
from spacar.deck.table_types import Purpose, third_block, uses
from spacar.errors import InputError, Message

NOT_UTF8 = re.compile("[\ud800-\udfff]")
Span = tuple[tuple[int, int], tuple[int, int]]
_NAMES = {2: "dynamics block", 3: "third block"}


class Contents(NamedTuple):
    """What a text says. `visualization`: lines of that section, None without one; `third`: kind of the third block;
    `spans`: where each block begins and ends (line, column); `shorthand`: UNITS, SECTION, MATERIAL and BEAMSEC, which
    `expansion` replaces, if there are any; `given`: the statements before that, in SI, and their `outline`; `found`:
    the statements."""

    visualization: tuple[str, ...] | None
    messages: tuple[Message, ...]
    third: BlockKind | None
    spans: dict[int, Span]
    shorthand: tuple[Statement, ...]
    expansion: Expansion
    given: StatementIndex
    outline: Outline
    found: StatementIndex


def read_text(text: str, source: str, mode: Purpose = None) -> Contents:
    """The statements of a text, checked; `source` names it in messages. Raises InputError with all errors."""
    findings = Findings(source)
    if "\0" in text and "\0" in without_comments(text).upper().partition("END")[0]:  # behind it they do no harm
        reason = "it has NUL bytes, as files in UTF-16 and results have; save a text as UTF-8"
        raise InputError([Message("error", source, None, "", f"not an input file: {reason}", "encoding")])
    scanned = scan(text)
    _lexical(text, scanned, findings)
    parts = split(scanned, findings)
    third = third_kind(parts.statements, third_block(mode))
    by_geometry = not WORDS.isdisjoint([part.keyword for part in parts.statements])
    outline = Outline(metre=_metre(parts.statements, findings) if by_geometry else 1.0)
    read: list[list[StatementGroup]] = [[] for _ in parts.statements]
    skipped = {block: Findings(source) for block in (2, 3) if not uses(mode, block)}
    findings_of = {1: findings, 2: findings, 3: findings, **skipped}
    kinds = {1: BlockKind.KINEMATICS, 2: BlockKind.DYNAMICS, 3: third}
    lost: list[Raw] = []
    others = []
    for part, groups in zip(parts.statements, read):  # noqa: B905 (a list for each)
        if part.keyword in ELEMENT_TYPES:
            _read(part, KEYWORDS[part.keyword, BlockKind.KINEMATICS], outline, findings, groups, lost)
        else:
            others.append((part, groups))
    outline = _with_elements(outline, list(chain.from_iterable(read)), lost)
    for raw in parts.strangers:
        # one with a number and two nodes is probably an element, whose absence has consequences that are not reported
        numbered = len(raw.words) >= 3 and all((integer_of(w.text) or 0) > 0 for w in raw.words[:3])
        if raw.block == 1 and numbered:
            _remember_broken(raw, outline)
    lost = []
    for part, groups in others:
        kind, into = kinds[part.block], findings_of[part.block]
        keyword = KEYWORDS.get((part.keyword, kind)) if kind is not None else None
        if keyword is None:
            _wrong_kind(part, kind, into)
        else:
            _read(part, keyword, outline, into, groups, lost)
    for raw in lost:
        outline.broken.add((raw.keyword, _number(raw)))
        outline.broken_blocks.add(raw.block)
    for found in skipped.values():
        found.messages.sort(key=lambda m: m.line or 0)  # only the first one is reported
    index = given = StatementIndex(list(chain.from_iterable(read)), parts.interleaved)
    before, expansion = outline, Expansion((), outline, (), ())
    shorthand: tuple[Statement, ...] = ()
    if by_geometry:
        from spacar.deck.section_block import expand  # most models have no beams by geometry

        statements = given.statements()
        expansion = expand(statements, outline, findings)
        outline, shorthand = expansion.outline, tuple([s for s in statements if s.keyword in WORDS])
        index = StatementIndex(grouped(expansion.statements))
    check(index, outline, mode, third, findings_of)
    for block, found in skipped.items():
        _report_skipped(block, parts.statements, mode, found, findings)
    if findings.messages:
        findings.messages.sort(key=lambda m: m.line or 0)
        if findings.errors:
            raise InputError(findings.messages)
    return Contents(
        scanned.visualization, tuple(findings.messages), third, parts.spans, shorthand, expansion,
        given, before, index,
    )  # fmt: skip


def _read(
    part: PlainLines | Raw, keyword: Keyword, outline: Outline, findings: Findings, groups: list[StatementGroup],
    lost: list[Raw],
) -> None:  # fmt: skip
    """Add what a part of the text says to the groups: plain lines together where nothing about them is unusual, halves
    of them where something is, and what remains by its words; what cannot be read to the lost."""
    if isinstance(part, PlainLines):
        if outline.metre == 1.0 and take_plain(part, keyword, outline):
            groups.append(part)
            return
        count = len(part.lines)
        if count > 1:
            for half in (part.part(0, count // 2), part.part(count // 2, count)):
                _read(half, keyword, outline, findings, groups, lost)
            return
        (part,) = raws_of(part)
    statement = read_statement(part, keyword, outline, findings)
    if statement is not None:
        groups.append(StatementGroup.of(statement))
    else:
        lost.append(part)


def _with_elements(empty: Outline, groups: list[StatementGroup], lost: list[Raw]) -> Outline:
    """The outline of a model with these elements; where something is unusual the order of the file matters."""
    for group in groups:
        empty.add(group)
    if empty.regular and not lost:
        return empty
    outline = Outline(metre=empty.metre)
    parts: list[Statement | Raw] = [*chain.from_iterable(groups), *lost]
    for part in sorted(parts, key=attrgetter("line")):
        if isinstance(part, Raw):
            _remember_broken(part, outline)
        else:
            outline.add(StatementGroup.of(part))
    return outline


def _metre(statements: list[PlainLines | Raw], findings: Findings) -> float:
    for raw in statements:
        if isinstance(raw, Raw) and raw.keyword == "UNITS" and raw.words:
            word = raw.words[0]
            if word.text.lower() in UNITS:
                return UNITS[word.text.lower()]
            text = f"there is no unit of length '{word.text}'; expected {' or '.join(UNITS)}"
            findings.add("error", word.line, "UNITS", text, "units")
    return 1.0


def _lexical(text: str, source: SourceText, findings: Findings) -> None:
    if source.long_lines:
        first, count = source.long_lines[0], len(source.long_lines)
        text_ = f"line longer than {LONGEST_LINE} characters; other programs that read this language do not accept it"
        if count > 1:
            text_ += f" ({count} such lines)"
        findings.add("warning", first, "", text_, "long-line")
    if text.isascii():
        return
    for word in source.words:
        if bad := NOT_UTF8.search(word.text):
            byte, shown = ord(bad.group()) & 0xFF, NOT_UTF8.sub("\ufffd", word.text)
            text_ = f"byte 0x{byte:02X} in '{shown}' (column {word.column}) is not UTF-8; allowed in comments only"
            findings.add("error", word.line, "", text_, "encoding")


def _remember_broken(raw: Raw, outline: Outline) -> None:
    """An element whose statement is wrong still exists, so that its other statements are not reported too."""
    outline.complete = False
    number = _number(raw)
    if number != 0:
        stub = Statement(raw.keyword, (number,), raw.block, raw.line, ((raw.words[0].line, raw.words[0].column),))
        outline.elements.setdefault(number, stub)


def _number(raw: Raw) -> int:
    """First argument of a statement that could not be read, 0 when it is no integer."""
    return (integer_of(raw.words[0].text) if raw.words else None) or 0


def _wrong_kind(part: PlainLines | Raw, kind: BlockKind | None, findings: Findings) -> None:
    here = kind.value if kind is not None else _NAMES[3]
    other = ", ".join(b.value for b in blocks_of(part.keyword))
    text = f"belongs to the {other}; here it stands in the {here}"
    for line in part.lines if isinstance(part, PlainLines) else (part.line,):
        findings.add("error", line, part.keyword, text, "wrong-block")


def _report_skipped(
    block: int, statements: list[PlainLines | Raw], mode: Purpose, found: Findings, findings: Findings
) -> None:
    """One line about a block that the mode does not use, and one when it has errors that would matter elsewhere."""
    first = next((s for s in statements if s.block == block), None)
    if first is None:
        return
    line, name = first.line, _NAMES[block]
    findings.add("information", line, "", f"the {name} is not used in mode {mode} and is skipped", "skipped-block")
    if errors := found.errors:
        text = f"the skipped {name} has {len(errors)} error{'s' * (len(errors) > 1)}, the first at line"
        text += f" {errors[0].line}: {errors[0].keyword}: {errors[0].text}"
        findings.add("warning", line, "", text, "skipped-block")
