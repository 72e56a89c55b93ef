"""Do the files of a run fit on the disk? Asked before its first step: the number of steps times what a step takes.

A step of a result file is its variables, 8 bytes a number, and a trailer of 8 (files.md section 8); of the log a line.
Matrices are counted as full ones, those of large models (sparse equations) and the eigenvectors not at all.
"""

import shutil
from pathlib import Path

from spacar.errors import UsageError
from spacar.stream import Run

LINE = 81  # characters of a line of the list of steps, with the counters of an integration
TRAILER = 8
NUMBER = 20  # characters of a number in a table, with its comma
LARGE = 200  # degrees of freedom from which matrices are sparse (MODES)
IN, OUT = ("INPUT", "INE", "INX", "NOM"), ("OUT", "REF")
UNITS = ("bytes", "kB", "MB", "GB", "TB", "PB")


def steps_of(run: Run) -> int:
    s, deck = run.mechanism.settings, run.mechanism.deck
    if run.mode.gives_setpoints:
        legs = [trtime.integers(1) for trtime in deck.of("TRTIME", block=3)]
        return 1 + sum(leg[0] * (leg[1] if len(leg) > 1 else 1) for leg in legs)
    if run.mode.takes_setpoints:
        return len(run.nominal.t) if run.nominal is not None else 1
    if run.mode.stationary:
        return s.stored_levels
    return 1 + (s.n_steps if s.duration is not None else 0)


def bytes_of_a_step(run: Run) -> dict[str, int]:
    """Of each file of the mode, and of the log."""
    n, s = run.mechanism.numbering, run.mechanism.settings
    level = s.sbd_level if s.sbd_level is not None else int(run.mode.stationary)
    first, second = (level < 0 or bool(level & flag) for flag in (1, 2))
    numbers = 1 + 6 * n.nx + 4 * n.ne
    numbers += first * (n.nx + n.ne) * (n.nkdof + n.ndof) + second * (n.nx + n.ne) * n.nkdof**2
    sizes = {"log": LINE, "sbd": 8 * numbers + TRAILER}
    free = n.ndof if run.mode.takes_setpoints else n.nddof
    full = 0 if free > LARGE else free
    if "sbm" in run.mode.files:
        sizes["sbm"] = 8 * (1 + 6 * full**2) + TRAILER
    if "ltv" in run.mode.files:
        third = run.mechanism.deck.block(3)
        inputs, outputs = (sum(len(rows) for k, rows in third.items() if k.startswith(of)) for of in (IN, OUT))
        matrices = (2 * full + outputs) * (2 * full + inputs)
        sizes["ltv"] = 8 * (1 + (inputs + outputs if run.mode.gives_setpoints else matrices)) + TRAILER
    return sizes


def require_room(run: Run, folder: Path) -> None:
    """Raises UsageError when the files of the run take more than is free on the disk of their folder."""
    steps = steps_of(run)
    sizes = {kind: steps * size for kind, size in bytes_of_a_step(run).items()}
    _require(sizes, f"the results of {steps} steps", "store fewer steps, choose another --output-dir", folder)


def require_room_for_rows(rows: int, columns: int, folder: Path) -> None:
    _require({"rows": rows * columns * NUMBER}, f"{rows} rows", "ask for fewer cases", folder)


def _require(sizes: dict[str, int], what: str, advice: str, folder: Path) -> None:
    needed, free = sum(sizes.values()), shutil.disk_usage(folder).free
    if needed > free:
        each = ", ".join(f"{kind} {_size(size)}" for kind, size in sizes.items())
        text = f"{what} take {_size(needed)} ({each}), but {_size(free)} are free in {folder.resolve()}"
        raise UsageError(f"{text}; {advice}, or go on with --force", "files.room")


def _size(count: float) -> str:
    k = 0
    while count >= 1000.0 and k < len(UNITS) - 1:
        count, k = count / 1000.0, k + 1
    return f"{count:.3g} {UNITS[k]}"
