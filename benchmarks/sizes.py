"""Cost against size: processor time, peak memory, size of the files and fitted exponents of every mode.

    python benchmarks/sizes.py                                 # all modes and models, n = 10 ... 2000
    python benchmarks/sizes.py --modes 7 9 --sizes 100 300 --models planar

Every point is a command `spacar MODE FILE` of its own, one thread; its processor time and largest memory are those
that the operating system counted for it. The exponent is the slope of log(time - time of the smallest) over the last
two sizes, the cost of starting Python being that of the smallest model. n is the number of elements (links).
"""

from __future__ import annotations

import argparse
import math
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

import models

SIZES = (10, 100, 300, 600, 1000, 2000)
MODES = (0, 1, 4, 7, 8, 9, 10)
STEP = "TIMESTEP 1e-9 1"  # a step or two, so that mode 1 is its start
SIGNALS = "INPUTF 1 {0} 2\nOUTX 1 {0} 2"


def planar(n: int) -> str:
    """Clamped cantilever of n planar beams, a tip load, 2n degrees of freedom."""
    return models.cantilever(n, load="-1. -1.", dynamics=(STEP,))


def spatial(n: int) -> str:
    """Clamped chain of n spatial beams, gravity, 5n degrees of freedom."""
    return models.spatial_chain(n).replace("TIMESTEP 0.01 1", STEP)


def rods(n: int) -> str:
    """Vertical chain of n planar rods under gravity, 1 m together."""
    kinematics = [f"PLRBEAM {i + 1} {i + 1} {n + 2 + i} {i + 2}" for i in range(n)]
    kinematics += [f"X {i + 1} 0. {-i / n!r}" for i in range(n + 1)]
    kinematics += ["FIX 1", *(f"DYNX {n + 2 + i} 1" for i in range(n))]
    return models.deck(kinematics, [*(f"EM {i + 1} 1." for i in range(n)), "GRAVITY 0. -9.81", STEP])


def joints(n: int) -> str:
    """Hanging chain of n spatial rods with hinges, n degrees of freedom."""
    return models.spatial_pendulum(n, 1e-9, 1).replace("GRAVITY 1. 2. -9.81", "GRAVITY 9.81 0. 0.")


MODELS = {"planar": planar, "spatial": spatial, "rods": rods, "joints": joints}


def point(mode: int, text: str, limit: float, memory: float) -> tuple[float, float, float, str]:
    """Processor time [s], peak memory [MB], files [MB], and '' or why there is no result."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "model.dat"
        tip = 3 if "ESTIFF" in text else 2  # a position node of every model, also after its own first one
        if mode in (4, 9):
            text = text.rsplit("END", 1)[0] + f"HALT\n{SIGNALS.format(tip)}\nEND\nEND\n"
        path.write_text(text)
        environment = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}

        def limits() -> None:
            resource.setrlimit(resource.RLIMIT_CPU, (int(limit), int(limit)))
            resource.setrlimit(resource.RLIMIT_AS, (int(memory * 1e9), int(memory * 1e9)))

        command = [str(Path(sys.executable).with_name("spacar")), str(mode), str(path)]
        process = subprocess.Popen(
            command, env=environment, preexec_fn=limits, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE
        )
        assert process.stderr is not None
        said = process.stderr.read().decode().strip()
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = status
        files = sum(p.stat().st_size for p in Path(folder).iterdir() if p != path) / 1e6
        seconds = usage.ru_utime + usage.ru_stime
        why = "" if status == 0 else (said.splitlines() or [f"stopped by signal {status & 127}"])[-1]
        return seconds, usage.ru_maxrss / 1e3, files, why


def exponent(sizes: list[int], seconds: list[float]) -> float:
    """Slope between the last two sizes of the time beyond that of the smallest."""
    if len(sizes) < 3 or min(seconds[-1], seconds[-2]) <= seconds[0]:
        return math.nan
    return math.log((seconds[-1] - seconds[0]) / (seconds[-2] - seconds[0])) / math.log(sizes[-1] / sizes[-2])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--modes", type=int, nargs="+", default=MODES)
    parser.add_argument("--models", nargs="+", default=list(MODELS), choices=list(MODELS))
    parser.add_argument("--sizes", type=int, nargs="+", default=SIZES)
    parser.add_argument("--limit", type=float, default=60.0, help="processor time of a point [s]")
    parser.add_argument("--memory", type=float, default=4.0, help="address space of a point [GB]")
    options = parser.parse_args()
    for name in options.models:
        for mode in options.modes:
            print(f"== {name}, mode {mode}: {(MODELS[name].__doc__ or '').splitlines()[0]}", flush=True)
            sizes: list[int] = []
            times: list[float] = []
            for n in options.sizes:
                seconds, peak, files, why = point(mode, MODELS[name](n), options.limit, options.memory)
                print(f"  n = {n:5d}  {seconds:8.2f} s  {peak:7.0f} MB  files {files:8.2f} MB  {why[:110]}", flush=True)
                if why:
                    break
                sizes.append(n)
                times.append(seconds)
            print(f"  exponent of the last two {exponent(sizes, times):.2f}", flush=True)


if __name__ == "__main__":
    main()
