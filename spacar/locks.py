"""Locks that end with the process: who else is writing to a file.

Where the system has flock, the lock is on the file itself. Windows does not let open files be renamed: there a byte of
FILE.lock is locked. A file system without either (some network disks) gets FILE.lock with host and process number,
which counts as long as that process lives.
"""

import contextlib
import errno
import os
import platform
from collections.abc import Callable
from pathlib import Path
from typing import Any

try:
    import fcntl
except ImportError:
    fcntl = None  # type: ignore[assignment]

UNSUPPORTED = (errno.ENOLCK, errno.EOPNOTSUPP, errno.ENOSYS, errno.EINVAL)
Release = Callable[[], None]


def lock(fd: int, path: Path) -> Release | None:
    """Lock the open file at `path`; the function that releases it, or None when another one holds the lock.

    Raises OSError when no kind of lock is possible.
    """
    if fcntl is not None:
        try:
            fcntl.flock(fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return lambda: fcntl.flock(fd, fcntl.LOCK_UN)
        except BlockingIOError:
            return None
        except OSError as error:
            if error.errno not in UNSUPPORTED:
                raise
    beside = path.with_name(f"{path.name}.lock")
    return _windows(beside) if os.name == "nt" else _process_file(beside)


def _windows(beside: Path) -> Release | None:
    import msvcrt

    system: Any = msvcrt
    file = open(beside, "a+b")  # noqa: SIM115 (open as long as the lock holds)
    try:
        file.seek(0)
        system.locking(file.fileno(), system.LK_NBLCK, 1)
    except OSError:
        file.close()
        return None
    return lambda: _give_up(beside, file.close)


def _process_file(beside: Path) -> Release | None:
    """A file with host and process number that only one can create."""
    for _ in range(2):
        try:
            fd = os.open(beside, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o644)
        except FileExistsError:
            if _holder_lives(beside):
                return None
            beside.unlink(missing_ok=True)
            continue
        with os.fdopen(fd, "w") as file:
            file.write(f"{platform.node()} {os.getpid()}\n")
        return lambda: _give_up(beside, lambda: None)
    return None


def _holder_lives(beside: Path) -> bool:
    """Whether the process named in the file lives.

    A process of another machine cannot be asked and counts as alive; so does the writer of an unfinished file.
    """
    try:
        host, number = _named(beside)
    except OSError:
        return False
    return host != platform.node() or not number.isdecimal() or is_alive(int(number))


def _named(beside: Path) -> tuple[str, ...]:
    return beside.read_text("utf-8", "replace")[:200].strip().rpartition(" ")[::2]


def holder(path: Path) -> str:
    """For a message: the file that is the lock, whose it is, and what to do when that process has ended; or nothing."""
    beside = path.with_name(f"{path.name}.lock")
    try:
        host, number = _named(beside)
    except OSError:  # a lock that ends with its process, or one that Windows does not let us read
        return ""
    known = host and number.isdecimal()
    whose = f"process {number} on {host}" if known else "a process that it does not name"
    return f" (its lock is {beside}, of {whose}; remove this file if that process has ended)"


def is_alive(process: int) -> bool:
    """Whether a process of this number exists (never asked on Windows, where it would end the process)."""
    try:
        os.kill(process, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except PermissionError:
        pass
    return True


def _give_up(beside: Path, close: Release) -> None:
    close()
    with contextlib.suppress(OSError):
        beside.unlink(missing_ok=True)
