"""Mistakes in the VISUALIZATION section (or NAME.spv), for `spacar check`: warnings, because no analysis reads it.

The drawing commands ignore what they do not know (settings.py); here the user hears of it. Line oriented: the first
word of a line is the setting, and nothing else may stand on that line (reference/input-language.md section 2).

The settings of the VISUALIZATION section: what each is for and what stands behind it, for `check` and `keywords`.
"""

from collections.abc import Collection, Iterator, Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import NamedTuple

from spacar.deck import Deck
from spacar.deck.lexer import integer_of, number_of, scan, split_lines
from spacar.errors import Message
from spacar.mechanism.element_rows import element_list
from spacar_drawing.settings import DIMENSIONS, _words


class Rule(NamedTuple):
    """Numbers behind a setting: how many (None: any number), their kind, and what they are."""

    how_many: int | None
    kind: str  # element, node, unit (0 to 1), switch (0 or 1), positive, real, number (integer from 1), shape
    what: str
    help: str


RULES = {
    "BEAMPROPS": Rule(
        None,
        "element",
        "element numbers",
        "heading: the lines CROSSTYPE and CROSSDIM behind it are for these beams, without numbers for all",
    ),
    "TRUSSPROPS": Rule(
        None,
        "element",
        "element numbers",
        "heading: the lines CROSSTYPE and CROSSDIM behind it are for these trusses, without numbers for all",
    ),
    "GRAPHICS": Rule(
        None,
        "element",
        "element numbers",
        "heading: the lines FACECOLOR and OPACITY behind it are for these elements, without numbers for all",
    ),
    "DONOTDRAW": Rule(None, "element", "element numbers", "leave elements out of the picture"),
    "INITIAL": Rule(0, "real", "", "heading: the line COLOR behind it is for the outline of the position at rest"),
    "CROSSTYPE": Rule(1, "shape", "shape", "shape of a cross-section: RECT, RECTHOL, CIRC, CIRCHOL, I or LINE"),
    "CROSSDIM": Rule(None, "positive", "dimensions", "dimensions of the cross-section in the order of BEAMVIS [m]"),
    "BEAMVIS": Rule(
        None,
        "section",
        "shape, element numbers and dimensions",
        "cross-section of beams: shape (RECT when left out), element numbers (none: all), dimensions [m]",
    ),
    "TRUSSVIS": Rule(None, "section", "shape, element numbers and dimensions", "cross-section of trusses, as BEAMVIS"),
    "HINGEVIS": Rule(3, "hinge", "numbers: element, radius, length", "size of a hinge: element, radius, length [m]"),
    "FACECOLOR": Rule(
        3, "unit", "numbers from 0 to 1: red, green, blue", "colour of elements: red, green, blue from 0 to 1"
    ),
    "COLOR": Rule(
        3,
        "unit",
        "numbers from 0 to 1: red, green, blue",
        "colour of the position at rest: red, green, blue from 0 to 1",
    ),
    "OPACITY": Rule(1, "unit", "number from 0 to 1", "opacity of elements: 0 cannot be seen, 1 is opaque"),
    "TRANSPARENCY": Rule(1, "unit", "number from 0 to 1", "opacity of all solids: 0 cannot be seen, 1 is opaque"),
    "LIGHT": Rule(1, "switch", "number, 0 or 1", "shade solids (1) or not (0)"),
    "TRAJECT": Rule(1, "switch", "number, 0 or 1", "draw the paths of TRAJECTNODE (1) or not (0)"),
    "TRAJECTNODE": Rule(None, "node", "node numbers", "nodes whose paths are drawn"),
    "STEPLINE": Rule(1, "positive", "positive number", "distance of the points on an elastic line, in element lengths"),
    "ENLARGEFACTOR": Rule(1, "real", "number", "factor on a mode whose degrees of freedom have norm 1"),
    "VIBRATIONMODE": Rule(1, "number", "mode number", "the vibration mode that spacar visual shows"),
    "BUCKLINGMODE": Rule(1, "number", "mode number", "the buckling mode that spacar visual shows"),
}
SPELLINGS = {"FACECOLOUR": "FACECOLOR", "COLOUR": "COLOR", "TRANSPERANCY": "TRANSPARENCY"}
NEEDS_GROUP = {
    "CROSSTYPE": ("BEAMPROPS", "TRUSSPROPS"),
    "CROSSDIM": ("BEAMPROPS", "TRUSSPROPS"),
    "FACECOLOR": ("GRAPHICS",),
    "OPACITY": ("GRAPHICS",),
    "COLOR": ("INITIAL",),
}


def check_settings(source: Path, deck: Deck | None, text: str | None = None) -> list[Message]:
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
    elements, nodes = _numbers(deck)
    return [
        Message("warning", file, first + i, keyword, problem, "input.visualization")
        for i, keyword, problem in _problems(lines, elements, nodes)
    ]


def _numbers(deck: Deck | None) -> tuple[Collection[int] | None, Collection[int] | None]:
    """The element and node numbers of a deck."""
    if deck is None:
        return None, None

    found = element_list(deck)
    return {n for n, _, _ in found}, {n for _, _, nodes in found for n in nodes}


def _problems(
    lines: Sequence[str], elements: Collection[int] | None, nodes: Collection[int] | None
) -> Iterator[tuple[int, str, str]]:
    """(index of the line, setting, what is wrong), at most one for a line."""
    group, shape = "", "RECT"
    for i, line in enumerate(lines):
        words = _words(line)
        if not words:
            continue
        given, values = words[0].upper(), words[1:]
        key = SPELLINGS.get(given, given)
        rule = RULES.get(key)
        if rule is None:
            yield i, "", _unknown(words[0])
            continue
        if key in ("BEAMPROPS", "TRUSSPROPS", "GRAPHICS", "INITIAL"):
            group, shape = key, "RECT"
        second = next((w for w in values if SPELLINGS.get(w.upper(), w.upper()) in RULES), None)
        if second is not None:
            yield i, given, f"a second setting '{second}' on the same line is not read; each setting has its own line"
            continue
        needed = NEEDS_GROUP.get(key)
        problem = ""
        if needed and group not in needed:
            problem = f"stands behind {group or 'no heading'}; it belongs behind a line {' or '.join(needed)}"
        problem = problem or _wrong(rule, values, shape if key == "CROSSDIM" else "", elements, nodes)
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


def _wrong(
    rule: Rule, values: Sequence[str], shape: str, elements: Collection[int] | None, nodes: Collection[int] | None
) -> str:
    """What is wrong with the values of a setting, "" when nothing is."""
    if rule.kind == "shape":
        if len(values) == 1 and values[0].upper() in DIMENSIONS:
            return ""
        found = " ".join(values) or "nothing"
        return f"'{found}' is no shape of a cross-section; expected {', '.join(DIMENSIONS)}"
    if rule.kind == "section":
        return _wrong_section(values, elements)
    bad = next((v for v in values if number_of(v) is None), None)
    if bad is not None:
        return f"'{bad}' is not a number; expected {rule.what or 'nothing'}"
    count = DIMENSIONS.get(shape, rule.how_many) if shape else rule.how_many
    if count is not None and len(values) != count:
        about = f" of {shape}" if shape else ""
        expected = f"{count} {rule.what}{about}" if count else "none"
        return f"{len(values)} numbers are given; expected {expected}"
    if rule.kind == "node" and not values:
        return f"no number is given; expected {rule.what}"
    if rule.kind in ("element", "node"):
        return _missing(values, rule.kind, elements if rule.kind == "element" else nodes)
    if rule.kind == "hinge":
        return _missing(values[:1], "element", elements) or _out_of_range("positive", values[1:])
    return _out_of_range(rule.kind, values)


def _wrong_section(values: Sequence[str], elements: Collection[int] | None) -> str:
    named = bool(values) and number_of(values[0]) is None
    if named and values[0].upper() not in DIMENSIONS:
        return f"'{values[0]}' is no shape of a cross-section; expected {', '.join(DIMENSIONS)}"
    shape, rest = (values[0].upper(), values[1:]) if named else ("RECT", values)
    bad = next((v for v in rest if number_of(v) is None), None)
    if bad is not None:
        return f"'{bad}' is not a number; expected element numbers and dimensions"
    n = DIMENSIONS[shape]
    if len(rest) < n:
        return f"{len(rest)} numbers are given; {shape} needs {n} dimensions"
    split = len(rest) - n
    return _missing(rest[:split], "element", elements) or _out_of_range("positive", rest[split:])


def _missing(values: Sequence[str], noun: str, known: Collection[int] | None) -> str:
    for word in values:
        number = integer_of(word)
        if number is None or number < 1:
            return f"'{word}' is no {noun} number"
        if known is not None and number not in known:
            return f"{noun} {number} does not exist"
    return ""


def _out_of_range(kind: str, values: Sequence[str]) -> str:
    for word in values:
        value = number_of(word)
        assert value is not None
        if kind == "positive" and not value > 0.0:
            return f"{word} must be positive"
        if kind == "unit" and not 0.0 <= value <= 1.0:
            return f"{word} must be between 0 and 1"
        if kind == "switch" and value not in (0.0, 1.0):
            return f"{word} must be 0 or 1"
        if kind == "number" and (integer_of(word) or 0) < 1:
            return f"'{word}' is no mode number; they count from 1"
    return ""
