"""Named arrays to files that other programs read: `.mat`, `.npz`, `.csv`. Each replaces its target as a whole."""

import csv
import itertools
import os
import zipfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, TextIO

import numpy as np

from spacar.errors import UsageError
from spacar_formats.loadsbd import named_arrays
from spacar_formats.locate import notes, open_result
from spacar_formats.safety import replacing
from spacar_formats.sbf import Record, SbfFile, matlab_name

Arrays = Mapping[str, np.ndarray]
NUMBERS_AT_ONCE = 100_000  # of steps that are written to a csv file


def export_to(target: Path, writers: Mapping[str, Callable[[], object]]) -> None:
    """Call the writer of the extension of a file. Raises UsageError for another extension."""
    if target.suffix.lower() not in writers:
        *others, last = writers
        text = f"cannot export to {target}: the extension must be {', '.join(others)} or {last}"
        raise UsageError(text, "files.export")
    writers[target.suffix.lower()]()


def to_mat(arrays: Arrays, target: Path) -> None:
    """A MATLAB 5 file. Numbers become double, the class that MATLAB computes with; text a char matrix, a row
    a line; shapes stay (a vector of one step is a column, several steps have the step as first index).
    """
    from scipy.io import savemat

    content = {name: value if value.dtype.kind == "U" else value.astype(np.float64) for name, value in arrays.items()}
    with replacing(target) as side:
        savemat(side, content, appendmat=False, oned_as="column")


def to_npz(arrays: Arrays, target: Path) -> None:
    """A NumPy archive; integers stay integers."""
    # not np.savez: after a full disk its archive is closed by the garbage collector, which complains on the screen
    with replacing(target) as side, zipfile.ZipFile(side, "w") as archive:
        for name, array in arrays.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as part:
                np.lib.format.write_array(part, np.asanyarray(array), allow_pickle=False)


def to_csv(table: Arrays, target: Path) -> None:
    """A table with a named column for each entry (1-D arrays of one length), with all digits of numbers. Text that a
    spreadsheet would evaluate has an apostrophe in front."""
    columns = [column.tolist() for column in table.values()]
    with replacing(target) as side, open(side, "w", newline="", encoding="utf-8") as out:
        writer = csv.writer(out)
        writer.writerows(map(no_formula, row) for row in itertools.chain([table], zip(*columns, strict=True)))


def no_formula(cell: Any) -> Any:
    return f"'{cell}" if isinstance(cell, str) and cell[:1] in ("=", "@") else cell


def steps_to_csv(file: SbfFile, ids: tuple[str, ...], target: Path) -> None:
    """Columns `step`, `time`, `x_1` ..., `m0_1_1`, `m0_2_1` ... (row, column; column after column), a row a step.

    A few steps are read at a time, and long lines written in pieces, so that memory does not grow with the file.
    """
    records = [file.variable(ident) for ident in ids]
    chosen = sorted((r for r in records if r.is_step and r.type != 3), key=lambda r: r.id != "T")
    many = max(1, NUMBERS_AT_ONCE // (1 + sum(r.size for r in chosen)))
    titles = itertools.chain.from_iterable(_column_names(record, file.kind) for record in chosen)

    def numbers(parts: list[np.ndarray]) -> Iterator[Iterable[str]]:
        for part in parts:
            for first in range(0, len(part), NUMBERS_AT_ONCE):
                yield map(repr, part[first : first + NUMBERS_AT_ONCE].tolist())

    with replacing(target) as side, open(side, "w", newline="", encoding="utf-8") as out:
        _write_line(out, "step", iter(lambda: list(itertools.islice(titles, NUMBERS_AT_ONCE)), []))
        for first in range(1, file.steps + 1, many):
            steps = range(first, min(first + many, file.steps + 1))
            parts = [np.asarray(file.get(r.id, steps)) for r in chosen]
            if len(steps) == 1:
                parts = [part.reshape(1, -1, order="F") for part in parts]
            for k, step in enumerate(steps):
                _write_line(out, str(step), numbers([part[k] for part in parts]))


def _write_line(out: TextIO, first: str, pieces: Iterable[Iterable[str]]) -> None:
    out.write(first)
    for piece in pieces:
        out.write(",")
        out.write(",".join(piece))
    out.write("\r\n")


def header_table(file: SbfFile, ids: tuple[str, ...]) -> dict[str, np.ndarray]:
    """The header variables in long form: columns name, row, column, value."""
    rows: list[tuple[str, int, int, str]] = []
    for record in (file.variable(ident) for ident in ids):
        if record.is_step:
            continue
        name, value = matlab_name(record.id, file.kind), file.header_value(record.id)
        if isinstance(value, list):
            rows += [(name, i, 1, line) for i, line in enumerate(value, 1)]
        else:
            rows += [(name, i + 1, j + 1, repr(value[i, j].item())) for i, j in np.ndindex(value.shape)]
    return {title: np.array([row[k] for row in rows]) for k, title in enumerate(("name", "row", "column", "value"))}


def export_file(
    name: str | os.PathLike[str], kind: str, idents: Sequence[str] = (), formats: Sequence[str] = (),
    output: str | os.PathLike[str] | None = None,
) -> tuple[list[Path], list[str]]:  # fmt: skip
    """Export the result `name` of a kind, all variables or only `idents`; returns the files written and warnings.

    Without `output` the target is `NAME.sbd.npz` (`.sbm.npz`) beside the result, in each of the formats
    "mat", "npz", "csv" asked for. Raises UsageError for a missing file or variable, an unknown format, and
    `output` together with `formats`.
    """
    if output is not None and formats:
        raise UsageError("give either the formats or the name of the new file, not both", "files.export")
    with open_result(name, kind) as file:
        targets = [file.path.with_name(f"{file.path.name}.{end}") for end in formats or ("npz",)]
        if output is not None:
            targets = [Path(output)]
        ids = tuple(file.variable(ident).id for ident in idents) or file.ids
        return [path for target in targets for path in _export(file, target, ids)], notes(file)


def _export(file: SbfFile, target: Path, ids: tuple[str, ...]) -> list[Path]:
    """Write the variables `ids` of an open file; a `.csv` holds the steps, `NAME.header.csv` the header."""
    export_to(target, {
        ".mat": lambda: to_mat(named_arrays(file, ids), target),
        ".npz": lambda: to_npz(named_arrays(file, ids), target), ".csv": lambda: steps_to_csv(file, ids, target),
    })  # fmt: skip
    if target.suffix.lower() != ".csv":
        return [target]
    header = target.with_suffix(".header.csv")
    to_csv(header_table(file, ids), header)
    return [target, header]


def _column_names(record: Record, kind: str) -> Iterator[str]:
    name = matlab_name(record.id, kind)
    if record.size == 1:
        return iter([name])
    if 1 in (record.rows, record.cols):
        return (f"{name}_{k + 1}" for k in range(record.size))
    return (f"{name}_{i + 1}_{j + 1}" for j in range(record.cols) for i in range(record.rows))
