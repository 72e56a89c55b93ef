"""Blocks as python-control systems (optional extra `control`): for `control.interconnect`,
`input_output_response`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from spacar.arrays import Array
from spacar.errors import UsageError
from spacar.simulation.blocks import Block


def as_control(block: Block) -> Any:
    """A block as a `control.NonlinearIOSystem` with its name and the names of its signals.

    Inputs are called u1, u2 ..., outputs y1, y2 ... (the numbers of the input file); `system.params` is
    empty. Sampled blocks become discrete-time systems of the same period only when they have no memory;
    otherwise UsageError. Raises UsageError when python-control is not installed.
    """
    try:
        import control
    except ImportError:
        text = "python-control is not installed: pip install 'spacar[control]'"
        raise UsageError(text, "simulation.control-missing") from None
    if block.period is not None:
        text = f"{block.name} is sampled: write it as a discrete-time system of python-control itself"
        raise UsageError(text, "simulation.control-sampled")
    start = block.start()

    def update(t: float, x: Array, u: Array, params: Any) -> Array:
        return block.derivative(float(t), np.array(x, float), np.array(u, float).reshape(block.n_in))

    def output(t: float, x: Array, u: Array, params: Any) -> Array:
        return block.outputs(float(t), np.array(x, float), np.array(u, float).reshape(block.n_in))

    system = control.NonlinearIOSystem(
        update if len(start) else None, output, name=block.name,
        inputs=[f"u{k + 1}" for k in range(block.n_in)], outputs=[f"y{k + 1}" for k in range(block.n_out)],
        states=[f"x{k + 1}" for k in range(len(start))],
    )  # fmt: skip
    return system
