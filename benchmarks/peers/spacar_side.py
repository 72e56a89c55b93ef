"""The scenarios in spacar: a file is read, checked, built and computed; every function returns the answer."""

from __future__ import annotations

import shutil
import tempfile
from functools import lru_cache
from pathlib import Path

import numpy as np
from mechanisms import BEAM

import spacar

HERE = Path(__file__).parent / "scenarios"


@lru_cache
def folder() -> Path:
    """Of the input files; it is kept as long as the process."""
    folder.kept = tempfile.TemporaryDirectory()  # type: ignore[attr-defined]
    return Path(shutil.copytree(HERE, Path(folder.kept.name) / "files"))  # type: ignore[attr-defined]


@lru_cache
def file(name: str) -> Path:
    """That of a scenario."""
    return folder() / f"{name}.dat"


@lru_cache
def beam(n: int, bent: bool, angles: bool = False) -> Path:
    """The file of a cantilever of n inextensible elements; with the force of S5, or for the three frequencies of S8.
    `angles`: in the angle measure (ADEFORM), which has fourth order."""
    lines = [f"PLBEAM {k} {2 * k - 1} {2 * k} {2 * k + 1} {2 * k + 2}" for k in range(1, n + 1)]
    lines += [f"X {2 * k + 1} {BEAM.length * k / n} 0." for k in range(n + 1)]
    lines += ["ADEFORM"] * angles
    lines += ["FIX 1", "FIX 2", *(f"DYNE {k} 2 3" for k in range(1, n + 1)), "END", "HALT"]
    lines += [f"EM {k} {BEAM.density}" for k in range(1, n + 1)]
    lines += [f"ESTIFF {k} 0. {BEAM.EI}" for k in range(1, n + 1)]
    bending = [f"XF {2 * n + 1} 0. {BEAM.force}", "ITERSTEP 20 10 1.e-10"]
    lines += bending if bent else ["ITERSTEP 10 1 1.e-12", "MODES 3"]
    path = folder() / f"beam_{n}_{bent}_{angles}.dat"
    path.write_text("\n".join([*lines, "END", "END", ""]))
    return path


def run(name: str, error: float | None, code: int | None) -> spacar.Result:
    """`error`: ERROR of the run, absolute and relative; `code`: INTEGRAT, None: what a file without it gets."""
    options = {} if error is None else {"atol": error, "rtol": error}
    if code is not None:
        options["integrator"] = code
    return spacar.run(1, file(name), **options)


def answer(name: str, error: float | None, code: int | None) -> np.ndarray:
    """S1a ... S4c."""
    result = run(name, error, code)
    if name == "S1a":
        return result.node(6, 1, "xdd")
    if name == "S1b":
        return result.node(2, 1)[1:]
    return result.node(7 if name == "S3a" else 8)[-1]


def bent(n: int, angles: bool = False) -> np.ndarray:
    """S5."""
    return spacar.run(8, beam(n, True, angles)).node(2 * n + 1)[-1]


def frequencies(n: int) -> np.ndarray:
    """S8."""
    return 2.0 * np.pi * spacar.run(7, beam(n, False)).frequencies[-1, :3]
