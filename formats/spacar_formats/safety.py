"""File safety (reference/files.md section 9): results grow in side files, files are only ever replaced as a
whole.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from spacar.errors import AnalysisError, UsageError


def part_path(final: Path) -> Path:
    """Where a result grows until it is complete: `crank.sbd` in `crank.sbd.part`."""
    return final.with_name(final.name + ".part")


def backup_path(final: Path) -> Path:
    return final.with_name(final.name + ".bak")


def begin(final: Path) -> Path:
    """Start of a run: move an existing result to `.bak` (one generation), return the `.part` path to write.

    A side file that an earlier run left is unlinked. Raises UsageError when the folder does not allow it.
    """
    part = part_path(final)
    try:
        if final.exists():
            os.replace(final, backup_path(final))
        part.unlink(missing_ok=True)
    except OSError as err:
        raise UsageError(f"cannot write {final}: {err.strerror}", "files.open") from None
    return part


def finish(final: Path) -> None:
    """End of a successful run: the side file gets its final name in one step. Raises AnalysisError."""
    try:
        os.replace(part_path(final), final)
    except OSError as err:
        raise AnalysisError(
            f"cannot rename {part_path(final)} to {final}: {err.strerror}", "files.write"
        ) from None


@contextmanager
def replacing(target: Path) -> Iterator[Path]:
    """A name beside `target` to write to; when the block ends well, its bytes are forced to the disk and take
    the target's place in one step, otherwise they are removed and the target stays as it was.

    Raises UsageError with the reason of the operating system when it does not let us.
    """
    side = target.with_name(f".{target.stem}.{os.getpid()}{target.suffix}")
    try:
        yield side
        with open(side, "rb+") as file:
            os.fsync(file.fileno())
        os.replace(side, target)
    except OSError as err:
        raise UsageError(f"cannot write {target}: {err.strerror or err}", "files.open") from None
    finally:
        side.unlink(missing_ok=True)
