"""C that lets Python call rhs of a generated file directly: a module `spacar_equations` with `rhs(t, y) -> ydot`.

A call by ctypes converts every argument again and costs ten times the arithmetic of a small system. This one takes y
as it is (any sequence of numbers, without a copy when it is a contiguous array of doubles) and returns a new array,
or the number of the pivot (int) that stopped the solution. c, p and u stay at the addresses that `bind` is given. It
needs the headers of Python and NumPy; without them everything else of the file works by ctypes.
"""

import sys
import sysconfig
from pathlib import Path

import numpy as np

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


def compiler_options() -> list[str] | None:
    """Where the headers are, and what a module needs to be linked; None when there are no headers of Python."""
    python, numpy = sysconfig.get_paths()["include"], np.get_include()
    if not (Path(python) / "Python.h").is_file() or not (Path(numpy) / "numpy" / "arrayobject.h").is_file():
        return None
    undefined = ["-undefined", "dynamic_lookup"] if sys.platform == "darwin" else []
    return [f"-I{python}", f"-I{numpy}", *undefined]
