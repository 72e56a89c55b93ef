"""`.ltv` files as `TimeVarying` records of the core, and back (reference/files.md section 6)."""

import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from spacar.errors import UsageError
from spacar.linearization.descriptor import dense_steps
from spacar.simulation.time_varying import TimeVarying
from spacar_formats import safety
from spacar_formats.locate import notes, open_result
from spacar_formats.sbf import SbfFile, SbfWriter
from spacar_formats.sparse_system import descriptor_of, is_sparse

COPIED = ("VERSION", "SOURCE", "SHA256", "MODE")
STEPS = {"A": "A", "B": "B", "C": "C", "D": "D", "M0": "m0", "C0B": "c0b", "K0B": "k0b"}
VECTORS = {"U0": "u0", "Y0": "y0", "SIG0": "sigma0"}


def read_ltv(name: str | os.PathLike[str]) -> tuple[TimeVarying, list[str]]:
    """The contents of the file `name` (extension optional), and what a user should know about it (stale, incomplete).

    Raises UsageError when there is no such file or no step in it, SbfError when it is damaged.
    """
    with open_result(name, "ltv") as file:
        warnings = notes(file)
        count = file.steps
        if not count:
            raise UsageError(f"{file.path.name} holds no step: there is nothing to compute with", "files.no-steps")
        data = TimeVarying(
            name=file.path.name,
            t=file.array("T").ravel(),
            n_nominal=file.count("NNOM") if file.has("NNOM") else 0,
            n_rigid=file.count("NRBM") if file.has("NRBM") else 0,
            second_rows=np.ravel(file.header.get("NYSI", ())).astype(np.int64) - 1,
            inputs=file.texts("UNAMES"),
            outputs=file.texts("YNAMES"),
            x0=file.array("X0").ravel() if file.has("X0") else None,
        )
        full: dict[str, Any] = {}
        if is_sparse(file):
            matrices = dense_steps((descriptor_of(file, k) for k in range(1, count + 1)), count)
            has_d = file.has("DFT") and file.count("DFT")
            full = {**matrices, "D": matrices["D"] if has_d else None}  # else only rounding
        found: dict[str, Any] = {name: _matrices(file, ident, count) for ident, name in STEPS.items()}
        found |= {name: _vectors(file, ident, count) for ident, name in VECTORS.items()}
        second = _matrices(file, "G", count)
        if second is not None:
            n = file.count("NX") // 2
            second = second.reshape(count, second.shape[1], n, n).swapaxes(-1, -2)
        return replace(data, second=second, **(found | full)), warnings


def write_ltv(data: TimeVarying, target: Path, source: Path) -> None:
    """Write a changed system; which program and input file it comes from is copied from the result `source`.

    Raises UsageError when the file cannot be written.
    """
    A, B, C = data.need("A", "B", "C")
    header: dict[str, Any] = {}
    with open_result(source, "ltv") as file:
        header |= {ident: file.header[ident] for ident in COPIED if file.has(ident)}
    header |= {
        "NNOM": data.n_nominal, "NX": A.shape[1], "NU": B.shape[2], "NY": C.shape[1], "NRBM": data.n_rigid,
        "NYS": len(data.second_rows), "DFT": int(data.D is not None),
        "X0": np.zeros(A.shape[1]) if data.x0 is None else data.x0,
    }  # fmt: skip
    names = {"UNAMES": data.inputs, "YNAMES": data.outputs}
    header |= {ident: list(lines) for ident, lines in names.items() if lines}
    if len(data.second_rows):
        header["NYSI"] = data.second_rows + 1
    fields = {ident: getattr(data, name) for ident, name in {**STEPS, **VECTORS}.items()}
    if data.second is not None:
        steps, rows, n, _ = data.second.shape
        fields["G"] = data.second.swapaxes(-1, -2).reshape(steps, rows, n * n)
    fields = {ident: value for ident, value in fields.items() if value is not None and value[0].size}
    shapes = {ident: value.shape[1:] if value.ndim == 3 else (value.shape[1], 1) for ident, value in fields.items()}
    with safety.replacing(target) as side, SbfWriter(side, "ltv", header, {"T": (1, 1), **shapes}) as writer:
        for k, t in enumerate(data.t):
            writer.append({"T": t} | {ident: value[k] for ident, value in fields.items()})


def _matrices(file: SbfFile, ident: str, count: int) -> np.ndarray | None:
    """(steps, rows, cols), None when the file does not have the variable."""
    if not file.has(ident):
        return None
    record = file.variable(ident)
    flat = file.array(ident)
    if count == 1:
        return flat.reshape(1, record.rows, record.cols)
    return flat.reshape(count, record.cols, record.rows).swapaxes(1, 2)


def _vectors(file: SbfFile, ident: str, count: int) -> np.ndarray | None:
    """(steps, length), None when the file does not have the variable."""
    return file.array(ident).reshape(count, -1) if file.has(ident) else None
