"""Statements to text: the canonical form of a deck, and the change of a single value in an existing text."""

from collections.abc import Iterable, Sequence

from spacar.deck.lexer import LONGEST_LINE, split_lines, word_end
from spacar.deck.statement import Statement, Value
from spacar.errors import UsageError

Row = tuple[Value, ...]  # keyword, values ...


def value_text(value: Value) -> str:
    """Shortest text that reads back to the same value."""
    if isinstance(value, (str, bool)):
        return str(value)
    try:
        return repr(int(value)) if isinstance(value, int) else repr(float(value))
    except (TypeError, ValueError):
        return str(value)


def _row(keyword: str, values: Iterable[Value]) -> str:
    """One statement, continued on further lines when it gets too long."""
    lines = [keyword]
    for value in values:
        word = value_text(value)
        if len(lines[-1]) + 1 + len(word) > LONGEST_LINE and lines[-1].strip():
            lines.append(" ")
        lines[-1] += f" {word}"
    return "\n".join(lines)


def rows(statements: Iterable[Statement], *more: Row) -> list[list[Row]]:
    """Those of each block, with some `more` in the first one."""
    blocks: list[list[Row]] = [[], [], []]
    for s in statements:
        blocks[s.block - 1].append((s.keyword, *s.values))
    blocks[0] += more
    return blocks


def write_rows(blocks: Sequence[Iterable[Sequence[Value]]], visualization: Sequence[str] = ()) -> str:
    """Text of up to three blocks of rows (keyword, values ...) without empty ones at the end, and of VISUALIZATION."""
    texts = ["\n".join(_row(str(row[0]), row[1:]) for row in block) for block in blocks]
    while len(texts) > 1 and not texts[-1]:
        texts.pop()
    text = "\nEND HALT\n".join(texts) + "\nEND END\n"
    if visualization:
        text += "VISUALIZATION\n" + "".join(f"{line}\n" for line in visualization)
    return text


def splice(text: str, statement: Statement, position: int, value: Value) -> str:
    """The text with argument `position` (from 1) of a statement replaced; left out arguments before it become 0.

    Comments and line numbers stay. Raises UsageError for a position below 1.
    """
    if position < 1:
        raise UsageError(f"{statement.subject}: arguments are counted from 1, not {position}", "usage.set")
    mark = "\ufeff" if text.startswith("\ufeff") else ""
    lines = split_lines(text.removeprefix(mark))
    index = position - 1
    if index < len(statement.values):
        line, start = statement.lines[index], statement.columns[index] - 1
        old = lines[line - 1]
        lines[line - 1] = old[:start] + value_text(value) + old[word_end(old, start) :]
        return mark + "\n".join(lines)
    words = ["0"] * (index - len(statement.values)) + [value_text(value)]
    if statement.values:
        line, start = statement.lines[-1], statement.columns[-1] - 1
    else:
        line, start = statement.line, 0
        start = lines[line - 1].upper().find(statement.keyword)
    old = lines[line - 1]
    end = word_end(old, start)
    lines[line - 1] = f"{old[:end]} {' '.join(words)}{old[end:]}"
    return mark + "\n".join(lines)
