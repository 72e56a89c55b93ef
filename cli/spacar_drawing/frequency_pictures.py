"""Root locus, Campbell diagram and Bode diagram."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from spacar_formats.vibration import without_rounding

from spacar.errors import escaped
from spacar_drawing.defaults import plain
from spacar_drawing.history import COLOURS
from spacar_drawing.stage import INK, RULE

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from spacar_formats.getss import SparseStep, StateSpaceStep
    from spacar_formats.vibration import Vibration


MOST_NAMED = 8  # curves in one panel
NAMES_A_ROW = 4  # of the legend of more
STYLES = ("-", "--", ":", "-.")


@plain
def root_figure(steps: Sequence[Vibration], across: np.ndarray, text: str, title: str) -> Figure:
    """Frequencies over `across` (a Campbell diagram when that is a speed), and the root locus, darker with the step."""
    from matplotlib import colormaps

    from spacar_drawing.shown_figure import ShownFigure

    figure = ShownFigure(figsize=(9.0, 4.2), dpi=110)
    left, right = figure.subplots(1, 2)
    shades = colormaps["viridis"](np.linspace(0.85, 0.0, max(len(steps), 2)))
    for k, step in enumerate(steps):
        shade = [shades[k]]
        values = without_rounding(step.values)
        oscillating = values[values.imag > 0.0]
        left.scatter(np.full(len(oscillating), across[k]), oscillating.imag / (2 * np.pi), s=12, c=shade)
        right.scatter(values.real, values.imag, s=12, c=shade)
    _dress(left, text, "frequency (Hz)")
    _dress(right, "real part (1/s)", "imaginary part (rad/s)")
    right.axvline(0.0, color=INK, lw=0.8)
    left.set_ylim(bottom=0.0)
    figure.suptitle(escaped(title), fontsize=10, color=INK, parse_math=False)
    figure.tight_layout()
    return figure


@plain
def bode_figure(
    system: StateSpaceStep | SparseStep, omega: np.ndarray, response: np.ndarray, pairs: Sequence[tuple[int, int]],
    title: str,
) -> Figure:  # fmt: skip
    """Amplitude [dB] and phase [deg, unwrapped] of (output, input) pairs over the frequency [Hz], all with a name.

    Up to MOST_NAMED curves share one pair of panels; of more every input has a column of its own, and a colour and line
    style stand for the same output in all of them.
    """
    from spacar_drawing.shown_figure import ShownFigure

    together = len(pairs) <= MOST_NAMED
    inputs = [None] if together else list(dict.fromkeys(j for _, j in pairs))
    outputs = list(dict.fromkeys(i for i, _ in pairs))
    width = 7.2 if together else max(7.2, 3.4 * len(inputs))
    rows = 0 if together else -(-len(outputs) // NAMES_A_ROW)
    figure = ShownFigure(figsize=(width, 5.4 + 0.2 * rows), dpi=110)
    panels = figure.subplots(2, len(inputs), sharex=True, sharey="row", squeeze=False)
    for column, own in enumerate(inputs):
        upper, lower = panels[:, column]
        chosen = [(i, j) for i, j in pairs if own is None or j == own]
        for k, (i, j) in enumerate(chosen):
            h = response[:, i, j]
            fine = np.isfinite(h) & (h != 0.0)
            n = k if own is None else outputs.index(i)
            look = {"color": COLOURS[n % len(COLOURS)], "ls": STYLES[n // len(COLOURS) % len(STYLES)], "lw": 1.3}
            f = omega[fine] / (2 * np.pi)
            name = f"{system.outputs[i]} / {system.inputs[j]}" if own is None else system.outputs[i]
            upper.semilogx(f, 20 * np.log10(np.abs(h[fine])), label=escaped(name), **look)
            lower.semilogx(f, np.degrees(np.unwrap(np.angle(h[fine]))), **look)
        _dress(upper, "", "" if column else "amplitude (dB)")
        _dress(lower, "frequency (Hz)", "" if column else "phase (deg)")
        if own is not None:
            upper.set_title(f"from {escaped(system.inputs[own])}", fontsize=8.5, color=INK, parse_math=False)
    figure.suptitle(escaped(title), fontsize=10, color=INK, parse_math=False)
    foot = 0.22 * rows / (5.4 + 0.2 * rows)
    figure.tight_layout(rect=(0.0, foot, 1.0, 1.0))
    if together:
        panels[0, 0].legend(fontsize=7, frameon=False)
    else:
        lines, names = panels[0, 0].get_legend_handles_labels()
        figure.legend(lines, names, loc="lower center", ncols=NAMES_A_ROW, fontsize=7, frameon=False)
    return figure


def _dress(axes: Axes, x: str, y: str) -> None:
    axes.set_xlabel(x, fontsize=8.5, color=INK)
    axes.set_ylabel(y, fontsize=8.5, color=INK)
    axes.grid(True, color=RULE, lw=0.6)
    axes.set_axisbelow(True)
    axes.tick_params(labelsize=8, colors=INK, length=0)
    for side in axes.spines.values():
        side.set_visible(False)
