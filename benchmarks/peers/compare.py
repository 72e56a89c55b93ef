"""The scenarios beside Exudyn and Pinocchio: ratios of whole times at equal error, measured in turn in one run.

    python benchmarks/peers/compare.py [--only S1b ...] [--repeats 9] [--json FILE]

Whole time: from the text of the model (ours: file read, checked, built; theirs: model built) to the last output in
memory, one thread. Every setting is run for its error, short ones several times; those that are compared are then
timed in turn, A B A B, and the ratio is that of the smallest processor times, which other work on the machine changes
least.

Three rows a level: `default` is our default command at the fastest ERROR that reaches the level; `best` our fastest
setting, picked afterwards; both against the fastest setting of the others, picked afterwards. `asked` is what one knows
beforehand: the error asked for is the level, on both sides, with the errors obtained.

Memory is the largest of a process of its own that computes the setting once: Python, NumPy and the program included.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from time import process_time

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before NumPy is imported
sys.path.insert(0, str(Path(__file__).parent))

from scenarios import LEVELS, OURS, TITLES, Setting, error, missing, settings

from spacar.errors import SpacarError

SLOW = 1.0  # [s] a setting that takes longer is not compared
SHORT = 0.05  # [s] a setting that takes less is timed several times before the fastest ones are chosen


@dataclass
class Tried:
    setting: Setting
    error: float
    seconds: float
    memory: float | None = None


def tried(name: str) -> list[Tried]:
    """Every setting: its error and time."""
    found = []
    slow: set[str] = set()
    loaded: set[str] = set()
    for s in settings(name):
        family = s.program + s.label.partition(" 1e-")[0]
        if family in slow:
            continue
        try:
            if s.program not in loaded:
                s.solve()  # loads modules
                loaded.add(s.program)
            begin = process_time()
            obtained = error(name, s.solve())
        except (SpacarError, ValueError, RuntimeError) as failure:
            print(f"   stopped: {s.program}, {s.label}: {str(failure)[:150]}")
            continue
        t = Tried(s, obtained, process_time() - begin)
        if t.seconds < SHORT:  # one run of a few milliseconds would choose by chance
            in_turn([t], 4)
        if t.seconds > SLOW:
            slow.add(family)
        found.append(t)
    return found


def in_turn(rows: Iterable[Tried], repeats: int) -> None:
    """A B A B: the smallest time of each."""
    rows = list(rows)
    for t in rows:
        t.seconds = float("inf")
    for _ in range(repeats):
        for t in rows:
            begin = process_time()
            t.setting.solve()
            t.seconds = min(t.seconds, process_time() - begin)


def fastest(rows: Iterable[Tried], level: float) -> Tried | None:
    return min((t for t in rows if t.error <= level), key=lambda t: t.seconds, default=None)


def memory(name: str, t: Tried) -> float | None:
    """Largest memory of a process that computes the setting once, with this program alone [MB]; None but on Linux.

    From /proc, as the number of `getrusage` begins with that of the process which started it.
    """
    if not Path("/proc/self/status").exists():
        return None
    code = (
        "import sys; sys.path.insert(0, sys.argv[1]); import scenarios; "
        "[s.solve() for s in scenarios.PROGRAMS[sys.argv[3]](sys.argv[2]) if s.label == sys.argv[4]]; "
        "print([line.split()[1] for line in open('/proc/self/status') if line.startswith('VmHWM')][0])"
    )
    words = [sys.executable, "-c", code, str(Path(__file__).parent), name, t.setting.program, t.setting.label]
    done = subprocess.run(words, capture_output=True, text=True, check=True)
    return float(done.stdout.split()[-1]) / 1024.0


def scenario(name: str, options: argparse.Namespace) -> list[dict[str, object]]:
    """The rows of one scenario."""
    print(f"== {name}: {TITLES[name]}", flush=True)
    rows = tried(name)
    ours = [t for t in rows if t.setting.program == OURS]
    others = [t for t in rows if t.setting.program != OURS]
    found = []
    for level in LEVELS[name]:
        pairs = [
            ("default", fastest((t for t in ours if t.setting.by_default), level), fastest(others, level)),
            ("best", fastest(ours, level), fastest(others, level)),
            ("asked", next((t for t in ours if t.setting.by_default and _asks(t, level)), None),
             fastest((t for t in others if _asks(t, level)), float("inf"))),
        ]  # fmt: skip
        in_turn({id(t): t for _, *both in pairs for t in both if t is not None}.values(), options.repeats)
        for what, we, they in pairs:
            if (what == "best" and we is pairs[0][1]) or (what == "asked" and (we is None or they is None)):
                continue
            found.append(_row(name, level, what, we, they, options))
    return found


def _asks(t: Tried, level: float) -> bool:
    known = t.setting.known
    return known is not None and (known == 0.0 or 0.5 < known / level < 2.0)


def _row(
    name: str, level: float, what: str, we: Tried | None, they: Tried | None, options: argparse.Namespace
) -> dict[str, object]:
    """Print and return one row."""
    ratio = we.seconds / they.seconds if we and they else None
    text = "  -  " if ratio is None else f"{ratio:5.2f}"
    sides = []
    for t in (we, they):
        if t is None:
            sides.append("not reached")
            continue
        if t.memory is None and options.memory:
            t.memory = memory(name, t)
        room = "" if t.memory is None else f", {t.memory:.0f} MB"
        sides.append(f"{1e3 * t.seconds:8.2f} ms{room}  {t.setting.program}: {t.setting.label} ({t.error:.0e})")
    print(f"  {level:.0e} {what:7s} {text}  {sides[0]:62s} | {sides[1]}", flush=True)
    return {
        "scenario": name, "level": level, "row": what, "ratio": ratio,
        "sides": [
            None if t is None else {"program": t.setting.program, "setting": t.setting.label, "error": t.error,
                                    "seconds": t.seconds, "memory": t.memory}
            for t in (we, they)
        ],
    }  # fmt: skip


def main(words: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", nargs="*", default=None, help="names of scenarios")
    parser.add_argument("--repeats", type=int, default=9)
    parser.add_argument("--no-memory", dest="memory", action="store_false")
    parser.add_argument("--json", type=Path, default=None)
    options = parser.parse_args(words)
    for name in missing():
        print(f"{name} is not installed (pip install 'spacar[peers]'): left out")
    table = []
    for name in LEVELS:
        if options.only is None or name in options.only:
            table += scenario(name, options)
    if options.json:
        options.json.write_text(json.dumps(table, indent=1) + "\n")


if __name__ == "__main__":
    main()
