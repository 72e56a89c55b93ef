"""Compile the C text once per machine and load it.

The library is kept in $XDG_CACHE_HOME/spacar (or ~/.cache/spacar) under the digest of its text, of the compiler call
and of the processor, so another version or machine never picks up a wrong one. CC names the compiler; default cc.
What may be loaded from there: `store`.
"""

from __future__ import annotations

import ctypes
import hashlib
import platform
from functools import lru_cache
from pathlib import Path

from spacar.errors import UsageError
from spacar.native.store import compiler, stored

NATIVE = "-march=native"  # some compilers do not know it: then without
FLAGS = (NATIVE, "-O3", "-fno-math-errno", "-fno-trapping-math", "-fPIC", "-shared", "-std=gnu11")
PARTS = ("lanes.c", "kernels.c", "sparse.c", "elements.c", "motion.c", "state.c", "model.c")
HERE = Path(__file__).parent
NEEDED = tuple(
    f"spacar_{name}"
    for name in (
        "begin", "end", "evaluate", "rhs", "stages", "complete", "gradient", "determinant", "reduced_mass", "guard",
        "rcond",
    )
)  # fmt: skip

DOUBLES = INTEGERS = ctypes.c_void_p  # addresses: typed pointers cost more to make than small models to evaluate


class CBatch(ctypes.Structure):
    """`Batch` of elements.c."""

    _fields_ = [
        *((name, ctypes.c_int) for name in ("kind", "n", "nxe", "nee", "np", "inertia")),
        ("x", INTEGERS), ("e", INTEGERS), ("p", DOUBLES),
    ]  # fmt: skip


class CSpec(ctypes.Structure):
    """`Spec` of elements.c."""

    _fields_ = [
        *((name, ctypes.c_int) for name in (
            "nx", "ne", "n_fixed_x", "n_rows", "n_equations", "n_batches", "n_stiffness", "n_damping", "prescribed",
            "n_constant", "n_free", "x_input", "n_x_input", "x_dynamic", "n_x_dynamic", "e_input", "n_e_input",
            "e_dynamic", "n_e_dynamic", "polynomial",
        )),
        ("batches", ctypes.c_void_p),
        ("constant_row", INTEGERS), ("constant_column", INTEGERS), ("constant_mass", DOUBLES),
        *((name, DOUBLES) for name in ("scale", "e_scale", "force", "field", "preload")),
        *((name, INTEGERS) for name in ("s_rows", "s_columns", "d_rows", "d_columns")),
        *((name, DOUBLES) for name in ("s_values", "d_values")),
        ("free", INTEGERS),
        *((name, DOUBLES) for name in ("x0", "x_motion", "e_motion")),
    ]  # fmt: skip


class CState(ctypes.Structure):
    """`State` of elements.c."""

    _fields_ = [
        ("known", ctypes.c_int), ("t", ctypes.c_double),
        *((name, DOUBLES) for name in ("x", "xd", "xdd", "e", "ed", "edd", "sigma", "given_e")),
    ]  # fmt: skip


@lru_cache
def library(lanes: int = 1) -> ctypes.CDLL:
    """The loaded library for as many cases at a time. Raises UsageError when no compiler is found or it fails."""
    text = b"".join((HERE / name).read_bytes() for name in PARTS)
    words = compiler()
    flags = (*FLAGS, f"-DLANES={lanes}")
    digest = hashlib.sha256(text + " ".join((*words, *flags, _processor())).encode("utf-8", "replace")).hexdigest()[:16]
    plain = tuple(flag for flag in flags if flag != NATIVE)
    target = stored(f"rhs-{digest}.so", words, (flags, plain), text, NEEDED)
    try:
        loaded = ctypes.CDLL(str(target))
    except OSError as error:
        raise UsageError(f"the compiled library cannot be loaded: {error}", "compiled.library") from None
    pointer, number, integer = ctypes.c_void_p, ctypes.c_double, ctypes.c_int
    loaded.spacar_begin.argtypes, loaded.spacar_begin.restype = [pointer], pointer
    loaded.spacar_end.argtypes, loaded.spacar_end.restype = [pointer], None
    loaded.spacar_evaluate.argtypes = [pointer, pointer, number, pointer, number, number, integer]
    loaded.spacar_rhs.argtypes = [pointer, pointer, number, pointer, pointer, number, number]
    loaded.spacar_stages.argtypes = [
        pointer, pointer, integer, integer, pointer, pointer, number, number, number, number, pointer, pointer, integer,
        number, number,
    ]  # fmt: skip
    loaded.spacar_complete.argtypes, loaded.spacar_complete.restype = [pointer] * 4, None
    loaded.spacar_gradient.argtypes = [pointer] * 4
    loaded.spacar_determinant.argtypes, loaded.spacar_determinant.restype = [pointer] * 3, None
    loaded.spacar_reduced_mass.argtypes = [pointer] * 2
    loaded.spacar_guard.argtypes, loaded.spacar_guard.restype = [pointer] * 2, number
    loaded.spacar_rcond.argtypes, loaded.spacar_rcond.restype = [pointer] * 3, number
    return loaded


def _processor() -> str:
    """What -march=native depends on."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        return next(line for line in lines if line.startswith(("flags", "Features")))
    except (OSError, StopIteration):
        return f"{platform.machine()} {platform.processor()} {platform.node()}"
