"""Blocks as python-control systems (optional extra `control`): for `control.interconnect`, `input_output_response`."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from spacar.arrays import Array
from spacar.errors import UsageError
from spacar.simulation.blocks import Block


def as_control(block: Block, numbered: bool = False) -> Any:
    """A block as a `control.NonlinearIOSystem` with its name and the names of its signals and states.

    A mechanism has inputs such as "INPUTS element 1 (HINGE) e1 relative rotation" and outputs such as "OUTX node 8 x",
    to be connected as "robot.OUTX node 8 x"; what python-control does not allow in a name ('.') becomes '_', a name
    that occurs twice gets its number. `numbered`: inputs are u1, u2 ..., outputs y1, y2 ..., states x1, x2 ...;
    `system.params` is empty. Raises UsageError for sampled blocks and delays, for blocks with a mode (limits, relays:
    python-control does not locate their ends), and when python-control is not installed.
    """
    control = python_control("simulation.control-missing")
    piecewise = "is smooth only piecewise, and python-control does not stop where a piece ends: simulate it with"
    sampled = block.period is not None
    for refused, text, code in (
        (sampled, "is sampled: write it as a discrete-time system of python-control itself", "sampled"),
        (block.lag, "remembers its input, which python-control cannot: use its pade() for a delay", "delay"),
        (block.n_events, f"{piecewise} spacar.simulation", "piecewise"),
    ):
        if refused:
            raise UsageError(f"{block.name} {text}", f"simulation.control-{code}")
    start = block.start()

    def called(function: Callable[[float, Array, Array], Array]) -> Any:
        return lambda t, x, u, params: function(float(t), np.array(x, float), np.array(u, float).reshape(block.n_in))

    return control.NonlinearIOSystem(
        called(block.derivative) if len(start) else None, called(block.outputs), name=block.name,
        inputs=_names("u", () if numbered else block.inputs, block.n_in),
        outputs=_names("y", () if numbered else block.outputs_, block.n_out),
        states=_names("x", () if numbered else getattr(block, "states", ()), len(start)),
    )  # fmt: skip


def python_control(code: str) -> Any:
    """The package. Raises UsageError with this code where it is not installed."""
    try:
        import control
    except ImportError:
        raise UsageError("python-control is not installed: pip install 'spacar[control]'", code) from None
    return control


def _names(letter: str, given: Sequence[str], count: int) -> list[str]:
    """Names that python-control accepts, all different."""
    if len(given) != count:
        return [f"{letter}{k + 1}" for k in range(count)]
    clean = [name.replace(".", "_") for name in given]
    return [name if clean.count(name) == 1 else f"{name} ({letter}{k + 1})" for k, name in enumerate(clean)]
