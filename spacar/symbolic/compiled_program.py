"""A generated C file, compiled with the system compiler: right-hand sides at 30 to 50 times the speed of Python.

The right-hand side is called as a function of an extension module where the headers of Python and NumPy are installed,
as ctypes converts every argument again and costs ten times the arithmetic of a small system; everything else by ctypes.
The function takes any y, without a copy when it is a contiguous array of doubles, and returns a new array, or the
number of the pivot (int) that stopped the solution. c, p and u stay at the addresses that `bind` is given.
"""

import ctypes
import importlib.machinery
import importlib.util
import os
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from spacar.errors import AnalysisError, UsageError
from spacar.native import store
from spacar.symbolic.emit import emit
from spacar.symbolic.emit.routines import sizes
from spacar.symbolic.ordered import OrderedProgram
from spacar.symbolic.program_jacobian import jacobian_of
from spacar.symbolic.simulated_motion import Feeds, check_values

MODULE = "spacar_equations"

SOURCE = """
enum { STATES = NY };
#undef NP  /* headers may use such short names */
#undef NC
#undef NQ
#undef N
#undef NY
#undef NU
#undef NOUT
#undef NM
#undef NG
#define PY_SSIZE_T_CLEAN
#define NPY_NO_DEPRECATED_API NPY_1_7_API_VERSION
#include <Python.h>
#include <numpy/arrayobject.h>

static double *bound_c, *bound_p, *bound_u;

static PyObject *bind(PyObject *self, PyObject *args)
{
    Py_ssize_t c, p, u;
    (void)self;
    if (!PyArg_ParseTuple(args, "nnn", &c, &p, &u)) return NULL;
    bound_c = (double *)c;
    bound_p = (double *)p;
    bound_u = (double *)u;
    Py_RETURN_NONE;
}

static PyObject *call(PyObject *self, PyObject *const *args, Py_ssize_t count)
{
    (void)self;
    if (count != 2) return PyErr_Format(PyExc_TypeError, "expected t and y, got %zd arguments", count);
    double t = PyFloat_AsDouble(args[0]);
    if (t == -1.0 && PyErr_Occurred()) return NULL;
    PyArrayObject *y = (PyArrayObject *)PyArray_FROM_OTF(args[1], NPY_DOUBLE, NPY_ARRAY_IN_ARRAY);
    if (!y) return NULL;
    if (PyArray_SIZE(y) != STATES) {
        Py_ssize_t given = PyArray_SIZE(y);
        PyErr_Format(PyExc_ValueError, "y has %zd numbers, the system has %d states", given, STATES);
        Py_DECREF(y);
        return NULL;
    }
    npy_intp size = STATES;
    PyObject *ydot = PyArray_SimpleNew(1, &size, NPY_DOUBLE);
    int bad = ydot ? rhs(t, bound_c, bound_p, PyArray_DATA(y), bound_u, PyArray_DATA((PyArrayObject *)ydot)) : 0;
    Py_DECREF(y);
    if (!bad) return ydot;
    Py_DECREF(ydot);
    return PyLong_FromLong(bad);
}

static PyMethodDef methods[] = {
    {"rhs", (PyCFunction)(void (*)(void))call, METH_FASTCALL, "rhs(t, y) -> ydot"},
    {"bind", bind, METH_VARARGS, "bind(c, p, u): addresses"},
    {NULL, NULL, 0, NULL}
};
static struct PyModuleDef module = {
    PyModuleDef_HEAD_INIT, "spacar_equations", NULL, -1, methods, NULL, NULL, NULL, NULL
};

PyMODINIT_FUNC PyInit_spacar_equations(void)
{
    import_array();
    return PyModule_Create(&module);
}
"""


def compiler() -> list[str] | None:
    """The words that call the C compiler: those of CC, else cc or gcc; None when CC is not set and there is none.

    Raises UsageError for a CC that is empty, cannot be read, or names a program that is not there.
    """
    if "CC" not in os.environ:
        return next(([c] for c in ("cc", "gcc") if shutil.which(c)), None)
    try:
        return store.compiler()
    except UsageError as error:
        if error.code != "compiled.no-compiler":
            raise
        text = f"the C compiler that the environment variable CC names, '{os.environ['CC']}', was not found"
        raise UsageError(f"{text}: unset CC, or name one that is there", error.code) from None


class CompiledFunction:
    """f(t, y) -> ẏ with f.jac, f.inputs, f.outputs and f.accel like the generated Python, computed in C."""

    def __init__(
        self, program: OrderedProgram, values: Mapping[str, float],
        feeds: Feeds | None = None,
    ) -> None:  # fmt: skip
        numbers = check_values(program, values, feeds)
        self.program = program
        self.library, module = _build(emit(program, "c", jacobian=True, headed=False))
        lengths = sizes(program, jacobian_of(program).once)
        lengths |= {"ydot": lengths["y"], "jac": lengths["y"] ** 2}
        # one buffer for every argument: addresses are taken once, a call costs little more than the arithmetic
        self._buffer = {name: np.zeros(max(length, 1)) for name, length in lengths.items()}
        self._at = {name: ctypes.c_void_p(array.ctypes.data) for name, array in self._buffer.items()}
        self._buffer["p"][: len(numbers)] = list(numbers.values())
        self._fed = [(i, (feeds or {})[s.name]) for i, (s, e) in enumerate(program.inputs.items()) if e is None]
        self._call("eom_once", "p", "c")
        self._rhs_places = [self._at[a] for a in ("c", "p", "y", "u", "ydot")]
        self._direct: Callable[..., Any] = self._by_ctypes
        if module is not None:
            module.bind(*(self._buffer[name].ctypes.data for name in ("c", "p", "u")))
            self._direct = module.rhs

    def _call(self, name: str, *arguments: str | float) -> int:
        return int(getattr(self.library, name)(*(self._at[a] if isinstance(a, str) else a for a in arguments)))

    def _feed(self, t: float, y: Any) -> None:
        for i, function in self._fed:
            self._buffer["u"][i] = function(t, y)

    def _at_state(self, t: float, y: Any) -> None:
        self._buffer["y"][:] = y
        self._feed(t, y)

    def __call__(self, t: float, y: Any) -> np.ndarray:
        """ẏ at (t, y). ArithmeticError when the mass matrix is not positive definite."""
        if self._fed:
            self._feed(t, y)
        rates = self._direct(t, y)
        if rates.__class__ is int:
            self._report(rates)
        return rates

    def _by_ctypes(self, t: float, y: Any) -> Any:
        """ẏ, or the number of the pivot that stopped the solution."""
        self._buffer["y"][:] = y
        return self.library.rhs(t, *self._rhs_places) or self._buffer["ydot"].copy()

    def many(self, t: Any, y: Any) -> np.ndarray:
        """ẏ (count, n) at times t (count,) and states y (count, n): the loop is in C, without the price of a call.

        ArithmeticError, with the number of the first state, when its mass matrix is not positive definite.
        """
        states = np.ascontiguousarray(y, dtype=float).reshape(-1, len(self.program.state))
        times = np.ascontiguousarray(np.broadcast_to(np.asarray(t, dtype=float), (len(states),)))
        inputs = np.zeros((len(states), max(len(self.program.inputs), 1)))[:, : len(self.program.inputs)].copy()
        for i, function in self._fed:
            inputs[:, i] = [function(*row) for row in zip(times.tolist(), states.tolist(), strict=True)]
        rates = np.empty_like(states)
        addresses = [ctypes.c_void_p(a.ctypes.data) for a in (times, states, inputs, rates)]
        bad = self.library.rhs_many(len(states), addresses[0], self._at["c"], self._at["p"], *addresses[1:])
        if bad:
            raise ArithmeticError(f"the right-hand side cannot be evaluated at state {bad}")
        return rates

    def jac(self, t: float, y: Any) -> np.ndarray:
        """∂ẏ/∂y at (t, y)."""
        self._at_state(t, y)
        self._report(self._call("jac", t, "c", "p", "y", "u", "jac"))
        size = len(self.program.state)
        return self._buffer["jac"].reshape(size, size).copy()

    def inputs(self, t: float, y: Any) -> tuple[float, ...]:
        """The inputs at (t, y)."""
        self._at_state(t, y)
        self._call("eom_feed", t, "c", "p", "y", "u")
        return tuple(self._buffer["u"][: len(self.program.inputs)].tolist())

    def outputs(self, t: float, y: Any) -> tuple[float, ...]:
        """The named outputs at (t, y)."""
        self._at_state(t, y)
        self._report(self._call("outputs", t, "c", "p", "y", "u", "out"))
        return tuple(self._buffer["out"][: len(self.program.outputs)].tolist())

    def accel(self, y: Any, u: Any) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Upper triangle of I, and f, for a state and inputs."""
        n = self.program.n
        self._buffer["y"][:] = y
        self._buffer["u"][: len(self.program.inputs)] = u
        self._call("accel", "p", "y", "u", "M", "f", *(("J", "h") if self.program.m else ()))
        M = self._buffer["M"].reshape(n, n)
        return tuple(M[np.triu_indices(n)].tolist()), tuple(self._buffer["f"].tolist())

    def manifold(self, t: float, y: Any) -> tuple[np.ndarray, ...]:
        """I, J, the open velocities e, the gaps g and ∂q̇/∂s of a program with constraints."""
        c = self.program.constraints
        if c is None:
            raise UsageError("the program has no constraints", "constraint")
        n, m, nq = self.program.n, self.program.m, len(self.program.coordinates)
        self.inputs(t, y)
        self._call("eom_step", "c", "p", "y", "u", "M", "f", "J", "h")
        self._call("eom_manifold", "c", "p", "y", "u", "res", "turn")
        M, J, res, turn = (self._buffer[name].copy() for name in ("M", "J", "res", "turn"))
        return M.reshape(n, n), J.reshape(m, n), res[:m], res[m : m + len(c.position)], turn[: nq * n].reshape(nq, n)

    def _report(self, bad: int) -> None:
        if bad < 0:
            raise ArithmeticError("the constraints depend on each other at this position")
        if bad:
            raise ArithmeticError(f"mass matrix is not positive definite at {self.program.speeds[bad - 1].name}")


def _build(text: str) -> tuple[Any, Any]:
    """The library, and the same file as a module when the headers of Python are there, else None."""
    cc = compiler()
    if cc is None:
        raise AnalysisError("no C compiler was found (cc, gcc or $CC): run without --compiled", "compiler")
    options = compiler_options()
    with tempfile.TemporaryDirectory(prefix="spacar-symbolic-") as folder:  # a loaded library stays mapped
        library = None
        if options is not None:
            library = _compile(cc, Path(folder) / "module", text + SOURCE, options)
        direct = library is not None
        if library is None:
            library = _compile(cc, Path(folder) / "plain", text, [])
        assert library is not None  # without options it is there, or an error was raised
        tried = subprocess.run([sys.executable, "-I", "-c", store.TRY, str(library)], capture_output=True, check=False)
        if tried.returncode:  # a broken library would end this process
            raise AnalysisError(f"{cc[0]} wrote a library that cannot be loaded: run without --compiled", "compiler")
        loaded = ctypes.CDLL(str(library))
        for timed in (loaded.rhs, loaded.jac, loaded.outputs, loaded.eom_feed):
            timed.argtypes = [ctypes.c_double]  # addresses follow
        return loaded, _module(library) if direct else None


def _compile(cc: list[str], stem: Path, text: str, options: list[str]) -> Path | None:
    """The compiled text. AnalysisError when it cannot be; None instead when `options` were asked for."""
    source, library = stem.with_suffix(".c"), stem.with_suffix(".so")
    source.write_text(text, encoding="utf-8")
    done = subprocess.run(
        [*cc, "-std=c99", "-O3", "-shared", "-fPIC", *options, "-o", str(library), str(source), "-lm"],
        capture_output=True, text=True, errors="replace", check=False,
    )  # fmt: skip
    if not done.returncode:
        return library
    if options:
        return None
    raise AnalysisError(f"{cc[0]} could not compile the generated file: {done.stderr.splitlines()[:1]}", "compiler")


def _module(library: Path) -> Any:
    loader = importlib.machinery.ExtensionFileLoader(MODULE, str(library))
    spec = importlib.util.spec_from_loader(MODULE, loader)
    assert spec is not None
    module = importlib.util.module_from_spec(spec)
    loader.exec_module(module)
    return module


def compiler_options() -> list[str] | None:
    """Where the headers are, and what a module needs to be linked; None when there are no headers of Python."""
    python, numpy = sysconfig.get_paths()["include"], np.get_include()
    if not (Path(python) / "Python.h").is_file() or not (Path(numpy) / "numpy" / "arrayobject.h").is_file():
        return None
    undefined = ["-undefined", "dynamic_lookup"] if sys.platform == "darwin" else []
    return [f"-I{python}", f"-I{numpy}", *undefined]
