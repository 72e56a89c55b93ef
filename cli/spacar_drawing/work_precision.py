"""The work-precision diagram: error against processor time, and right-hand sides (stationary modes: elements)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from spacar.errors import escaped
from spacar_drawing.defaults import plain

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from spacar.studies.policies.trade import Entry


@plain
def work_precision_figure(
    entries: Sequence[Entry], reference_error: float, target: float, stationary: bool, title: str
) -> Figure:
    """The diagram; settings without error or cost are left out."""
    from matplotlib.ticker import LogFormatterSciNotation, LogLocator

    from spacar_drawing.shown_figure import ShownFigure

    figure = ShownFigure(figsize=(10, 4.5), dpi=120, layout="constrained")
    left, right = figure.subplots(1, 2, sharey=True)
    for name, group in _curves(entries).items():
        errors = [max(e.error, 1e-16) for e in group]
        left.loglog([e.seconds for e in group], errors, "o-", label=name, markersize=4)
        work = [(e.setup.elements if stationary else e.rhs) if e.setup is not None else None for e in group]
        points = [(w, e) for w, e in zip(work, errors, strict=True) if w]
        if points:
            right.loglog(*zip(*points, strict=True), "o-", markersize=4)
        else:
            right.loglog([], [])  # keeps the colours of both sides the same
    for axes in (left, right):
        axes.axhline(target, color="0.5", linestyle="--", linewidth=0.8)
        if reference_error > 0.0:
            axes.axhline(reference_error, color="0.5", linestyle=":", linewidth=0.8)
        axes.grid(alpha=0.3)
        axes.xaxis.set_minor_locator(LogLocator(subs=(2.0, 5.0)))  # labels of less than two decades do not touch
        axes.xaxis.set_minor_formatter(LogFormatterSciNotation(minor_thresholds=(2.0, 2.0)))
    left.set_xlabel("processor time [s]")
    left.set_ylabel("error (dashed: target, dotted: of the reference)")
    right.set_xlabel("elements a beam" if stationary else "right-hand sides")
    left.legend(fontsize="small")
    figure.suptitle(escaped(title), parse_math=False)
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
