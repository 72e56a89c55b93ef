"""Root locus, Campbell diagram and Bode diagram."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from spacar.errors import escaped
from spacar_drawing.history import COLOURS
from spacar_drawing.stage import INK, RULE

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from spacar_formats.getss import StateSpaceStep
    from spacar_formats.vibration import Vibration


def root_figure(steps: Sequence[Vibration], across: np.ndarray, text: str, title: str) -> Figure:
    """Frequencies over `across` (a Campbell diagram when that is a speed), and the root locus, darker with the step."""
    from matplotlib import colormaps
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 4.2), dpi=110)
    left, right = figure.subplots(1, 2)
    shades = colormaps["viridis"](np.linspace(0.85, 0.0, max(len(steps), 2)))
    for k, step in enumerate(steps):
        shade = [shades[k]]
        oscillating = step.values[step.values.imag > 0.0]
        left.scatter(np.full(len(oscillating), across[k]), oscillating.imag / (2 * np.pi), s=12, c=shade)
        right.scatter(step.values.real, step.values.imag, s=12, c=shade)
    _dress(left, text, "frequency (Hz)")
    _dress(right, "real part (1/s)", "imaginary part (rad/s)")
    right.axvline(0.0, color=INK, lw=0.8)
    left.set_ylim(bottom=0.0)
    figure.suptitle(escaped(title), fontsize=10, color=INK, parse_math=False)
    figure.tight_layout()
    return figure


def bode_figure(
    system: StateSpaceStep, omega: np.ndarray, response: np.ndarray, pairs: Sequence[tuple[int, int]], title: str
) -> Figure:
    """Amplitude [dB] and phase [deg, unwrapped] of (output, input) pairs over the frequency [Hz]."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.2, 5.4), dpi=110)
    upper, lower = figure.subplots(2, 1, sharex=True)
    for k, (i, j) in enumerate(pairs):
        h = response[:, i, j]
        fine = np.isfinite(h) & (h != 0.0)
        label, colour = f"{system.outputs[i]} / {system.inputs[j]}", COLOURS[k % len(COLOURS)]
        f = omega[fine] / (2 * np.pi)
        upper.semilogx(f, 20 * np.log10(np.abs(h[fine])), color=colour, lw=1.3, label=label)
        lower.semilogx(f, np.degrees(np.unwrap(np.angle(h[fine]))), color=colour, lw=1.3)
    _dress(upper, "", "amplitude (dB)")
    _dress(lower, "frequency (Hz)", "phase (deg)")
    if len(pairs) <= 8:
        upper.legend(fontsize=7, frameon=False)
    figure.suptitle(escaped(title), fontsize=10, color=INK, parse_math=False)
    figure.tight_layout()
    return figure


def _dress(axes: Axes, x: str, y: str) -> None:
    axes.set_xlabel(x, fontsize=8.5, color=INK)
    axes.set_ylabel(y, fontsize=8.5, color=INK)
    axes.grid(True, color=RULE, lw=0.6)
    axes.set_axisbelow(True)
    axes.tick_params(labelsize=8, colors=INK, length=0)
    for side in axes.spines.values():
        side.set_visible(False)
