"""The door through which everything is written: files are only ever replaced as a whole (files.md section 9).

`replacing` gives a side file in the folder of the target; it is forced to the disk and takes the target's name in one
step, with the permissions of the file that it replaces. The side file is locked while it is written: one that can be
locked belongs to a process that was killed, and the next one that writes into the folder removes it.

Results of runs grow and can be read meanwhile: `Claim` lets one writer at a time do so, by a lock on NAME.part from
before the run computes until its end. The second one is refused in one sentence. The lock ends with the process, so a
killed run blocks nobody. Only the file that this process made is ever renamed or removed.
"""

from __future__ import annotations

import contextlib
import itertools
import os
import re
import stat
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from spacar import locks
from spacar.errors import AnalysisError, UsageError

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


PAUSE = 0.1  # seconds between two looks of one that waits


class Claim:
    """The right to write `final`; `begin` makes its empty .part, `publish` gives that the final name.

    Raises UsageError when another run has it (with `wait`: waits for that run to end), when `final` is a folder or
    the folder cannot be written. A context manager that releases it; a second `release` does nothing.
    """

    def __init__(self, final: Path, wait: bool = False) -> None:
        self.final, self.part = final, part_path(final)
        self._fd = -1
        self._release: locks.Release | None = None
        for path in (final, self.part, backup_path(final)):
            if path.is_dir():
                raise UsageError(f"cannot write {final}: {path} is a folder", "files.open")
        try:
            self._made = not self.part.exists()
            while not self._locked():
                if not wait:
                    text = f"another run is writing {final}{locks.holder(self.part)}: wait for it (--wait does),"
                    raise UsageError(f"{text} or write somewhere else", "files.busy")
                time.sleep(PAUSE)
        except OSError as err:
            raise UsageError(f"cannot write {final}: {err.strerror}", "files.open") from None

    def __enter__(self) -> Claim:
        return self

    def __exit__(self, *_: object) -> None:
        self.release()

    def _locked(self) -> bool:
        """One try. The file may have got another name between opening and locking it: then it was not the one."""
        fd = os.open(self.part, os.O_RDWR | os.O_CREAT, 0o666)
        try:
            release = locks.lock(fd, self.part)
        except OSError:
            os.close(fd)
            raise
        if release is not None and _same(fd, self.part):
            self._fd, self._release = fd, release
            return True
        if release is not None:
            release()
        os.close(fd)
        return False

    def begin(self) -> None:
        """Move an existing result to `.bak` (one generation) and start a new, empty .part. Raises UsageError.

        What a killed run left there goes away by its name only: who has it open keeps the bytes.
        """
        try:
            if self.final.exists():
                os.replace(self.final, backup_path(self.final))
            if os.fstat(self._fd).st_size and locks.fcntl is not None:
                self._renew()
            elif os.fstat(self._fd).st_size:
                os.ftruncate(self._fd, 0)
            self._made = True
        except OSError as err:
            raise UsageError(f"cannot write {self.final}: {err.strerror}", "files.open") from None
        sweep(self.final.parent)

    def _renew(self) -> None:
        """A new file takes the name; it is locked before it has it, so the name is never without a lock."""
        side = side_path(self.part)
        side.unlink(missing_ok=True)
        fd = os.open(side, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o666)
        release = locks.lock(fd, self.part)
        os.replace(side, self.part)
        os.close(self._fd)
        self._fd, self._release = fd, release or self._release

    def open(self) -> BinaryIO:
        """The .part for the writer, unbuffered; closing it leaves the claim as it is."""
        return os.fdopen(os.dup(self._fd), "r+b", buffering=0)

    def publish(self) -> None:
        """End of a successful run: the .part gets its final name in one step. Raises AnalysisError."""
        if not _same(self._fd, self.part):
            text = f"{self.part} was removed or replaced while the run wrote to it: its results are lost"
            raise AnalysisError(text, "files.write")
        if os.name == "nt":
            os.close(self._fd)  # open files cannot be renamed there; the lock is on another file
            self._fd = -1
        try:
            os.replace(self.part, self.final)
        except OSError as err:
            raise AnalysisError(f"cannot rename {self.part} to {self.final}: {err.strerror}", "files.write") from None
        force(self.final.parent)
        self._made = False
        self.release()

    def release(self) -> None:
        """Let others write. A .part of this process without a byte is removed, one with results stays."""
        if self._release is None:
            return
        with contextlib.suppress(OSError):
            if self._made and self._fd >= 0 and not os.fstat(self._fd).st_size and _same(self._fd, self.part):
                self.part.unlink()
        with contextlib.suppress(OSError):
            self._release()
        self._release = None
        if self._fd >= 0:
            os.close(self._fd)
            self._fd = -1


def _same(fd: int, path: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(fd), os.stat(path))
    except OSError:
        return False
