"""Append-only rows of a study: one line for every finished case, complete or absent.

Rows that came together are written with a single call, so they survive the process; they are on the disk at most SYNC
seconds later, as waiting for the disk costs more than a small case. A process that is killed leaves at most a piece of
a last line; it is cut off when the file is opened again. JSON lines hold anything; csv has its columns fixed by the
first row. Rows are told apart by the text `case`.
"""

from __future__ import annotations

import csv
import io
import json
import os
import time
from collections.abc import Sequence
from hashlib import sha256
from pathlib import Path
from typing import Any

from spacar.errors import UsageError

Row = dict[str, Any]
SYNC = 0.1  # seconds


class Rows:
    """The file of rows; use as a context. `done` holds the rows that were there, by `case`, the last of each.

    Raises UsageError when the file belongs to something else or another process is writing to it.
    """

    def __init__(self, path: Path, columns: Sequence[str]) -> None:
        self.path, self.columns = path, tuple(columns)
        self.csv = path.suffix.lower() == ".csv"
        self.done: dict[str, Row] = {}
        self._synced = 0.0

    def __enter__(self) -> Rows:
        self._file = self.path.open("a+b")
        try:
            _lock(self._file, self.path)
            self._file.seek(0)
            data = self._file.read()
            whole = data.rfind(b"\n") + 1
            if whole < len(data):
                self._file.truncate(whole)
            text = data[:whole].decode("utf-8")
            for row in self._read_csv(text) if self.csv else self._read_json(text):
                self.done[str(row["case"])] = row
            if self.csv and not whole:
                self._write(_csv_line(self.columns))
        except BaseException:
            self._file.close()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self._to_disk()
        self._file.close()

    def add(self, *rows: Row) -> None:
        """Append rows; they survive the process at once, and the machine after SYNC seconds."""
        if self.csv:
            lines = [_csv_line([_cell(row.get(name)) for name in self.columns]) for row in rows]
        else:
            lines = [json.dumps(row, default=_parts) + "\n" for row in rows]
        self._write("".join(lines))
        for row in rows:
            self.done[str(row["case"])] = row

    def _write(self, line: str) -> None:
        self._file.write(line.encode("utf-8"))
        self._file.flush()
        if time.monotonic() - self._synced > SYNC:
            self._to_disk()

    def _to_disk(self) -> None:
        os.fsync(self._file.fileno())
        self._synced = time.monotonic()

    def _read_csv(self, text: str) -> list[Row]:
        if not text:
            return []
        header, *lines = csv.reader(io.StringIO(text))
        if tuple(header) != self.columns:
            odd = ", ".join(sorted({*header} ^ {*self.columns})) or "the order"
            text = f"{self.path} has other columns than this study ({odd}); choose another --output"
            raise UsageError(text, "study.rows")
        return [dict(zip(header, line, strict=True)) for line in lines]

    def _read_json(self, text: str) -> list[Row]:
        try:
            rows = [json.loads(line) for line in text.splitlines()]
        except json.JSONDecodeError:
            rows = [None]
        if not all(isinstance(row, dict) and "case" in row for row in rows):
            raise UsageError(f"{self.path} does not hold rows of a study; choose another --output", "study.rows")
        return rows


def key(*parts: Any) -> str:
    """A short digest that tells cases apart: the same parts give the same key in every process."""
    return digest(key_text(parts))


def key_text(part: Any) -> str:
    """What of a part enters a key."""
    return json.dumps(_plain(part), sort_keys=True)


def digest(text: str) -> str:
    """The key of the text of all parts."""
    return sha256(text.encode()).hexdigest()[:16]


def _parts(value: Any) -> list[float]:
    """JSON has no complex numbers."""
    if isinstance(value, complex):
        return [value.real, value.imag]
    raise TypeError(f"{value!r} in a row")


def _plain(value: Any) -> Any:
    """JSON has no complex numbers: [real, imaginary]."""
    if isinstance(value, complex):
        return [value.real, value.imag]
    if isinstance(value, dict):
        return {k: _plain(v) for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(v) for v in value]
    return value


def _cell(value: Any) -> str:
    """Numbers with all their digits; a complex one as Python and NumPy read it."""
    if value is None:
        return ""
    if isinstance(value, complex):
        return repr(value).strip("()")
    return repr(value) if isinstance(value, float) else str(value)


def _csv_line(cells: Sequence[str]) -> str:
    line = io.StringIO()
    csv.writer(line, lineterminator="\n").writerow([" ".join(c.splitlines()) for c in cells])
    return line.getvalue()


def _lock(file: Any, path: Path) -> None:
    """One writer at a time; the lock ends with the process. Not on systems without flock."""
    try:
        import fcntl
    except ImportError:
        return
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise UsageError(f"{path} is being written by another study", "study.rows") from None
