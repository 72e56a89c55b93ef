"""Stream writer of SBF files (reference/files.md section 8, "Writing").

Each step is handed to the operating system before the count of steps in the file grows, so a process that is killed
leaves a file with whole steps only. The disk is forced only once, at the end: the page cache survives the process.
"""

from __future__ import annotations

import os
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from spacar.errors import AnalysisError, UsageError
from spacar_formats.sbf.record_layout import (
    COMPLETE,
    COUNT,
    COUNT_IN_RECORD,
    PREAMBLE,
    STATE_AT,
    STOPPED,
    TRAILER,
    Value,
    build,
    padded,
)


class SbfWriter:
    """Writes one file: the header at once, then step after step.

    `kind` is "sbd", "sbm" or "ltv". `header` maps identifiers to numbers, arrays (at most two dimensions; a
    vector becomes a column) or text. `step_variables` maps identifiers to (rows, cols); all are real. An
    existing file of that name is unlinked first, so that a reader who still has it mapped keeps the old
    bytes; or `file` is an open, empty file at that place.

    Raises ValueError for what the container cannot hold, UsageError when the file cannot be created.
    """

    def __init__(
        self, path: str | os.PathLike[str], kind: str, header: Mapping[str, Value],
        step_variables: Mapping[str, tuple[int, int]], file: BinaryIO | None = None,
    ) -> None:  # fmt: skip
        head = build(kind, header, step_variables)
        self.path = Path(path)
        self.steps = 0
        (*_, tdef_offset, self._end, stride, _, _, _) = PREAMBLE.unpack_from(head)
        self._count_at = tdef_offset + COUNT_IN_RECORD
        self._block = bytearray(stride)
        self._covered = memoryview(self._block)[:-4]
        self._slots: list[tuple[str, tuple[int, ...], np.ndarray]] = []
        at = 0
        for name, (rows, cols) in step_variables.items():
            shape = (rows * cols,) if 1 in (rows, cols) else (rows, cols)  # n x 1 and 1 x n are 1-D
            flat = np.frombuffer(self._block, "<f8", rows * cols, at)
            self._slots.append((name, shape, flat.reshape(shape, order="F")))
            at += padded(flat.nbytes)
        try:
            if file is None:
                self.path.unlink(missing_ok=True)
                file = open(self.path, "xb", buffering=0)  # noqa: SIM115 (open for the life of the writer)
            self._file = file
        except OSError as err:
            raise UsageError(f"cannot create {self.path}: {err.strerror}", "files.open") from None
        self._write(0, head)

    def append(self, values: Mapping[str, Any]) -> None:
        """Write one step: an array for every step variable, named as in `step_variables`, and no others.

        Vectors may be given as (n,), (n, 1) or (1, n). Raises ValueError for a missing, unknown or wrongly
        sized value (nothing is written then) and AnalysisError when the disk refuses the bytes.
        """
        if len(values) != len(self._slots):
            raise ValueError(f"step variables expected: {[s[0] for s in self._slots]}, given: {list(values)}")
        for name, shape, view in self._slots:
            try:
                value = np.asarray(values[name], dtype=np.float64)
            except KeyError:
                raise ValueError(f"no value for the step variable {name}") from None
            if value.shape != shape:  # a vector written as a matrix, or a number as a vector of one
                vector = len(shape) == 1 and sum(length != 1 for length in value.shape) <= 1
                if not vector or value.size != shape[0]:
                    raise ValueError(f"{name} has the shape {value.shape}, its definition says {shape}")
                value = value.reshape(shape)
            view[...] = value
        block, k = self._block, self.steps + 1
        TRAILER.pack_into(block, len(block) - 8, k & 0xFFFFFFFF, 0)
        block[-4:] = zlib.crc32(self._covered).to_bytes(4, "little")
        self._write(self._end, block)
        self._write(self._count_at, COUNT.pack(k))
        self._end += len(block)
        self.steps = k

    def close(self, complete: bool = True) -> None:
        """Force the bytes to the disk, then mark the file complete or stopped early. A second call does nothing."""
        if self._file.closed:
            return
        try:
            os.fsync(self._file.fileno())
            self._write(STATE_AT, bytes([COMPLETE if complete else STOPPED]))
        except OSError as err:
            raise AnalysisError(f"cannot write {self.path}: {err.strerror}", "files.write") from None
        finally:
            self._file.close()

    def __enter__(self) -> SbfWriter:
        return self

    def __exit__(self, kind: object, *_: object) -> None:
        self.close(complete=kind is None)

    def _write(self, at: int, data: bytes | bytearray) -> None:
        """Put bytes at a place; a disk that takes only a part is asked again for the rest."""
        try:
            self._file.seek(at)
            done = self._file.write(data)
            while done < len(data):
                done += self._file.write(memoryview(data)[done:])
        except OSError as err:
            text = f"cannot write {self.path} (step {self.steps + 1}): {err.strerror}; earlier steps are kept"
            raise AnalysisError(text, "files.write") from None
