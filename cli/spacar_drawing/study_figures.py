"""Figures of answers in memory: rows of a sweep, derivatives, signals of a simulation, what accuracy costs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from spacar_formats.signal_tables import panels_by_quantity, table_of

from spacar.errors import UsageError, escaped
from spacar_drawing.defaults import plain
from spacar_drawing.files import save
from spacar_drawing.history import COLOURS
from spacar_drawing.scope_panels import scope_figure
from spacar_drawing.work_precision import work_precision_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from spacar.sensitivities.sensitivity import Sensitivity
    from spacar.simulation.response import Response
    from spacar.studies.study_answers import SweepRows, TradeAnswer


@plain
def sweep_plot(
    rows: SweepRows, names: Sequence[str] = (), path: str | Path | None = None, *, against: str | None = None
) -> Figure:
    """Results over a number that was changed; a curve for every choice of the others. Cases that failed are gaps."""
    from spacar_drawing.shown_figure import ShownFigure

    across = against or rows.changed[0]
    shown = tuple(names) or rows.results
    for name, known in ((across, rows.changed), *((n, rows.results) for n in shown)):
        if name not in known:
            raise UsageError(f"'{name}' is not among {', '.join(known)}", "plot.name")
    others = [name for name in rows.changed if name != across]
    figure = ShownFigure(figsize=(7.2, 1.0 + 2.6 * len(shown)), dpi=110, layout="constrained")
    curves: dict[tuple[float, ...], list] = {}
    for row in rows:
        curves.setdefault(tuple(row[name] for name in others), []).append(row)
    for axes, name in zip(figure.subplots(len(shown), 1, sharex=True, squeeze=False)[:, 0], shown, strict=True):
        for k, (values, group) in enumerate(curves.items()):
            label = ", ".join(f"{n} = {v:.4g}" for n, v in zip(others, values, strict=True))
            ordered = sorted(group, key=lambda row: row[across])
            y = [row[name] if row["status"] == "done" else np.nan for row in ordered]
            axes.plot([row[across] for row in ordered], y, "o-", ms=3.5, lw=1.2, color=COLOURS[k % len(COLOURS)],
                      label=escaped(label))  # fmt: skip
        axes.set_ylabel(escaped(name), parse_math=False)
        axes.grid(alpha=0.3)
        if others and len(curves) <= 12:
            axes.legend(fontsize="small", frameon=False)
    axes.set_xlabel(escaped(across), parse_math=False)
    figure.suptitle(escaped(rows.source), parse_math=False)
    return _written(figure, path)


@plain
def trade_plot(answer: TradeAnswer, path: str | Path | None = None) -> Figure:
    """The work-precision diagram."""
    shown = work_precision_figure(
        answer.entries, answer.reference.error, answer.target, answer.stationary, answer.title
    )
    return _written(shown, path)


@plain
def sensitivity_plot(found: Sensitivity, path: str | Path | None = None) -> Figure:
    """Relative changes as bars: a panel for each quantity, a bar for each parameter."""
    from spacar_drawing.shown_figure import ShownFigure

    count = len(found.parameters)
    height = 0.6 + len(found.quantities) * (0.5 + 0.28 * count)
    figure = ShownFigure(figsize=(7.2, height), dpi=110, layout="constrained")
    panels = figure.subplots(len(found.quantities), 1, sharex=True, squeeze=False)[:, 0]
    for axes, name, change in zip(panels, found.quantities, found.relative, strict=True):
        axes.barh(range(count), change, color=[COLOURS[0] if not v < 0 else COLOURS[1] for v in change], height=0.6)
        axes.set_yticks(range(count), [escaped(p) for p in found.parameters], parse_math=False)
        axes.invert_yaxis()
        axes.axvline(0.0, color="0.3", lw=0.8)
        axes.set_title(escaped(name), fontsize="medium", loc="left", parse_math=False)
        axes.grid(axis="x", alpha=0.3)
    axes.set_xlabel("relative change of the quantity over that of the parameter (-)")
    return _written(figure, path)


@plain
def response_plot(response: Response, names: Sequence[str] = (), path: str | Path | None = None) -> Figure:
    """The scopes of a simulation; without one, or with names of blocks, the outputs of the blocks by quantity."""
    from spacar.simulation.plant import Spasim

    table, blocks = table_of(response), response.diagram.blocks
    unknown = [name for name in names if name not in blocks]
    if unknown:
        raise UsageError(f"there is no block {unknown[0]}; the blocks are {', '.join(blocks)}", "simulation.signal")
    plants = [name for name, block in blocks.items() if isinstance(block, Spasim)]
    chosen = names or plants or [name for name, block in blocks.items() if block.n_out]
    panels = (() if names else table.panels) or [p for name in chosen for p in panels_by_quantity(table, name)]
    return _written(scope_figure(table, response.t, panels, ", ".join(plants) or "simulation"), path)


def _written(figure: Figure, path: str | Path | None) -> Figure:
    if path is not None:
        save(figure, Path(path))
    return figure
