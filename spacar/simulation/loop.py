"""The shortest way to a controlled simulation: one mechanism and one control law."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from spacar.arrays import Array
from spacar.simulation.blocks import Function, Sampled
from spacar.simulation.diagram import Diagram
from spacar.simulation.engine import Response, simulate
from spacar.simulation.plant import Spasim


def closed_loop(
    plant: Spasim, control: Callable[..., Any], times: Sequence[float] | Array, *, feedback: str | None = None,
    period: float | None = None, **options: Any,
) -> Response:  # fmt: skip
    """Simulate a mechanism with u = control(t, y).

    feedback  numbers (from 1) of the outputs that the law gets, such as "1-6"; default: all. The vector y has the
              length of all outputs, so that numbers keep their place; those that are not fed back are NaN
    period    sampling period [s] of a discrete-time law; default: continuous
    options   of `simulate`

    The blocks of the response are the plant under its own name and "control". Raises as `simulate`.
    """
    diagram = Diagram().add(plant)
    name, rows = diagram.signals(plant.name if feedback is None else f"{plant.name}:{feedback}")
    chosen = [plant.outputs_[k] for k in rows]

    def law(t: float, y: Array) -> Any:
        full = np.full(plant.n_out, np.nan)
        full[rows] = y
        return control(t, full)

    if period is None:
        diagram.add(Function("control", law, chosen, plant.inputs, getattr(control, "breaks", ())))
    else:
        diagram.add(Sampled("control", lambda t, x, y: (x, law(t, y)), period, chosen, plant.inputs))
    wire = name if feedback is None else f"{name}:{feedback}"
    diagram.connect(wire, "control").connect("control", name)
    return simulate(diagram, times, **options)
