"""Types of numbers on the command line: finite, in a range, with a sentence for what is not."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import click

LARGEST, SMALLEST = 1e100, 1e-100  # as in input files: squares and products of such numbers are still numbers
MOST = 10**15


class Real(click.FloatRange):
    """A finite number, of a size between 1e-100 and 1e100 or zero, inside `min` ... `max`."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        number: float = click.FLOAT.convert(value, param, ctx)
        if not math.isfinite(number):
            self.fail(f"{value!r} is not a finite number", param, ctx)
        if number and not SMALLEST <= abs(number) <= LARGEST:
            self.fail(f"{value} is outside of {SMALLEST:g} ... {LARGEST:g}", param, ctx)
        result: float = super().convert(number, param, ctx)
        return result

    def _describe_range(self) -> str:
        """The range in the help; nothing where there is none."""
        return "" if self.min is None and self.max is None else super()._describe_range()


class Whole(click.IntRange):
    """A whole number inside `min` ... `max`, at most 1e15: far more than can be counted, and exact as a real."""

    def __init__(self, min: int | None = None, max: int | None = None) -> None:
        super().__init__(-MOST if min is None else min, MOST if max is None else max)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> int:
        if isinstance(value, str) and len(value) > 40:
            self.fail(f"a whole number of at most 15 digits is needed, not {len(value)} characters", param, ctx)
        number: int = click.INT.convert(value, param, ctx)
        if abs(number) > MOST:
            self.fail(f"a whole number of at most 15 digits is needed, not {number}", param, ctx)
        result: int = super().convert(number, param, ctx)
        return result

    def _describe_range(self) -> str:
        """The range in the help, without the limits that nobody meets."""
        low = "" if self.min == -MOST else f"x>={self.min}"
        return low if self.max == MOST else f"{self.min}<=x<={self.max}"


class StepNumber(Whole):
    """The number of a stored step: from 1; counted from the end where it is negative, `end` the last one."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> int:
        return -1 if value == "end" else super().convert(value, param, ctx)


class TablePath(click.Path):
    """The name of a file, or - for standard output; another word that begins with - is a forgotten name."""

    def __init__(self) -> None:
        super().__init__(allow_dash=True, path_type=Path)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if isinstance(value, str) and value.startswith("-") and value != "-":
            self.fail(f"'{value}' is no name of a file; - prints the rows", param, ctx)
        return super().convert(value, param, ctx)


POSITIVE = Real(min=0.0, min_open=True)
TOLERANCE = Real(min=0.0, min_open=True, max=1.0)
STEPS = Whole(min=1)
