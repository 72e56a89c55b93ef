"""Root locus, Campbell diagram and Bode diagram."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from spacar_formats.signal_tables import signal_unit
from spacar_formats.vibration import Vibration, without_rounding

from spacar.errors import escaped
from spacar.expressions import Unit, combine, unit_text
from spacar_drawing.defaults import plain
from spacar_drawing.drawn_shapes import together
from spacar_drawing.history import COLOURS
from spacar_drawing.stage import INK, blank, dress, head

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from spacar_formats.getss import SparseStep, StateSpaceStep


MOST_NAMED = 8  # curves in one panel
NAMES_A_ROW = 4  # of the legend of more
STEEP = 200.0  # dB for a factor e of the frequency: the foot of a peak, 4 % from its frequency
UNDAMPED = 60.0  # dB above the foot: a relative damping below 1e-4
STYLES = ("-", "--", ":", "-.")


@plain
def root_figure(steps: Sequence[Vibration], across: np.ndarray, text: str, title: str) -> Figure:
    """Frequencies over `across` (a Campbell diagram when that is a speed), and the root locus, darker with the step."""
    from matplotlib import colormaps

    figure = blank(9.0, 4.2)
    left, right = figure.subplots(1, 2)
    shades = colormaps["viridis"](np.linspace(0.85, 0.0, max(len(steps), 2)))
    named = {0, (len(steps) - 1) // 2, len(steps) - 1} if len(steps) > 1 else set()
    for k, step in enumerate(steps):
        shade = [shades[k]]
        values = without_rounding(step.values)
        oscillating = values[values.imag > 0.0]
        label = f"{text.partition(' (')[0]} = {across[k]:.4g}" if k in named else None
        left.scatter(np.full(len(oscillating), across[k]), oscillating.imag / (2 * np.pi), s=12, c=shade)
        right.scatter(values.real, values.imag, s=12, c=shade, label=label)
    dress(left, text, "frequency (Hz)", framed=False)
    dress(right, "real part (1/s)", "imaginary part (rad/s)", framed=False)
    right.axvline(0.0, color=INK, lw=0.8)
    left.set_ylim(bottom=0.0)
    if text.endswith("(rad/s)") and len(steps) > 1:  # what an imbalance excites
        top = left.get_ylim()[1]
        left.plot(across, np.abs(across) / (2 * np.pi), color=INK, lw=0.9, ls="--", label="once a turn")
        left.set_ylim(0.0, top)
        left.legend(fontsize=7, frameon=False)
    if named:
        right.legend(fontsize=7, frameon=False)
    head(figure, title)
    figure.tight_layout()
    return figure


@plain
def bode_figure(
    system: StateSpaceStep | SparseStep, omega: np.ndarray, response: np.ndarray, pairs: Sequence[tuple[int, int]],
    title: str,
) -> Figure:  # fmt: skip
    """Amplitude [dB] and phase [deg, unwrapped] of (output, input) pairs over the frequency [Hz], all with a name.

    Up to MOST_NAMED curves share the panels of their unit, with their margins; of more every input has a column of its
    own, and a colour and line style stand for the same output in all of them. Peaks without damping are cut off.
    """
    from matplotlib.ticker import MultipleLocator

    shared = len(pairs) <= MOST_NAMED
    units: dict[tuple[int, int], Unit | None] = {}
    for i, j in pairs:
        above, below = signal_unit(system.outputs[i]), signal_unit(system.inputs[j])
        units[i, j] = None if above is None or below is None else combine(above, below, -1)
    columns = together(((shared or pair[1], units[pair]), pair) for pair in pairs)
    outputs = list(dict.fromkeys(i for i, _ in pairs))
    if shared:  # the panels of a unit above each other
        figure = blank(7.2, len(columns) * 4.6 + 0.17 * len(pairs) + 0.6, layout="constrained")
        panels = figure.subplots(2 * len(columns), 1, sharex=True).reshape(-1, 2).T
    else:
        rows = -(-len(outputs) // NAMES_A_ROW)
        figure = blank(max(7.2, 3.4 * len(columns)), 5.4 + 0.2 * rows, layout="constrained")
        panels = figure.subplots(2, len(columns), sharex=True, squeeze=False)
    f = omega / (2 * np.pi)
    for (upper, lower), chosen in zip(panels.T, columns.values(), strict=True):
        tops = []
        for k, (i, j) in enumerate(chosen):
            h = response[:, i, j]
            fine = np.isfinite(h) & (h != 0.0)
            n = k if shared else outputs.index(i)
            look = {"color": COLOURS[n % len(COLOURS)], "ls": STYLES[n // len(COLOURS) % len(STYLES)], "lw": 1.3}
            decibels, degrees = 20 * np.log10(np.abs(h[fine])), unwrapped(h[fine])
            name = f"{system.outputs[i]} / {system.inputs[j]}" if shared else system.outputs[i]
            said = margins(f[fine], decibels, degrees) if shared else ""
            upper.semilogx(f[fine], decibels, label=escaped(f"{name}: {said}" if said else name), **look)
            lower.semilogx(f[fine], degrees, **look)
            tops.append(top_of(f[fine], decibels))
        low, high = upper.get_ylim()
        upper.set_ylim(low, min(high, max(tops, default=high)))
        unit = unit_text(units[chosen[0]])
        dress(upper, "", f"amplitude (dB, 0 is 1 {unit})" if unit else "amplitude (dB)", framed=False)
        last = not shared or lower is panels[-1, -1]
        dress(lower, "frequency (Hz)" if last else "", "phase (deg)", framed=False)
        span = np.ptp(lower.get_ylim())
        step = next((part for part in (15, 30, 45, 90, 180, 360) if span / part <= 8), 720)  # parts of a turn
        lower.yaxis.set_major_locator(MultipleLocator(step))
        if not shared:
            upper.set_title(f"from {escaped(system.inputs[chosen[0][1]])}", fontsize=8.5, color=INK, parse_math=False)
        else:
            upper.legend(fontsize=7, frameon=False, loc="lower left", bbox_to_anchor=(0.0, 1.0), borderpad=0.1)
    head(figure, title)
    if not shared:
        lines = {line.get_label(): line for axes in panels[0] for line in axes.lines}
        figure.legend(lines.values(), lines, loc="outside lower center", ncols=NAMES_A_ROW, fontsize=7, frameon=False)
    return figure


def unwrapped(h: np.ndarray) -> np.ndarray:
    """Phase [deg] of a response h (n,) that begins between -180 and 180. A jump of half a turn between neighbours, at a
    pole or zero without damping, goes down at a peak and up at a gap: as with the damping that everything has."""
    change = np.angle(h[1:] / h[:-1])
    size = np.abs(h)
    for k in np.flatnonzero(np.abs(np.abs(change) - np.pi) < 1e-3):
        around = size[max(k - 1, 0) : k + 3]
        peak = max(size[k], size[k + 1]) >= around.max()
        change[k] = -abs(change[k]) if peak else abs(change[k])
    return np.degrees(np.angle(h[:1]) + np.concatenate(([0.0], np.cumsum(change))))


def margins(f: np.ndarray, decibels: np.ndarray, degrees: np.ndarray) -> str:
    """Gain margin and phase margin of an open loop with the feedback -1, the smallest of each; "" without crossings."""
    smooth = np.abs(np.diff(degrees)) < 90.0  # others are poles and zeros without damping: no margin is there
    crossed = np.flatnonzero(((decibels[:-1] > 0.0) != (decibels[1:] > 0.0)) & smooth)
    turns = np.floor((degrees + 180.0) / 360.0)
    turned = np.flatnonzero((turns[:-1] != turns[1:]) & smooth)

    def between(k: int, values: np.ndarray, other: np.ndarray, at: float) -> tuple[float, float]:
        """Frequency and the other value where values pass `at` between places k and k + 1."""
        part = (at - values[k]) / (values[k + 1] - values[k])
        return float(f[k] * (f[k + 1] / f[k]) ** part), float(other[k] + part * (other[k + 1] - other[k]))

    gains = [between(k, degrees, decibels, 360.0 * max(turns[k], turns[k + 1]) - 180.0) for k in turned.tolist()]
    phases = [between(k, decibels, degrees, 0.0) for k in crossed.tolist()]
    left = [(value % 360.0 - 180.0, at) for at, value in phases]
    left = [found for found in left if abs(abs(found[0]) - 90.0) < 89.9]  # not at 0 or half a turn by no damping
    words = []
    if gains:
        at, value = min(gains, key=lambda found: abs(found[1]))
        words.append(f"gain margin {-value:.3g} dB at {at:.3g} Hz")
    if left:
        value, at = min(left, key=lambda found: abs(found[0]))
        words.append(f"phase margin {value:.3g}\N{DEGREE SIGN} at {at:.3g} Hz")
    return ", ".join(words)


def top_of(f: np.ndarray, decibels: np.ndarray) -> float:
    """The top of the axis: above the curve; where peaks without damping stand out by UNDAMPED, above their feet."""
    if len(f) < 2:
        return decibels.max(initial=0.0) + 1.0
    slope = np.abs(np.diff(decibels) / np.diff(np.log(f)))
    feet, top = decibels[:-1][slope < STEEP].max(initial=-np.inf), decibels.max()
    top = feet + 0.5 * UNDAMPED if top > feet + UNDAMPED and np.isfinite(feet) else top
    return top + 0.05 * np.ptp(np.minimum(decibels, top))
