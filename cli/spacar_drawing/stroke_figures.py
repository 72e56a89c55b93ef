"""Curves of `spacar flexure` over the stroke, in the unit of length of the model.

Tables of `spacar flexure`: the same rows for the terminal and for the page, in the unit of length of the model.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from spacar.arrays import Array
from spacar.deck.length_unit import shown_in
from spacar.expressions import Unit, combine, unit_text
from spacar.stroke import Flexure
from spacar.stroke.flexure_results import Column
from spacar_drawing.curves import Curve
from spacar_drawing.defaults import plain
from spacar_drawing.history import history_figure, panels
from spacar_drawing.stage import INK

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

NOTHING = 1e-12  # of the size of the model, or rad: what is smaller is rounding and not shown
TRACE = 1e-4  # of the largest one of the same kind
ROUNDING = 1e-13  # of the largest value of a column
RIGID = "rigid"
MOST_FREQUENCIES = 3


@dataclass(frozen=True)
class StrokeTable:
    """A table with one row a state: heading, heads of the columns with units, texts, what is explained below it."""

    title: str
    heads: list[str]
    rows: list[list[str]]
    note: str


def stroke_tables(study: Flexure, body: bool) -> list[StrokeTable]:
    """Force and energy, motion, support stiffness, frequencies with buckling and stress."""
    c = by_name(study, body)
    axes = "axes of the node" if body else "global axes"
    hidden = ("u_", "rotation_") if study.errors.turning else ()
    motion = [m for m in study.motion_columns() if not m.name.startswith(hidden) and matters(study, m)]
    last = [*(name for name in frequencies(study) if name != "mises"), "mises", "mises_element", "mises_place"]
    ideal = "axis" if study.errors.turning else "line"
    if np.isnan(c["mises"].values).all():
        last = [name for name in last if not name.startswith("mises")]
    tables = [
        _table(study, "Force and energy", [c[n] for n in ("force", "drive_stiffness", "work", "energy")]),
        _table(study, f"Motion of node {study.node.position}", motion,
               f"errors against the {ideal} of the undeflected state"),
        _table(study, f"Support stiffness of node {study.node.position}, drive locked ({axes})",
               supported(study, c, "k")),
        _table(study, "Remaining support stiffness", [r for r in supported(study, c, "remaining") if _known(r)],
               "in % of the undeflected state"),
        _table(study, "Frequencies, buckling, stress", [c[n] for n in last if _known(c[n])],
               "f 1, f 2 ... with the drive locked, f 1 is the first unwanted one; f drive: of the free drive; "
               "margin: lowest multiplier of all loads"
               + (f", margin extra: of {' and '.join(study.extra)} alone" if study.extra else "")),
    ]  # fmt: skip
    return [table for table in tables if len(table.heads) > 1]


def by_name(study: Flexure, body: bool = False) -> dict[str, Column]:
    return {c.name: c for c in study.columns(body)}


def supported(study: Flexure, columns: dict[str, Column], kind: str) -> list[Column]:
    """Those of the support, kind "k" or "remaining"."""
    return [columns[f"{kind}_{study.directions[i]}"] for i in study.support]


def frequencies(study: Flexure) -> list[str]:
    """Names of the first frequencies with the drive locked, that of the drive, load multipliers, stress."""
    first = [f"f_{i}" for i in range(1, 1 + min(MOST_FREQUENCIES, study.frequencies.shape[1]))]
    extra = ["margin_extra", "margin_extra_free"] if study.extra else []
    return [*first, "f_drive", "margin", "margin_free", *extra, "mises"]


def errors(study: Flexure, of_axis: tuple[str, ...], of_line: tuple[str, ...]) -> list[Column]:
    """Errors of these kinds that are more than a trace."""
    kinds = of_axis if study.errors.turning else of_line
    return [c for c in study.motion_columns() if c.name.startswith(kinds) and matters(study, c)]


def shown_column(study: Flexure, column: Column) -> tuple[str, Array]:
    """Unit and values in the unit of length of the model; ratios in %."""
    if column.name.startswith("remaining"):
        return "%", 100.0 * column.values
    factor, unit = shown_in(column.unit, study.metre)
    finite = np.abs(column.values[np.isfinite(column.values)])
    still = np.abs(column.values) <= ROUNDING * finite.max(initial=0.0)
    return unit, factor * np.where(still, 0.0, column.values)


def cell_text(value: float, digits: int = 5) -> str:
    """`rigid` for an infinite stiffness, nothing for what is not known."""
    if value != value:
        return ""
    return RIGID if np.isinf(value) else f"{float(value) + 0.0:.{digits}g}"


def _known(column: Column) -> bool:
    return not bool(np.isnan(column.values).all())


def matters(study: Flexure, column: Column) -> bool:
    """Is it more than rounding, and more than a trace beside the same of the other axes?"""
    kind = column.name[: column.name.rfind("_")]
    group = [c for c in study.motion_columns() if c.name[: c.name.rfind("_")] == kind]
    length = study.result.mechanism.length if column.unit == "m" else 1.0
    largest = max(np.nanmax(np.abs(c.values), initial=0.0) for c in group)
    return bool(np.nanmax(np.abs(column.values), initial=0.0) > max(NOTHING * length, TRACE * largest))


def _table(study: Flexure, title: str, columns: list[Column], note: str = "") -> StrokeTable:
    heads, texts = [], []
    for c in (by_name(study)["stroke"], *columns):
        unit, values = shown_column(study, c)
        name = c.name.removeprefix("remaining_").replace("mises_", "").replace("_", " ")
        heads.append(f"{name} ({unit})" if unit and unit != "%" else name)
        texts.append([_text(c, v) for v in values.tolist()])
    return StrokeTable(title, heads, [list(row) for row in zip(*texts, strict=True)], note)


def _text(column: Column, value: float) -> str:
    if column.name.startswith("margin") and np.isinf(value):
        return "none"
    if column.name == "mises_element":
        return str(int(value)) if value else ""
    return cell_text(value, 4 if column.name.startswith("remaining") else 5)


DENSE = 201  # points of a curve
KINK = 4.0
HIDDEN = 0.02  # of its range: a curve this near to another one hides it


def overview_figure(study: Flexure, body: bool) -> Figure:
    """What is left of the support stiffness, the error motions, first frequencies, and the largest stress."""
    c = by_name(study, body)
    left = [r for r in supported(study, c, "remaining") if np.isfinite(r.values).any()]
    rest = [c[name] for name in ("f_1", "f_drive", "mises") if np.isfinite(c[name].values).sum() > 1]
    return _figure(study, [*left, *errors(study, ("pivot_",), ("line_",)), *rest] or [c["force"]])


def all_figures(study: Flexure, body: bool) -> list[tuple[Figure, str]]:
    """Every figure that has something to show, with its caption; a support that is rigid in all directions has none."""
    c = by_name(study, body)
    k, left = ([s for s in supported(study, c, kind) if np.isfinite(s.values).any()] for kind in ("k", "remaining"))
    made = (
        ([c[n] for n in ("force", "drive_stiffness", "energy")],
         "Actuator force, its derivative by the stroke, and stored energy."),
        (errors(study, ("pivot_", "tilt_"), ("line_", "rotation_")),
         "Pivot shift and tilt of the axis." if study.errors.turning
         else "Deviation from the ideal line, and rotations."),
        ([*k, *left] if k else [], "Support stiffness with the drive locked, and what remains of it."),
        ([c[name] for name in frequencies(study) if np.isfinite(c[name].values).sum() > 1],
         "Frequencies with the drive locked and of the free drive, lowest load multipliers, largest stress."),
    )  # fmt: skip
    return [(_figure(study, columns), caption) for columns, caption in made if columns]


@plain
def _figure(study: Flexure, columns: Sequence[Column]) -> Figure:
    """A panel for every unit; columns of one kind ("support stiffness, y") have the kind on the axis. Stiffnesses and
    load multipliers have logarithmic scales."""
    across = _curve(study, by_name(study)["stroke"])
    curves = [_curve(study, c) for c in columns]
    kinds: dict[object, str] = {}
    for unit in dict.fromkeys(c.unit for c in curves):
        group = [c for c in curves if c.unit == unit]
        heads = {c.text.partition(", ")[0] for c in group}
        if len(group) > 1 and len(heads) == 1:
            kinds[unit] = heads.pop()
    shorter = [replace(c, text=c.text.partition(", ")[2]) if c.unit in kinds else c for c in curves]
    figure = history_figure(shorter, across)
    logarithmic = {c.unit for c, of in zip(curves, columns, strict=True) if of.name.startswith(("k_", "margin"))}
    for axes, group in zip(figure.axes, panels(shorter), strict=True):
        if group[0].unit in kinds:
            text, kind = unit_text(group[0].unit), kinds[group[0].unit]
            axes.set_ylabel(f"{kind} ({text})" if text else kind)
        _smooth(axes)
        if group[0].unit in logarithmic:
            _logarithmic(axes)
    return figure


def _smooth(axes: Axes) -> None:
    """Marks at the computed states and a smooth curve between them; dashes where a curve would hide another one."""
    shown: list[np.ndarray] = []
    legend = axes.get_legend()
    named = list(axes.lines) if legend is None else legend.get_lines()
    for line, sample in zip(list(axes.lines), named, strict=True):
        x, y = (np.asarray(v, float) for v in line.get_data())
        span = np.ptp(y[np.isfinite(y)]) if np.isfinite(y).any() else 0.0
        hidden = sum(np.allclose(y, other, rtol=0.0, atol=HIDDEN * span, equal_nan=True) for other in shown)
        shown.append(y)
        if hidden:
            for each in (line, sample):
                each.set_linestyle((0, (4, 3 + 4 * hidden)))
                each.set_linewidth(1.4 + 0.5 * hidden)
        axes.plot(x, y, "o", ms=3.0, color=line.get_color())
        if len(x) > 2 and np.isfinite(y).all() and np.all(np.diff(x) > 0.0):
            line.set_data(*smooth(x, y))


def smooth(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The cubic that keeps the monotony of y (n,) over x (n,), n > 2; a place where the slope changes KINK times as
    much as elsewhere (the size of what changes its sign) stays a kink."""
    from scipy.interpolate import PchipInterpolator

    bends = np.abs(np.diff(np.diff(y) / np.diff(x)))
    k = int(np.argmax(bends))
    others = np.delete(bends, k)
    cuts = [0, len(x) - 1]
    if len(others) and bends[k] > KINK * others.max():
        cuts.insert(1, k + 1)
    parts = []
    for a, b in pairwise(cuts):
        dense = np.union1d(x[a : b + 1], np.linspace(x[a], x[b], DENSE))
        part = y[a : b + 1]
        at = PchipInterpolator(x[a : b + 1], part)(dense) if b > a + 1 else np.interp(dense, x[a : b + 1], part)
        parts.append((dense, at))
    return np.concatenate([v for v, _ in parts]), np.concatenate([v for _, v in parts])


def _logarithmic(axes: Axes) -> None:
    """Where the values span more than a decade and have one sign."""
    values = np.concatenate([np.asarray(line.get_ydata(), float) for line in axes.lines])
    values = values[np.isfinite(values)]
    if not len(values) or values.min() <= 0.0 or values.max() < 10.0 * values.min():
        return
    axes.set_yscale("log")
    axes.tick_params(axis="y", which="both", labelsize=8, colors=INK, length=0)


def _curve(study: Flexure, column: Column) -> Curve:
    unit, values = shown_column(study, column)
    return Curve(column.title, np.where(np.isfinite(values), values, np.nan), symbols(unit), "")


def symbols(text: str) -> Unit:
    """The unit of a text such as "N mm/rad" or "N/m^2"."""
    words = ([word.partition("^") for word in part.split()] for part in text.partition("/")[::2])
    above, below = (tuple((name, int(power or 1)) for name, _, power in part) for part in words)
    return combine(above, below, -1)
