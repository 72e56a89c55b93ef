"""Words to raw statements in blocks: END HALT and END END, unknown and misplaced keywords.

Nothing is known about the model here; a word is judged by the keyword names of the block only.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from spacar.deck.findings import Findings
from spacar.deck.keyword_table import ALIASES, KEYWORDS, NAME_PLACES, NAMES, BlockKind, blocks_of
from spacar.deck.lexer import SourceText, Word

_NOT_NUMBERS = ("NAN", "INF", "INFINITY")
_SUGGESTIONS = 40
# Share of equal letters from which a word is a misspelt keyword of another block: one wrong, missing or swapped letter
# of five (TIMESTP, ESTIF, GRAVTY). SPRING and USERSIG share 0.62, which says nothing about a missing END HALT.
MISSPELT = 0.8
_BLOCK_NAMES = {1: "kinematics block", 2: "dynamics block", 3: "third block"}


@dataclass(slots=True, eq=False)
class Raw:
    """A statement whose arguments are still words."""

    keyword: str
    word: Word
    block: int
    words: list[Word] = field(default_factory=list)


@dataclass(slots=True, eq=False)
class Split:
    """All raw statements and, for each block that was opened, where its text begins and ends (line,
    column); `strangers` are refused words with what follows them."""

    statements: list[Raw] = field(default_factory=list)
    strangers: list[Raw] = field(default_factory=list)
    spans: dict[int, tuple[tuple[int, int], tuple[int, int]]] = field(default_factory=dict)


def split(source: SourceText, findings: Findings) -> Split:
    """Divide the words into blocks and raw statements; structural errors go to the findings."""
    return _Splitter(source, findings).run()


class _Splitter:
    """State of one pass over the words; `skipping` while the arguments of a refused keyword go by."""

    def __init__(self, source: SourceText, findings: Findings) -> None:
        self.words = source.words
        self.last_line = source.last_line
        self.findings = findings
        self.result = Split()
        self.block = 1
        self.opened = 1
        self.start: tuple[int, int] = (1, 1)
        self.current: Raw | None = None
        self.misplaced: set[tuple[int, int]] = set()
        self.skipping = False

    def error(self, word: Word, text: str, code: str) -> None:
        self.findings.add("error", word.line, "", text, code)

    def run(self) -> Split:
        i = 0
        while i < len(self.words):
            word = self.words[i]
            name = word.text.upper()
            name = ALIASES.get(name, name)
            if self._wants_name(word):
                self._append(word)
            elif name == "END":
                step = self._end(i)
                if step == 0:
                    return self.result
                i += step
                continue
            elif name == "HALT":
                self.error(word, f"HALT without END before it in the {self._open()}", "structure")
                if self.block < 3:
                    self._next_block(word)
            elif name in NAMES[self.block]:
                self._begin(name, word, self.block)
            elif name[0].isalpha():
                self._stranger(name, word, i)
            else:
                self._argument(word)
            i += 1
        self._unfinished("")
        return self.result

    # -- statements ----------------------------------------------------------------------------------------

    def _begin(self, name: str, word: Word, block: int) -> None:
        self.current = Raw(name, word, block)
        self.result.statements.append(self.current)

    def _append(self, word: Word) -> None:
        assert self.current is not None
        self.current.words.append(word)

    def _wants_name(self, word: Word) -> bool:
        """Whether the word is a name; behind other arguments a name stands on their line, else it was left out."""
        current = self.current
        if current is None or len(current.words) not in NAME_PLACES.get(current.keyword, ()):
            return False
        return not (current.words and word.first)

    def _argument(self, word: Word) -> None:
        if self.current is not None:
            self._append(word)
        elif self.skipping:
            if self.result.strangers:
                self.result.strangers[-1].words.append(word)
        else:
            self.error(word, f"'{word.text}' stands before any keyword of the {self._open()}", "structure")
            self.skipping = True

    def _stranger(self, name: str, word: Word, i: int) -> None:
        """A word that starts with a letter and is no keyword of this block."""
        blocks = blocks_of(name)
        if blocks:
            self._other_block(name, word, i)
            return
        if self.current is not None and not word.first:
            room = len(self.current.words) < NAMES[self.current.block][self.current.keyword]
            if room and (name in _NOT_NUMBERS or not name.isalpha() or not nearest(name, self.block)):
                self._append(word)  # reported with the meaning of its position
                return
        elif self.current is None and self.skipping and not word.first:
            return
        self.current = None
        self.skipping = True
        many = (
            len(self.findings.messages) > _SUGGESTIONS
        )  # a file that is no input at all must not take minutes
        self.result.strangers.append(Raw(name, word, self.block))
        self.error(word, unknown(word, self.block, suggest=not many), "unknown-keyword")

    def _other_block(self, name: str, word: Word, i: int) -> None:
        other = blocks_of(name)[0]
        target = other.number
        forward = target > self.block and not self._block_goes_on(i)
        if (self.block, target) not in self.misplaced or forward:
            self.misplaced.add((self.block, target))
            here = _BLOCK_NAMES[self.block]
            if forward:
                advice = (
                    f"an END HALT is missing before this line (the {here} is open since line {self.opened})"
                )
            elif target < self.block:
                advice = (
                    f"an END HALT before line {self.opened} is superfluous, or the statement must be "
                    "moved there"
                )
            else:
                advice = "move it there; if it is in place, an END HALT is missing before it"
            self.error(
                word, f"{name} belongs to the {other.value}, not to the {here}; {advice}", "wrong-block"
            )
        if forward:
            while self.block < target:
                self._next_block(word)
        self._begin(name, word, target)

    def _block_goes_on(self, i: int) -> bool:
        """Whether a keyword that only the open block knows follows before the next END."""
        for word in self.words[i:]:
            name = word.text.upper()
            if name == "END":
                return False
            if name in NAMES[self.block] and {b.number for b in blocks_of(name)} == {self.block}:
                return True
        return False

    # -- blocks --------------------------------------------------------------------------------------------

    def _open(self) -> str:
        return f"{_BLOCK_NAMES[self.block]} (open since line {self.opened})"

    def _close(self, line: int, column: int) -> None:
        self.result.spans[self.block] = (self.start, (line, column))
        self.current = None
        self.skipping = False

    def _next_block(self, word: Word) -> None:
        end = word.column + len(word.text)
        self._close(word.line, end)
        self.block += 1
        self.start = (word.line, end)
        following = next((w for w in self.words if (w.line, w.column) >= self.start), None)
        self.opened = following.line if following is not None else word.line

    def _end(self, i: int) -> int:
        """Handle END at word `i`; the number of words to go on, 0 at the end of the analysis part."""
        word = self.words[i]
        follower = self.words[i + 1] if i + 1 < len(self.words) else None
        if follower is None:
            self._unfinished(" after a single END")
            return 0
        name = follower.text.upper()
        end = follower.column + len(follower.text)
        if name == "END":
            self._close(follower.line, end)
            return 0
        if name == "HALT":
            if self.block == 3:
                self.error(
                    word,
                    f"END HALT closes the {self._open()}, but no block follows: use END END",
                    "structure",
                )
                self._close(follower.line, end)
                return 0
            self._next_block(follower)
            return 2
        self.error(
            follower,
            f"END must be followed by HALT (another block follows) or END (end of the input), not by "
            f"'{follower.text}'; the {self._open()} is open",
            "structure",
        )
        if self.block < 3:
            self._next_block(word)
        return 1

    def _unfinished(self, where: str) -> None:
        self._close(self.last_line, 10**6)
        self.findings.add(
            "error",
            self.last_line,
            "",
            f"end of file{where} inside the {self._open()}; END END is missing",
            "structure",
        )


def nearest(name: str, block: int, cutoff: float = 0.6) -> str:
    """The keyword of a block that looks most like a name, "" when none is near; cutoff: share of equal letters."""
    from difflib import get_close_matches

    found = get_close_matches(name, [*NAMES[block], "END", "HALT"], n=1, cutoff=cutoff)
    return found[0] if found else ""


def unknown(word: Word, block: int, suggest: bool = True) -> str:
    """Text for an unknown keyword, with the nearest one of this block or of another block."""
    text = f"unknown keyword '{word.text}' (column {word.column}) in the {_BLOCK_NAMES[block]}"
    if not suggest:
        return text
    near = nearest(word.text.upper(), block)
    if near:
        return f"{text}; nearest: {near}"
    for other in (1, 2, 3):
        near = nearest(word.text.upper(), other, MISSPELT)
        if near:
            where = _BLOCK_NAMES[other]
            return f"{text}; nearest: {near} of the {where}: an END HALT may be missing or superfluous"
    return text


def third_kind(statements: list[Raw], kind: BlockKind | None) -> BlockKind | None:
    """The kind of the third block: the one that the mode asks for, else the one its keywords belong to."""
    if kind is not None:
        return kind
    third = [r for r in statements if r.block == 3]
    if not third:
        return None
    trajectory = sum((r.keyword, BlockKind.TRAJECTORY) in KEYWORDS for r in third)
    return BlockKind.TRAJECTORY if trajectory > len(third) // 2 else BlockKind.LINEARIZATION
