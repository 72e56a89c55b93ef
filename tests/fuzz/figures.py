"""Time and memory of large work, each in a process of its own: how the program grows."""

import os
import shutil
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tests.examples import DATA

SPACAR = Path(sys.executable).with_name("spacar")


@dataclass(frozen=True)
class Figure:
    """What was run, its status, wall time [s], largest memory [MB]."""

    what: str
    status: int
    seconds: float
    megabytes: float


def measured(what: str, folder: Path, *words: object) -> Figure:
    begun = time.perf_counter()
    with open(os.devnull, "wb") as null:
        process = subprocess.Popen([str(SPACAR), *map(str, words)], cwd=folder, stdout=null, stderr=null)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    return Figure(what, process.returncode, time.perf_counter() - begun, usage.ru_maxrss / 1024)


def variants(folder: Path, scale: float) -> Figure:
    n = max(int(10_000 * scale), 10)
    shutil.copy(DATA / "crank.dat", folder)
    words = ("sweep", "crank", "--set", f"XM.6=0.03:0.04:{n}", "--result", "x[6,1]@end", "--steps", 2, "--time", 0.001)
    return measured(f"sweep over {n} variants", folder, *words)


def steps(folder: Path, scale: float) -> Figure:
    n = max(int(1_000_000 * scale), 10)
    shutil.copy(DATA / "slider.dat", folder)
    return measured(f"slider, {n} output steps", folder, 1, "slider", "--steps", n, "--time", 1.0)


def big_file(folder: Path, scale: float) -> Figure:
    """checksbf reads every byte of a file of a gigabyte."""
    from spacar_formats.sbf import SbfWriter

    size = int(1e9 * scale)
    n = 1000
    with SbfWriter(folder / "big.sbd", "sbd", {"NX": n}, {"T": (1, 1), "X": (n, 1)}) as out:
        for k in range(max(size // (8 * (n + 1)), 2)):
            out.append({"T": float(k), "X": np.full(n, float(k))})
    megabytes = (folder / "big.sbd").stat().st_size / 1e6
    return measured(f"checksbf of {megabytes:.0f} MB", folder, "checksbf", "big")


def one_step_of_it(folder: Path, scale: float) -> Figure:
    return measured("one step of the same file", folder, "getfrsbf", "big", "x", "end")


def elements(folder: Path, scale: float) -> Figure:
    """Soft cantilevers of 1000 beams each: accelerations and one output step in mode 1."""
    n = max(int(1000 * scale), 10)
    first, second = [], []
    for row in range(5):
        e, p = row * n, row * (2 * n + 2)
        nodes = [" ".join(str(p + 2 * k + i) for i in (-1, 0, 1, 2)) for k in range(1, n + 1)]
        first += [f"PLBEAM {e + k} {own}" for k, own in enumerate(nodes, 1)]
        first += [f"X {p + 2 * k + 1} {k} {row}" for k in range(n + 1)] + [f"FIX {p + 1}", f"FIX {p + 2}"]
        first += [f"DYNE {e + k} 2 3" for k in range(1, n + 1)]
        second += [f"EM {e + k} 1." for k in range(1, n + 1)] + [f"ESTIFF {e + k} 1e6 1e-6" for k in range(1, n + 1)]
    order = {"PLBEAM": 0}
    first.sort(key=lambda line: order.get(line.split()[0], 1))
    second += ["GRAVITY 0. -1.", "TIMESTEP 1e-6 1", "ERROR 1e-3 1e-3"]
    (folder / "rows.dat").write_text("\n".join([*first, "END", "HALT", *second, "END", "END"]) + "\n")
    return measured(f"mode 1 of {5 * n} beams, one output step", folder, 1, "rows")


FIGURES: tuple[Callable[[Path, float], Figure], ...] = (variants, steps, big_file, one_step_of_it, elements)
