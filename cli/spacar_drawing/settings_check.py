"""Mistakes in the VISUALIZATION section (or NAME.spv), for `spacar check`: warnings, because no analysis reads it.

The drawing commands ignore what they do not know (settings.py); here the user hears of it. Line oriented: the first
word of a line is the setting, and nothing else may stand on that line (reference/input-language.md section 2).
"""

from collections.abc import Collection, Iterator, Sequence
from difflib import get_close_matches
from pathlib import Path

from spacar.deck import ELEMENT_TYPES, Deck
from spacar.deck.lexer import integer_of, number_of, scan, split_lines
from spacar.deck.rewrite.references import NODE, named
from spacar.errors import Message
from spacar_drawing.settings import DIMENSIONS, KINDS, RULES, Rule, setting_of, words_of

Known = dict[str, Collection[int]]  # numbers of elements and of nodes that exist; without them they are not checked


def check_settings(source: Path, deck: Deck | None, text: str | None) -> list[Message]:
    """Warnings about the settings of an input file or of the NAME.spv beside it, with the lines of that file.

    deck   gives the element and node numbers that exist; None: they are not checked
    text   of the file, where it need not be read
    """
    scanned = scan(source.read_text("utf-8", "replace") if text is None else text)
    file, first = source.name, len(scanned.lines) + 2  # the line behind the word VISUALIZATION
    lines: Sequence[str] = scanned.visualization or ()
    beside = source.with_suffix(".spv")
    if scanned.visualization is None and beside.is_file():
        file, first = beside.name, 1
        lines = split_lines(beside.read_text("utf-8", "replace").removeprefix("\ufeff"))
        for i, line in enumerate(lines):
            if line.strip().upper() == "VISUALIZATION":
                lines, first = lines[i + 1 :], i + 2
                break
    return [
        Message("warning", file, first + i, keyword, problem, "input.visualization")
        for i, keyword, problem in _problems(lines, _numbers(deck))
    ]


def _numbers(deck: Deck | None) -> Known:
    if deck is None:
        return {}
    found = deck.of(*ELEMENT_TYPES, block=1)
    return {"element": {s.integer(0) for s in found}, "node": {n for s in found for n in named(s, NODE)}}


def _problems(lines: Sequence[str], known: Known) -> Iterator[tuple[int, str, str]]:
    """(index of the line, setting, what is wrong), at most one for a line."""
    group, shape = "", "RECT"
    for i, line in enumerate(lines):
        words = words_of(line)
        if not words:
            continue
        given, values = words[0].upper(), words[1:]
        key = setting_of(given)
        rule = RULES.get(key)
        if rule is None:
            yield i, "", _unknown(words[0])
            continue
        if key in ("BEAMPROPS", "TRUSSPROPS", "GRAPHICS", "INITIAL"):
            group, shape = key, "RECT"
        second = next((w for w in values if setting_of(w) in RULES), None)
        if second is not None:
            yield i, given, f"a second setting '{second}' on the same line is not read; each setting has its own line"
            continue
        problem = f"stands behind {group or 'no heading'}; it belongs behind a line {' or '.join(rule.groups)}"
        if not rule.groups or group in rule.groups:
            problem = _wrong(rule, values, shape if key == "CROSSDIM" else "", known)
        if problem:
            yield i, given, problem
        elif key == "CROSSTYPE":
            shape = values[0].upper()


def _unknown(word: str) -> str:
    if number_of(word) is not None:
        return f"'{word}' stands where a setting is expected; the line is not read"
    near = get_close_matches(word.upper(), RULES, n=1, cutoff=0.6)
    hint = f"; nearest: {near[0]}" if near else ""
    return f"unknown setting '{word}' of VISUALIZATION, not read{hint}"


def _wrong(rule: Rule, values: Sequence[str], shape: str, known: Known) -> str:
    """What is wrong with the values of a setting, "" when nothing is."""
    if rule.kind == "shape":
        if len(values) == 1 and values[0].upper() in DIMENSIONS:
            return ""
        found = " ".join(values) or "nothing"
        return f"'{found}' is no shape of a cross-section; expected {', '.join(DIMENSIONS)}"
    if rule.kind == "section":
        return _wrong_section(values, known)
    count, what = KINDS[rule.kind]
    bad = next((v for v in values if number_of(v) is None), None)
    if bad is not None:
        return f"'{bad}' is not a number; expected {what or 'nothing'}"
    count = DIMENSIONS.get(shape, count)
    if count is not None and len(values) != count:
        about = f" of {shape}" if shape else ""
        expected = f"{count} {what}{about}" if count else "none"
        return f"{len(values)} numbers are given; expected {expected}"
    if rule.kind == "node" and not values:
        return f"no number is given; expected {what}"
    if rule.kind in ("element", "node"):
        return _missing(values, rule.kind, known)
    if rule.kind == "hinge":
        return _missing(values[:1], "element", known) or _out_of_range("positive", values[1:])
    return _out_of_range(rule.kind, values)


def _wrong_section(values: Sequence[str], known: Known) -> str:
    worded = bool(values) and number_of(values[0]) is None
    if worded and values[0].upper() not in DIMENSIONS:
        return f"'{values[0]}' is no shape of a cross-section; expected {', '.join(DIMENSIONS)}"
    shape, rest = (values[0].upper(), values[1:]) if worded else ("RECT", values)
    bad = next((v for v in rest if number_of(v) is None), None)
    if bad is not None:
        return f"'{bad}' is not a number; expected element numbers and dimensions"
    n = DIMENSIONS[shape]
    if len(rest) < n:
        return f"{len(rest)} numbers are given; {shape} needs {n} dimensions"
    split = len(rest) - n
    return _missing(rest[:split], "element", known) or _out_of_range("positive", rest[split:])


def _missing(values: Sequence[str], noun: str, known: Known) -> str:
    for word in values:
        number = integer_of(word)
        if number is None or number < 1:
            return f"'{word}' is no {noun} number"
        if number not in known.get(noun, (number,)):
            return f"{noun} {number} does not exist"
    return ""


def _out_of_range(kind: str, values: Sequence[str]) -> str:
    for word in values:
        value = number_of(word)
        assert value is not None
        if kind in ("positive", "dimensions") and not value > 0.0:
            return f"{word} must be positive"
        if kind in ("unit", "colour") and not 0.0 <= value <= 1.0:
            return f"{word} must be between 0 and 1"
        if kind == "switch" and value not in (0.0, 1.0):
            return f"{word} must be 0 or 1"
        if kind == "number" and (integer_of(word) or 0) < 1:
            return f"'{word}' is no mode number; they count from 1"
    return ""
