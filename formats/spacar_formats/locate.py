"""Finding a result file by name, and what a user should know about it before trusting it (files.md sections 7-9)."""

import hashlib
import os
from pathlib import Path

import numpy as np

from spacar.errors import UsageError
from spacar_formats.consistency import check_tables
from spacar_formats.safety import part_path
from spacar_formats.sbf import SbfFile

_WRITTEN_BY = {
    "sbd": "any mode writes it", "sbm": "modes 3, 4, 7, 8, 9 and 10 write it", "ltv": "modes 2, 3, 4 and 9 write it",
}  # fmt: skip


def result_path(name: str | os.PathLike[str], kind: str | None = None) -> Path:
    """The file that `name`, with or without extension, stands for; without a kind `.sbd` comes before `.sbm`, `.ltv`.

    Raises UsageError when there is none; the text says which command writes it and mentions an unfinished run.
    """
    path = Path(name)
    if not path.name or "\0" in str(path):
        raise UsageError(f"'{name}' is not the name of a result file", "files.not-found")
    with_kind = [path.with_name(f"{path.name}.{k}") for k in (_WRITTEN_BY if kind is None else (kind,))]
    named = path.suffix[1:].lower() in (*_WRITTEN_BY, "part", "bak")
    candidates = [path, *with_kind] if named else [*with_kind, path]
    for candidate in candidates:
        if candidate.is_file():
            return candidate
    wanted = candidates[0]
    unfinished = [part_path(c) for c in candidates if part_path(c).is_file()]
    if unfinished:
        text = f"{wanted} not found; the run did not finish, its results are in {unfinished[0]}"
        raise UsageError(text, "files.not-found")
    suffix = wanted.suffix[1:].lower()
    text = f"{wanted} not found"
    if suffix in _WRITTEN_BY:
        text += f"; {_WRITTEN_BY[suffix]}: spacar MODE {wanted.with_suffix('')}"
    raise UsageError(text, "files.not-found")


def open_result(name: str | os.PathLike[str], kind: str | None = None, verify: bool = True) -> SbfFile:
    """Open a result by name; with `kind` given, a file of another kind is a UsageError.

    Raises SbfError when its bytes or its tables are damaged.
    """
    file = SbfFile(result_path(name, kind), verify)
    try:
        if kind is not None and file.kind != kind:
            raise UsageError(f"{file.path} is an .{file.kind} file, an .{kind} file is needed", "files.kind")
        check_tables(file)
    except BaseException:
        file.close()
        raise
    return file


def digest(path: str | os.PathLike[str]) -> str:
    """SHA-256 of the bytes of a file, in hexadecimal: the header variable `SHA256`."""
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()


def notes(file: SbfFile) -> list[str]:
    """Warnings about a result: incomplete, or the input file beside it has changed since."""
    return [note for note in (incomplete_note(file), stale_note(file)) if note is not None]


def incomplete_note(file: SbfFile) -> str | None:
    """The sentence for a file whose run did not come to its end, None for a complete one."""
    if file.complete:
        return None
    text = f"{file.path} is incomplete: stopped "
    if not file.steps:
        return text + "before the first step"
    text += f"after step {file.steps}"
    try:
        time = np.ravel(file.get("T", file.steps)) if file.has("T") else np.zeros(0)
    except UsageError:
        return text
    return text if time.size != 1 or time.dtype.kind != "f" else f"{text} at t = {time[0]:.12g}"


def stale_note(file: SbfFile) -> str | None:
    """The warning when the `.dat` beside the result is not the one it was computed from."""
    source, expected = (next(iter(file.texts(ident)), "") for ident in ("SOURCE", "SHA256"))
    if not source or not expected:
        return None
    beside = file.path.parent / Path(source.replace("\0", "")).name
    try:
        same = digest(beside) == expected
    except OSError:
        return None
    return None if same else f"{file.path} is older than {beside}, which has changed since; run it again"
