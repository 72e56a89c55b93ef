"""Options that several drawing commands share, and how they change the settings of the input file."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from spacar_drawing.mechanism_picture import Extras
from spacar_drawing.settings import ALL, DIMENSIONS, PictureSettings, SectionShape

from spacar.errors import UsageError
from spacar_cli import vocabulary as words

PICTURES = ": a picture, by its ending png, svg or pdf. May be repeated."
COMMON = (
    words.option(
        "output",
        ": a picture, by its ending png, svg, pdf, gif (no other program needed), mp4 (needs ffmpeg). May be repeated.",
        multiple=True,
    ),
    words.option("view", ", as -60,25", default="iso"),
    words.option(
        "sections",
        ': "[RECT|RECTHOL|CIRC|CIRCHOL|LINE] [elements] dimensions", as in the VISUALIZATION section. May be repeated.',
        multiple=True,
    ),
    words.option("opacity"),
    words.option("light", default=None),
    words.option("hide", "May be repeated.", multiple=True),
    words.option("supports", default=True),
    words.option("numbers", "; orientation nodes in brackets, element numbers in boxes."),
    words.option("node_numbers"),
    words.option("element_numbers"),
    words.option("title"),
    words.option("dpi", default=150.0),
    words.option("fps", default=25.0),
    words.option("show"),
    words.option("stale_ok"),
)


def common(function: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options that `draw` and `visual` share."""
    for option in reversed(COMMON):
        function = option(function)
    return function


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

    def extras(self) -> Extras:
        return Extras(
            self.numbers or self.node_numbers, self.numbers or self.element_numbers, self.supports, self.view,
            self.title,
        )  # fmt: skip

    def overridden(self, settings: PictureSettings) -> PictureSettings:
        """The settings of the file with those of the command line in their place. Raises UsageError."""
        if self.sections:
            settings = replace(settings, beams=settings.beams | sections_of(self.sections))
        if self.opacity is not None:
            settings = replace(settings, opacity=self.opacity, opacities={})
        if self.light is not None:
            settings = replace(settings, light=self.light)
        return replace(settings, hidden=settings.hidden | set(self.hide))


def symbol_kinds(text: str | None) -> tuple[str, ...]:
    """The kinds of `--symbols`, all of them for "all". Raises UsageError."""
    from spacar_drawing.symbols import KINDS

    words = [word.strip().lower() for word in (text or "").split(",") if word.strip()]
    for word in words:
        if word not in (*KINDS, "all"):
            raise UsageError(f"--symbols {word}: expected {', '.join(KINDS)}, with commas between, or all")
    return KINDS if "all" in words else tuple(words)


def sections_of(texts: Sequence[str]) -> dict[int, SectionShape]:
    """The cross-sections of `--section` values. Raises UsageError."""
    from spacar_drawing.settings import statement_section

    found: dict[int, SectionShape] = {}
    for text in texts:
        read = statement_section(text.split())
        if read is None or any(not 0 < d <= 1e100 for d in read[1].dims):
            forms = ", ".join(f"{name} with {n} dimensions" for name, n in DIMENSIONS.items())
            raise UsageError(
                f"--section {text}: expected a shape, element numbers (none: all) and positive dimensions; {forms}"
            )
        if ALL in read[0]:
            found = {}
        found |= dict.fromkeys(read[0], read[1])
    return found


def check_elements(numbers: Sequence[int], known: Sequence[int], option: str) -> None:
    """Raises UsageError for a number that is not in the model."""
    for n in numbers:
        if n not in known:
            raise UsageError(f"{option} {n} does not exist; the model has {_ranges(known)}")


def _ranges(numbers: Sequence[int]) -> str:
    return ", ".join(map(str, numbers)) if len(numbers) <= 20 else f"{numbers[0]} to {numbers[-1]}"
