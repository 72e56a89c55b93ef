"""Time and memory of large work, each in a process of its own: how the program grows."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .cases import DATA

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
    """Accelerations and two output steps of a soft cantilever; mode 0 would need dense matrices of all coordinates."""
    n = max(int(5000 * scale), 10)
    lines = [f"PLBEAM {k} {2 * k - 1} {2 * k} {2 * k + 1} {2 * k + 2}" for k in range(1, n + 1)]
    lines += [f"X {2 * k + 1} {k / n:.17g} 0." for k in range(1, n + 1)]
    lines += ["FIX 1", "FIX 2", *(f"DYNE {k} 2 3" for k in range(1, n + 1)), "END", "HALT"]
    lines += [f"EM {k} 1." for k in range(1, n + 1)] + [f"ESTIFF {k} 1e6 1e-6" for k in range(1, n + 1)]
    lines += ["GRAVITY 0. -1.", "TIMESTEP 1e-6 1", "ERROR 1e-3 1e-3"]
    (folder / "chain.dat").write_text("\n".join([*lines, "END", "END"]) + "\n")
    return measured(f"mode 1 of {n} beams in a row, one output step", folder, 1, "chain")


FIGURES: tuple[Callable[[Path, float], Figure], ...] = (variants, steps, big_file, one_step_of_it, elements)
