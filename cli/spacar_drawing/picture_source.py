"""Where the numbers come from: a `.sbd` file (one step at a time), or a Result in memory.

The named quantities of a result of `spacar symbolic`, and the empty scene of one without points.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from spacar_formats.locate import open_result, stale_note
from spacar_formats.result_files import sbd_header
from spacar_formats.sbf import SbfFile
from spacar_formats.signal_tables import SignalTable, read_table

from spacar.arrays import Array
from spacar.errors import UsageError
from spacar.expressions.grammar import MATRICES, VECTORS
from spacar.frame import column
from spacar.modes import find_mode
from spacar.result import Result
from spacar.stream import Run
from spacar_drawing.scene import Scene
from spacar_drawing.settings import PictureSettings, parse_settings, read_settings

GROUPS = {"Q": "QNAME", "S": "SNAME", "U": "UNAME", "Y": "YNAME"}


def named_columns(file: SbfFile) -> dict[str, Array]:
    """(steps,) by name: states, inputs and outputs of a result of `spacar symbolic`; of another result nothing."""
    named: dict[str, Array] = {}
    if "symbolic" in file.header.get("KIND", ""):
        for letter, names in GROUPS.items():
            if file.has(letter):
                values = np.asarray(file.get(letter)).reshape(file.steps, -1)
                named |= dict(zip((str(n) for n in file.header[names]), values.T, strict=True))
    return named


def nothing(title: str) -> Scene:
    """A moving scene without elements: mode 1 says that the steps are times."""
    none, whole = np.zeros((0, 0)), np.zeros((0, 0), int)
    return Scene(
        planar=True, mode=1, title=title, keywords=(), lnp=whole, le=whole, ln=whole, frame_p=none, frame_q=none,
        length=none, data=none, stiffness=none, damping=none, quadratic=whole, nxp=whole, nep=whole,
    )  # fmt: skip


LEVELS = {"dx": "0 1", "de": "0 1", "dxc": "0 1", "dec": "0 1", "d2x": "0 2", "d2e": "0 2"}
ALIASES = {"fxtot": "fxt"}
NEEDED = (
    "ETYPE", "MODE", "LNP", "LE", "LN", "RXYZ", "RQ", "RL0", "DR0", "STIF", "EDAMP", "KDEF", "NXP", "NEP", "T", "X",
)  # fmt: skip


@dataclass(frozen=True)
class PictureSource:
    """A result to be drawn. `read(name, k)` gives a variable of step k (from 1), or of all (k None, step first)."""

    scene: Scene
    settings: PictureSettings
    steps: int
    name: str  # of the result, for messages
    input: Path | None  # the input file beside the result, if there is one
    read: Callable[[str, int | None], Array | None]
    header: Mapping[str, Any]
    complete: bool = True
    named: Mapping[str, Array] = field(default_factory=dict)  # of `spacar symbolic`: (steps,) by name
    signals: SignalTable | None = None  # of a simulation

    def get(self, name: str, k: int | None = None) -> Array:
        """A variable of step k, (n,) or (rows, cols); of all steps with one more first axis. UsageError if absent."""
        value = self.read(name, k)
        if value is None:
            level = LEVELS.get(name.lower())
            advice = f"; put OUTLEVEL {level} into the kinematics block and run again" if level else ""
            raise UsageError(f"{self.name} does not contain {name}{advice}", "draw.missing")
        return value

    def x(self, k: int | None = None) -> Array:
        """Coordinates; UsageError when there is nothing to draw because they are not finite, or beyond 1e100."""
        value = self.get("x", k)
        if not np.all(np.abs(value) <= 1e100):
            step = f"step {k}" if k is not None else "a step"
            raise UsageError(f"{self.name}: coordinates of {step} are not finite or beyond 1e100", "draw.finite")
        return value

    def require(self, k: int) -> None:
        """Raises UsageError for a step that there is not."""
        if not 1 <= k <= self.steps:
            raise UsageError(f"step {k} does not exist: {self.name} has steps 1 to {self.steps}", "files.step")

    def time(self, k: int) -> float:
        return float(np.ravel(self.get("t", k))[0])

    def beside(self, ending: str) -> Path:
        """A file with the name of the result and another ending."""
        return Path(self.name).parent / f"{self.scene.title}{ending}"


def open_source(name: str | Path, stale_ok: bool = False, drawn: bool = True) -> PictureSource:
    """The `.sbd` result of this name (extension optional), with the settings of the input file beside it.

    A result of `spacar symbolic` has its quantities in `named`; with `drawn=False` it may be without nodes. Raises
    UsageError when there is no result, when it has no steps, or when the input file has changed since (unless
    `stale_ok`). The file stays open as long as the PictureSource lives; only what is asked for is read.
    """
    wanted = Path(name)
    if wanted.suffix.lower() in (".dat", ".sbm", ".ltv", ".toml", ".py"):
        wanted = wanted.with_suffix("")
    file = open_result(wanted, "sbd")
    kind = file.header.get("KIND", "")
    symbolic = "symbolic" in kind or "signals" in kind
    missing = [ident for ident in NEEDED if not file.has(ident)]
    if missing and symbolic and drawn:
        raise UsageError(f"{file.path} has no points that could be drawn: use spacar plot", "draw.symbolic")
    if missing and not symbolic:
        raise UsageError(f"{file.path} has no {missing[0]}: it is not the result of a mode", "draw.missing")
    note = stale_note(file)
    if note and not stale_ok:
        raise UsageError(f"{note}, or draw it as it is with --stale-ok", "draw.stale")
    if not file.steps:
        raise UsageError(f"{file.path} contains no steps: the run stopped before the first one", "draw.empty")
    stem = file.path.name.removesuffix(".part").removesuffix(".bak").removesuffix(".sbd")
    source = file.header.get("SOURCE")
    origin = source[0].replace("\0", "") if isinstance(source, list) and source else f"{stem}.dat"
    beside = None if symbolic else file.path.parent / Path(origin).name
    header = dict(file.header.items())

    def read(variable: str, k: int | None) -> Array | None:
        ident = ALIASES.get(variable.lower(), variable.lower())
        if ident in (*VECTORS, *MATRICES):
            with matrices_beside(str(file.path), header) as matrices:
                return _of_steps(matrices, ident, k)
        return _of_steps(file, ident, k)

    settings = PictureSettings() if beside is None else read_settings(beside)
    return PictureSource(
        nothing(stem) if missing else Scene.of_header(header, stem, settings.metre), settings, file.steps,
        str(file.path), beside if beside is not None and beside.is_file() else None, read, header, file.complete,
        named_columns(file), read_table(file),
    )  # fmt: skip


def _of_steps(file: SbfFile, ident: str, k: int | None) -> Array | None:
    """A variable of step k, or of all with the step first; None where the file does not have it."""
    records = {i.lower(): r for i, r in file.step_records.items()}
    if ident not in records:
        return None
    rows, cols = records[ident].rows, records[ident].cols
    value = np.asarray(file.get(ident, k))
    if k is not None:
        return value.reshape(rows, cols) if cols > 1 else value.ravel()
    # several steps come one a row, column-major; one step in its own shape
    flat = value.reshape(1, -1, order="F") if file.steps == 1 else value
    return flat if cols == 1 else flat.reshape(-1, cols, rows).swapaxes(1, 2)


def matrices_beside(name: str, header: Mapping[str, Any]) -> SbfFile:
    """The `.sbm` file beside a `.sbd` result with this name and header. UsageError when there is none, or when it
    belongs to another input."""
    path = Path(name)
    file = open_result(path.with_name(path.name.replace(".sbd", ".sbm")), "sbm")
    ours, theirs = (np.ravel(h.get("SHA256", [""]))[0] for h in (header, file.header))
    if ours != theirs or file.count("MODE") != int(np.ravel(header["MODE"])[0]):
        raise UsageError(f"{file.path} and {name} are of different runs; run again", "draw.stale")
    return file


def source_of_result(result: Result) -> PictureSource:
    """The same of a Result in memory (tests, scripts, live window)."""
    header = sbd_header(Run(find_mode(result.mode), result.mechanism))
    frames: Sequence[Any] = result.frames
    deck = result.mechanism.deck
    settings = replace(parse_settings(deck.visualization), metre=deck.metre)

    def read(variable: str, k: int | None) -> Array | None:
        name = "fxtot" if variable.lower() in ALIASES.values() else variable.lower()
        if not len(frames):
            return None
        value = column(frames, name) if k is None else frames[k - 1].value(name)
        return None if value is None else np.array(value, float)

    title = Path(deck.source).stem
    scene = Scene.of_header(header, title, settings.metre)
    return PictureSource(scene, settings, len(frames), title, None, read, header)
