"""One writer at a time of a result that grows: a lock on NAME.part, from before the run computes until its end.

The second one is refused in one sentence. The lock ends with the process, so a killed run blocks nobody. Only the
file that this process made is ever renamed or removed.
"""

from __future__ import annotations

import contextlib
import os
import time
from pathlib import Path
from typing import BinaryIO

from spacar import locks
from spacar.errors import AnalysisError, UsageError
from spacar_formats.safety import backup_path, force, part_path, side_path, sweep

PAUSE = 0.1  # seconds between two looks of one that waits


class Claim:
    """The right to write `final`; `begin` makes its empty .part, `publish` gives that the final name.

    Raises UsageError when another run has it (with `wait`: waits for that run to end), when `final` is a folder or
    the folder cannot be written. `release` in any case; a second call does nothing.
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
                    raise UsageError(
                        f"another run is writing {final}{locks.holder(self.part)}: wait for it (--wait does), or write "
                        "somewhere else",
                        "files.busy",
                    )
                time.sleep(PAUSE)
        except OSError as err:
            raise UsageError(f"cannot write {final}: {err.strerror}", "files.open") from None

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
            raise AnalysisError(
                f"{self.part} was removed or replaced while the run wrote to it: its results are lost", "files.write"
            )
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
