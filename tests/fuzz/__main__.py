"""The long run: `python -m tests.fuzz` (make fuzz). A report in Markdown; status 1 when there are findings."""

import argparse
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from . import figures, kills
from .harness import sound_results

CHUNK = 250


def main() -> int:
    p = argparse.ArgumentParser(description=__doc__)
    p.add_argument("--decks", type=int, default=20_000)
    p.add_argument("--files", type=int, default=5_000)
    p.add_argument("--words", type=int, default=5_000)
    p.add_argument("--forged", type=int, default=5_000)
    p.add_argument("--kills", type=int, default=200)
    p.add_argument("--combinations", type=int, default=5_000, help="Random mechanisms (tests/combinations).")
    p.add_argument("--first", type=int, default=0, help="First number of the cases: other numbers are other cases.")
    p.add_argument("--scale", type=float, default=1.0, help="Size of what is measured; 0: nothing.")
    p.add_argument("--report", type=Path, default=Path("out/fuzz.md"))
    a = p.parse_args()
    begun = time.monotonic()
    found: list[dict[str, Any]] = []
    with tempfile.TemporaryDirectory(prefix="fuzz-") as name:
        folder = Path(name)
        (folder / "sound").mkdir()
        with tempfile.TemporaryDirectory() as made:
            for file, data in sound_results(Path(made)).items():
                (folder / "sound" / file).write_bytes(data)
        for kind, count in (("deck", a.decks), ("file", a.files), ("words", a.words), ("forged", a.forged)):
            for first in range(a.first, a.first + count, CHUNK):
                found += chunk(kind, first, min(CHUNK, a.first + count - first), folder)
                print(f"{kind} {first + CHUNK - a.first}/{count}: {len(found)} findings", file=sys.stderr, flush=True)
        for first in range(a.first, a.first + a.combinations, CHUNK):
            found += combined(first, min(CHUNK, a.first + a.combinations - first))
            print(f"combinations {first + CHUNK - a.first}/{a.combinations}", file=sys.stderr, flush=True)
        if a.kills:
            found += killed(a.kills, a.first, folder)
        measured = []
        if a.scale:
            (folder / "figures").mkdir()
            measured = [figure(folder / "figures", a.scale) for figure in figures.FIGURES]
            found += [{"kind": "figure", "seed": 0, "words": f.what, "text": f"status {f.status}"}
                      for f in measured if f.status]  # fmt: skip
    counts = f"{a.decks} decks, {a.files} result files, {a.words} command lines, {a.forged} forged files"
    counts += f", {a.kills} kills, {a.combinations} mechanisms"
    seconds = time.monotonic() - begun
    lines = ["# Fuzzing", "", f"{counts}, first number {a.first}; {seconds:.0f} s. **{len(found)} findings.**", ""]
    lines += [f"- {f['kind']} {f['seed']}: `{' '.join(f['words'])[:200]}`: {f['text'][:300]}" for f in found]
    if measured:
        lines += ["", "| what | wall time [s] | largest memory [MB] |", "|---|---|---|"]
        lines += [f"| {f.what} | {f.seconds:.1f} | {f.megabytes:.0f} |" for f in measured]
    a.report.parent.mkdir(parents=True, exist_ok=True)
    a.report.write_text("\n".join(lines) + "\n", encoding="utf-8", errors="backslashreplace")
    print("\n".join(lines))
    return 1 if found else 0


def chunk(kind: str, first: int, count: int, folder: Path) -> list[dict[str, Any]]:
    """Findings of some cases; a process that dies is a finding, and the cases after it are run all the same."""
    found: list[dict[str, Any]] = []
    while count > 0:
        words = [sys.executable, "-m", "tests.fuzz.worker", kind, str(first), str(count), str(folder)]
        done = subprocess.run(words, capture_output=True, text=True, errors="replace", check=False)
        found += [json.loads(line) for line in done.stdout.splitlines() if line.startswith("{")]
        if not done.returncode:
            break
        at = int((folder / "at").read_text())
        text = f"the process ended with {done.returncode}: {done.stderr.strip()[-200:]}"
        found.append({"kind": kind, "seed": at, "words": ["?"], "text": text})
        count -= at + 1 - first
        first = at + 1
    return found


def combined(first: int, count: int) -> list[dict[str, Any]]:
    """Relations that do not hold; a process that dies is a finding too."""
    words = [sys.executable, "-m", "tests.combinations.campaign"]
    words += ["--first", str(100_000 + first), "--count", str(count)]
    done = subprocess.run(words, capture_output=True, text=True, errors="replace", check=False)
    lines = done.stdout.splitlines()[:-1] if done.returncode in (0, 1) else [done.stderr.strip()[-300:]]
    return [{"kind": "combination", "seed": 100_000 + first, "words": [], "text": line} for line in lines]


def killed(count: int, first: int, folder: Path) -> list[dict[str, Any]]:
    place = folder / "kills"
    place.mkdir()
    kills.prepare(place)
    longest: dict[int, float] = {}
    texts = [(seed, kills.kill_one(place, seed, longest)) for seed in range(first, first + count)]
    texts += [(-1, text) for text in kills.clean_up(place)]
    return [{"kind": "kill", "seed": seed, "words": [], "text": text} for seed, text in texts if text]


if __name__ == "__main__":
    sys.exit(main())
