"""The result along which mode 3 linearizes: found by name and read (reference/files.md 1).

From the name of the input file at least one character is removed from the right until a valid, complete result
`<shorter>.sbd` of mode 2, or of mode 7 to 10, is found; the longest name wins. A result that was computed from another
version of its input file is refused, unless the user named it.
"""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from spacar.arrays import Array
from spacar.errors import UsageError
from spacar.inverse.nominal import Nominal
from spacar.modes import MODES
from spacar_formats.locate import stale_note
from spacar_formats.safety import backup_path
from spacar_formats.sbf import SbfError, SbfFile


def find_setpoints(source: Path, name: str | None = None) -> Nominal:
    """The result `name`, or the one with the longest name that is the beginning of that of the input file.

    Raises UsageError with the names that were tried and why each was refused.
    """
    if name is not None:
        given = Path(name)
        paths = [given if given.name.endswith((".sbd", ".sbd.bak")) else given.parent / f"{given.name}.sbd"]
    else:
        stem = source.stem
        paths = [source.with_name(f"{stem[:length]}.sbd") for length in range(len(stem) - 1, 0, -1)]
    refused, absent = [], []
    for path in paths:
        if not path.is_file():
            absent.append(path.name)
            continue
        try:
            nominal, stale = _read(path)
        except UsageError as error:
            refused.append(str(error) if isinstance(error, SbfError) else f"{path.name}: {error}")
            continue
        if stale is not None and name is None:
            hint = f"or name it with --setpoints {path.stem} to use it as it is"
            raise UsageError(f"the mode {nominal.mode} result is stale: {stale}, {hint}", "files.setpoints-stale")
        return nominal if stale is None else replace(nominal, warnings=(stale,))
    refused += [f"absent: {', '.join(absent)}"] if absent else []
    tried = "; ".join(refused) or "the name is too short"
    text = f"no mode 2 result to linearize along for {source.name} ({tried}); run `spacar 2` first (or `spacar 10`,"
    text += " whose load steps do as well), or name the result with --setpoints"
    raise UsageError(text, "files.setpoints-not-found")


def _read(path: Path) -> tuple[Nominal, str | None]:
    """The nominal motion of a result, and the sentence that says it is stale."""
    with SbfFile(path) as file:
        mode = file.count("MODE") if "MODE" in file.header else None
        if mode not in MODES or not MODES[mode].nominal:
            before = backup_path(path)
            kept = f" ({before.name} is the one before: name it with --setpoints)" if before.is_file() else ""
            raise UsageError(f"it is a result of mode {mode}{kept}", "files.not-mode-2")
        if not file.complete:
            raise UsageError("it is incomplete", "files.incomplete")
        fixed, _, prescribed = np.ravel(file.header["NEP"])[:3].astype(int)
        arrays: dict[str, Any] = {name: _rows(file, name) for name in ("x", "xd", "xdd", "e", "ed", "edd", "sig")}
        arrays |= {name: np.asarray(file.header[name]).astype(np.int64) for name in ("lnp", "le", "ln")}
        nominal = Nominal(
            name=path.name, t=file.array("T").ravel(), **arrays, keywords=tuple(str(k) for k in file.header["ETYPE"]),
            n_fixed=int(fixed), n_given=int(fixed + prescribed), mode=mode,
        )  # fmt: skip
        if MODES[mode].gives_setpoints:
            nominal = replace(nominal, u0=_inputs(path.with_suffix(".ltv"), len(nominal.t)))
        return nominal, stale_note(file)


def _inputs(path: Path, steps: int) -> Array | None:
    """The nominal inputs of the same run, for comparison; None when they are not beside the result."""
    try:
        with SbfFile(path) as file:
            return _rows(file, "U0") if file.complete and file.has("U0") and file.steps == steps else None
    except UsageError:
        return None


def _rows(file: SbfFile, name: str) -> Array:
    return file.array(name).reshape(file.steps, -1)
