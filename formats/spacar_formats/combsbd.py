"""combsbd: put the steps of several `.sbd` files one after the other into one (reference/files.md sections 7 and 9).

The original SPACAR overwrites the output without warning; here an existing file is replaced only with `force`.
"""

import os
import zlib
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path

import numpy as np

from spacar.errors import UsageError
from spacar_formats.locate import open_result
from spacar_formats.safety import replacing
from spacar_formats.sbf import SbfFile
from spacar_formats.sbf.record_layout import COMPLETE, COUNT, COUNT_IN_RECORD, STATE_AT, STOPPED, TRAILER

# Header variables that say which mechanism it is; all others are taken from the first file.
_MECHANISM = ("NX", "NE", "NXP", "NEP", "LNP", "LE", "LN", "IT")


def combsbd(
    names: Sequence[str | os.PathLike[str]], output: str | os.PathLike[str], force: bool = False
) -> tuple[Path, int]:
    """Write the steps of the files `names` (in this order) to `output`; returns its path and number of steps.

    The step variables and the mechanism must be the same in all files; the header is that of the first, and
    times are kept as they are. The result is complete when all files are. An existing output is replaced only
    with `force`. Raises UsageError for all this, SbfError for a damaged step.
    """
    target = Path(output)
    if not target.name:
        raise UsageError(f"cannot write {target}: it is a folder", "files.open")
    if target.suffix.lower() != ".sbd":
        target = target.with_name(target.name + ".sbd")
    if len(names) < 2:
        raise UsageError("combsbd needs two or more files", "files.combine")
    if target.exists() and not force:
        text = f"{target} exists and may hold the only copy of a result; the original overwrites it without a word,"
        how = "--overwrite (in MATLAB '-force', in Python force=True)"
        raise UsageError(f"{text} here {how} replaces it", "files.exists")
    with ExitStack() as stack:
        files = [stack.enter_context(open_result(name, "sbd")) for name in names]
        for other in files[1:]:
            _check_same(files[0], other)
        head = bytearray(files[0].head)
        total = sum(file.steps for file in files)
        at = files[0].directory.tdef_offset + COUNT_IN_RECORD
        head[at : at + COUNT.size] = COUNT.pack(total)
        head[STATE_AT] = COMPLETE if all(file.complete for file in files) else STOPPED
        with replacing(target) as side, open(side, "wb") as out:
            out.write(head)
            number = 0
            for file in files:
                for k in range(1, file.steps + 1):
                    number += 1
                    file.check_steps(np.array([k - 1]))
                    covered = file.block(k)[: -TRAILER.size] + (number & 0xFFFFFFFF).to_bytes(4, "little")
                    out.write(covered + zlib.crc32(covered).to_bytes(4, "little"))
    return target, total


def _check_same(first: SbfFile, other: SbfFile) -> None:
    a, b = first.step_records, other.step_records
    if list(a.values()) != list(b.values()):
        for ident in dict.fromkeys((*a, *b)):
            if ident not in a or ident not in b:
                where = other.path if ident in a else first.path
                raise UsageError(f"{where} has no step variable {ident}, the other file has", "files.combine")
            if a[ident] != b[ident]:
                sizes = f"{a[ident].rows} x {a[ident].cols} in {first.path}, {b[ident].rows} x {b[ident].cols}"
                raise UsageError(f"the step variable {ident} is {sizes} in {other.path}", "files.combine")
        raise UsageError(f"the step variables of {first.path} and {other.path} differ in order", "files.combine")
    for ident in _MECHANISM:
        mine, theirs = first.header.get(ident), other.header.get(ident)
        if (mine is None) != (theirs is None) or (mine is not None and not np.array_equal(mine, theirs)):  # type: ignore[arg-type]
            text = f"{first.path} and {other.path} are of different mechanisms: {ident} differs"
            raise UsageError(text, "files.combine")
