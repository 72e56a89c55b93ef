"""Where compiled libraries are kept, and which of them are loaded.

A library is code that this process runs, so it is loaded only when nobody else can have written it: folder and file
belong to this user and are writable by nobody else, nobody else can put another folder in its place, and the file has
the checksum beside it. A damaged one is built again, once. Without such a folder (somebody else's, a home that cannot
be written) a private one serves for the time of the process. What a compiler made is tried in another process before it
is stored: a broken library ends the process that loads it.
"""

from __future__ import annotations

import atexit
import hashlib
import os
import shlex
import shutil
import stat
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path

from spacar.errors import UsageError

TRY = "import ctypes, sys\nlibrary = ctypes.CDLL(sys.argv[1])\nfor name in sys.argv[2:]: getattr(library, name)"


def compiler() -> list[str]:
    """The words of CC, default cc. Raises UsageError for an empty or unreadable CC and a program that is not there."""
    text = os.environ.get("CC", "cc")
    try:
        words = shlex.split(text)
    except ValueError as error:
        raise UsageError(f"cannot read the environment variable CC={text}: {error}", "compiled.compiler") from None
    if not words:
        raise UsageError("the environment variable CC is empty: unset it, or name a C compiler", "compiled.compiler")
    if shutil.which(words[0]) is None:
        raise UsageError(
            f"--compiled needs a C compiler, and '{words[0]}' was not found: install gcc or clang (or set CC),"
            " or run without it",
            "compiled.no-compiler",
        )
    return words


def stored(name: str, words: Sequence[str], flags: Sequence[Sequence[str]], text: bytes, needed: Sequence[str]) -> Path:
    """The library `name`, built from the C text when there is no sound one. `words` call the compiler.

    `flags` are tried one after the other; `needed` are names that it must have. Raises UsageError.
    """
    folder = _folder()
    target = folder / name
    if not is_sound(target):
        _build(words, flags, text, target, needed)
    return target


def is_sound(library: Path) -> bool:
    """Whether a library is there, of this user only, and has the checksum beside it."""
    if not (_is_ours(library, stat.S_ISREG) and _is_ours(_checksum(library), stat.S_ISREG)):
        return False
    try:
        return _digest(library.read_bytes()) == _checksum(library).read_text("ascii").strip()
    except (OSError, UnicodeDecodeError):
        return False


def _checksum(library: Path) -> Path:
    return library.with_name(f"{library.name}.sha256")


def _digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def _is_ours(path: Path, kind: object) -> bool:
    """Of this user and writable by nobody else; links are not followed."""
    try:
        found = os.lstat(path)
    except OSError:
        return False
    if not kind(found.st_mode):  # type: ignore[operator]
        return False
    return not hasattr(os, "getuid") or (found.st_uid == os.getuid() and not found.st_mode & 0o022)


def _stays(folder: Path) -> bool:
    """Can nobody but this user and root put another one in its place? The folders above (no links) belong to these, and
    others may not write them, or as in /tmp (sticky) only what is their own."""
    if not hasattr(os, "getuid"):
        return True
    above = [os.lstat(place) for place in folder.parents]
    return all(a.st_uid in (0, os.getuid()) and (a.st_mode & stat.S_ISVTX or not a.st_mode & 0o022) for a in above)


def _folder() -> Path:
    """$XDG_CACHE_HOME/spacar or ~/.cache/spacar when it is safe, else a folder of this process."""
    base = os.environ.get("XDG_CACHE_HOME")
    try:
        cache = Path(base) if base else Path.home() / ".cache"
        cache.mkdir(mode=0o700, parents=True, exist_ok=True)
        folder = cache.resolve() / "spacar"
        folder.mkdir(mode=0o700, exist_ok=True)
        safe = _is_ours(folder, stat.S_ISDIR) and _stays(folder) and os.access(folder, os.W_OK)
    except (OSError, RuntimeError):
        return _private()
    return folder if safe else _private()


@lru_cache
def _private() -> Path:
    folder = tempfile.mkdtemp(prefix="spacar-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return Path(folder)


def _build(
    words: Sequence[str], flags: Sequence[Sequence[str]], text: bytes, target: Path, needed: Sequence[str]
) -> None:
    """Compile, try in another process, store with its checksum."""
    with tempfile.TemporaryDirectory(dir=target.parent) as folder:
        source, made = Path(folder) / "rhs.c", Path(folder) / "rhs.so"
        source.write_bytes(text)
        for tried in flags:
            failure = _run([*words, *tried, str(source), "-o", str(made), "-lm"])
            if failure is None:
                break
        else:
            raise UsageError(f"the C compiler failed: {failure}", "compiled.compiler")
        if not made.is_file():
            raise UsageError(f"the C compiler '{words[0]}' wrote no library", "compiled.compiler")
        failure = _run([sys.executable, "-I", "-c", TRY, str(made), *needed])
        if failure is not None:
            raise UsageError(
                f"the C compiler '{words[0]}' wrote a library that cannot be loaded: {failure}", "compiled.compiler"
            )
        made.chmod(0o700)
        check = Path(folder) / "sum"
        check.write_text(_digest(made.read_bytes()) + "\n", "ascii")
        check.chmod(0o600)
        made.replace(target)  # atomic: parallel runs may compile at the same time
        check.replace(_checksum(target))


def _run(words: list[str]) -> str | None:
    """None when a program ends well, else the end of what it says."""
    try:
        done = subprocess.run(words, capture_output=True, stdin=subprocess.DEVNULL, check=False)
    except OSError as error:
        return f"{words[0]}: {error.strerror or error}"
    if not done.returncode:
        return None
    said = done.stderr.decode("utf-8", "replace").strip()[-400:]
    return said or (f"it was ended by signal {-done.returncode}" if done.returncode < 0 else "it said nothing")
