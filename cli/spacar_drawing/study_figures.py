"""Figures of answers in memory: rows of a sweep, derivatives, signals of a simulation, what accuracy costs.

The work-precision diagram: error against processor time, and right-hand sides (stationary modes: elements).
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from spacar_formats.signal_tables import panels_by_quantity, table_of

from spacar.calls import texts
from spacar.errors import UsageError, escaped
from spacar_drawing.defaults import plain
from spacar_drawing.drawn_shapes import together
from spacar_drawing.files import kept
from spacar_drawing.history import COLOURS, scope_figure
from spacar_drawing.stage import INK, blank, dress, head

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from spacar.sensitivities.sensitivity import Sensitivity
    from spacar.simulation.response import Response
    from spacar.studies.policies.trade import Entry
    from spacar.studies.study_calls import SweepRows, TradeAnswer

MARKS = ("o", "s", "^", "D")


@plain
def work_precision_figure(
    entries: Sequence[Entry], reference_error: float, target: float, stationary: bool, title: str
) -> Figure:
    """The diagram; settings without error or cost are left out."""
    from matplotlib.ticker import FuncFormatter, LogFormatterSciNotation, LogLocator, MaxNLocator, NullLocator

    figure = blank(9.0, 4.6, layout="constrained")
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
        dress(axes, text, "error" if axes is left else "", framed=False)
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
    head(figure, title)
    return figure


def _curves(entries: Sequence[Entry]) -> dict[str, list[Entry]]:
    """Entries of one curve: the same model and method; in the stationary modes the same kind of model."""

    def name(e: Entry) -> str:
        s = e.setup
        if s is None:
            return "extrapolated" + (", linear strain" if "linear" in e.label[0] else "")
        if s.method == "perturbation" or s.integrator is not None:
            return f"{s.integrator if s.method != 'perturbation' else s.method}, {s.model}"
        kind = "rigid beams" if s.beams == "rigid" else f"{s.strain} strain"
        return kind + f", {s.measure} measure" * bool(s.measure)

    return together((name(e), e) for e in entries if e.error >= 0.0)


@plain
def sweep_plot(
    rows: SweepRows, names: Sequence[str] = (), path: str | Path | None = None, *, against: str | None = None
) -> Figure:
    """Results over a number that was changed; a curve for every choice of the others. Cases that failed are gaps."""
    across = against or rows.changed[0]
    shown = tuple(names) or rows.results
    for name, known in ((across, rows.changed), *((n, rows.results) for n in shown)):
        if name not in known:
            raise UsageError(f"'{name}' is not among {', '.join(known)}", "plot.name")
    others = [name for name in rows.changed if name != across]
    figure = blank(7.2, 1.0 + 2.6 * len(shown), layout="constrained")
    curves = together((tuple(row[name] for name in others), row) for row in rows)
    for axes, name in zip(figure.subplots(len(shown), 1, sharex=True, squeeze=False)[:, 0], shown, strict=True):
        for k, (values, group) in enumerate(curves.items()):
            label = ", ".join(f"{n} = {v:.4g}" for n, v in zip(others, values, strict=True))
            ordered = sorted(group, key=lambda row: row[across])
            y = [row[name] if row["status"] == "done" else np.nan for row in ordered]
            axes.plot([row[across] for row in ordered], y, "o-", ms=3.5, lw=1.2, color=COLOURS[k % len(COLOURS)],
                      label=escaped(label))  # fmt: skip
        dress(axes, "", escaped(name))
        if others and len(curves) <= 12:
            axes.legend(fontsize=8, labelcolor=INK, frameon=False)
    axes.set_xlabel(escaped(across))
    head(figure, rows.source)
    return kept(figure, path)


@plain
def trade_plot(answer: TradeAnswer, path: str | Path | None = None) -> Figure:
    """The work-precision diagram."""
    reference, target = answer.reference.error, answer.target
    return kept(work_precision_figure(answer.entries, reference, target, answer.stationary, answer.title), path)


@plain
def sensitivity_plot(found: Sensitivity, path: str | Path | None = None) -> Figure:
    """Relative changes as bars: a panel for each quantity, a bar for each parameter."""
    count = len(found.parameters)
    figure = blank(7.2, 0.6 + len(found.quantities) * (0.5 + 0.28 * count), layout="constrained")
    panels = figure.subplots(len(found.quantities), 1, sharex=True, squeeze=False)[:, 0]
    for axes, name, change in zip(panels, found.quantities, found.relative, strict=True):
        axes.barh(range(count), change, color=[COLOURS[0] if not v < 0 else COLOURS[1] for v in change], height=0.6)
        dress(axes)
        axes.grid(False, axis="y")
        axes.set_yticks(range(count), [escaped(p) for p in found.parameters], parse_math=False)
        axes.invert_yaxis()
        axes.axvline(0.0, color=INK, lw=0.8)
        axes.set_title(escaped(name), fontsize=8.5, color=INK, loc="left", parse_math=False)
    axes.set_xlabel("relative change of the quantity over that of the parameter (-)")
    return kept(figure, path)


@plain
def response_plot(response: Response, names: Sequence[str] = (), path: str | Path | None = None) -> Figure:
    """The scopes of a simulation; without one, or with names of signals ("robot", "robot:1-3"), those by quantity."""
    from spacar.simulation.plant import Spasim

    table, blocks = table_of(response), response.diagram.blocks
    plants = [name for name, block in blocks.items() if isinstance(block, Spasim)]
    chosen = texts("a signal", names) or plants or [name for name, block in blocks.items() if block.n_out]
    sinks = {name for name, block in blocks.items() if not block.n_out}
    signals = [
        response.diagram.signals(n, "input" if n.partition(":")[0].strip() in sinks else "output") for n in chosen
    ]
    panels = (() if names else table.panels) or [p for signal in signals for p in panels_by_quantity(table, *signal)]
    return kept(scope_figure(table, response.t, panels, ", ".join(plants) or "simulation"), path)
