"""Compile the C text once per machine and load it.

The library is kept in $XDG_CACHE_HOME/spacar (or ~/.cache/spacar) under the digest of its text and of the compiler
call, so another version never picks up a wrong one. CC names the compiler; default cc.
"""

from __future__ import annotations

import ctypes
import hashlib
import os
import shlex
import shutil
import subprocess
import tempfile
from functools import lru_cache
from pathlib import Path

from spacar.errors import UsageError

FLAGS = ("-O2", "-fPIC", "-shared", "-std=gnu99")
HERE = Path(__file__).parent

DOUBLES = ctypes.POINTER(ctypes.c_double)
INTEGERS = ctypes.POINTER(ctypes.c_int)


class CBatch(ctypes.Structure):
    """`Batch` of solver.c."""

    _fields_ = [
        *((name, ctypes.c_int) for name in ("kind", "n", "nxe", "nee", "np", "inertia")),
        ("x", INTEGERS), ("e", INTEGERS), ("p", DOUBLES),
    ]  # fmt: skip


class CModel(ctypes.Structure):
    """`Model` of solver.c."""

    _fields_ = [
        *((name, ctypes.c_int) for name in (
            "nx", "ne", "n_fixed_x", "n_rows", "n_equations", "n_batches", "n_stiffness", "n_damping",
            "prescribed",
        )),
        ("batches", ctypes.POINTER(CBatch)),
        *((name, DOUBLES) for name in ("constant_mass", "scale", "force", "field", "preload")),
        *((name, INTEGERS) for name in ("s_rows", "s_columns", "d_rows", "d_columns")),
        *((name, DOUBLES) for name in ("s_values", "d_values")),
        ("free", INTEGERS), ("n_free", ctypes.c_int), ("mass_scale", ctypes.c_double),
        *((name, DOUBLES) for name in ("V", "M", "A", "h", "convected", "work")),
        ("pivot", INTEGERS),
    ]  # fmt: skip


class CState(ctypes.Structure):
    """`State` of solver.c."""

    _fields_ = [
        *((name, ctypes.c_int) for name in (
            "x_input", "n_x_input", "x_dynamic", "n_x_dynamic", "e_input", "n_e_input", "e_dynamic", "n_e_dynamic",
            "polynomial", "known",
        )),
        ("t", ctypes.c_double),
        *((name, DOUBLES) for name in (
            "x0", "x_motion", "e_motion", "x", "xd", "xdd", "given_e", "given_ed", "given_edd", "near", "e", "ed",
            "edd", "sigma", "next_x", "next_xd", "next_xdd",
        )),
    ]  # fmt: skip


@lru_cache(maxsize=1)
def library() -> ctypes.CDLL:
    """The loaded library. Raises UsageError when no compiler is found or it fails."""
    text = (HERE / "kernels.c").read_bytes() + (HERE / "solver.c").read_bytes()
    compiler = shlex.split(os.environ.get("CC", "cc"))
    digest = hashlib.sha256(text + " ".join((*compiler, *FLAGS)).encode()).hexdigest()[:16]
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    target = Path(base) / "spacar" / f"rhs-{digest}.so"
    if not target.exists():
        _compile(compiler, text, target)
    loaded = ctypes.CDLL(str(target))
    pointer, number = ctypes.c_void_p, ctypes.c_double
    loaded.spacar_evaluate.argtypes = [pointer, pointer, number, pointer, number, number]
    loaded.spacar_rhs.argtypes = [pointer, pointer, number, pointer, pointer, number, number]
    loaded.spacar_evaluate.restype = loaded.spacar_rhs.restype = ctypes.c_int
    loaded.spacar_forces.argtypes = [ctypes.c_void_p] * 5
    loaded.spacar_forces.restype = None
    return loaded


def _compile(compiler: list[str], text: bytes, target: Path) -> None:
    if shutil.which(compiler[0]) is None:
        raise UsageError(
            f"--compiled needs a C compiler, and '{compiler[0]}' was not found: install gcc or clang (or set CC),"
            " or run without it",
            "compiled.no-compiler",
        )
    target.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=target.parent) as folder:
        source, made = Path(folder) / "rhs.c", Path(folder) / "rhs.so"
        source.write_bytes(text)
        done = subprocess.run([*compiler, *FLAGS, str(source), "-o", str(made), "-lm"], capture_output=True, text=True)
        if done.returncode:
            raise UsageError(f"the C compiler failed: {done.stderr.strip()[-400:]}", "compiled.compiler")
        made.replace(target)  # atomic: parallel runs may compile at the same time
