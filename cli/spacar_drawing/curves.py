"""Expressions of a drawn result as curves with units; the language is that of spacar.expressions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from spacar import expressions
from spacar.deck.length_unit import shown_in
from spacar.errors import UsageError
from spacar.expressions import NONE, Dimensions, Unit
from spacar_drawing.named_source import named_values
from spacar_drawing.signal_curves import columns_of, expression_of_signals

if TYPE_CHECKING:
    from spacar_drawing.picture_source import PictureSource


@dataclass(frozen=True)
class Curve:
    """An evaluated expression, (steps,); `variable` is its name when it is a single variable, else empty."""

    text: str
    values: NDArray[np.float64]
    unit: Unit | None
    variable: str
    group: str = ""  # curves with the same one share a panel, which it names


@dataclass(frozen=True)
class _Variables:
    """The variables of a source as the language reads them."""

    source: PictureSource

    @property
    def lnp(self) -> NDArray[np.int64]:
        return self.source.scene.lnp

    @property
    def le(self) -> NDArray[np.int64]:
        return self.source.scene.le

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        return self.source.get(name)


def curves_of(source: PictureSource, text: str) -> list[Curve]:
    """The curve of an expression, or the curves of a block or scope of a simulation. Raises UsageError."""
    table = source.signals
    found = None if table is None else columns_of(table, text)
    if table is None or found is None:
        return [evaluate(source, text)]
    block, columns = found
    panel = next((p for p in table.panels if set(columns) <= set(p.columns)), None)
    group = block if panel is None else f"{panel.title} ({panel.unit})" if panel.unit else panel.title
    names = {k: table.names[k] for k in columns}
    if panel is not None:
        names |= dict(zip(panel.columns, panel.labels, strict=True))
    return [_shown(source, Curve(names[k], table.values[:, k], NONE, "", group)) for k in columns]


def evaluate(source: PictureSource, text: str) -> Curve:
    """The values of an expression at all steps, with its unit. Raises UsageError with the reason."""
    if source.signals is not None:
        single = columns_of(source.signals, text)
        if single is not None:
            if len(single[1]) != 1:
                raise UsageError(f"'{text}' stands for {len(single[1])} signals, one is needed here", "plot.signal")
            return curves_of(source, text)[0]
        mixed = expression_of_signals(source, source.signals, text)
        if mixed is not None:
            return _shown(source, Curve(text.strip(), mixed, NONE, ""))
        if not source.scene.lnp.size and text.strip() == "t":
            return _shown(source, Curve("t", np.ravel(source.get("t")), NONE, "t"))
        if not source.scene.lnp.size:
            known = ", ".join(dict.fromkeys(source.signals.blocks))
            raise UsageError(f"'{text}': what is plotted here is t, and BLOCK:NUMBER of {known}", "plot.signal")
    if source.named:
        found, name = named_values(source, text)
        return _shown(source, Curve(text.strip(), found, NONE, name))
    scene = source.scene
    dimensions = Dimensions(scene.planar, scene.analysis.stationary, frozenset(scene.position_nodes), scene.keywords)
    expression = expressions.parse(text)
    values, unit = expressions.evaluate(expression, _Variables(source), dimensions)
    if np.iscomplexobj(values):
        raise UsageError(f"'{text}' is complex; plot its abs(), real() or imag()", "plot.complex")
    return _shown(source, Curve(expression.text, values, unit, expression.variable))


def in_units(curve: Curve, metre: float) -> Curve:
    """The curve in the unit of length of the input, for pictures and tables; as it is where its unit is not known."""
    if metre == 1.0 or not curve.unit:
        return curve
    powers = dict(curve.unit)
    power = powers.pop("m", 0)
    if power:
        powers[shown_in("m", metre)[1]] = power
    return replace(curve, values=np.asarray(curve.values) * metre**-power, unit=tuple(sorted(powers.items())))


def _shown(source: PictureSource, curve: Curve) -> Curve:
    """The curve with a value at every step. Raises UsageError when none of them can be shown."""
    if not np.isfinite(curve.values).any():
        raise UsageError(f"'{curve.text}' is nowhere a finite number", "plot.finite")
    return replace(curve, values=np.broadcast_to(np.asarray(curve.values, float), (source.steps,)))


def warnings(curves: Sequence[Curve]) -> list[str]:
    """What a user should know before trusting a curve: values that cannot be shown."""
    found = []
    for curve in curves:
        bad = int(np.count_nonzero(~np.isfinite(curve.values)))
        if bad:
            found.append(f"'{curve.text}' is not a finite number at {bad} of {np.size(curve.values)} steps")
    return found
