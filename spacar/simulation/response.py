"""What a simulation is asked and what it answers: signals at a time, events of the caller, the response."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from spacar.arrays import Array
from spacar.simulation.diagram import Diagram


class Signals(Mapping[str, Array]):
    """The outputs of all blocks at one time, by signal name ("robot:1-3")."""

    def __init__(self, diagram: Diagram, outputs: Mapping[str, slice], y: Array) -> None:
        self._diagram, self._outputs, self._y = diagram, outputs, y

    def __getitem__(self, name: str) -> Array:
        block, rows = self._diagram.signals(name)
        return np.asarray(self._y[..., self._outputs[block].start + rows])

    def __iter__(self) -> Any:
        return iter(self._diagram.blocks)

    def __len__(self) -> int:
        return len(self._diagram.blocks)


@dataclass(frozen=True)
class Event:
    """A zero of function(t, signals). direction: +1 only rising, -1 only falling, 0 both.

    `terminal`: the event ends the simulation.
    """

    name: str
    function: Callable[[float, Signals], float]
    terminal: bool = False
    direction: int = 0


@dataclass(frozen=True)
class Response:
    """What happened: `response["robot:10-12"]` are outputs (times, signals).

    t (n,) [s];  y (n, all outputs);  x (n, all states);  u (n, all inputs)
    outputs, states, inputs   columns of each block in y, x, u
    events (time, name) in order;  notes for the log;  statistics  counters of work
    """

    t: Array
    y: Array
    x: Array
    diagram: Diagram
    outputs: Mapping[str, slice]
    states: Mapping[str, slice]
    inputs: Mapping[str, slice]
    u: Array
    events: tuple[tuple[float, str], ...]
    notes: tuple[str, ...]
    statistics: dict[str, int] = field(default_factory=dict)

    def __getitem__(self, name: str) -> Array:
        """(times, signals) outputs by signal name. Raises UsageError for an unknown one."""
        return Signals(self.diagram, self.outputs, self.y)[name]
