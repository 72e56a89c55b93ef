"""Plots of a run: one figure a quantity against time, as in the paper (bibliography.md; its figures 2 to 5)."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from spacar_drawing.defaults import plain
from spacar_drawing.files import save

from spacar.symbolic.simulated_motion import SimulatedMotion


@plain
def plot(run: SimulatedMotion, names: Iterable[str] | None = None, labels: dict[str, str] | None = None) -> list[Any]:
    """One matplotlib figure for every name (default: coordinates that are not field amplitudes, and outputs)."""
    from matplotlib.figure import Figure

    chosen = list(names) if names is not None else default_names(run)
    figures = []
    for name in chosen:
        figure = Figure(figsize=(6.4, 3.2), layout="constrained")
        axes = figure.add_subplot()
        axes.plot(run.time, run[name], linewidth=1.0, color="black")
        axes.set_xlabel("time t [s]")
        axes.set_ylabel((labels or {}).get(name, name))
        axes.grid(visible=True, linewidth=0.3)
        axes.margins(x=0)
        figures.append(figure)
    return figures


def default_names(run: SimulatedMotion) -> list[str]:
    """Coordinates without the amplitudes φ of fields, then the outputs."""
    coordinates = run.names[: len(run.names) - len(run.names) // 2]
    return [*(name for name in coordinates if not name.startswith("phi")), *run.outputs]


def save_plots(run: SimulatedMotion, stem: Path, names: Iterable[str] | None) -> list[Path]:
    """Write STEM-NAME.png for every quantity; returns the paths."""
    chosen = list(names) if names is not None else default_names(run)
    paths = []
    for name, figure in zip(chosen, plot(run, chosen), strict=True):
        paths.append(stem.with_name(f"{stem.name}-{name}.png"))
        save(figure, paths[-1])
    return paths
