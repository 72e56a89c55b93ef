"""Collecting messages about a deck: the place is that of the offending word, the subject names the statement."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import partialmethod

from spacar.deck.statement import Statement
from spacar.errors import Message

_ORDINALS = (
    "first", "second", "third", "fourth", "fifth", "sixth", "seventh", "eighth", "ninth", "tenth", "eleventh",
    "twelfth",
)  # fmt: skip


@dataclass(slots=True, eq=False)
class Findings:
    """The messages found so far in one file."""

    file: str
    messages: list[Message] = field(default_factory=list)

    def add(self, severity: str, line: int | None, keyword: str, text: str, code: str) -> None:
        self.messages.append(Message(severity, self.file, line, _clean(keyword), _clean(text), f"input.{code}"))

    def about(
        self, severity: str, statement: Statement, index: int | None, text: str, code: str, bare: bool = False
    ) -> None:
        """A message at the value `index` of a statement (None: at its keyword); `bare` names the keyword only."""
        self.add(severity, statement.line_of(index), statement.keyword if bare else statement.subject, text, code)

    error = partialmethod(about, "error")
    warning = partialmethod(about, "warning")
    information = partialmethod(about, "information")

    @property
    def errors(self) -> list[Message]:
        return [m for m in self.messages if m.severity == "error"]


def _clean(text: str) -> str:
    """Input is quoted in messages: control characters are shown escaped, very long text is cut."""
    if len(text) > 500:
        text = f"{text[:300]} ... {text[-100:]}"
    return text if text.isprintable() else "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text)


def ordinal(index: int) -> str:
    """`ordinal(0)` is "first"."""
    return _ORDINALS[index] if index < len(_ORDINALS) else f"{index + 1}th"


def runs(numbers: Iterable[int], to: str) -> list[str]:
    """Numbers that follow each other as one text: "1", or, with " to " between them, "3 to 7"."""
    found: list[list[int]] = []
    for n in sorted(set(numbers)):
        if found and found[-1][1] == n - 1:
            found[-1][1] = n
        else:
            found.append([n, n])
    return [str(a) if a == b else f"{a}{to}{b}" for a, b in found]


def ranges(numbers: list[int] | set[int], most: int = 8) -> str:
    """Numbers as ranges: "1-3, 7"; "none" when there are none, shortened after `most` ranges."""
    parts = runs(numbers, "-")
    if len(parts) > most:
        parts = [*parts[:most], "..."]
    return ", ".join(parts) or "none"


def alternatives(counts: tuple[int, ...] | set[int]) -> str:
    """Allowed counts in words: "2 to 4", "5, 8 or 9"."""
    values = sorted(counts)
    if len(values) > 2 and values[-1] - values[0] == len(values) - 1:
        return f"{values[0]} to {values[-1]}"
    texts = [str(n) for n in values]
    return texts[0] if len(texts) == 1 else f"{', '.join(texts[:-1])} or {texts[-1]}"


def nearest(word: str, known: Iterable[str], cutoff: float = 0.6) -> str:
    """The known word that looks most like one, "" when none is near; cutoff: share of equal letters."""
    from difflib import get_close_matches

    return next(iter(get_close_matches(word, list(known), 1, cutoff)), "")
