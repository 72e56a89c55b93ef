"""Expressions of a drawn result as curves with units; the language is that of spacar.expressions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from spacar import expressions
from spacar.errors import UsageError
from spacar.expressions import Dimensions, Unit

if TYPE_CHECKING:
    from spacar_drawing.source import Source


@dataclass(frozen=True)
class Curve:
    """An evaluated expression, (steps,); `variable` is its name when it is a single variable, else empty."""

    text: str
    values: NDArray[np.float64]
    unit: Unit | None
    variable: str


@dataclass(frozen=True)
class _Variables:
    """The variables of a source as the language reads them."""

    source: Source

    @property
    def lnp(self) -> NDArray[np.int64]:
        return self.source.scene.lnp

    @property
    def le(self) -> NDArray[np.int64]:
        return self.source.scene.le

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        return self.source.get(name)


def evaluate(source: Source, text: str) -> Curve:
    """The values of an expression at all steps, with its unit. Raises UsageError with the reason."""
    if source.named and text.strip() != "t":
        return _named(source, text.strip())
    scene = source.scene
    dimensions = Dimensions(scene.planar, scene.analysis.stationary, frozenset(scene.position_nodes), scene.keywords)
    expression = expressions.parse(text)
    values, unit = expressions.evaluate(expression, _Variables(source), dimensions)
    if np.iscomplexobj(values):
        raise UsageError(f"'{text}' is complex; plot its abs(), real() or imag()", "plot.complex")
    if not np.isfinite(values).any():
        raise UsageError(f"'{text}' is nowhere a finite number", "plot.finite")
    every = np.broadcast_to(np.asarray(values, float), (source.steps,))
    return Curve(expression.text, every, unit, expression.variable)


def warnings(curves: Sequence[Curve]) -> list[str]:
    """What a user should know before trusting a curve: values that cannot be shown."""
    found = []
    for curve in curves:
        bad = int(np.count_nonzero(~np.isfinite(curve.values)))
        if bad:
            found.append(f"'{curve.text}' is not a finite number at {bad} of {np.size(curve.values)} steps")
    return found


def _named(source: Source, text: str) -> Curve:
    """A quantity of a symbolic result, by its name: its unit is that of the model, which nobody stated."""
    if text not in source.named:
        raise UsageError(f"'{text}' is none of t, {', '.join(source.named)}", "plot.name")
    values = np.asarray(source.named[text], float)
    if not np.isfinite(values).any():
        raise UsageError(f"'{text}' is nowhere a finite number", "plot.finite")
    return Curve(text, values, expressions.NONE, text)
