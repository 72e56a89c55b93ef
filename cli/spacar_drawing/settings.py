"""The VISUALIZATION section of an input file (or NAME.spv): both spellings and generations (input-language.md 2).

`RULES` has the settings, for the reading here, for `check` (settings_check.py) and for `keywords`.

Line oriented. Unknown lines are ignored, because later versions have more settings than are known to us. Readings that
the reference leaves open, decided here: TRANSPARENCY is the opacity of solids (1 opaque), CIRC takes the diameter,
CIRCHOL outer and inner diameter, RECTHOL outer width and height, then inner width and height, HINGEVIS radius and
length, STEPLINE the distance of the points on an elastic line in element lengths, ENLARGEFACTOR the factor on the
degrees of freedom of a mode that is scaled to norm 1.
"""

from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple

from spacar.deck import read_deck
from spacar.deck.lexer import number_of, scan, visualization_of
from spacar.errors import InputError

DIMENSIONS = {"RECT": 2, "RECTHOL": 4, "CIRC": 1, "CIRCHOL": 2, "I": 4, "LINE": 0}
ALL = 0  # the key of a setting that holds for all elements

# Kind of the values behind a setting -> how many (None: any number), and what they are.
KINDS: dict[str, tuple[int | None, str]] = {
    "none": (0, ""), "element": (None, "element numbers"), "node": (None, "node numbers"), "shape": (1, "shape"),
    "dimensions": (None, "dimensions"), "section": (None, "shape, element numbers and dimensions"),
    "hinge": (3, "numbers: element, radius, length"), "colour": (3, "numbers from 0 to 1: red, green, blue"),
    "unit": (1, "number from 0 to 1"), "switch": (1, "number, 0 or 1"), "positive": (1, "positive number"),
    "real": (1, "number"), "number": (1, "mode number"),
}  # fmt: skip
# Kinds of one number -> its value in a picture
READ: dict[str, Callable[[float], Any]] = {
    "unit": lambda v: min(max(v, 0.0), 1.0), "switch": bool, "positive": float, "real": float, "number": int,
}  # fmt: skip


class Rule(NamedTuple):
    """Kind of the values of a setting, what it is for, the field of PictureSettings that it sets as it stands, and the
    headings behind which it must stand."""

    kind: str
    help: str
    field: str = ""
    groups: tuple[str, ...] = ()


_SECTIONS = ("BEAMPROPS", "TRUSSPROPS")
RULES = {
    "BEAMPROPS": Rule("element", "heading: the lines CROSSTYPE and CROSSDIM behind it are for these beams, without"
                      " numbers for all"),
    "TRUSSPROPS": Rule("element", "heading: the lines CROSSTYPE and CROSSDIM behind it are for these trusses, without"
                       " numbers for all"),
    "GRAPHICS": Rule("element", "heading: the lines FACECOLOR and OPACITY behind it are for these elements, without"
                     " numbers for all"),
    "DONOTDRAW": Rule("element", "leave elements out of the picture"),
    "INITIAL": Rule("none", "heading: the line COLOR behind it is for the outline of the position at rest"),
    "CROSSTYPE": Rule("shape", "shape of a cross-section: RECT, RECTHOL, CIRC, CIRCHOL, I or LINE", groups=_SECTIONS),
    "CROSSDIM": Rule("dimensions", "dimensions of the cross-section in the order of BEAMVIS [m]", groups=_SECTIONS),
    "BEAMVIS": Rule("section", "cross-section of beams: shape (RECT when left out), element numbers (none: all),"
                    " dimensions [m]"),
    "TRUSSVIS": Rule("section", "cross-section of trusses, as BEAMVIS"),
    "HINGEVIS": Rule("hinge", "size of a hinge: element, radius, length [m]"),
    "FACECOLOR": Rule("colour", "colour of elements: red, green, blue from 0 to 1", groups=("GRAPHICS",)),
    "COLOR": Rule("colour", "colour of the position at rest: red, green, blue from 0 to 1", groups=("INITIAL",)),
    "OPACITY": Rule("unit", "opacity of elements: 0 cannot be seen, 1 is opaque", groups=("GRAPHICS",)),
    "TRANSPARENCY": Rule("unit", "opacity of all solids: 0 cannot be seen, 1 is opaque", "opacity"),
    "LIGHT": Rule("switch", "shade solids (1) or not (0)", "light"),
    "TRAJECT": Rule("switch", "draw the paths of TRAJECTNODE (1) or not (0)"),
    "TRAJECTNODE": Rule("node", "nodes whose paths are drawn"),
    "STEPLINE": Rule("positive", "distance of the points on an elastic line, in element lengths", "step_line"),
    "ENLARGEFACTOR": Rule("real", "factor on a mode whose degrees of freedom have norm 1", "enlarge"),
    "VIBRATIONMODE": Rule("number", "the vibration mode that spacar visual shows", "vibration_mode"),
    "BUCKLINGMODE": Rule("number", "the buckling mode that spacar visual shows", "buckling_mode"),
}  # fmt: skip
SPELLINGS = {"FACECOLOUR": "FACECOLOR", "COLOUR": "COLOR", "TRANSPERANCY": "TRANSPARENCY"}


@dataclass(frozen=True)
class SectionShape:
    """A cross-section: RECT w h; RECTHOL w h inner w h; CIRC d; CIRCHOL d inner d; LINE. w along y', h along z' [m]."""

    shape: str
    dims: tuple[float, ...] = ()


@dataclass(frozen=True)
class PictureSettings:
    """What the VISUALIZATION section says; None or empty: not said. Keys of tables: element numbers, 0 for all."""

    beams: dict[int, SectionShape] = field(default_factory=dict)
    trusses: dict[int, SectionShape] = field(default_factory=dict)
    hinges: dict[int, tuple[float, float]] = field(default_factory=dict)  # radius, length [m]
    colours: dict[int, tuple[float, float, float]] = field(default_factory=dict)
    opacities: dict[int, float] = field(default_factory=dict)
    initial_colour: tuple[float, float, float] | None = None
    hidden: frozenset[int] = frozenset()
    light: bool = True
    opacity: float = 1.0
    traces: tuple[int, ...] = ()
    step_line: float | None = None
    enlarge: float | None = None
    vibration_mode: int | None = None
    buckling_mode: int | None = None
    metre: float = 1.0  # unit of length of the input file, from UNITS

    def section(self, element: int, shape: str) -> SectionShape | None:
        """That of an element of a shape of the element table ("beam", "truss" ...)."""
        table = self.trusses if shape == "truss" else self.beams
        return table.get(element, table.get(ALL))

    def colour(self, element: int) -> tuple[float, float, float] | None:
        return self.colours.get(element, self.colours.get(ALL))

    def opacity_of(self, element: int) -> float:
        return self.opacities.get(element, self.opacities.get(ALL, self.opacity))


def read_settings(source: Path) -> PictureSettings:
    """The settings in the input file or, when it has no section, in NAME.spv beside it; defaults without either.

    Sections of beams that the file gives with BEAMSEC come first.
    """
    lines: Sequence[str] = ()
    if source.is_file():
        scanned = scan(source.read_text("utf-8", "replace"))
        lines = scanned.visualization or ()
        if any(word.text.upper() in ("BEAMSEC", "UNITS") for word in scanned.words):
            with suppress(InputError):  # the file was changed after the run: read on without BEAMSEC and UNITS
                deck = read_deck(source)
                return replace(parse_settings(deck.visualization), metre=deck.metre)
    beside = source.with_suffix(".spv")
    if not lines and beside.is_file():
        lines = visualization_of(beside.read_text("utf-8", "replace"))
    return parse_settings(lines)


def parse_settings(lines: Iterable[str]) -> PictureSettings:
    """The settings of the lines behind the word VISUALIZATION. A number that is missing sets nothing."""
    s = PictureSettings()  # its tables are filled in place
    group, shape, traced = "", "RECT", True
    elements: tuple[int, ...] = (ALL,)
    for text in lines:
        words = words_of(text)
        key, values = (setting_of(words[0]), words[1:]) if words else ("", [])
        rule = RULES.get(key, Rule("none", ""))
        numbers = [v for v in map(number_of, values) if v is not None and abs(v) <= 1e100]
        integers = tuple(int(v) for v in numbers)
        match key:
            case "BEAMPROPS" | "TRUSSPROPS" | "GRAPHICS" | "INITIAL":
                group, shape, elements = key, "RECT", (integers if key != "INITIAL" else ()) or (ALL,)
            case "CROSSTYPE" if values:
                shape = values[0].upper()
                if shape == "LINE":
                    _keep(s.trusses if group == "TRUSSPROPS" else s.beams, elements, SectionShape("LINE"))
            case "CROSSDIM":
                section = SectionShape(shape, tuple(numbers[: DIMENSIONS.get(shape)]))
                _keep(s.trusses if group == "TRUSSPROPS" else s.beams, elements, section)
            case "BEAMVIS" | "TRUSSVIS" if found := statement_section(values):
                _keep(s.trusses if key == "TRUSSVIS" else s.beams, *found)
            case "HINGEVIS" if len(numbers) == 3:
                s.hinges[integers[0]] = numbers[1], numbers[2]
            case "FACECOLOR" if len(numbers) == 3:
                s.colours.update(dict.fromkeys(elements, (numbers[0], numbers[1], numbers[2])))
            case "COLOR" if len(numbers) == 3 and group == "INITIAL":
                s = replace(s, initial_colour=(numbers[0], numbers[1], numbers[2]))
            case "OPACITY" if numbers:
                s.opacities.update(dict.fromkeys(elements, READ["unit"](numbers[0])))
            case "DONOTDRAW":
                s = replace(s, hidden=s.hidden | set(integers))
            case "TRAJECTNODE":
                s = replace(s, traces=s.traces + integers)
            case "TRAJECT" if numbers:
                traced = bool(numbers[0])
            case _ if rule.field and numbers and (rule.kind != "positive" or numbers[0] > 0):
                s = replace(s, **{rule.field: READ[rule.kind](numbers[0])})
    return s if traced else replace(s, traces=())


def _keep(table: dict[int, SectionShape], elements: Sequence[int], section: SectionShape) -> None:
    """Sections with dimensions that cannot be are ignored."""
    needed = DIMENSIONS.get(section.shape)
    if needed is not None and len(section.dims) >= needed and all(0 < d <= 1e100 for d in section.dims):
        table.update(dict.fromkeys(elements, section))


def words_of(line: str) -> list[str]:
    for mark in "%#;":
        line = line.partition(mark)[0]
    return line.split()


def setting_of(word: str) -> str:
    """The setting that a word means, in capitals."""
    return SPELLINGS.get(word.upper(), word.upper())


def statement_section(values: Sequence[str]) -> tuple[tuple[int, ...], SectionShape] | None:
    """Elements and section of `BEAMVIS [shape] [elements] dims`; None when the numbers do not suffice."""
    shape = values[0].upper() if values and values[0].upper() in DIMENSIONS else "RECT"
    numbers = [v for v in map(number_of, values) if v is not None]
    split = len(numbers) - DIMENSIONS[shape]
    if split < 0 or any(abs(v) > 1e100 for v in numbers):
        return None
    return tuple(int(v) for v in numbers[:split]) or (ALL,), SectionShape(shape, tuple(numbers[split:]))
