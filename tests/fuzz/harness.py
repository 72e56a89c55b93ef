"""Run a case in this process and judge how it ended."""

import os
import shutil
import signal
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import sympy  # noqa: F401  (a Ctrl-C within its import would leave half of it to the cases behind)
from spacar_formats.checksbf import checksbf

from spacar.errors import LONGEST_LINE
from tests.command_line import call
from tests.examples import DATA

from .cases import Case

PATIENCE = 1.0  # seconds of processor time until Ctrl-C; a changed model may well run for hours
GRACE = 5.0  # seconds of processor time after it
SOUND = (("crank", "1", "--steps", "5"), ("lateral4", "7"), ("lever", "9"), ("robotinv", "2"))


def sound_results(folder: Path) -> dict[str, bytes]:
    """Small results of four modes, by file name."""
    here = os.getcwd()
    os.chdir(folder)
    try:
        for name, mode, *options in SOUND:
            shutil.copy(DATA / f"{name}.dat", folder)
            assert call(mode, name, *options).status == 0
    finally:
        os.chdir(here)
    found = (p for p in sorted(folder.iterdir()) if p.suffix in (".sbd", ".sbm", ".ltv"))
    return {p.name: p.read_bytes() for p in found}


@contextmanager
def impatient() -> Iterator[None]:
    """Ctrl-C after PATIENCE, of processor time, so that a busy machine changes nothing."""

    def interrupt(*_: object) -> None:
        signal.setitimer(signal.ITIMER_PROF, 0.5)  # again: a library may swallow one
        signal.raise_signal(signal.SIGINT)

    before = signal.signal(signal.SIGPROF, interrupt)
    signal.setitimer(signal.ITIMER_PROF, PATIENCE)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)


def finding(case: Case) -> str | None:
    """What is wrong with how the case ended, in one line; None when nothing is."""
    here = os.getcwd()
    with tempfile.TemporaryDirectory(prefix="fuzz-") as folder:
        os.chdir(folder)
        try:
            for name, data in case.files.items():
                Path(name).parent.mkdir(exist_ok=True)
                Path(name).write_bytes(data)
            before = time.process_time()
            try:
                with impatient():
                    status, out, err = call(*case.words)
            except KeyboardInterrupt:
                return None  # between the command and this line
            except BaseException as error:
                return f"{type(error).__name__}: {error}"[:300]
            seconds = time.process_time() - before
            return _judge(case, status, out, err, seconds)
        finally:
            os.chdir(here)


def _judge(case: Case, status: int, out: str, err: str, seconds: float) -> str | None:
    if status not in (0, 1, 2, 130):
        return f"status {status}"
    if "internal error" in err or "Traceback" in err or "internal" in out:
        return (err or out).strip()[:300]
    if status and not any(line.startswith("error: ") for line in err.splitlines()) and not out.strip():
        return f"status {status} without a word: {err[:100]!r}"
    if any(c < " " and c not in "\n\t\r" for c in out + err):
        return "control characters on the screen"
    if max(map(len, err.splitlines()), default=0) > LONGEST_LINE + 200:
        return "an endless line"
    if seconds > PATIENCE + GRACE:
        return f"Ctrl-C took {seconds - PATIENCE:.1f} s"
    left = [p.name for p in Path().rglob("*") if "spacar-side" in p.name]
    if left:
        return f"left behind: {left[0]}"
    if case.kind == "deck" and status == 0 and case.words[0] not in ("check", "symbolic", "sim"):
        if Path("F.sbd.part").exists():
            return "a complete run left its .part"
        if Path("F.sbd").exists() and not checksbf("F.sbd").sound:
            return "a damaged result"
    return None
