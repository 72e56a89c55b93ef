"""The motion of a mechanism in a controlled simulation as a `.sbd` file, like that of mode 1 (reference/files.md 4).

At every output time the states and inputs of the Spasim block give the whole state of its mechanism, so that `spacar
draw`, `spacar plot` and `spacar report` work on the result as on one of mode 1. The signals of the diagram stand beside
the motion (signal_tables).
"""

from pathlib import Path

from spacar.modes import find_mode
from spacar.simulation.plant import Spasim
from spacar.simulation.response import Response
from spacar.stream import Run
from spacar_formats.safety import Claim
from spacar_formats.signal_tables import SignalTable, table_of
from spacar_formats.sinks import write_steps
from spacar_formats.sinks.results import KINDS


def write_motions(response: Response, stem: Path) -> list[Path]:
    """Write `stem.sbd`; with several mechanisms `stem_BLOCK.sbd` each. Returns the paths.

    Raises UsageError when a file cannot be written, AnalysisError when the disk refuses bytes.
    """
    plants = [b for b in response.diagram.blocks.values() if isinstance(b, Spasim)]
    table = table_of(response)
    names = [stem.name] if len(plants) == 1 else [f"{stem.name}_{plant.name}" for plant in plants]
    return [
        _write(response, table, plant, stem.with_name(f"{name}.sbd")) for plant, name in zip(plants, names, strict=True)
    ]


def _write(response: Response, table: SignalTable, plant: Spasim, path: Path) -> Path:
    header, values = KINDS["sbd"]
    x, u = response.x[:, response.states[plant.name]], response.u[:, response.inputs[plant.name]]
    states = zip(response.t.tolist(), x, u, table.values, strict=True)
    steps = (values(plant.frame(t, state, inputs)) | {"SIGNAL": row} for t, state, inputs, row in states)
    with Claim(path) as claim:
        return write_steps(claim, {**header(Run(find_mode(1), plant.mechanism), ()), **table.header()}, steps)
