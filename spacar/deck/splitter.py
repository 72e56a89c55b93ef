"""Lines and words to raw statements in blocks: END HALT and END END, unknown and misplaced keywords.

Nothing is known about the model here; a word is judged by the keyword names of the block only. Plain lines, a keyword
of their block and numbers, are statements as they stand; those with the same keyword and count are put together, also
where other plain lines stand between them. All other lines are taken word by word.
"""

from spacar.deck.findings import Findings, nearest
from spacar.deck.keyword_table import ALIASES, KEYWORDS, NAME_PLACES, NAMES, BlockKind, blocks_of
from spacar.deck.lexer import SourceText, Word, words_of
from spacar.deck.raw_statements import PlainLines, Raw, Split

_NOT_NUMBERS = ("NAN", "INF", "INFINITY")
_SUGGESTIONS = 40
# Share of equal letters from which a word is a misspelt keyword of another block: one wrong, missing or swapped letter
# of five (TIMESTP, ESTIF, GRAVTY). SPRING and USERSIG share 0.62, which says nothing about a missing END HALT.
MISSPELT = 0.8
_BLOCK_NAMES = {1: "kinematics block", 2: "dynamics block", 3: "third block"}
# For each block the keywords that may begin a plain line, also by their older names: those without a name among their
# arguments.
_PLAIN = {
    block: {
        word: name
        for name in names
        if name not in NAME_PLACES
        for word in (name, *[alias for alias, of in ALIASES.items() if of == name])
    }
    for block, names in NAMES.items()
}


def split(source: SourceText, findings: Findings) -> Split:
    """Divide the text into blocks and statements; structural errors go to the findings."""
    before = len(findings.messages)
    while (found := _Splitter(source, findings).run()).odd:  # once more, with those lines word by word
        del findings.messages[before:]
        source.odd |= found.odd
    return found


class _Splitter:
    """State of one pass over the lines; `current` or the last of `lines` is the open statement, `alike` the plain lines
    of each keyword since the last other line, `names` the keywords that may begin a plain line now, `skipping` while
    the arguments of a refused keyword go by, `end` an END whose next word has not come yet, `fresh` while no word of
    the block has come."""

    def __init__(self, source: SourceText, findings: Findings) -> None:
        self.source = source
        self.last_line = len(source.lines)
        self.findings = findings
        self.result = Split()
        self.block = 1
        self.opened = 1
        self.fresh = False
        self.start: tuple[int, int] = (1, 1)
        self.current: Raw | None = None
        self.lines: PlainLines | None = None
        self.alike: dict[str, PlainLines] = {}
        self.names = _PLAIN[1]
        self.misplaced: set[tuple[int, int]] = set()
        self.skipping = False
        self.end: Word | None = None

    def error(self, word: Word, text: str, code: str) -> None:
        self.findings.add("error", word.line, "", text, code)

    def run(self) -> Split:
        if not self._lines():
            self._close(self.last_line, 10**6)
            where = " after a single END" if self.end is not None else ""
            text = f"end of file{where} inside the {self._open()}; END END is missing"
            self.findings.add("error", self.last_line, "", text, "structure")
        self.result.convert()
        return self.result

    def _lines(self) -> bool:
        """Take the lines; true at the end of the analysis part."""
        odd, alike = self.source.odd, self.alike
        for number, line in enumerate(self.source.lines, 1):
            words = line.split()
            if odd and number in odd:
                lines = None
            elif not words:
                continue
            else:
                lines = alike.get(words[0])
                if lines is None or lines.width != len(words) - 1:
                    lines = self._plain(words, number)
            if lines is None:
                if self._words(words_of(line, number)):
                    return True
                continue
            if lines is not self.lines:
                self.lines, self.result.interleaved = lines, True
            lines.values += words
            lines.lines.append(number)
            lines.places.append(line)
        return False

    def _plain(self, words: list[str], number: int) -> PlainLines | None:
        """Those that a line with these words belongs to; None when no keyword begins it that may begin a plain line."""
        name = self.names.get(words[0].upper())
        if name is None:
            return None
        lines = self.alike.get(name)
        if lines is None or lines.width != len(words) - 1:
            self._open_since(number)
            self.current = None
            lines = self.lines = PlainLines(name, self.block, len(words) - 1)
            self.result.statements.append(lines)
        self.alike[words[0]] = self.alike[name] = lines
        return lines

    def _words(self, words: list[Word]) -> bool:
        """Take the words of a line that is not plain; true at the end of the analysis part."""
        if words:
            self.alike.clear()
        for word in words:
            if self._take(word):
                return True
        # what follows a single END, or a keyword that begins with a name, is no keyword
        open_ = self.current
        named = open_ is not None and not open_.words and 0 in NAME_PLACES.get(open_.keyword, ())
        self.names = {} if named or self.end is not None else _PLAIN[self.block]
        return False

    def _take(self, word: Word) -> bool:
        """Take the next word; true at the end of the analysis part."""
        self._open_since(word.line)
        name = word.text.upper()
        name = ALIASES.get(name, name)
        if self.end is not None:
            end, self.end = self.end, None
            taken, last = self._follows(end, word, name)
            if taken:
                return last
        if self.current is not None and self._wants_name(self.current, word):
            self.current.words.append(word)
        elif name == "END":
            self.end = word
        elif name == "HALT":
            self.error(word, f"HALT without END before it in the {self._open()}", "structure")
            if self.block < 3:
                self._next_block(word)
        elif name in NAMES[self.block]:
            self._begin(name, word, self.block)
        elif name[0].isalpha():
            self._stranger(name, word)
        else:
            self._argument(word)
        return False

    def _open_since(self, line: int) -> None:
        """A block is open since the line of its first word."""
        if self.fresh:
            self.opened, self.fresh = line, False

    def _begin(self, name: str, word: Word, block: int) -> None:
        self.current, self.lines = Raw(name, block, word.line), None
        self.result.statements.append(self.current)

    def _detach(self) -> None:
        """Make the last of plain lines a statement of its own, as words follow that it may take."""
        if self.lines is None:
            return
        statements = self.result.statements
        self.current, odd = self.lines.pop()
        self.result.odd |= odd
        if not self.lines.lines:
            statements.remove(self.lines)
        statements.append(self.current)
        self.lines = None

    def _wants_name(self, current: Raw, word: Word) -> bool:
        """Whether the word is a name; on the next line a keyword is one only as the first argument."""
        if len(current.words) not in NAME_PLACES.get(current.keyword, ()):
            return False
        name = word.text.upper()
        is_keyword = name in ("END", "HALT") or ALIASES.get(name, name) in NAMES[self.block]
        return not (current.words and word.first and is_keyword)

    def _argument(self, word: Word) -> None:
        self._detach()
        if self.current is not None:
            self.current.words.append(word)
        elif self.skipping:
            if self.result.strangers:
                self.result.strangers[-1].words.append(word)
        else:
            self.error(word, f"'{word.text}' stands before any keyword of the {self._open()}", "structure")
            self.skipping = True

    def _stranger(self, name: str, word: Word) -> None:
        """A word that starts with a letter and is no keyword of this block."""
        self._detach()
        if blocks_of(name):
            self._other_block(name, word)
            return
        if self.current is not None and not word.first:
            room = len(self.current.words) < NAMES[self.current.block][self.current.keyword]
            if room and (name in _NOT_NUMBERS or not name.isalpha() or not nearest_keyword(name, self.block)):
                self.current.words.append(word)  # reported with the meaning of its position
                return
        elif self.current is None and self.skipping and not word.first:
            return
        self.current = None
        self.skipping = True
        many = len(self.findings.messages) > _SUGGESTIONS  # a file that is no input at all must not take minutes
        self.result.strangers.append(Raw(name, self.block, word.line))
        self.error(word, unknown(word, self.block, suggest=not many), "unknown-keyword")

    def _other_block(self, name: str, word: Word) -> None:
        other = blocks_of(name)[0]
        target = other.number
        forward = target > self.block and not self._block_goes_on(word)
        if (self.block, target) not in self.misplaced or forward:
            self.misplaced.add((self.block, target))
            here = _BLOCK_NAMES[self.block]
            if forward:
                advice = f"an END HALT is missing before this line (the {here} is open since line {self.opened})"
            elif target < self.block:
                advice = f"an END HALT before line {self.opened} is superfluous, or the statement must be moved there"
            else:
                advice = "move it there; if it is in place, an END HALT is missing before it"
            self.error(word, f"{name} belongs to the {other.value}, not to the {here}; {advice}", "wrong-block")
        if forward:
            while self.block < target:
                self._next_block(word)
        self._begin(name, word, target)

    def _block_goes_on(self, word: Word) -> bool:
        """Whether a keyword that only the open block knows follows before the next END."""
        for other in self.source.words[self.source.words.index(word) :]:
            name = other.text.upper()
            if name == "END":
                return False
            if name in NAMES[self.block] and {b.number for b in blocks_of(name)} == {self.block}:
                return True
        return False

    def _open(self) -> str:
        return f"{_BLOCK_NAMES[self.block]} (open since line {self.opened})"

    def _close(self, line: int, column: int) -> None:
        self.result.spans[self.block] = (self.start, (line, column))
        self.current = self.lines = None
        self.skipping = False

    def _next_block(self, word: Word) -> None:
        end = word.column + len(word.text)
        self._close(word.line, end)
        self.block += 1
        self.start = (word.line, end)
        self.opened, self.fresh = word.line, True

    def _follows(self, end: Word, word: Word, name: str) -> tuple[bool, bool]:
        """The word behind an END: whether that takes it, and whether it is the last one of the analysis part."""
        place = word.column + len(word.text)
        if name == "END":
            self._close(word.line, place)
            return True, True
        if name == "HALT":
            if self.block == 3:
                text = f"END HALT closes the {self._open()}, but no block follows: use END END"
                self.error(end, text, "structure")
                self._close(word.line, place)
                return True, True
            self._next_block(word)
            return True, False
        text = "END must be followed by HALT (another block follows) or END (end of the input), not by"
        self.error(word, f"{text} '{word.text}'; the {self._open()} is open", "structure")
        if self.block < 3:
            self._next_block(end)
            self._open_since(word.line)
        return False, False


def nearest_keyword(name: str, block: int, cutoff: float = 0.6) -> str:
    """The keyword of a block that looks most like a name, as `nearest`."""
    return nearest(name, [*NAMES[block], "END", "HALT"], cutoff)


def unknown(word: Word, block: int, suggest: bool = True) -> str:
    """Text for an unknown keyword, with the nearest one of this block or of another block."""
    text = f"unknown keyword '{word.text}' (column {word.column}) in the {_BLOCK_NAMES[block]}"
    if not suggest:
        return text
    near = nearest_keyword(word.text.upper(), block)
    if near:
        return f"{text}; nearest: {near}"
    for other in (1, 2, 3):
        near = nearest_keyword(word.text.upper(), other, MISSPELT)
        if near:
            where = _BLOCK_NAMES[other]
            return f"{text}; nearest: {near} of the {where}: an END HALT may be missing or superfluous"
    return text


def third_kind(statements: list[PlainLines | Raw], kind: BlockKind | None) -> BlockKind | None:
    """The kind of the third block: the one that the mode asks for, else the one its keywords belong to."""
    if kind is not None:
        return kind
    counts = [(s.keyword, len(s.lines) if isinstance(s, PlainLines) else 1) for s in statements if s.block == 3]
    if not counts:
        return None
    trajectory = sum(n for name, n in counts if (name, BlockKind.TRAJECTORY) in KEYWORDS)
    return BlockKind.TRAJECTORY if trajectory > sum(n for _, n in counts) // 2 else BlockKind.LINEARIZATION
