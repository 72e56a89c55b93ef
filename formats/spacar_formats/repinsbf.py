"""repinsbf: replace the value of one variable (reference/files.md sections 7 and 9).

The target is never changed in place: a complete copy with the new value and new checksums takes its name.
"""

import os
import shutil
import zlib
from collections.abc import Sequence

import numpy as np

from spacar.errors import UsageError
from spacar_formats.locate import open_result
from spacar_formats.safety import replacing
from spacar_formats.sbf import Record
from spacar_formats.sbf.record_layout import DTYPES, PREAMBLE, REAL, TEXT, encode_text, padded, preamble


def repinsbf(
    name: str | os.PathLike[str], ident: str, value: np.ndarray | float | str | Sequence, step: int | None = None
) -> None:
    """Replace a header variable, or a step variable at one step (1, 2, ...; -1 the last).

    The size must be that of the stored variable: (rows, cols), or (n,) for a vector, or a number for 1 x 1; text must
    have the same number of lines, none longer than the stored width. Raises UsageError otherwise, for an unknown
    variable or step and when the file cannot be written; SbfError when what is replaced is damaged.
    """
    with open_result(name) as file:
        record = file.variable(ident)
        payload = _payload(record, value, str(file.path))
        if record.is_step != (step is not None):
            need = "needs a step number" if record.is_step else "has one value, a step number is not possible"
            raise UsageError(f"{record.id} in {file.path} {need}", "files.step")
        path, where = file.path.resolve(), file.directory
        if step is None:
            head = bytearray(file.head)
            head[record.offset : record.offset + len(payload)] = payload
            body = bytes(head[PREAMBLE.size :])
            at, new = 0, preamble(file.kind, file.state, where.tdef_offset, where.stride, body) + body
        else:
            chosen = file.step_indices(step)
            file.check_steps(chosen)
            block = bytearray(file.block(int(chosen[0]) + 1))
            block[record.offset : record.offset + len(payload)] = payload
            block[-4:] = zlib.crc32(block[:-4]).to_bytes(4, "little")
            at, new = where.data_offset + int(chosen[0]) * where.stride, bytes(block)
    with replacing(path) as side:
        shutil.copyfile(path, side)
        with open(side, "r+b") as out:
            out.seek(at)
            out.write(new)


def _payload(record: Record, value: np.ndarray | float | str | Sequence, file: str) -> bytes:
    """Bytes of the new value, padded. Raises UsageError when type or size differ from the record."""
    shape = (record.rows, record.cols)
    if record.type == TEXT:
        lines = [value] if isinstance(value, str) else list(np.ravel(np.asarray(value)))
        if len(lines) != record.rows or not all(isinstance(line, str) for line in lines):
            raise UsageError(f"{record.id} in {file} is text of {record.rows} lines", "files.size")
        try:
            data = encode_text([str(line) for line in lines], record.cols)[3]
        except ValueError as err:
            raise UsageError(f"{record.id} in {file}: {err}", "files.size") from None
        return data.ljust(padded(len(data)), b"\0")
    try:
        array = np.asarray(value)
    except (ValueError, OverflowError):
        raise UsageError(f"the rows of the new value of {record.id} have different lengths", "files.size") from None
    if array.dtype.kind not in "biuf":
        raise UsageError(f"{record.id} in {file} holds numbers, the new value does not", "files.size")
    if not np.isfinite(array).all():
        raise UsageError(f"the new value of {record.id} must be finite", "files.value")
    vector = array.ndim <= 1 and 1 in shape and array.size == record.size
    if not vector and array.shape != shape:
        text = f"{record.id} in {file} is {shape[0]} x {shape[1]}, the new value has the shape {array.shape}"
        raise UsageError(text, "files.size")
    with np.errstate(all="ignore"):
        stored = array.astype(DTYPES[record.type])
    if array.dtype.kind == "f" and record.type != REAL and not np.array_equal(stored, array):
        raise UsageError(f"{record.id} in {file} holds integers, the new value has a fraction", "files.size")
    return stored.tobytes(order="F")
