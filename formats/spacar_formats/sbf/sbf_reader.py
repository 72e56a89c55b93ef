"""Random-access reader of SBF files (reference/files.md section 8 "Reading", section 4 "How getfrsbf returns data").

The step blocks are mapped into memory: only the requested steps are read. With `verify` (the default) a step that is
touched for the first time has its checksum and number checked, which reads its whole block; `verify=False` reads
nothing but the requested variable, for tools that scan one small variable of a huge file.
"""

from __future__ import annotations

import mmap
import os
import zlib
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

import numpy as np

from spacar.errors import UsageError
from spacar_formats.sbf.record_layout import (
    COMPLETE,
    DTYPES,
    PREAMBLE,
    TEXT,
    TRAILER,
    Record,
    SbfError,
    data_offset_of,
    decode,
    find,
    not_found,
    parse,
)


class Header(Mapping[str, "np.ndarray | list[str]"]):
    """The header variables of a file by name (any case, short or MATLAB name): (rows, cols) arrays, lines of text."""

    def __init__(self, file: SbfFile) -> None:
        self._file = file

    def __getitem__(self, name: str) -> np.ndarray | list[str]:
        ident = find(name, self._file.header_records)
        if ident is None:
            raise KeyError(name)
        return self._file.header_value(ident)

    def __iter__(self) -> Iterator[str]:
        return iter(self._file.header_records)

    def __len__(self) -> int:
        return len(self._file.header_records)


class SbfFile:
    """An open result file; a snapshot, when the file is still being written.

    Raises UsageError when the file cannot be opened and SbfError when the bytes are damaged; a damaged step
    only when it is asked for. Use it as a context manager or call `close`.
    """

    def __init__(self, path: str | os.PathLike[str], verify: bool = True) -> None:
        self.path = Path(path)
        self.verify = verify
        name = str(self.path)
        try:
            with open(self.path, "rb") as file:
                first = file.read(PREAMBLE.size)
                size = os.fstat(file.fileno()).st_size
                head = first + file.read(data_offset_of(first, size, name) - PREAMBLE.size)
                self.directory = parse(head, name)
                data, stride = self.directory.data_offset, self.directory.stride
                self.surplus = size - data - self.directory.committed * stride
                # A count beyond the end of the file: the file was cut off, or the machine stopped before all bytes
                # were on the disk.
                self.steps = min(self.directory.committed, (size - data) // stride)
                self._map = mmap.mmap(file.fileno(), data + self.steps * stride, access=mmap.ACCESS_READ)
        except OSError as err:
            raise UsageError(f"cannot open {name}: {err.strerror}", "files.open") from None
        except ValueError as err:  # the file shrank between the two looks at its size
            raise SbfError(f"{name} is damaged: {err}") from None
        self.head = head  # the bytes in front of the step blocks
        self.header_records = {r.id: r for r in self.directory.header}
        self.step_records = {r.id: r for r in self.directory.steps}
        self._good = np.zeros(self.steps, dtype=bool)
        self._blocks = np.ndarray((self.steps, stride), np.uint8, self._map, data, (stride, 1))

    @property
    def kind(self) -> str:
        """ "sbd", "sbm" or "ltv"."""
        return self.directory.kind

    @property
    def state(self) -> int:
        """0 being written or killed, 1 complete, 2 stopped early."""
        return self.directory.state

    @property
    def truncated(self) -> bool:
        """The file has fewer steps than it says."""
        return self.steps < self.directory.committed

    @property
    def complete(self) -> bool:
        """The run came to its end and all its steps are here."""
        return self.state == COMPLETE and not self.truncated

    @property
    def ids(self) -> tuple[str, ...]:
        """Identifiers, header variables first, in the order of the file."""
        return (*self.header_records, *self.step_records)

    @property
    def header(self) -> Header:
        return Header(self)

    def has(self, name: str) -> bool:
        """Whether a variable of this name (any case, short or MATLAB name) is in the file."""
        return find(name, self.header_records) is not None or find(name, self.step_records) is not None

    def variable(self, name: str) -> Record:
        """Type, rows, cols and role of a variable. Raises UsageError "ID not found"."""
        for records in (self.header_records, self.step_records):
            ident = find(name, records)
            if ident is not None:
                return records[ident]
        raise not_found(name, self.ids, str(self.path))

    def header_value(self, ident: str) -> np.ndarray | list[str]:
        """Value of a header variable under its exact identifier, as `get` gives it."""
        record = self.header_records[ident]
        return decode(record, self.head[record.offset : record.offset + record.length], str(self.path))

    def get(self, name: str, steps: int | Iterable[int] | None = None) -> np.ndarray | list[str]:
        """Value of a variable, for step variables at all steps or at the given ones (1, 2, ...).

        A header variable, one step, or a file of one step: the native (rows, cols) array, a vector as a
        column. Several steps: (number of steps, rows*cols), the values of a step column after column. Text: a
        list of lines. `TDEF` gives the number of steps as a 1 x 1 array.

        Raises UsageError for an unknown variable or step, SbfError when a step is damaged.
        """
        if name.strip().upper() == "TDEF" and steps is None:
            return np.array([[self.steps]])
        record = self.variable(name)
        if not record.is_step:
            if steps is not None:
                raise UsageError(f"{record.id} in {self.path} has one value, not one for each step", "files.step")
            return self.header_value(record.id)
        chosen = self.step_indices(steps)
        if self.verify:
            self.check_steps(chosen)
        here = self._blocks[:, record.offset : record.offset + record.length]
        raw = np.ascontiguousarray(here) if steps is None else here[chosen]
        if record.type == TEXT:
            return [line for row in raw for line in decode(record, row.tobytes(), str(self.path))]
        if len(chosen) == 1:
            return decode(record, raw.data, str(self.path))
        if record.size == 0:
            return np.zeros((len(chosen), 0))
        values = raw.view(DTYPES[record.type])
        return values.astype(values.dtype.newbyteorder("="), copy=False)

    def array(self, name: str, step: int | None = None) -> np.ndarray:
        """As `get`, of numbers as reals."""
        return np.asarray(self.get(name, step), float)

    def count(self, name: str) -> int:
        """The whole number of a header variable; KeyError without it."""
        return int(np.ravel(self.header[name])[0])

    def texts(self, name: str) -> tuple[str, ...]:
        """The lines of a header variable; none where it is not there or no text."""
        found = self.header.get(name)
        return tuple(found) if isinstance(found, list) else ()

    def time(self, step: int) -> float:
        """t of a step [s], or its load step; nan where the file has none."""
        return float(np.ravel(self.get("T", step))[0]) if self.has("T") else float("nan")

    def step_indices(self, steps: int | Iterable[int] | None) -> np.ndarray:
        """Zero-based indices of the given steps; one that is negative counts from the end.

        Raises UsageError for steps that the file does not have.
        """
        if steps is None:
            return np.arange(self.steps)
        wanted = list(steps) if isinstance(steps, Iterable) else [steps]
        if isinstance(steps, (int, np.integer)) and -self.steps <= steps < 0:
            wanted = [self.steps + 1 + int(steps)]
        wrong = [k for k in wanted if not isinstance(k, (int, np.integer)) or not 1 <= k <= self.steps]
        if wrong:
            there = f"steps 1 to {self.steps}" if self.steps else "no steps"
            raise UsageError(f"step {wrong[0]} does not exist: {self.path} has {there}", "files.step")
        return np.array(wanted, np.intp) - 1

    def damaged_steps(self, chosen: np.ndarray | None = None) -> np.ndarray:
        """Numbers (1, 2, ...) of the steps whose checksum or number is wrong, among the zero-based indices given."""
        todo = np.arange(self.steps) if chosen is None else np.unique(chosen)
        todo = todo[~self._good[todo]]
        data, stride = self.directory.data_offset, self.directory.stride
        bad = []
        with memoryview(self._map) as view:
            for k in todo.tolist():
                end = data + (k + 1) * stride
                number, crc = TRAILER.unpack_from(view, end - TRAILER.size)
                with view[end - stride : end - 4] as covered:
                    right = zlib.crc32(covered) == crc and number == (k + 1) & 0xFFFFFFFF
                if right:
                    self._good[k] = True
                else:
                    bad.append(k + 1)
        return np.array(bad, dtype=np.intp)

    def check_steps(self, chosen: np.ndarray) -> None:
        """Raise SbfError when one of the steps (zero-based) is damaged."""
        bad = self.damaged_steps(chosen)
        if bad.size:
            few = ", ".join(map(str, bad[:5])) + (", ..." if bad.size > 5 else "")
            raise SbfError(f"{self.path} is damaged: wrong checksum of step {few} ({bad.size} of {self.steps} steps)")

    def block(self, k: int) -> bytes:
        """A copy of the bytes of step block k (1, 2, ...)."""
        return self._blocks[self.step_indices(k)[0]].tobytes()

    def close(self) -> None:
        """Release the map; arrays returned by `get` stay valid."""
        self._blocks = np.zeros((0, self.directory.stride), np.uint8)
        self.steps = 0
        self._map.close()

    def __enter__(self) -> SbfFile:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
