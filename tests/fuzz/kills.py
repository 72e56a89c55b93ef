"""Processes killed at random moments: what was there before is whole, what comes next cleans up."""

import contextlib
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

from spacar_formats.sbf import SbfError, SbfFile

from tests.examples import DATA

SPACAR = Path(sys.executable).with_name("spacar")
# words, and the file that is the old one or the new one whatever happens
TARGETS = (
    (("draw", "old", "-o", "a.svg"), "a.svg"), (("draw", "old", "-o", "a.png"), "a.png"),
    (("draw", "old", "--frames", "6", "-o", "a.gif"), "a.gif"), (("report", "old", "-o", "a.html"), "a.html"),
    (("plot", "old", "x[6,1]", "--csv", "a.csv"), "a.csv"), (("loadsbd", "old", "-o", "a.npz"), "a.npz"),
    (("repinsbf", "old", "T", "0", "--at", "1"), "old.sbd"), (("combsbd", "old", "old", "a", "--overwrite"), "a.sbd"),
    (("trade", "old", "-i", "155", "-t", "1e-3", "--repeats", "1", "-o", "a.json"), "a.json"),
    (("sweep", "old", "--set", "XM.6=0.03:0.04:200", "--result", "x[6,1]@end", "-o", "rows.csv"), None),
    (("1", "crank", "--steps", "4000"), None),
    (("symbolic", "export", "manipulator.toml", "--language", "c", "-o", "a.c"), "a.c"),
)  # fmt: skip


ENDS = {".svg": b"</svg>", ".html": b"</html>", ".json": b"}", ".png": b"IEND", ".gif": b";", ".npz": b"PK"}


def prepare(folder: Path) -> None:
    """Models, a result, and what every target looks like when it is complete."""
    shutil.copy(DATA / "crank.dat", folder)
    shutil.copy(DATA / "crank.dat", folder / "old.dat")
    shutil.copy(DATA / "symbolic" / "manipulator.toml", folder)
    for words in (("1", "old"), *(w for w, target in TARGETS if target is not None)):
        _run(folder, words)


def _run(folder: Path, words: tuple[str, ...]) -> int:
    done = subprocess.run([str(SPACAR), *words], cwd=folder, capture_output=True, check=False, timeout=600)
    return done.returncode


def kill_one(folder: Path, seed: int, longest: dict[int, float]) -> str | None:
    """Start, kill at a random part of the usual time, look. A finding, or None."""
    rng = random.Random(f"kill {seed}")
    k = seed % len(TARGETS)
    words, target = TARGETS[k]
    before = (folder / target).read_bytes() if target else b""
    begun = time.monotonic()
    process = subprocess.Popen([str(SPACAR), *words], cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    usual = longest.get(k, 3.0)
    # most kills fall into the last part, where files are written
    with contextlib.suppress(subprocess.TimeoutExpired):
        process.wait(usual * (1.0 - rng.random() ** 2 * 0.7))
    if process.poll() is None:
        process.send_signal(signal.SIGKILL)
    else:
        longest[k] = time.monotonic() - begun
    process.wait()
    if target:
        path = folder / target
        if not path.exists() or not path.stat().st_size:
            return f"{words}: {target} is {'empty' if path.exists() else 'gone'}"
        after = path.read_bytes()
        if after != before and not _whole(path, before):
            return f"{words}: {target} is neither the old nor the new one"
    for part in folder.glob("*.sbd*"):
        if part.stat().st_size:
            try:
                with SbfFile(part) as file:
                    if len(file.damaged_steps()):
                        return f"{words}: {part.name} has damaged steps"
            except SbfError as error:
                if part.suffix != ".part" or "preamble" not in str(error):
                    return f"{words}: {error}"
    return None


def _whole(path: Path, before: bytes) -> bool:
    """A new file may differ (times in it), but not be a piece: nearly as long, and the same end where it has one."""
    after = path.read_bytes()
    return len(after) > 0.5 * len(before) and ENDS.get(path.suffix, b"") in after[-64:]


def clean_up(folder: Path) -> list[str]:
    """After the kills every command runs once more: nothing may be left."""
    for words, _ in TARGETS:
        status = _run(folder, words)
        if status:
            return [f"{words}: status {status} after the kills"]
    return [f"left behind: {p.name}" for p in folder.iterdir() if "spacar-side" in p.name or p.suffix == ".part"]
