"""Signals of a simulation in a `.sbd`: SIGNAL (n, 1) at every step, and in the header

    SIGNAME   a line each: block, tab, name of the signal
    SCOPES    a line each in JSON: title, unit, labels and columns (from 1) of a panel

They stand beside the motion of the mechanism, a `.sbd` file like that of mode 1: at every output time the states and
inputs of the Spasim block give the whole state. A diagram without one has a file of its own (KIND signals). What a
scope looks at is a signal under its name.

Units of signals from their names: "OUTXP node 8 x" is a speed, "INPUTS element 1 (HINGE) e1 ..." a moment.

The letters behind the kind of a coordinate tell its derivative (P, DP), and S or F an input or output that is its dual.

Time histories as `.npz`, `.mat` or `.csv` files: what `spacar sim`, `ltv` and `mrltv` write.
"""

import json
import re
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

import spacar
from spacar.deck import ELEMENT_TYPES
from spacar.expressions import NONE, Dimensions, Unit, unit_text
from spacar.modes import find_mode
from spacar.simulation.blocks import Scope
from spacar.simulation.diagram import wired_names
from spacar.simulation.plant import Spasim
from spacar.simulation.response import Response
from spacar.stream import Run
from spacar_formats.exports import export_to, to_csv, to_mat, to_npz
from spacar_formats.result_files import sbd_header, sbd_values, write_steps
from spacar_formats.safety import Claim
from spacar_formats.sbf import SbfFile
from spacar_formats.sbf.record_layout import require

KIND = re.compile(r"(?:IN|OUT|NOM|REF|INPUT)(E|X|S|F)(DP|P|S)? ")
NODE = re.compile(r"node \d+ (?:([xyz])|w|phi|lambda\d)")
ELEMENT = re.compile(r"element \d+ \((\w+)\) e(\d+)")
DERIVATIVES = {"P": 1, "DP": 2}


def signal_unit(name: str) -> Unit | None:
    """None: the name does not tell."""
    kind = KIND.match(name)
    if kind is None:
        return None
    letter, order = kind[1], DERIVATIVES.get(kind[2] or "", 0)
    rest = name[kind.end() :]
    if (node := NODE.match(rest)) is not None:
        variable = "fx" if letter == "F" else ("x", "xd", "xdd")[order]
        units = Dimensions(" phi" in rest, False, (1,) if node[1] else (), ())
        return units(variable, (1, 1)) if " w" not in rest else NONE
    element = ELEMENT.match(rest)
    if element is None or element[1] not in ELEMENT_TYPES:
        return None
    mode = int(element[2])
    if not 1 <= mode <= len(ELEMENT_TYPES[element[1]].modes):
        return None
    variable = "sig" if letter == "S" else ("e", "ed", "edd")[order]
    return Dimensions(True, False, (), (element[1],))(variable, (1, mode))


@dataclass(frozen=True)
class Panel:
    """Curves drawn together: columns (from 0) of the table, a label each, the unit of the axis."""

    title: str
    columns: tuple[int, ...]
    labels: tuple[str, ...]
    unit: str


@dataclass(frozen=True)
class SignalTable:
    """Signals (steps, n): the block and the name of each, and the panels of the scopes."""

    blocks: tuple[str, ...]
    names: tuple[str, ...]
    values: np.ndarray = field(repr=False)
    panels: tuple[Panel, ...] = ()

    def columns(self, block: str) -> list[int]:
        return [k for k, name in enumerate(self.blocks) if name == block]

    def header(self) -> dict[str, Any]:
        lines = [f"{block}\t{name}" for block, name in zip(self.blocks, self.names, strict=True)]
        scopes = [
            json.dumps({"title": p.title, "unit": p.unit, "labels": p.labels, "columns": [k + 1 for k in p.columns]})
            for p in self.panels
        ]
        return {"SIGNAME": lines} | ({"SCOPES": scopes} if scopes else {})


def table_of(response: Response) -> SignalTable:
    """The outputs of all blocks and the inputs of the scopes; without a scope the outputs of every mechanism."""
    arrays: dict[str, tuple[Sequence[str], np.ndarray]] = {}
    panels: list[Panel] = []
    for name, block in response.diagram.blocks.items():
        if isinstance(block, Scope):
            labels = block.labels or tuple(wired_names(response.diagram, block))
            first = sum(len(names) for names, _ in arrays.values())
            panels.append(Panel(block.title, tuple(range(first, first + block.n_in)), labels, block.unit))
            arrays[name] = labels, response.u[:, response.inputs[name]]
        else:
            arrays[name] = block.outputs_, response.y[:, response.outputs[name]]
    return replace(table_of_arrays(arrays), panels=tuple(panels))


def table_of_arrays(arrays: Mapping[str, tuple[Sequence[str], np.ndarray]]) -> SignalTable:
    """Names and values (steps, n) by block."""
    blocks = tuple(block for block, (names, _) in arrays.items() for _ in names)
    names = tuple(name for given, _ in arrays.values() for name in given)
    return SignalTable(blocks, names, np.hstack([values for _, values in arrays.values()]))


def panels_by_quantity(table: SignalTable, block: str, rows: Iterable[int] | None = None) -> list[Panel]:
    """The signals of a block (from 0, default all), those of one keyword (OUTX ...) or letter, and unit, together."""
    groups: dict[tuple[str, Unit | None], list[int]] = {}
    own = table.columns(block)
    for k in own if rows is None else (own[row] for row in rows):
        what = table.names[k].split(" ")[0].rstrip("0123456789")
        groups.setdefault((what, signal_unit(table.names[k])), []).append(k)
    panels = []
    for (what, of), ks in groups.items():
        labels = tuple(table.names[k].removeprefix(f"{what} ") for k in ks)
        panels.append(Panel(f"{block} {what}".strip(), tuple(ks), labels, unit_text(of)))
    return panels


def read_table(file: SbfFile) -> SignalTable | None:
    """The signals of a result; None when it has none. Raises SbfError."""
    if not (file.has("SIGNAL") and file.has("SIGNAME")):
        return None
    lines = [str(line).partition("\t") for line in file.header["SIGNAME"]]
    values = file.array("SIGNAL").reshape(file.steps, -1)
    require(len(lines) == values.shape[1], file.path, f"has {values.shape[1]} signals and {len(lines)} names")
    panels = [
        _panel(file, number, str(line), values.shape[1])
        for number, line in enumerate(file.header["SCOPES"] if file.has("SCOPES") else (), 1)
    ]
    return SignalTable(tuple(line[0] for line in lines), tuple(line[2] for line in lines), values, tuple(panels))


def _panel(file: SbfFile, number: int, line: str, count: int) -> Panel:
    """What a line of SCOPES says, whoever wrote it. Raises SbfError."""
    parts: list[Any] = [None] * 4
    with suppress(ValueError, KeyError, TypeError, RecursionError):
        found = json.loads(line)
        parts = [found[key] for key in ("title", "unit", "columns", "labels")]
    title, unit, columns, labels = parts
    texts = [title, unit, *labels] if isinstance(labels, list) else [None]
    right = isinstance(columns, list) and all(isinstance(text, str) for text in texts)
    require(right, file.path, f"line {number} of SCOPES is no description of a scope")
    right = all(type(k) is int and 1 <= k <= count for k in columns) and len(columns) == len(labels)
    text = f"line {number} of SCOPES needs a label and a signal from 1 to {count} for every curve"
    require(right, file.path, text)
    return Panel(title, tuple(k - 1 for k in columns), tuple(labels), unit)


def write_table(stem: Path, t: Sequence[float] | np.ndarray, table: SignalTable, source: Path) -> Path:
    """`stem.sbd` with time and signals only. Raises UsageError when it cannot be written."""
    path = stem.with_name(f"{stem.name}.sbd")
    header = {"TITLE": stem.name, "KIND": "signals", "VERSION": f"spacar {spacar.__version__}", "SOURCE": source.name}
    steps = ({"T": time, "SIGNAL": row} for time, row in zip(t, table.values, strict=True))
    with Claim(path) as claim:
        return write_steps(claim, header | table.header(), steps)


def write_motions(response: Response, stem: Path) -> list[Path]:
    """Write `stem.sbd`; with several mechanisms `stem_BLOCK.sbd` each. Returns the paths.

    Raises UsageError when a file cannot be written, AnalysisError when the disk refuses bytes.
    """
    plants = [b for b in response.diagram.blocks.values() if isinstance(b, Spasim)]
    table = table_of(response)
    written = []
    for plant in plants:
        x, u = response.x[:, response.states[plant.name]], response.u[:, response.inputs[plant.name]]
        frames = map(plant.frame, response.t.tolist(), x, u)
        steps = (sbd_values(frame) | {"SIGNAL": row} for frame, row in zip(frames, table.values, strict=True))
        name = stem.name if len(plants) == 1 else f"{stem.name}_{plant.name}"
        with Claim(stem.with_name(f"{name}.sbd")) as claim:
            written.append(write_steps(claim, sbd_header(Run(find_mode(1), plant.mechanism)) | table.header(), steps))
    return written


def export_signals(arrays: Mapping[str, np.ndarray], target: Path) -> None:
    """Arrays (steps,) or (steps, n) by name; in a `.csv` every column has the name and its number.

    Raises UsageError for another extension or a file that cannot be written.
    """
    plain = {_name(k): np.asarray(v) for k, v in arrays.items()}
    table: dict[str, np.ndarray] = {}
    for name, value in arrays.items():
        columns = np.asarray(value)
        table |= {name: columns} if columns.ndim == 1 else {f"{name}_{k}": c for k, c in enumerate(columns.T, 1)}
    export_to(target, {".npz": lambda: to_npz(plain, target), ".mat": lambda: to_mat(plain, target),
                       ".csv": lambda: to_csv(table, target)})  # fmt: skip


def _name(text: str) -> str:
    """A name that MATLAB and Python accept for a variable."""
    clean = "".join(c if c.isalnum() or c == "_" else "_" for c in text)
    return clean if clean[:1].isalpha() else f"b_{clean}"
