"""Options that several drawing commands share, and how they change the settings of the input file."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from spacar_drawing.mechanism_picture import Extras
from spacar_drawing.picture_source import PictureSource, open_source
from spacar_drawing.scene import check_numbers
from spacar_drawing.settings import ALL, DIMENSIONS, SectionShape, statement_section
from spacar_drawing.symbols import KINDS

from spacar.errors import UsageError
from spacar_cli import vocabulary as words

PICTURES = ": a picture, by its ending png, svg or pdf. May be repeated."
FILMS = ": a picture, by its ending png, svg, pdf, gif (no other program needed), mp4 (needs ffmpeg). May be repeated."
SHAPES = ': "[RECT|RECTHOL|CIRC|CIRCHOL|I|LINE] [elements] dimensions", as in section VISUALIZATION. May be repeated.'
common = words.options((
    words.option("output", FILMS, multiple=True), words.option("view", ", as -60,25", default="iso"),
    words.option("sections", SHAPES, multiple=True), words.option("opacity"), words.option("light", default=None),
    words.option("hide", "May be repeated.", multiple=True), words.option("supports", default=True),
    words.option("numbers", "; orientation nodes in brackets, element numbers in boxes."),
    words.option("node_numbers"), words.option("element_numbers"), words.option("title"),
    words.option("dpi", default=150.0), words.option("fps", default=25.0), words.option("show"),
    words.option("stale_ok"),
))  # fmt: skip


@dataclass(frozen=True)
class Choices:
    """The values of the shared options."""

    output: tuple[Path, ...]
    view: str
    sections: tuple[str, ...]
    opacity: float | None
    light: bool | None
    hide: tuple[int, ...]
    supports: bool
    numbers: bool
    node_numbers: bool
    element_numbers: bool
    title: str | None
    dpi: float
    fps: float
    show: bool
    stale_ok: bool

    def opened(self, file: str) -> PictureSource:
        """A result, with the settings of the file and of the command line. Raises UsageError."""
        source = open_source(file, self.stale_ok)
        check_numbers(self.hide, [e.number for e in source.scene.elements], "--hide: element")
        settings = source.settings
        if self.sections:
            settings = replace(settings, beams=settings.beams | sections_of(self.sections))
        if self.opacity is not None:
            settings = replace(settings, opacity=self.opacity, opacities={})
        if self.light is not None:
            settings = replace(settings, light=self.light)
        return replace(source, settings=replace(settings, hidden=settings.hidden | set(self.hide)))

    def extras(self) -> Extras:
        return Extras(
            self.numbers or self.node_numbers, self.numbers or self.element_numbers, self.supports, self.view,
            self.title,
        )  # fmt: skip


def symbol_kinds(text: str | None) -> tuple[str, ...]:
    """The kinds of `--symbols`, all of them for "all". Raises UsageError."""
    wanted = [word.strip().lower() for word in (text or "").split(",") if word.strip()]
    for word in wanted:
        if word not in (*KINDS, "all"):
            raise UsageError(f"--symbols {word}: expected {', '.join(KINDS)}, with commas between, or all")
    return KINDS if "all" in wanted else tuple(wanted)


def sections_of(texts: Sequence[str]) -> dict[int, SectionShape]:
    """The cross-sections of `--section` values. Raises UsageError."""
    found: dict[int, SectionShape] = {}
    for text in texts:
        read = statement_section(text.split())
        if read is None or any(not 0 < d <= 1e100 for d in read[1].dims):
            forms = ", ".join(f"{name} with {n} dimensions" for name, n in DIMENSIONS.items())
            wanted = "a shape, element numbers (none: all) and positive dimensions"
            raise UsageError(f"--section {text}: expected {wanted}; {forms}")
        if ALL in read[0]:
            found = {}
        found |= dict.fromkeys(read[0], read[1])
    return found
