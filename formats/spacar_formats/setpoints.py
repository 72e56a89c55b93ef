"""The mode 2 result along which mode 3 linearizes: found by name, checked against the model
(reference/files.md 1)."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from spacar.errors import UsageError
from spacar.mechanism.numbering import Numbering
from spacar_formats.sbf import SbfError, SbfFile

Array = NDArray[np.float64]
INVERSE_DYNAMICS = 2


@dataclass(frozen=True)
class Nominal:
    """The nominal motion: one row a step, in the numbering (lnp, le) of its own file."""

    path: Path
    t: Array  # (steps,) [s]
    x: Array  # (steps, nx)
    xd: Array
    xdd: Array
    e: Array  # (steps, ne)
    ed: Array
    edd: Array
    sig: Array
    lnp: NDArray[np.int64]  # 1-based, 0 where nothing exists
    le: NDArray[np.int64]
    ln: NDArray[np.int64]
    keywords: tuple[str, ...]  # ETYPE


def find_setpoints(source: Path, name: str | None = None) -> Nominal:
    """The result `name`, or the one with the longest name that is the beginning of that of the input file.

    Raises UsageError with the names that were tried and why each was refused.
    """
    if name is not None:
        given = Path(name)
        paths = [given if given.suffix == ".sbd" else given.with_name(f"{given.name}.sbd")]
    else:
        stem = source.stem
        paths = [source.with_name(f"{stem[:length]}.sbd") for length in range(len(stem) - 1, 0, -1)]
    refused, absent = [], []
    for path in paths:
        if not path.is_file():
            absent.append(path.name)
            continue
        try:
            return _read(path)
        except SbfError as error:
            refused.append(str(error))
        except UsageError as error:
            refused.append(f"{path.name}: {error}")
    tried = (
        "; ".join([*refused, f"absent: {', '.join(absent)}"] if absent else refused)
        or "the name is too short"
    )
    raise UsageError(
        f"no mode 2 result to linearize along for {source.name} ({tried}); run `spacar 2` first, or name the "
        "result with --setpoints",
        "files.setpoints-not-found",
    )


def check_same_model(nominal: Nominal, n: Numbering) -> None:
    """Nodes and elements must be those of the nominal motion; classes may differ. Raises UsageError naming
    the first."""
    where = f"the mechanism differs from that of {nominal.path.name}"
    here = {number: (keyword, nodes) for number, keyword, nodes in n.elements}
    there = {
        i: (keyword, tuple(int(k) for k in nodes if k))
        for i, (keyword, nodes) in enumerate(zip(nominal.keywords, nominal.ln, strict=True), 1)
        if keyword
    }
    for element in sorted({*here, *there}):
        if here.get(element) != there.get(element):
            ours, theirs = (_described(elements.get(element)) for elements in (here, there))
            text = f"{where}: element {element} is {ours} here, {theirs} there"
            raise UsageError(text, "files.different-mechanism")
    for node in range(1, max(len(n.lnp), len(nominal.lnp)) + 1):
        sizes = [
            int(np.count_nonzero(table[node - 1])) if node <= len(table) else 0
            for table in (n.lnp, nominal.lnp)
        ]
        if sizes[0] != sizes[1]:
            text = f"{where}: node {node} has {sizes[0]} coordinates here, {sizes[1]} there"
            raise UsageError(text, "files.different-mechanism")


def _described(element: tuple[str, tuple[int, ...]] | None) -> str:
    return f"{element[0]} with nodes {' '.join(map(str, element[1]))}" if element else "absent"


def _read(path: Path) -> Nominal:
    with SbfFile(path) as file:
        mode = int(np.ravel(file.header["MODE"])[0]) if "MODE" in file.header else None
        if mode != INVERSE_DYNAMICS:
            raise UsageError(f"it is a result of mode {mode}", "files.not-mode-2")
        if not file.complete:
            raise UsageError("it is incomplete", "files.incomplete")
        return Nominal(
            path=path,
            t=np.ravel(file.get("T")).copy(),
            x=_rows(file, "x"),
            xd=_rows(file, "xd"),
            xdd=_rows(file, "xdd"),
            e=_rows(file, "e"),
            ed=_rows(file, "ed"),
            edd=_rows(file, "edd"),
            sig=_rows(file, "sig"),
            lnp=_table(file, "lnp"),
            le=_table(file, "le"),
            ln=_table(file, "ln"),
            keywords=tuple(str(k) for k in file.header["ETYPE"]),
        )


def _table(file: SbfFile, name: str) -> NDArray[np.int64]:
    return np.asarray(file.header[name]).astype(np.int64)


def _rows(file: SbfFile, name: str) -> Array:
    return np.array(file.get(name), dtype=float).reshape(file.steps, -1)
