"""Frames and lattices of thousands of beams: processor time, peak memory and exponents, beside OpenSees.

    python benchmarks/frames.py                                   # 84 to 9792 beams in space, 30 x 30 to 80 x 80 grids
    python benchmarks/frames.py --only space --cells 19x10x10 --modes 7 10
    python benchmarks/frames.py --only space --cells 12x6x6 --modes 1 --integrator 320
    python benchmarks/frames.py --peer /path/to/python            # one in which openseespy is installed

Every point is a whole process with one thread; ours and the peer's take turns (A B A B), and the smaller of both runs
counts. Mode 7 is five load steps and six frequencies; OpenSees does the same with its corotational elasticBeamColumn,
by UmfPack and ProfileSPD, of which the faster one counts. Coordinates of the nodes are the degrees of freedom.
"""

from __future__ import annotations

import argparse
import importlib.util
import math
import os
import resource
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Iterator
from pathlib import Path

AREA, SHEAR, BENDING, SPACING, LOAD = 2e5, 1.0, 1.5, 0.1, -5.0  # E A, G I_t, E I [N, N m^2], m, N
SPACE = ("4x2x2", "8x4x4", "12x6x6", "16x8x8", "24x11x11")
PLANE = ("30x30", "50x50", "80x80")
SOLVERS = ("UmfPack", "ProfileSPD")
DIRECTIONS = ("0. 1. 0.", "0. 0. 1.", "1. 0. 0.")


def members(cells: tuple[int, ...]) -> Iterator[tuple[int, int, int]]:
    """Node, node and direction of every beam of a lattice that is clamped at its first plane; nodes from 0 on."""
    shape = [k + 1 for k in cells]
    for at in _places(shape):
        for axis in range(len(cells)):
            if at[axis] < cells[axis] and (at[0] or axis == 0):
                yield _number(at, shape), _number(tuple(k + (a == axis) for a, k in enumerate(at)), shape), axis


def _places(shape: list[int]) -> Iterator[tuple[int, ...]]:
    if not shape:
        yield ()
        return
    for first in range(shape[0]):
        for rest in _places(shape[1:]):
            yield (first, *rest)


def _number(at: Iterable[int], shape: list[int]) -> int:
    found = 0
    for k, size in zip(at, shape, strict=True):
        found = found * size + k
    return found


def deck(cells: tuple[int, ...], mode: int, integrator: int | None = None) -> str:
    """The input file. Node k has the position 2 k + 1 and the orientation 2 k + 2."""
    space, shape = len(cells) == 3, [k + 1 for k in cells]
    keyword, stiffness = ("BEAM", f"{AREA} {SHEAR} {BENDING} {BENDING}") if space else ("PLBEAM", f"{AREA} {BENDING}")
    elements, properties = [], []
    for k, (p, q, axis) in enumerate(members(cells), 1):
        direction = DIRECTIONS[axis] if space else ""
        elements.append(f"{keyword} {k} {2 * p + 1} {2 * p + 2} {2 * q + 1} {2 * q + 2} {direction}")
        properties += [f"EM {k} 0.1" + " 1e-6" * space, f"ESTIFF {k} {stiffness}"]
    nodes = []
    for at in _places(shape):
        p = 2 * _number(at, shape) + 1
        nodes.append(f"X {p} " + " ".join(f"{SPACING * k:.6g}" for k in at))
        nodes += [f"FIX {p}", f"FIX {p + 1}"] if at[0] == 0 else [f"DYNX {p}", f"DYNX {p + 1}" + " 2 3 4" * space]
    releases = [f"RLSE {k + 1}" for k in range(len(elements))]
    tip = 2 * _number((cells[0], *(0 for _ in cells[1:])), shape) + 1
    loads = [f"XF {tip} " + "0. " * (len(cells) - 1) + f"{LOAD}", "MODES 6"]
    motion = "TIMESTEP 1e-9 1" if integrator is None else f"TIMESTEP 0.004 2\nINTEGRAT {integrator} 0.002"
    end = motion if mode == 1 else "ITERSTEP 20 5 1e-8"
    return "\n".join([*elements, *nodes, *releases, "END", "HALT", *properties, *loads, end, "END", "END", ""])


def run(command: list[str]) -> tuple[float, float]:
    """Processor time [s] and largest memory [MB] of a process."""
    environment = os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)  # compiling every module again is half of a short run
    libraries = Path(command[0]).parents[1].glob("lib/python*/site-packages/openseespylinux/lib")  # not found by itself
    environment["LD_LIBRARY_PATH"] = os.pathsep.join(map(str, libraries))
    process = subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    if status:
        raise SystemExit(f"{' '.join(command)} failed")
    return usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024.0


def opensees(cells: tuple[int, ...], solver: str) -> None:
    """The same structure, loads and frequencies in OpenSees."""
    import openseespy.opensees as ops

    space, shape = len(cells) == 3, [k + 1 for k in cells]
    ops.model("basic", "-ndm", len(cells), "-ndf", 6 if space else 3)
    for at in _places(shape):
        ops.node(_number(at, shape) + 1, *(SPACING * k for k in at))
        if at[0] == 0:
            ops.fix(_number(at, shape) + 1, *[1] * (6 if space else 3))
    for k, direction in enumerate(DIRECTIONS if space else ("",), 1):
        ops.geomTransf("Corotational", k, *map(float, direction.split()))
    inertia = BENDING / AREA
    for k, (p, q, axis) in enumerate(members(cells), 1):
        section = (AREA, AREA / 2, 2 * SHEAR / AREA, inertia, inertia) if space else (AREA, inertia)
        transformation = axis + 1 if space else 1
        ops.element("elasticBeamColumn", k, p + 1, q + 1, 1.0, *section, transformation, "-mass", 0.1, "-cMass")
    ops.timeSeries("Linear", 1)
    ops.pattern("Plain", 1, 1)
    tip = _number((cells[0], *(0 for _ in cells[1:])), shape) + 1
    ops.load(tip, *((0.0, 0.0, LOAD, 0.0, 0.0, 0.0) if space else (0.0, LOAD, 0.0)))
    ops.constraints("Plain")
    ops.numberer("RCM")
    ops.system(solver)
    ops.test("NormDispIncr", 1e-10, 20, 0)
    ops.algorithm("Newton")
    ops.integrator("LoadControl", 0.2)
    ops.analysis("Static")
    if ops.analyze(5):
        raise SystemExit("no equilibrium")
    ops.eigen("-genBandArpack", 6)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", choices=("space", "plane"))
    parser.add_argument("--cells", nargs="+", help="sizes such as 12x6x6 or 30x30")
    parser.add_argument("--modes", nargs="+", type=int, default=[0, 1, 7, 8, 10])
    parser.add_argument("--integrator", type=int, help="of mode 1, two steps of 2 ms; else its start only")
    parser.add_argument("--rounds", type=int, default=2)
    parser.add_argument("--peer", default=sys.executable if importlib.util.find_spec("openseespy") else None)
    parser.add_argument("--opensees", nargs=2, help=argparse.SUPPRESS)
    chosen = parser.parse_args()
    if chosen.opensees:
        opensees(_cells(chosen.opensees[0]), chosen.opensees[1])
        return
    sizes = chosen.cells or [*(SPACE if chosen.only != "plane" else ()), *(PLANE if chosen.only != "space" else ())]
    ours = str(Path(sys.executable).with_name("spacar"))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    with tempfile.TemporaryDirectory() as folder:
        known: dict[tuple[int, str], tuple[int, float]] = {}
        for size in sizes:
            cells = _cells(size)
            beams = sum(1 for _ in members(cells))
            commands = {}
            for mode in chosen.modes:
                file = Path(folder) / f"{size}_{mode}.dat"
                file.write_text(deck(cells, mode, chosen.integrator))
                commands[f"mode {mode}"] = [ours, str(mode), str(file), "--output-dir", folder]
            if chosen.peer and 7 in chosen.modes:
                for solver in SOLVERS:
                    commands[solver] = [chosen.peer, __file__, "--opensees", size, solver]
            found: dict[str, list[tuple[float, float]]] = {name: [] for name in commands}
            for _ in range(chosen.rounds):
                for name, command in commands.items():
                    found[name].append(run(command))
            print(f"{size}, {beams} beams")
            for name, results in found.items():
                seconds, memory = min(results)
                text = f"  {name:10s} {seconds:8.2f} s {memory:7.0f} MB"
                key = len(cells), name
                if key in known:
                    n, before = known[key]
                    text += f"   exponent {math.log(seconds / before) / math.log(beams / n):.2f}"
                known[key] = beams, seconds
                print(text, flush=True)


def _cells(size: str) -> tuple[int, ...]:
    return tuple(int(k) for k in size.split("x"))


if __name__ == "__main__":
    main()
