"""The work-precision diagram: error against processor time, and right-hand sides (stationary modes: elements)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from spacar.errors import escaped
from spacar_drawing.defaults import plain
from spacar_drawing.frequency_pictures import dress
from spacar_drawing.history import COLOURS
from spacar_drawing.stage import INK

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from spacar.studies.policies.trade import Entry

MARKS = ("o", "s", "^", "D")


@plain
def work_precision_figure(
    entries: Sequence[Entry], reference_error: float, target: float, stationary: bool, title: str
) -> Figure:
    """The diagram; settings without error or cost are left out."""
    from matplotlib.ticker import FuncFormatter, LogFormatterSciNotation, LogLocator, MaxNLocator, NullLocator

    from spacar_drawing.shown_figure import ShownFigure

    figure = ShownFigure(figsize=(9.0, 4.6), dpi=110, layout="constrained")
    left, right = figure.subplots(1, 2, sharey=True)
    for k, (name, group) in enumerate(_curves(entries).items()):
        look = {"color": COLOURS[k % len(COLOURS)], "marker": MARKS[k // len(COLOURS) % len(MARKS)], "lw": 1.3, "ms": 4}
        errors = [max(e.error, 1e-16) for e in group]
        left.loglog([e.seconds for e in group], errors, label=name, **look)
        work = [(e.setup.elements if stationary else e.rhs) if e.setup is not None else None for e in group]
        points = [(w, e) for w, e in zip(work, errors, strict=True) if w]
        if points:
            right.loglog(*zip(*points, strict=True), **look)
    across = ("processor time (s)", "elements a beam" if stationary else "right-hand sides")
    for axes, text in zip((left, right), across, strict=True):
        axes.axhline(target, color=INK, ls="--", lw=0.9, label="target")
        if reference_error > 0.0:
            axes.axhline(reference_error, color=INK, ls=":", lw=0.9, label="error of the reference")
        dress(axes, text, "error" if axes is left else "")
        axes.set_xscale("log")
        low, high = axes.get_xlim()
        if high < 8.0 * low:  # numbers that do not touch
            axes.xaxis.set_major_locator(MaxNLocator(4))
            axes.xaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:.3g}"))
            axes.xaxis.set_minor_locator(NullLocator())
        elif high < 100.0 * low:
            axes.xaxis.set_minor_locator(LogLocator(subs=(2.0, 5.0)))
            axes.xaxis.set_minor_formatter(LogFormatterSciNotation(minor_thresholds=(2.0, 2.0)))
        axes.tick_params(which="minor", labelsize=8, colors=INK, length=0)
    figure.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=3, fontsize=7, frameon=False)
    figure.suptitle(escaped(title), fontsize=10, color=INK, parse_math=False)
    return figure


def _curves(entries: Sequence[Entry]) -> dict[str, list[Entry]]:
    """Entries of one curve: the same model and method; in the stationary modes the same kind of model."""
    curves: dict[str, list[Entry]] = {}
    for e in entries:
        if not e.error >= 0.0:
            continue
        if e.setup is None:
            name = "extrapolated" + (", linear strain" if "linear" in e.label[0] else "")
        elif e.setup.method == "perturbation":
            name = f"perturbation, {e.setup.model}"
        elif e.setup.integrator is None:
            name = "rigid beams" if e.setup.beams == "rigid" else f"{e.setup.strain} strain"
        else:
            name = f"{e.setup.integrator}, {e.setup.model}"
        curves.setdefault(name, []).append(e)
    return curves
