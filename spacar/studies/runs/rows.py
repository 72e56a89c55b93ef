"""Append-only rows of a study: one line for every finished case, complete or absent.

Rows that came together are written with a single call, so they survive the process; they are on the disk at most SYNC
seconds later, as waiting for the disk costs more than a small case. A process that is killed leaves at most a piece of
a last line; it is cut off when the file is opened again. JSON lines hold anything; csv has its columns fixed by the
first row. Rows are told apart by the text `case`.

A file that was edited, or saved by another program, goes on when its rows can be told: with a byte order mark, empty
lines, short rows, a last line without an end. One that is not of this study is not touched.
"""

import csv
import io
import json
import os
import time
from collections.abc import Sequence
from hashlib import sha256
from pathlib import Path
from typing import Any

from spacar import locks
from spacar.errors import UsageError, shown

Row = dict[str, Any]
SYNC = 0.1  # seconds
BEGIN = b'{"case": "'  # of a row in JSON


class Rows:
    """The file of rows; use as a context. `done` holds the rows that were there, by `case`, the last of each.

    Raises UsageError when the file belongs to something else or another process is writing to it.
    """

    def __init__(self, path: Path, columns: Sequence[str]) -> None:
        self.path, self.columns = path, tuple(columns)
        self.csv = path.suffix.lower() == ".csv"
        self.done: dict[str, Row] = {}
        self._synced = 0.0
        self._release: locks.Release | None = None

    def __enter__(self) -> "Rows":
        """Read what is there; nothing of the file changes before all of it was understood."""
        if self.path.exists() and not self.path.is_file():
            raise UsageError(f"{self.path} is no file: rows are read before others are added", "study.rows")
        self._file = self.path.open("a+b")
        try:
            self._release = locks.lock(self._file.fileno(), self.path)
            if self._release is None:
                held = locks.holder(self.path)
                raise UsageError(f"{self.path} is being written by another study{held}", "study.rows")
            self._file.seek(0)
            data = self._file.read()
            rows, whole = self._read_csv(data) if self.csv else self._read_json(data)
            self.done.update((str(row["case"]), row) for row in rows)
            if whole < len(data):
                self._file.truncate(whole)
            if self.csv and not whole:
                self._write(_csv_line(self.columns))
            elif whole and not data[:whole].endswith(b"\n"):
                self._write("\n")
        except BaseException:
            self._close()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self._to_disk()
        self._close()

    def _close(self) -> None:
        if self._release is not None:
            self._release()
        self._file.close()

    def add(self, *rows: Row) -> None:
        """Append rows; they survive the process at once, and the machine after SYNC seconds."""
        if self.csv:
            lines = [_csv_line([_cell(row.get(name)) for name in self.columns]) for row in rows]
        else:
            lines = [json.dumps(row, default=_parts) + "\n" for row in rows]
        self._write("".join(lines))
        self.done.update((str(row["case"]), row) for row in rows)

    def _write(self, line: str) -> None:
        self._file.write(line.encode("utf-8"))
        self._file.flush()
        if time.monotonic() - self._synced > SYNC:
            self._to_disk()

    def _to_disk(self) -> None:
        os.fsync(self._file.fileno())
        self._synced = time.monotonic()

    def _read_csv(self, data: bytes) -> tuple[list[Row], int]:
        """The rows, and up to which byte the file is whole."""
        own = _csv_line(self.columns).encode()
        if own.startswith(data):  # nothing, or a piece of the header
            return [], 0 if len(data) < len(own) else len(data)
        whole = data.rfind(b"\n") + 1 or len(data)
        lines = self._cells(self._text(data[:whole]))
        header = lines.pop(0)[1] if lines else []
        if tuple(header) != self.columns:
            odd = ", ".join(sorted({*header} ^ {*self.columns})) or "the order"
            raise self._refusal(f"has other columns than this study ({shown(odd)})")
        try:  # the last line: complete (saved by another program), or what a killed process left, perhaps of a reason
            rest = csv.reader([data[whole:].decode()], strict=True)
            last = [line for line in rest if len(line) == len(header) and not line[-1]]
        except (csv.Error, UnicodeDecodeError):
            last = []
        if last:
            lines.append((len(lines) + 2, last[0]))
            whole = len(data)
        for number, line in lines:
            if any(line[len(header) :]):
                raise self._refusal(f"has a row with {len(line)} cells under {len(header)} columns in line {number}")
        return [dict(zip(header, line + [""] * len(header), strict=False)) for _, line in lines], whole

    def _cells(self, text: str) -> list[tuple[int, list[str]]]:
        """Number of the line and cells of the rows that are not empty."""
        reader = csv.reader(io.StringIO(text, newline=""))
        try:
            return [(reader.line_num, line) for line in reader if any(line)]
        except csv.Error as error:
            raise self._refusal(f"cannot be read as csv ({error} in line {reader.line_num})") from None

    def _read_json(self, data: bytes) -> tuple[list[Row], int]:
        self._text(data[: data.rfind(b"\n") + 1])
        rows, whole, at = [], 0, 0
        for number, line in enumerate(data.splitlines(keepends=True), 1):
            at += len(line)
            try:
                row = json.loads(line.decode("utf-8-sig")) if line.strip() else None
            except (ValueError, RecursionError):
                row = ""
            if row is not None and not (isinstance(row, dict) and row.keys() >= {"case", "status"}):
                if not line.endswith(b"\n") and (number > 1 or BEGIN.startswith(line[: len(BEGIN)])):
                    break  # what a killed process left
                raise self._refusal(f"does not hold rows of a study (line {number})")
            rows += [row] if row is not None else []
            whole = at
        return rows, whole

    def _text(self, data: bytes) -> str:
        """Of UTF-8, without the mark that other programs put at the start."""
        try:
            return data.decode("utf-8-sig")
        except UnicodeDecodeError as error:
            line = data.count(b"\n", 0, error.start) + 1
            raise self._refusal(f"is not UTF-8 (byte {data[error.start]:#04x} in line {line})") from None

    def _refusal(self, what: str) -> UsageError:
        return UsageError(f"{self.path} {what}; it was not touched: choose another --output", "study.rows")


def key(*parts: Any) -> str:
    """A short digest that tells cases apart: the same parts give the same key in every process."""
    return sha256(json.dumps(parts, sort_keys=True, default=_parts).encode()).hexdigest()[:16]


def _parts(value: Any) -> list[float]:
    """JSON has no complex numbers: [real, imaginary]."""
    if isinstance(value, complex):
        return [value.real, value.imag]
    raise TypeError(f"{value!r} in a row")


def _cell(value: Any) -> str:
    """Numbers with all their digits; a complex one as Python and NumPy read it. No text is a spreadsheet's formula."""
    if value is None:
        return ""
    if isinstance(value, complex):
        return repr(value).strip("()")
    text = repr(value) if isinstance(value, float) else str(value)
    return f"'{text}" if text[:1] in ("=", "@") else text


def _csv_line(cells: Sequence[str]) -> str:
    line = io.StringIO()
    csv.writer(line, lineterminator="\n").writerow([" ".join(c.splitlines()) for c in cells])
    return line.getvalue()
