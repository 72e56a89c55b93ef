"""Curves over time, or against another expression, in one panel per unit.

The scopes of a simulation: as a figure of their own, and beside the mechanism with a line at the time shown.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from spacar_formats.signal_tables import Panel, SignalTable

from spacar.arrays import Array
from spacar.errors import escaped
from spacar.expressions import MEANING, NONE, unit_text
from spacar_drawing.curves import Curve, panel_title
from spacar_drawing.defaults import plain
from spacar_drawing.drawn_shapes import together
from spacar_drawing.stage import INK, blank, dress, widened

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS = ("#2f74b5", "#c2703d", "#3d8b5f", "#8e5ea2", "#c0272d", "#6b4a2b", "#5d6d7a", "#b8a11b")
PANEL = 2.15  # inches
LEGEND, LINE = 104, 7  # letters in a row of the legend; what the line before a name takes of them


def axis_text(curve: Curve) -> str:
    """`x[6,1] (m)`; just the text for a pure number."""
    text = unit_text(curve.unit)
    return f"{curve.text} ({text})" if text else curve.text


def panels(curves: Sequence[Curve]) -> list[list[Curve]]:
    """Curves of the same variable, or of expressions with the same unit, together, in the given order."""
    return list(together(((c.variable, c.unit, c.group), c) for c in curves).values())


def panel_text(group: Sequence[Curve]) -> str:
    if group[0].group:
        return group[0].group
    if len(group) == 1:
        return axis_text(group[0])
    text = unit_text(group[0].unit)
    name = MEANING.get(group[0].variable, "value")
    return f"{name} ({text})" if text else name


def _powers(axes: Axes, numbers: float) -> None:
    """A power of ten beside large and small numbers, and room above the curves."""
    axes.margins(y=0.08)
    axes.ticklabel_format(axis="y", scilimits=(-4, 5), useMathText=True, useOffset=False)
    axes.yaxis.get_offset_text().set(fontsize=numbers, color=INK)


@plain
def history_figure(curves: Sequence[Curve], against: Curve, title: str = "", stationary: bool = False) -> Figure:
    """Panels above each other with a common horizontal axis."""
    groups = panels(curves)
    n = len(groups)
    rows = [-(-len(g) // _columns(g)) - 1 for g in groups]  # of the legends, beyond the first
    height = (n * PANEL + 0.85 if n > 1 else 3.6) + 0.17 * rows[0] + 0.17 * (n - 1) * max(rows)
    figure = blank(7.2, height)
    all_axes = figure.subplots(n, 1, sharex=True, squeeze=False)[:, 0]
    across = np.asarray(against.values)
    few = len(across) < 3
    for axes, group in zip(all_axes, groups, strict=True):
        for k, c in enumerate(group):
            colour, form = COLOURS[k % len(COLOURS)], "o-" if few else "-"
            axes.plot(across, c.values, form, color=colour, lw=1.4, ms=4, label=c.text)
        dress(axes, "", panel_text(group))
        _powers(axes, 8.0)
        axes.margins(x=0.0 if against.variable == "t" and not few else 0.05)
        if len(group) > 1 or group[0].group:
            axes.legend(
                fontsize=8, frameon=False, ncols=_columns(group), loc="lower left", borderpad=0.1,
                bbox_to_anchor=(0.06, 1.0),  # beside the power of ten of the axis
            )  # fmt: skip
    label = ("load step" if stationary else "time t (s)") if against.variable == "t" else axis_text(against)
    all_axes[-1].set_xlabel(label, fontsize=8.5, color=INK, parse_math=False)
    figure.align_ylabels(all_axes)
    named = len(groups[0]) > 1 or groups[0][0].group != ""
    top = (0.15, 0.45, 0.62)[(title != "") + named] + 0.17 * rows[0]
    figure.subplots_adjust(
        left=0.12, right=0.965, bottom=0.52 / height, top=1 - top / height,
        hspace=(0.32 if any(len(g) > 1 or g[0].group for g in groups) else 0.16) + 0.1 * max(rows),
    )  # fmt: skip
    if title:
        figure.text(0.12, 1 - 0.12 / height, escaped(title), fontsize=10, color=INK, va="top", parse_math=False)
    return figure


def _columns(group: Sequence[Curve]) -> int:
    """Names of curves in a row of the legend: as many as fit into the width, their lines included."""
    return max(min(len(group), LEGEND // (max(len(c.text) for c in group) + LINE)), 1)


WIDTH = 3.6  # inches of the scopes beside a mechanism
MOST_BESIDE = 4  # panels beside a mechanism; more are too small to be read


@plain
def scope_figure(table: SignalTable, t: Array, panels: Sequence[Panel], title: str) -> Figure:
    """The panels above each other over time [s]."""
    curves = [
        Curve(label, table.values[:, k], NONE, "", panel_title(p))
        for p in panels
        for k, label in zip(p.columns, p.labels, strict=True)
    ]
    return history_figure(curves, Curve("t", np.asarray(t), NONE, "t"), title)


class TimeLine:
    """Scopes in a part of a figure, with a line that `show` moves to a time. `left` inches of the figure stay free."""

    def __init__(self, figure: Figure, table: SignalTable, t: Array, left: float = 0.0) -> None:
        width, height = figure.get_size_inches()
        shown = table.panels[:MOST_BESIDE]
        x, wide = (left + 0.55) / width, (width - left - 0.75) / width
        each = (height - 0.45) / len(shown)
        self.figure, self.lines = figure, []
        for i, panel in enumerate(shown):
            bottom, last = 0.45 + (len(shown) - 1 - i) * each, i == len(shown) - 1
            axes = figure.add_axes((x, bottom / height, wide, (each - 0.36) / height))
            for n, (k, label) in enumerate(zip(panel.columns, panel.labels, strict=True)):
                axes.plot(t, table.values[:, k], color=COLOURS[n % len(COLOURS)], lw=1.1, label=escaped(label))
            axes.set_title(escaped(panel_title(panel)), fontsize=8, color=INK, loc="left", pad=3, parse_math=False)
            dress(axes, numbers=7.0)
            _powers(axes, 7.0)
            axes.tick_params(labelbottom=last)
            axes.margins(x=0.0)
            if len(panel.columns) > 1 and max(map(len, panel.labels)) < 16:
                axes.legend(fontsize=6.5, frameon=False, loc="best", handlelength=1.2, borderpad=0.1, labelspacing=0.2)
            if last:
                axes.set_xlabel("time t (s)", fontsize=8, color=INK)
            self.lines.append(axes.axvline(float(t[0]), color=INK, lw=0.9))

    def show(self, time: float) -> None:
        for line in self.lines:
            line.set_xdata([time, time])
        self.figure.canvas.draw_idle()


def beside(figure: Figure, table: SignalTable, t: Array) -> TimeLine:
    """Scopes to the right of what a figure shows; the figure becomes wider."""
    return TimeLine(figure, table, t, widened(figure, WIDTH))
