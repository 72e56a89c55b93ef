"""The speed table: time to reach an error, against what the fastest compiled programs need, scaled to this machine.

    python benchmarks/run.py [--repeats N] [--only NAME ...] [--json FILE] [--references]

`make bench` runs it. Everything is measured in one process with one thread; times are medians of the repeats.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from dataclasses import asdict
from pathlib import Path
from statistics import median
from time import perf_counter

os.environ.setdefault("OMP_NUM_THREADS", "1")  # the matrices are small; before NumPy is imported

import cases
import ensemble
import measure
import numpy as np

CHAIN_TARGETS = {10: 0.12e-3, 100: 0.18e-3, 1000: 1.4e-3}  # n: [s] that a prototype in NumPy took
SIZES = (10, 20, 50, 100, 200, 500, 1000, 2000)
PROCESS_FACTOR = 4.0  # `spacar 1 crank` over importing NumPy


def chains(machine: float, repeats: int) -> dict[str, dict[int, float]]:
    """Seconds of one right-hand side per kind, path and size; prints the exponent of the cost from 200 to 2000."""
    print("== chains: one right-hand side [ms]")
    print("  " + " " * 27 + "".join(f"{n:>9d}" for n in SIZES) + "  exponent from 200")
    table: dict[str, dict[int, float]] = {}
    for kind, text in cases.CHAINS.items():
        for compiled in (False, True):
            name = f"{kind}, compiled" if compiled else kind
            row = table[name] = {}
            for n in SIZES:
                evaluate = cases.Evaluator(text(n), compiled=compiled)
                times = []
                for _ in range(repeats * (3 if n >= 1000 else 10)):
                    begin = perf_counter()
                    evaluate()
                    times.append(perf_counter() - begin)
                row[n] = median(times)
            big = [n for n in SIZES if n >= 200]
            exponent = np.polyfit(np.log(big), np.log([row[n] for n in big]), 1)[0]
            print(f"  {name:27s}" + "".join(f"{1e3 * t:9.3f}" for t in row.values()) + f"  {exponent:.2f}", flush=True)
    for n, seconds in CHAIN_TARGETS.items():
        ratios = ", ".join(f"{name} {row[n] / (seconds * machine):.2f}" for name, row in table.items())
        print(f"  target n = {n}: {1e3 * seconds * machine:.2f} ms, ratio {ratios}")
    return table


def process(numpy: float, repeats: int) -> float:
    """Seconds of `spacar 1 crank` as a process, less an empty Python process; prints the ratio to importing NumPy.

    With bytecode, as after an installation: it is kept in the temporary folder, also where PYTHONDONTWRITEBYTECODE is
    set or a file is newer than its bytecode, and a first run that makes it does not count.
    """
    program = Path(sys.executable).with_name("spacar")
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "crank.dat").write_text(cases.models.example("crank"))
        environment = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
        environment["PYTHONPYCACHEPREFIX"] = str(Path(folder, "bytecode"))
        times = []
        for words in [[str(program), "1", "crank", "--quiet"], [sys.executable, "-c", "pass"]] * (repeats + 1):
            begin = perf_counter()
            subprocess.run(words, cwd=folder, check=True, capture_output=True, env=environment)
            times.append(perf_counter() - begin)
    whole, empty = median(times[2::2]), median(times[3::2])
    for what, seconds in (("whole process", whole), ("less an empty Python process", whole - empty)):
        ratio = seconds / numpy
        word = "met" if ratio <= PROCESS_FACTOR else "MISSED"
        print(f"== process: spacar 1 crank, {what} {1e3 * seconds:.0f} ms, {ratio:.2f} times importing NumPy ({word})")
    return whole


def keep_references() -> None:
    """Compute the references that take long and write them to references.json."""
    found = {name: solve().tolist() for name, solve in cases.SLOW_REFERENCES.items()}
    cases.REFERENCES.write_text(json.dumps(found, indent=1) + "\n")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--only", nargs="*", default=None, help="names of cases, chains, process, sweep")
    parser.add_argument("--json", type=Path, default=None)
    parser.add_argument("--references", action="store_true")
    options = parser.parse_args()
    if options.references:
        keep_references()
        return

    def wanted(name: str) -> bool:
        return options.only is None or name in options.only

    numpy = measure.numpy_import()
    machine = numpy / measure.NUMPY_IMPORT
    print(f"importing NumPy {1e3 * numpy:.0f} ms: targets scaled by {machine:.2f}; load {os.getloadavg()[0]:.1f}")
    found = {}
    for case in cases.CASES:
        if wanted(case.name):
            before = measure.numpy_import(3)
            result = found[case.name] = measure.measure(case, options.repeats)
            # on a shared machine the speed changes from minute to minute: the factor of this case is measured around it
            machine = 0.5 * (before + measure.numpy_import(3)) / measure.NUMPY_IMPORT
            print("\n".join(measure.lines(result, machine)), flush=True)
    table = chains(machine, options.repeats) if wanted("chains") else {}
    whole = process(numpy, options.repeats) if wanted("process") else None
    if wanted("sweep"):
        print("== sweep of 200 manipulators [ms a variant]", flush=True)
        ensemble.main()
    promises = [(name, *row) for name, result in found.items() for row in measure.promise(result)]
    if promises:
        print("== error obtained / error asked (ERROR)")
        for name in found:
            row = [ratio for case, _, _, ratio in promises if case == name]
            if row:
                kept = sum(r <= 10.0 for r in row)
                print(f"  {name:13s} {min(row):.1e} ... {max(row):.1e}  {kept} of {len(row)} within a factor of 10")
        for name, label, asked, ratio in promises:
            if ratio > 10.0:
                print(f"  not kept: {name}, {label}: {ratio * asked:.1e}")
    if options.json:
        data = {name: [asdict(p) for p in result.points] for name, result in found.items()}
        options.json.write_text(
            json.dumps({"machine": machine, "cases": data, "chains": table, "process": whole}, indent=1)
        )


if __name__ == "__main__":
    main()
