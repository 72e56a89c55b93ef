"""Reading: text to words, words to statements, statements to the checked contents of a deck."""

from __future__ import annotations

import re
from dataclasses import dataclass

from spacar.deck.arguments import read_statement
from spacar.deck.deck_checks import check
from spacar.deck.expansion import WORDS, Expansion
from spacar.deck.findings import Findings
from spacar.deck.keyword_table import KEYWORDS, BlockKind, blocks_of
from spacar.deck.lexer import LONGEST_LINE, SourceText, integer_of, scan
from spacar.deck.mode_blocks import Purpose, third_block, uses
from spacar.deck.outline import Outline
from spacar.deck.splitter import Raw, split, third_kind
from spacar.deck.statement import Statement
from spacar.deck.statement_index import StatementIndex
from spacar.deck.table_elements import ELEMENT_TYPES
from spacar.deck.table_sections import UNITS
from spacar.errors import InputError, Message

NOT_UTF8 = re.compile("[\ud800-\udfff]")
Span = tuple[tuple[int, int], tuple[int, int]]
_NAMES = {2: "dynamics block", 3: "third block"}


@dataclass(frozen=True)
class Contents:
    """What a text says. `visualization`: lines of that section, None without one; `third`: kind of the third block;
    `spans`: where each block begins and ends (line, column); `shorthand`: UNITS, SECTION, MATERIAL and BEAMSEC, which
    `expansion` replaces; `given`: the statements before that, in SI, and their `outline`; `index`: of `statements`."""

    statements: tuple[Statement, ...]
    visualization: tuple[str, ...] | None
    messages: tuple[Message, ...]
    third: BlockKind | None
    spans: dict[int, Span]
    shorthand: tuple[Statement, ...]
    expansion: Expansion
    given: tuple[Statement, ...]
    outline: Outline
    index: StatementIndex


def read_text(text: str, source: str, mode: Purpose = None) -> Contents:
    """The statements of a text, checked; `source` names it in messages. Raises InputError with all errors."""
    findings = Findings(source)
    scanned = scan(text)
    _lexical(text, scanned, findings)
    parts = split(scanned, findings)
    third = third_kind(parts.statements, third_block(mode))
    by_geometry = any(raw.keyword in WORDS for raw in parts.statements)
    outline = Outline(metre=_metre(parts.statements, findings) if by_geometry else 1.0)
    read: dict[int, Statement] = {}
    skipped = {block: Findings(source) for block in (2, 3) if not uses(mode, block)}
    for raw in parts.statements:
        if raw.keyword in ELEMENT_TYPES:
            statement = read_statement(raw, KEYWORDS[raw.keyword, BlockKind.KINEMATICS], outline, findings)
            if statement is None:
                _remember_broken(raw, outline)
            else:
                read[id(raw)] = statement
                outline.add(statement)
    for raw in parts.strangers:
        if raw.block == 1 and _may_be_element(raw):
            _remember_broken(raw, outline)
    for raw in parts.statements:
        if raw.keyword not in ELEMENT_TYPES:
            kind = {1: BlockKind.KINEMATICS, 2: BlockKind.DYNAMICS}.get(raw.block, third)
            into = skipped.get(raw.block, findings)
            keyword = KEYWORDS.get((raw.keyword, kind)) if kind is not None else None
            if keyword is None:
                _wrong_kind(raw, kind, into)
                continue
            statement = read_statement(raw, keyword, outline, into)
            if statement is not None:
                read[id(raw)] = statement
            else:
                outline.broken.add((raw.keyword, _number(raw)))
                outline.broken_blocks.add(raw.block)
    given, before = tuple([s for raw in parts.statements if (s := read.get(id(raw))) is not None]), outline
    expansion = _expansion(given, by_geometry, outline, findings)
    statements, outline, index = expansion.statements, expansion.outline, StatementIndex(expansion.statements)
    check(index, outline, mode, third, {block: skipped.get(block, findings) for block in (1, 2, 3)})
    for block, found in skipped.items():
        _report_skipped(block, parts.statements, mode, found, findings)
    findings.messages.sort(key=lambda m: m.line or 0)
    if findings.errors:
        raise InputError(findings.messages)
    shorthand = tuple([s for s in read.values() if s.keyword in WORDS]) if by_geometry else ()
    return Contents(
        statements, scanned.visualization, tuple(findings.messages), third, parts.spans, shorthand, expansion,
        given, before, index,
    )  # fmt: skip


def _expansion(
    statements: tuple[Statement, ...], by_geometry: bool, outline: Outline, findings: Findings
) -> Expansion:
    """Beams by geometry to plain statements; most models have none, and do not load what makes them."""
    if not by_geometry:
        return Expansion(statements, outline, (), ())
    from spacar.deck.section_block import expand

    return expand(statements, outline, findings)


def _metre(raws: list[Raw], findings: Findings) -> float:
    """Length of the unit of length in metres, from UNITS."""
    for raw in raws:
        if raw.keyword == "UNITS" and raw.words:
            word = raw.words[0]
            if word.text.lower() in UNITS:
                return UNITS[word.text.lower()]
            text = f"there is no unit of length '{word.text}'; expected {' or '.join(UNITS)}"
            findings.add("error", word.line, "UNITS", text, "units")
    return 1.0


def _lexical(text: str, source: SourceText, findings: Findings) -> None:
    if source.long_lines:
        first, count = source.long_lines[0], len(source.long_lines)
        text_ = (
            f"line longer than {LONGEST_LINE} characters; other programs that read this language do not "
            "accept it"
        )
        if count > 1:
            text_ += f" ({count} such lines)"
        findings.add("warning", first, "", text_, "long-line")
    if text.isascii():
        return
    for word in source.words:
        bad = NOT_UTF8.search(word.text)
        if bad:
            byte = ord(bad.group()) & 0xFF
            shown = NOT_UTF8.sub("\ufffd", word.text)
            findings.add(
                "error",
                word.line,
                "",
                f"byte 0x{byte:02X} in '{shown}' (column {word.column}) is not UTF-8; allowed in "
                "comments only",
                "encoding",
            )


def _remember_broken(raw: Raw, outline: Outline) -> None:
    """An element whose statement is wrong still exists, so that its other statements are not reported too."""
    outline.complete = False
    number = _number(raw)
    if number != 0:
        stub = Statement(raw.keyword, (number,), raw.block, raw.line, (raw.words[0].line,))
        outline.elements.setdefault(number, stub)


def _may_be_element(raw: Raw) -> bool:
    """An unknown keyword with a number and two nodes: probably an element, whose absence has consequences that are
    not reported."""
    return len(raw.words) >= 3 and all((integer_of(w.text) or 0) > 0 for w in raw.words[:3])


def _number(raw: Raw) -> int:
    """First argument of a statement that could not be read, 0 when it is no integer."""
    return (integer_of(raw.words[0].text) if raw.words else None) or 0


def _wrong_kind(raw: Raw, kind: BlockKind | None, findings: Findings) -> None:
    here = kind.value if kind is not None else _NAMES[3]
    other = ", ".join(b.value for b in blocks_of(raw.keyword))
    findings.add(
        "error",
        raw.line,
        raw.keyword,
        f"belongs to the {other}; here it stands in the {here}",
        "wrong-block",
    )


def _report_skipped(block: int, raws: list[Raw], mode: Purpose, found: Findings, findings: Findings) -> None:
    """One line about a block that the mode does not use, and one when it has errors that would matter elsewhere."""
    first = next((r for r in raws if r.block == block), None)
    if first is None:
        return
    line, name = first.line, _NAMES[block]
    findings.add(
        "information", line, "", f"the {name} is not used in mode {mode} and is skipped", "skipped-block"
    )
    errors = found.errors
    if errors:
        findings.add(
            "warning",
            line,
            "",
            f"the skipped {name} has {len(errors)} error{'s' * (len(errors) > 1)}, the first at line {errors[0].line}:"
            f" {errors[0].keyword}: {errors[0].text}",
            "skipped-block",
        )
