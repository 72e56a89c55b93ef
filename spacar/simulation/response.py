"""What a simulation is asked and what it answers: signals at a time, events of the caller, the response."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from spacar.arrays import Array
from spacar.modes import registered
from spacar.simulation.diagram import Diagram


@dataclass(frozen=True, eq=False)
class Signals(Mapping[str, Array]):
    """The outputs of all blocks at one time, by signal name ("robot:1-3")."""

    _diagram: Diagram
    _outputs: Mapping[str, slice]
    _y: Array

    def __getitem__(self, name: str) -> Array:
        block, rows = self._diagram.signals(str(name))
        return self._y[..., self._outputs[block].start + rows]

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


@dataclass(frozen=True, repr=False)
class Response:
    """What happened: `response["robot:10-12"]` are outputs (times, signals).

    t (n,) [s];  y (n, all outputs);  x (n, all states);  u (n, all inputs)
    outputs, states, inputs   columns of each block in y, x, u
    events (time, name) in order;  notes for the log;  statistics  counters of work;  hint  what the time is spent on,
    and how to spend less
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
    hint: str = ""

    def __repr__(self) -> str:
        blocks = ", ".join(f"{name} ({block.n_out})" for name, block in self.diagram.blocks.items() if block.n_out)
        lines = [
            f"Response: {len(self.t)} times, t = {self.t[0]:.6g} to {self.t[-1]:.6g} s",
            f"  outputs     {blocks or 'none'}",
            "  work        " + ", ".join(f"{count} {what}" for what, count in self.statistics.items()),
        ]
        if self.events:
            t, name = self.events[-1]
            lines.append(f"  events      {len(self.events)}, the last one {name} at {t:.6g} s")
        return "\n".join([*lines, "  response['block:1-3'], .plot(), .to_pandas()"])

    def plot(self, *blocks: str, path: str | Path | None = None) -> Any:
        """A matplotlib figure of the scopes, or of the outputs of `blocks`, also written to `path`."""
        return registered("response_plot")(self, blocks, path)

    def to_pandas(self) -> Any:
        """A pandas.DataFrame over t, columns (block, signal). Raises UsageError without pandas
        (`pip install 'spacar[tables]'`)."""
        return registered("frame_of_response")(self)

    def __getitem__(self, name: str) -> Array:
        """(times, signals) outputs by signal name. Raises UsageError for an unknown one."""
        return Signals(self.diagram, self.outputs, self.y)[name]
