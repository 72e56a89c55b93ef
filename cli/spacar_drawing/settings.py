"""The VISUALIZATION section of an input file (or NAME.spv): both spellings and generations (input-language.md 2).

Line oriented. Unknown lines are ignored, because later versions have more settings than are known to us. Readings that
the reference leaves open, decided here: TRANSPARENCY is the opacity of solids (1 opaque), CIRC takes the diameter,
CIRCHOL outer and inner diameter, RECTHOL outer width and height, then inner width and height, HINGEVIS radius and
length, STEPLINE the distance of the points on an elastic line in element lengths, ENLARGEFACTOR the factor on the
degrees of freedom of a mode that is scaled to norm 1.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from spacar.deck import read_deck
from spacar.deck.lexer import number_of, scan, visualization_of
from spacar.errors import InputError

DIMENSIONS = {"RECT": 2, "RECTHOL": 4, "CIRC": 1, "CIRCHOL": 2, "I": 4, "LINE": 0}
ALL = 0  # the key of a setting that holds for all elements


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

    def section(self, element: int, truss: bool = False) -> SectionShape | None:
        table = self.trusses if truss else self.beams
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
            try:
                deck = read_deck(source)
                return replace(parse_settings(deck.visualization), metre=deck.metre)
            except InputError:  # the file was changed after the run and is wrong: read on without BEAMSEC and UNITS
                pass
    beside = source.with_suffix(".spv")
    if not lines and beside.is_file():
        lines = visualization_of(beside.read_text("utf-8", "replace"))
    return parse_settings(lines)


@dataclass(frozen=True)
class _SettingLine:
    """One line: its first word in capitals, the other words, and those of them that are numbers."""

    key: str
    values: list[str]
    numbers: list[float]

    @property
    def integers(self) -> tuple[int, ...]:
        return tuple(int(v) for v in self.numbers)


@dataclass
class _Reading:
    """What was said so far, and the heading line of the new style to which a line belongs."""

    settings: PictureSettings = field(default_factory=PictureSettings)
    group: str = ""
    elements: tuple[int, ...] = (ALL,)
    shape: str = "RECT"
    traces: bool = True

    def set(self, **values: Any) -> None:
        self.settings = replace(self.settings, **values)

    def section(self, section: SectionShape, elements: Sequence[int], truss: bool) -> None:
        """Sections with dimensions that cannot be are ignored."""
        dims = section.dims
        if section.shape not in DIMENSIONS or len(dims) < DIMENSIONS[section.shape]:
            return
        if any(not 0 < d <= 1e100 for d in dims):
            return
        name = "trusses" if truss else "beams"
        self.set(**{name: getattr(self.settings, name) | dict.fromkeys(elements, section)})


def _heading(r: _Reading, line: _SettingLine) -> None:
    r.group, r.shape = line.key, "RECT"
    r.elements = (line.integers if line.key != "INITIAL" else ()) or (ALL,)


def _cross_type(r: _Reading, line: _SettingLine) -> None:
    if line.values:
        r.shape = line.values[0].upper()
        if r.shape == "LINE":
            r.section(SectionShape("LINE"), r.elements, r.group == "TRUSSPROPS")


def _cross_dimensions(r: _Reading, line: _SettingLine) -> None:
    dims = tuple(line.numbers[: DIMENSIONS.get(r.shape)])
    r.section(SectionShape(r.shape, dims), r.elements, r.group == "TRUSSPROPS")


def _whole_section(r: _Reading, line: _SettingLine) -> None:
    found = statement_section(line.values)
    if found is not None:
        r.section(found[1], found[0], line.key == "TRUSSVIS")


def _hinge(r: _Reading, line: _SettingLine) -> None:
    if len(line.numbers) == 3:
        element, radius, length = line.numbers
        r.set(hinges=r.settings.hinges | {int(element): (radius, length)})


def _colour(r: _Reading, line: _SettingLine) -> None:
    colour = tuple(line.numbers)
    if len(colour) == 3 and line.key.startswith("FACE"):
        r.set(colours=r.settings.colours | dict.fromkeys(r.elements, colour))
    elif len(colour) == 3 and r.group == "INITIAL":
        r.set(initial_colour=colour)


def _traces_wanted(r: _Reading, value: float) -> None:
    r.traces = bool(value)


def _step_line(r: _Reading, value: float) -> None:
    if value > 0:
        r.set(step_line=value)


def _number(store: Callable[[_Reading, float], None]) -> Callable[[_Reading, _SettingLine], None]:
    """A setting that is one number; without it nothing is set."""
    return lambda r, line: store(r, line.numbers[0]) if line.numbers else None


def _unit(value: float) -> float:
    return min(max(value, 0.0), 1.0)


# First word of a line -> what it does.
WORDS: dict[str, Callable[[_Reading, _SettingLine], None]] = {
    **dict.fromkeys(("BEAMPROPS", "TRUSSPROPS", "GRAPHICS", "INITIAL"), _heading),
    "CROSSTYPE": _cross_type,
    "CROSSDIM": _cross_dimensions,
    **dict.fromkeys(("BEAMVIS", "TRUSSVIS"), _whole_section),
    "HINGEVIS": _hinge,
    **dict.fromkeys(("FACECOLOR", "FACECOLOUR", "COLOR", "COLOUR"), _colour),
    "OPACITY": _number(lambda r, v: r.set(opacities=r.settings.opacities | dict.fromkeys(r.elements, _unit(v)))),
    "DONOTDRAW": lambda r, line: r.set(hidden=r.settings.hidden | set(line.integers)),
    **dict.fromkeys(("TRANSPARENCY", "TRANSPERANCY"), _number(lambda r, v: r.set(opacity=_unit(v)))),
    "LIGHT": _number(lambda r, v: r.set(light=bool(v))),
    "TRAJECT": _number(_traces_wanted),
    "TRAJECTNODE": lambda r, line: r.set(traces=r.settings.traces + line.integers),
    "STEPLINE": _number(_step_line),
    "ENLARGEFACTOR": _number(lambda r, v: r.set(enlarge=v)),
    "VIBRATIONMODE": _number(lambda r, v: r.set(vibration_mode=int(v))),
    "BUCKLINGMODE": _number(lambda r, v: r.set(buckling_mode=int(v))),
}


def parse_settings(lines: Iterable[str]) -> PictureSettings:
    """The settings of the lines behind the word VISUALIZATION."""
    reading = _Reading()
    for text in lines:
        words = _words(text)
        if words and words[0].upper() in WORDS:
            numbers = [v for v in map(number_of, words[1:]) if v is not None and abs(v) <= 1e100]
            line = _SettingLine(words[0].upper(), words[1:], numbers)
            WORDS[line.key](reading, line)
    return reading.settings if reading.traces else replace(reading.settings, traces=())


def _words(line: str) -> list[str]:
    for mark in "%#;":
        line = line.partition(mark)[0]
    return line.split()


def statement_section(values: Sequence[str]) -> tuple[tuple[int, ...], SectionShape] | None:
    """Elements and section of `BEAMVIS [shape] [elements] dims`; None when the numbers do not suffice."""
    shape = values[0].upper() if values and values[0].upper() in DIMENSIONS else "RECT"
    numbers = [v for v in map(number_of, values) if v is not None]
    if any(abs(v) > 1e100 for v in numbers):
        return None
    n = DIMENSIONS[shape]
    if len(numbers) < n:
        return None
    split = len(numbers) - n
    return tuple(int(v) for v in numbers[:split]) or (ALL,), SectionShape(shape, tuple(numbers[split:]))
