"""The VISUALIZATION section of an input file (or NAME.spv): both spellings and generations (input-language.md 2).

Line oriented. Unknown lines are ignored, because later versions have more settings than are known to us. Readings that
the reference leaves open, decided here: TRANSPARENCY is the opacity of solids (1 opaque), CIRC takes the diameter,
CIRCHOL outer and inner diameter, RECTHOL outer width and height, then inner width and height, HINGEVIS radius and
length, STEPLINE the distance of the points on an elastic line in element lengths, ENLARGEFACTOR the factor on the
degrees of freedom of a mode that is scaled to norm 1.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from spacar.deck.lexer import number_of, scan, visualization_of

DIMENSIONS = {"RECT": 2, "RECTHOL": 4, "CIRC": 1, "CIRCHOL": 2, "LINE": 0}
ALL = 0  # the key of a setting that holds for all elements


@dataclass(frozen=True)
class Section:
    """A cross-section: RECT w h; RECTHOL w h inner w h; CIRC d; CIRCHOL d inner d; LINE. w along y', h along z' [m]."""

    shape: str
    dims: tuple[float, ...] = ()


@dataclass(frozen=True)
class Settings:
    """What the VISUALIZATION section says; None or empty: not said. Keys of tables: element numbers, 0 for all."""

    beams: dict[int, Section] = field(default_factory=dict)
    trusses: dict[int, Section] = field(default_factory=dict)
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

    def section(self, element: int, truss: bool = False) -> Section | None:
        table = self.trusses if truss else self.beams
        return table.get(element, table.get(ALL))

    def colour(self, element: int) -> tuple[float, float, float] | None:
        return self.colours.get(element, self.colours.get(ALL))

    def opacity_of(self, element: int) -> float:
        return self.opacities.get(element, self.opacities.get(ALL, self.opacity))


def read_settings(source: Path) -> Settings:
    """The settings in the input file or, when it has no section, in NAME.spv beside it; defaults without either."""
    lines: Sequence[str] = ()
    if source.is_file():
        lines = scan(source.read_text("utf-8", "replace")).visualization or ()
    beside = source.with_suffix(".spv")
    if not lines and beside.is_file():
        lines = visualization_of(beside.read_text("utf-8", "replace"))
    return parse_settings(lines)


def parse_settings(lines: Iterable[str]) -> Settings:
    """The settings of the lines behind the word VISUALIZATION."""
    settings = Settings()
    group: str = ""
    elements: tuple[int, ...] = (ALL,)  # the new style: a heading line, then lines that belong to it
    trace_wanted: bool | None = None
    shape = "RECT"
    for line in lines:
        words = _words(line)
        if not words:
            continue
        key, values = words[0].upper(), words[1:]
        numbers = [v for v in map(number_of, values) if v is not None and abs(v) <= 1e100]
        if key in ("BEAMPROPS", "TRUSSPROPS", "GRAPHICS"):
            group, elements, shape = key, tuple(int(v) for v in numbers) or (ALL,), "RECT"
        elif key == "INITIAL":
            group, elements = key, (ALL,)
        elif key == "CROSSTYPE" and values:
            shape = values[0].upper()
            if shape == "LINE":
                settings = _with_sections(settings, group == "TRUSSPROPS", elements, Section("LINE"))
        elif key == "CROSSDIM":
            n = DIMENSIONS.get(shape, len(numbers))
            settings = _with_sections(settings, group == "TRUSSPROPS", elements, Section(shape, tuple(numbers[:n])))
        elif key in ("BEAMVIS", "TRUSSVIS"):
            found = statement_section(values)
            if found is not None:
                settings = _with_sections(settings, key == "TRUSSVIS", *found)
        elif key == "HINGEVIS" and len(numbers) == 3:
            settings = replace(settings, hinges=settings.hinges | {int(numbers[0]): (numbers[1], numbers[2])})
        elif key in ("FACECOLOR", "FACECOLOUR") and len(numbers) == 3:
            rgb = (numbers[0], numbers[1], numbers[2])
            settings = replace(settings, colours=settings.colours | dict.fromkeys(elements, rgb))
        elif key in ("COLOR", "COLOUR") and group == "INITIAL" and len(numbers) == 3:
            settings = replace(settings, initial_colour=(numbers[0], numbers[1], numbers[2]))
        elif key == "OPACITY" and numbers:
            settings = replace(settings, opacities=settings.opacities | dict.fromkeys(elements, _unit(numbers[0])))
        elif key == "DONOTDRAW":
            settings = replace(settings, hidden=settings.hidden | {int(v) for v in numbers})
        elif key in ("TRANSPARENCY", "TRANSPERANCY") and numbers:
            settings = replace(settings, opacity=_unit(numbers[0]))
        elif key == "LIGHT" and numbers:
            settings = replace(settings, light=bool(numbers[0]))
        elif key == "TRAJECT" and numbers:
            trace_wanted = bool(numbers[0])
        elif key == "TRAJECTNODE":
            settings = replace(settings, traces=settings.traces + tuple(int(v) for v in numbers))
        elif key == "STEPLINE" and numbers and numbers[0] > 0:
            settings = replace(settings, step_line=numbers[0])
        elif key == "ENLARGEFACTOR" and numbers:
            settings = replace(settings, enlarge=numbers[0])
        elif key == "VIBRATIONMODE" and numbers:
            settings = replace(settings, vibration_mode=int(numbers[0]))
        elif key == "BUCKLINGMODE" and numbers:
            settings = replace(settings, buckling_mode=int(numbers[0]))
    return replace(settings, traces=()) if trace_wanted is False else settings


def _words(line: str) -> list[str]:
    for mark in "%#;":
        line = line.partition(mark)[0]
    return line.split()


def _unit(value: float) -> float:
    return min(max(value, 0.0), 1.0)


def statement_section(values: Sequence[str]) -> tuple[tuple[int, ...], Section] | None:
    """Elements and section of `BEAMVIS [shape] [elements] dims`; None when the numbers do not suffice."""
    shape = values[0].upper() if values and values[0].upper() in DIMENSIONS else "RECT"
    numbers = [v for v in map(number_of, values) if v is not None]
    if any(abs(v) > 1e100 for v in numbers):
        return None
    n = DIMENSIONS[shape]
    if len(numbers) < n:
        return None
    split = len(numbers) - n
    return tuple(int(v) for v in numbers[:split]) or (ALL,), Section(shape, tuple(numbers[split:]))


def _with_sections(settings: Settings, truss: bool, elements: Sequence[int], section: Section) -> Settings:
    if section.shape not in DIMENSIONS or len(section.dims) < DIMENSIONS[section.shape]:
        return settings
    if any(not 0 < d <= 1e100 for d in section.dims):
        return settings
    if truss:
        return replace(settings, trusses=settings.trusses | dict.fromkeys(elements, section))
    return replace(settings, beams=settings.beams | dict.fromkeys(elements, section))
