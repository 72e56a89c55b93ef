"""Two revisions beside each other: results, logs, messages, help texts, cost.

    python benchmarks/compare_revisions.py OLD NEW [--within EPS] [--only NAME ...] [--cost]

Every file of data/ that both have runs in all modes with both engines, and every command prints its help. Compared are
the exit status, what was printed, the log and each variable of the result files.
The times of runs and the version are left out. A difference of numbers is max |new - old| / max |old| of a variable;
equal means at most EPS (default 0: every bit). `--cost` adds instructions (perf, else valgrind) and memory of commands.
OLD and NEW are revisions that git knows; `.` is the folder as it is. Status 1: they differ.

Linux only: each run is a fork of a process that has imported the program, so that 600 runs take two minutes.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import os
import re
import resource
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

TOP = Path(__file__).resolve().parent.parent
MODES = (0, 1, 2, 3, 4, 7, 8, 9, 10)
COSTS = ("1 crank", "1 crankfl", "7 plbeam5", "10 lateral4", "4 lever", "0 cardan", "--help")
LONGEST = 300  # [s] of one run
# What differs between two runs of one program: times, the version, folders of this comparison.
CHANGING = (
    (re.compile(r"\d{4}-\d\d-\d\d \d\d:\d\d:\d\d [+-]\d{4}"), "DATE"),
    (re.compile(r"^spacar \d\S*"), "spacar VERSION"),
    (re.compile(r"[-+.\de]+ s of (wall|processor) time"), "TIME"),
    (re.compile(r'"seconds": [-+.\de]+'), '"seconds": TIME'),
)
NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")


def tree_of(revision: str, folder: Path) -> Path:
    """The files of a revision with their engine, in out/revisions; built once."""
    if revision == ".":
        subprocess.run([sys.executable, "hatch_build.py"], cwd=TOP, check=True, stdout=sys.stderr)
        return TOP
    ask = ["git", "rev-parse", "--verify", f"{revision}^{{commit}}"]
    name = subprocess.run(ask, cwd=TOP, check=True, capture_output=True, text=True).stdout.strip()
    tree = folder / name[:12]
    if not (tree / ".built").exists():
        tree.mkdir(parents=True, exist_ok=True)
        packed = subprocess.run(["git", "archive", name], cwd=TOP, check=True, capture_output=True).stdout
        subprocess.run(["tar", "-x", "-C", tree], input=packed, check=True)
        subprocess.run([sys.executable, "hatch_build.py"], cwd=tree, check=True, stdout=sys.stderr)
        (tree / ".built").touch()
    return tree


def environment(tree: Path) -> dict[str, str]:
    """In which that tree is the program."""
    paths = os.pathsep.join(str(tree / part) for part in ("", "formats", "cli"))
    return os.environ | {"PYTHONPATH": paths, "PYTHONHASHSEED": "0", "OMP_NUM_THREADS": "1", "COLUMNS": "100"}


def jobs(names: list[str], commands: list[str]) -> Iterator[tuple[str, list[str]]]:
    """Name and words of each run."""
    for name in names:
        for mode in MODES:
            for engine in ([], ["--general"]):
                if mode or not engine:
                    words = [str(mode), f"data/{name}.dat", "--json", *engine]
                    yield f"{mode}-{name}{'-general' if engine else ''}", words
    for command in commands:
        yield f"help-{command or 'spacar'}", [*command.split(), "--help"]


def run_all(tree: Path, target: Path, names: list[str]) -> None:
    """In the process of one tree: each run in a fork, its files in a folder of its name; costs.json has costs."""
    os.chdir(tree)
    from spacar_cli.main import main  # the program of PYTHONPATH

    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        main(["--help"])
        with tempfile.TemporaryDirectory() as name:  # imports what most runs need
            for mode in (1, 8, 9):
                main([str(mode), "data/lever.dat", "--output-dir", name])
    listed = printed.getvalue().partition("Commands:")[2].partition("\n\n")[0]
    commands = ["", *re.findall(r"^  (\w+)  ", listed, re.M), *map(str, MODES)]
    costs: dict[str, tuple[int, float, int]] = {}
    for name, words in jobs(names, commands):
        folder = target / name
        folder.mkdir(parents=True)
        child = os.fork()
        if not child:
            resource.setrlimit(resource.RLIMIT_CPU, (LONGEST, LONGEST))
            for stream, file in ((1, "printed"), (2, "messages")):
                os.dup2(os.open(folder / file, os.O_WRONLY | os.O_CREAT, 0o644), stream)
            status = 99
            try:
                status = main([*words, *([] if name.startswith("help") else ["--output-dir", str(folder)])])
            finally:
                sys.stdout.flush()
                os._exit(status)
        _, status, used = os.wait4(child, 0)
        costs[name] = os.waitstatus_to_exitcode(status), used.ru_utime + used.ru_stime, used.ru_maxrss
    (target / "costs.json").write_text(json.dumps(costs))


def lines(path: Path, target: Path) -> list[str]:
    """A text without what changes from run to run."""
    text = path.read_text(errors="replace").replace(str(target), "OUT")
    for pattern, word in CHANGING:
        text = pattern.sub(word, text)
    return text.splitlines()


def difference_of_texts(old: list[str], new: list[str], within: float) -> str:
    """Empty, or the first line that differs by more than its numbers may."""
    for a, b in zip(old, new, strict=False):
        if a == b:
            continue
        if not within or NUMBER.sub("#", a).split() != NUMBER.sub("#", b).split():
            return f"'{a.strip()[:60]}' -> '{b.strip()[:60]}'"
        for x, y in zip(map(float, NUMBER.findall(a)), map(float, NUMBER.findall(b)), strict=True):
            if abs(x - y) > 2e-5 * max(abs(x), abs(y)) and max(abs(x), abs(y)) > within:  # printed digits
                return f"'{a.strip()[:60]}' -> '{b.strip()[:60]}'"
    return "" if len(old) == len(new) else f"{len(old)} -> {len(new)} lines"


def differences_of_results(old: Path, new: Path, within: float) -> Iterator[str]:
    """Variables that one file lacks, or that differ by more than `within`."""
    from spacar_formats.sbf import SbfFile

    with SbfFile(old) as a, SbfFile(new) as b:
        for name in sorted({*a.ids, *b.ids}):
            if not (a.has(name) and b.has(name)):
                yield f"{name} {'is new' if b.has(name) else 'is gone'}"
                continue
            x, y = a.get(name), b.get(name)
            if isinstance(x, list) or isinstance(y, list):
                if [*x] != [*y]:
                    yield f"{name}: texts differ"
            elif x.shape != y.shape:
                yield f"{name}: shape {x.shape} -> {y.shape}"
            elif not np.array_equal(x, y, equal_nan=True):
                size = np.max(np.abs(x[np.isfinite(x)]), initial=0.0) if x.dtype.kind == "f" else 1.0
                apart = np.max(np.abs(np.nan_to_num(x) - np.nan_to_num(y)), initial=0.0) / (size or 1.0)
                if not apart <= within or np.any(np.isnan(x) != np.isnan(y)):
                    yield f"{name}: {apart:.1e}"


def compare(old: Path, new: Path, within: float) -> list[str]:
    """A line for each difference."""
    costs = [json.loads((target / "costs.json").read_text()) for target in (old, new)]
    found = []
    for name in [n for n in costs[0] if n in costs[1]]:
        if costs[0][name][0] != costs[1][name][0]:
            found.append(f"{name}: status {costs[0][name][0]} -> {costs[1][name][0]}")
        files = sorted({p.name for target in (old, new) for p in (target / name).iterdir()})
        for file in files:
            a, b = old / name / file, new / name / file
            if not (a.exists() and b.exists()):
                found.append(f"{name}: {file} {'is new' if b.exists() else 'is gone'}")
            elif a.suffix in (".sbd", ".sbm", ".ltv"):
                found += [f"{name}: {file} {line}" for line in differences_of_results(a, b, within)]
            elif line := difference_of_texts(lines(a, old), lines(b, new), within):
                found.append(f"{name}: {file}: {line}")
    for name in sorted(costs[0].keys() ^ costs[1].keys()):
        found.append(f"{name} {'is new' if name in costs[1] else 'is gone'}")
    seconds = [sum(row[1] for row in cost.values()) for cost in costs]
    memory = [max(row[2] for row in cost.values()) / 1024 for cost in costs]
    print(f"processor time of all runs {seconds[0]:.1f} -> {seconds[1]:.1f} s,", end=" ")
    print(f"largest {memory[0]:.0f} -> {memory[1]:.0f} MB")
    return found


def counted(tree: Path, words: list[str], folder: Path) -> tuple[int, float]:
    """Instructions and megabytes of one command as a process."""
    command = [sys.executable, "-c", "from spacar_cli.main import main; raise SystemExit(main())", *words]
    env, perf = environment(tree), ["perf", "stat", "-x,", "-e", "instructions:u", "-o", str(folder / "perf")]
    subprocess.run(command, env=env, cwd=folder, capture_output=True)  # bytecode
    subprocess.run([*perf, *command], env=env, cwd=folder, capture_output=True)
    report = folder / "perf"
    count = report.read_text().split(",")[0].split()[-1] if report.exists() else ""
    if not count.isdigit():
        tool = ["valgrind", "--tool=cachegrind", "--cache-sim=no", "--cachegrind-out-file=/dev/null"]
        text = subprocess.run([*tool, *command], env=env, cwd=folder, capture_output=True, text=True).stderr
        count = re.search(r"I\s+refs:\s+([\d,]+)", text)[1].replace(",", "")  # type: ignore[index]
    silent = subprocess.DEVNULL
    with subprocess.Popen(command, env=env, cwd=folder, stdout=silent, stderr=silent) as process:
        _, _, used = os.wait4(process.pid, 0)
        process.returncode = 0
    return int(count), used.ru_maxrss / 1024


def print_costs(trees: list[Path], folder: Path) -> None:
    """A table of whole commands."""
    print(f"{'command':16s}{'instructions':>28s}{'ratio':>8s}{'MB':>14s}")
    for text in COSTS:
        rows = []
        for k, tree in enumerate(trees):
            own = folder / f"cost-{k}-{text.replace(' ', '-')}"
            own.mkdir()
            first, *names = text.split()
            words = [first, *(str(tree / "data" / f"{name}.dat") for name in names)]
            rows.append(counted(tree, [*words, "--output-dir", "."] if names else words, own))
        (a, x), (b, y) = rows
        print(f"{text:16s}{a / 1e6:12.1f} -> {b / 1e6:9.1f} M{b / a:8.3f}{x:7.0f} -> {y:.0f}", flush=True)


def main() -> int:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("old")
    p.add_argument("new")
    p.add_argument("--within", type=float, default=0.0, metavar="EPS")
    p.add_argument("--only", nargs="*", default=[], metavar="NAME")
    p.add_argument("--cost", action="store_true")
    p.add_argument("--folder", type=Path, default=TOP / "out" / "revisions")
    p.add_argument("--runs-of", type=Path, help=argparse.SUPPRESS)  # the process of one tree
    a = p.parse_args()
    if a.runs_of:
        run_all(Path(a.old), a.runs_of, a.only)
        return 0
    trees = [tree_of(revision, a.folder) for revision in (a.old, a.new)]
    names = sorted(set.intersection(*({p.stem for p in (t / "data").glob("*.dat")} for t in trees)))
    names = [name for name in names if not a.only or name in a.only]
    with tempfile.TemporaryDirectory() as name:
        targets = [Path(name) / "old", Path(name) / "new"]
        running = []
        for tree, target in zip(trees, targets, strict=True):
            words = [sys.executable, __file__, str(tree), ".", "--runs-of", str(target), "--only", *names]
            running.append(subprocess.Popen(words, env=environment(tree)))
        if any([process.wait() for process in running]):
            return 2
        found = compare(*targets, a.within)
        print(*found, sep="\n")
        print(f"{len(found)} differences in {len(list(targets[0].iterdir())) - 1} runs")
        if a.cost:
            print_costs(trees, Path(name))
    return 1 if found else 0


if __name__ == "__main__":
    raise SystemExit(main())
