"""A generated C file, compiled with the system compiler and called by ctypes: 3 to 15 times the speed of Python."""

from __future__ import annotations

import ctypes
import os
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from spacar.errors import AnalysisError
from spacar.symbolic.program import Program

_DOUBLES = np.ctypeslib.ndpointer(dtype=np.float64, flags="C_CONTIGUOUS")


def compiler() -> str | None:
    """The C compiler: $CC, cc or gcc; None when there is none."""
    return next((c for c in (os.environ.get("CC"), "cc", "gcc") if c and shutil.which(c)), None)


class CompiledFunction:
    """f(t, y) -> ẏ with f.jac, f.inputs, f.outputs and f.accel like the generated Python, computed in C."""

    def __init__(self, program: Program, values: Mapping[str, float], feeds: Mapping[str, Callable[..., float]] | None = None) -> None:
        from spacar.symbolic.run import check_values, check_feeds

        numbers = check_values(program, values)
        check_feeds(program, feeds)
        self.program, self.library = program, _build(program.text("c", jacobian=True))
        self.p = np.array([numbers[s.name] for s in program.parameters] or [0.0])
        self.c = np.zeros(len(program.jacobian.once) + 1)
        self.u = np.zeros(max(len(program.inputs), 1))
        self._fed = [(i, (feeds or {})[s.name]) for i, (s, e) in enumerate(program.inputs.items()) if e is None]
        self.library.eom_once(self.p, self.c)

    def _state(self, t: float, y: Any) -> np.ndarray:
        state = np.ascontiguousarray(y, dtype=float)
        for i, function in self._fed:
            self.u[i] = function(t, y)
        return state

    def __call__(self, t: float, y: Any) -> np.ndarray:
        """ẏ at (t, y). ArithmeticError when the mass matrix is not positive definite."""
        rate = np.empty(len(self.program.state))
        self._report(self.library.rhs(t, self.c, self.p, self._state(t, y), self.u, rate))
        return rate

    def jac(self, t: float, y: Any) -> np.ndarray:
        """∂ẏ/∂y at (t, y)."""
        size = len(self.program.state)
        J = np.empty((size, size))
        self._report(self.library.jac(t, self.c, self.p, self._state(t, y), self.u, J))
        return J

    def inputs(self, t: float, y: Any) -> tuple[float, ...]:
        self.library.eom_feed(t, self.c, self.p, self._state(t, y), self.u)
        return tuple(self.u[: len(self.program.inputs)].tolist())

    def outputs(self, t: float, y: Any) -> tuple[float, ...]:
        self.inputs(t, y)
        out = np.zeros(len(self.program.outputs) + 1)
        self.library.eom_outputs(self.c, self.p, self._state(t, y), self.u, out)
        return tuple(out[:-1].tolist())

    def accel(self, y: Any, u: Any) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Upper triangle of I and f."""
        n = self.program.n
        M, f = np.empty((n, n)), np.empty(n)
        self.library.accel(self.p, np.array(y, dtype=float), np.array([*u, 0.0], dtype=float), M, f)
        return tuple(M[np.triu_indices(n)].tolist()), tuple(f.tolist())

    def _report(self, bad: int) -> None:
        if bad:
            raise ArithmeticError(f"mass matrix is not positive definite at {self.program.speeds[bad - 1].name}")


def _build(text: str) -> Any:
    cc = compiler()
    if cc is None:
        raise AnalysisError("no C compiler was found (cc, gcc or $CC): run without --compile", "compiler")
    folder = tempfile.TemporaryDirectory(prefix="spacar-symbolic-")
    source, library = Path(folder.name) / "equations.c", Path(folder.name) / "equations.so"
    source.write_text(text, encoding="utf-8")
    done = subprocess.run(
        [cc, "-std=c99", "-O2", "-shared", "-fPIC", "-o", str(library), str(source), "-lm"],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    if done.returncode:
        raise AnalysisError(f"{cc} could not compile the generated file: {done.stderr.splitlines()[:1]}", "compiler")
    loaded = ctypes.CDLL(str(library))
    folder.cleanup()  # the loaded library stays mapped
    real = ctypes.c_double
    for name, arguments in {
        "eom_once": [_DOUBLES] * 2, "accel": [_DOUBLES] * 5, "eom_feed": [real, *[_DOUBLES] * 4],
        "eom_outputs": [_DOUBLES] * 5, "rhs": [real, *[_DOUBLES] * 5], "jac": [real, *[_DOUBLES] * 5],
    }.items():  # fmt: skip
        getattr(loaded, name).argtypes = arguments
        getattr(loaded, name).restype = ctypes.c_int if name in ("rhs", "jac") else None
    return loaded
