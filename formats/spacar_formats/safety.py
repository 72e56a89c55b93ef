"""The door through which everything is written: files are only ever replaced as a whole (files.md section 9).

`replacing` gives a side file in the folder of the target; it is forced to the disk and takes the target's name in one
step, with the permissions of the file that it replaces. The side file is locked while it is written: one that can be
locked belongs to a process that was killed, and the next one that writes into the folder removes it.
Results of runs, which grow and can be read meanwhile, are in `claim.py`.
"""

from __future__ import annotations

import contextlib
import itertools
import os
import re
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from spacar import locks
from spacar.errors import UsageError

SIDE = re.compile(r"\..*\.(\d+)-\d+\.spacar-side(\.\w+)?")
_numbers = itertools.count(1)
_swept: set[tuple[int, int]] = set()


def part_path(final: Path) -> Path:
    """Where a result grows until it is complete: `crank.sbd` in `crank.sbd.part`."""
    return final.with_name(final.name + ".part")


def backup_path(final: Path) -> Path:
    return final.with_name(final.name + ".bak")


@contextmanager
def replacing(target: Path) -> Iterator[Path]:
    """A name beside `target` to write to; when the block ends well, its bytes are forced to the disk and take
    the target's place in one step, otherwise they are removed and the target stays as it was.

    A link is followed; what is no file (a pipe, /dev/stdout) gets the bytes when they are complete. Raises UsageError
    with the reason of the operating system when it does not let us.
    """
    try:
        kind = os.stat(target).st_mode if os.path.lexists(target) else None
        if kind is not None and stat.S_ISDIR(kind):
            raise UsageError(f"cannot write {target}: it is a folder", "files.open")
        if kind is not None and not os.access(target, os.W_OK):
            raise PermissionError(13, "Permission denied")
        if kind is None or stat.S_ISREG(kind):
            with _beside(Path(os.path.realpath(target)), kind) as side:
                yield side
        else:
            import shutil
            import tempfile

            with tempfile.TemporaryDirectory() as folder:
                side = Path(folder) / f"side{target.suffix}"
                yield side
                with open(side, "rb") as made, open(target, "wb") as out:
                    shutil.copyfileobj(made, out)
    except OSError as err:
        raise UsageError(f"cannot write {target}: {err.strerror or err}", "files.open") from None


def write_text(target: Path, text: str) -> None:
    """Replace a file by this text in UTF-8. Raises UsageError."""
    with replacing(target) as side:
        side.write_text(text, encoding="utf-8", errors="backslashreplace", newline="")


def side_path(target: Path) -> Path:
    """A name of its own, which is not too long where that of the target is just not."""
    return target.with_name(f".{target.stem[:40]}.{os.getpid()}-{next(_numbers)}.spacar-side{target.suffix}")


@contextmanager
def _beside(target: Path, mode: int | None) -> Iterator[Path]:
    sweep(target.parent)
    side = side_path(target)
    fd = os.open(side, os.O_CREAT | os.O_EXCL | os.O_RDWR, 0o666)
    try:
        release = locks.lock(fd, side)
        yield side
        if mode is not None:
            with contextlib.suppress(OSError):
                os.chmod(side, stat.S_IMODE(mode))
        with open(side, "rb+") as file:
            os.fsync(file.fileno())
        if os.name == "nt":
            os.close(fd)  # open files cannot be renamed there
            fd = -1
        os.replace(side, target)
        force(target.parent)
        if release is not None and fd >= 0:
            release()
    finally:
        if fd >= 0:
            os.close(fd)
        side.unlink(missing_ok=True)
        side.with_name(f"{side.name}.lock").unlink(missing_ok=True)


def force(folder: Path) -> None:
    """Force the names in a folder to the disk, where the system can do that."""
    with contextlib.suppress(OSError):
        fd = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(fd)
        finally:
            os.close(fd)


def sweep(folder: Path) -> None:
    """Remove side files that killed processes left in a folder; once a process and folder."""
    with contextlib.suppress(OSError):
        place = os.stat(folder)
        if (place.st_dev, place.st_ino) in _swept:
            return
        _swept.add((place.st_dev, place.st_ino))
        with os.scandir(folder) as entries:
            left = [(Path(e.path), m) for e in entries if (m := SIDE.fullmatch(e.name)) is not None]
        for side, match in left:
            with contextlib.suppress(OSError):
                if _is_abandoned(side, int(match[1])):
                    side.unlink(missing_ok=True)


def _is_abandoned(side: Path, process: int) -> bool:
    if locks.fcntl is None:
        return os.name != "nt" and not locks.is_alive(process)
    fd = os.open(side, os.O_RDWR | getattr(os, "O_NOFOLLOW", 0))
    try:
        release = locks.lock(fd, side)
        if release is not None:
            release()
        return release is not None
    finally:
        os.close(fd)
