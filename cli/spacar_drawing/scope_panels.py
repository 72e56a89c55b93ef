"""The scopes of a simulation: as a figure of their own, and beside the mechanism with a line at the time shown."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from spacar_formats.signal_tables import Panel, SignalTable

from spacar.arrays import Array
from spacar.errors import escaped
from spacar.expressions import NONE
from spacar_drawing.curves import Curve
from spacar_drawing.defaults import plain
from spacar_drawing.history import COLOURS, history_figure
from spacar_drawing.stage import INK, RULE

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDTH = 3.6  # inches of the scopes beside a mechanism
MOST_BESIDE = 4  # panels beside a mechanism; more are too small to be read


@plain
def scope_figure(table: SignalTable, t: Array, panels: Sequence[Panel], title: str) -> Figure:
    """The panels above each other over time [s]."""
    curves = [
        Curve(label, table.values[:, k], NONE, "", f"{p.title} ({p.unit})" if p.unit else p.title)
        for p in panels
        for k, label in zip(p.columns, p.labels, strict=True)
    ]
    return history_figure(curves, Curve("t", np.asarray(t), NONE, "t"), title)


class TimeLine:
    """Panels in a part of a figure, with a line that `show` moves to a time. `left` inches of the figure stay free."""

    def __init__(
        self, figure: Figure, table: SignalTable, t: Array, panels: Sequence[Panel], left: float = 0.0
    ) -> None:
        width, height = figure.get_size_inches()
        shown = list(panels)[:MOST_BESIDE]
        x, wide = (left + 0.55) / width, (width - left - 0.75) / width
        each = (height - 0.45) / len(shown)
        self.figure, self.lines = figure, []
        for i, panel in enumerate(shown):
            bottom, last = 0.45 + (len(shown) - 1 - i) * each, i == len(shown) - 1
            axes = figure.add_axes((x, bottom / height, wide, (each - 0.36) / height))
            _fill(axes, table, t, panel, last)
            self.lines.append(axes.axvline(float(t[0]), color=INK, lw=0.9))

    def show(self, time: float) -> None:
        for line in self.lines:
            line.set_xdata([time, time])
        self.figure.canvas.draw_idle()


def beside(figure: Figure, table: SignalTable, t: Array, panels: Sequence[Panel]) -> TimeLine:
    """Panels to the right of what a figure shows; the figure becomes wider."""
    width, height = figure.get_size_inches()
    part = width / (width + WIDTH)
    for axes in figure.axes:
        box = axes.get_position()
        axes.set_position((box.x0 * part, box.y0, box.width * part, box.height))
    figure.set_size_inches(width + WIDTH, height)
    return TimeLine(figure, table, t, panels, width)


def _fill(axes: Any, table: SignalTable, t: Array, panel: Panel, last: bool) -> None:
    for i, (k, label) in enumerate(zip(panel.columns, panel.labels, strict=True)):
        axes.plot(t, table.values[:, k], color=COLOURS[i % len(COLOURS)], lw=1.1, label=escaped(label))
    unit = f" ({panel.unit})" if panel.unit else ""
    axes.set_title(escaped(panel.title + unit), fontsize=8, color=INK, loc="left", pad=3, parse_math=False)
    axes.grid(True, color=RULE, lw=0.6)
    axes.set_axisbelow(True)
    axes.tick_params(labelsize=7, colors=INK, length=0, labelbottom=last)
    axes.margins(x=0.0, y=0.08)
    axes.ticklabel_format(axis="y", scilimits=(-4, 5), useMathText=True, useOffset=False)
    axes.yaxis.get_offset_text().set(fontsize=7, color=INK)
    for side in axes.spines.values():
        side.set(color="#cfd5da", linewidth=0.8)
    if len(panel.columns) > 1 and max(map(len, panel.labels)) < 16:
        axes.legend(fontsize=6.5, frameon=False, loc="best", handlelength=1.2, borderpad=0.1, labelspacing=0.2)
    if last:
        axes.set_xlabel("time t (s)", fontsize=8, color=INK)
