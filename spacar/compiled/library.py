"""The compiled engine: a shared library, built when spacar was installed (hatch_build.py) and loaded with ctypes.

It lies in this package and nowhere else: nothing is compiled at run time, and no other place is looked at.
`cpu_dispatch.c` has builds for several levels of the processor and says which one serves. In a clone
the C text lies beside the library; a library of another text is not used.
"""

from __future__ import annotations

import ctypes
import hashlib
import os
import sys
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any

from spacar.arrays import Array
from spacar.errors import UsageError

HERE = Path(__file__).parent
NAME = {"win32": "engine.dll", "darwin": "engine.dylib"}.get(sys.platform, "engine.so")
GENERAL = "SPACAR_GENERAL"  # environment variable: anything but empty or 0 switches the engine off

# What kernels.c and derivatives.c are derived from: a row of elements that is not in the library must not be taken for
# one that is
GENERATED_FROM = (
    "definitions.py", "planar_definitions.py", "spatial_definitions.py", "element_parameters.py", "generate.py",
    "derivative_kernels.py", "element_texts.py",
)  # fmt: skip
DOUBLES = INTEGERS = ctypes.c_void_p  # addresses: typed pointers cost more to make than small models to evaluate


class CElements(ctypes.Structure):
    """`Elements` of batches.c."""

    _fields_ = [*((name, ctypes.c_int) for name in ("kind", "n", "nxe", "nee", "np")), ("p", DOUBLES)]


class CForeign(ctypes.Structure):
    """`Foreign` of elements.c."""

    _fields_ = [(name, DOUBLES) for name in ("x", "v", "branch", "e", "V", "H", "M", "h")]


class CUser(ctypes.Structure):
    """`User` of elements.c."""

    _fields_ = [
        *((name, DOUBLES) for name in ("x", "xd", "force", "e", "ed", "sigma")), ("lost", ctypes.c_int),
    ]  # fmt: skip


class CPythonCallbacks(ctypes.Structure):
    """`PythonCallbacks` of python_callbacks.c."""

    _fields_ = [
        ("python", ctypes.c_void_p), ("sigma", DOUBLES), ("force", DOUBLES), ("n_sigma", ctypes.c_int),
        *((name, ctypes.c_void_p) for name in ("function", *(f"told_{k}" for k in range(8)))),
        *((name, ctypes.c_void_p) for name in ("back", "answer", "keep", "read", "rows")),
        ("t", ctypes.c_double), *((name, ctypes.c_int) for name in ("n_force", "within", "stopped")),
    ]  # fmt: skip


class CState(ctypes.Structure):
    """`State` of elements.c."""

    _fields_ = [
        ("known", ctypes.c_int), ("t", ctypes.c_double),
        *((name, DOUBLES) for name in (
            "x", "xd", "xdd", "e", "ed", "edd", "sigma", "given_e", "applied", "gravity", "total", "y",
        )),
        ("whole", ctypes.c_int64), ("watched", ctypes.c_int), ("signs", ctypes.c_int),
        ("mantissa", ctypes.c_double), ("exponent", ctypes.c_double),
    ]  # fmt: skip


WIDTH = ctypes.sizeof(ctypes.c_double)  # of a number in memory
_NOTHING = ctypes.c_char * 0


def address_of(array: Array) -> int:
    """Address of the first number of a contiguous array that may be written to; `array.ctypes` takes three times as
    long."""
    return ctypes.addressof(_NOTHING.from_buffer(array))  # type: ignore[arg-type]


POINTER, NUMBER, INTEGER = ctypes.c_void_p, ctypes.c_double, ctypes.c_int
FUNCTIONS: dict[str, tuple[Any, ...]] = {  # in the order of the table in engine.c: result, arguments
    "begin": (POINTER, POINTER, POINTER, POINTER, POINTER, POINTER),
    "end": (None, POINTER),
    "capsules": (None, POINTER),
    "dropped": (None, POINTER),
    "renew": (None, POINTER),
    "state": (None, POINTER, POINTER, POINTER),
    "start": (INTEGER, POINTER, POINTER, POINTER, POINTER, NUMBER, NUMBER, NUMBER, INTEGER),
    "evaluate": (INTEGER, POINTER, POINTER, NUMBER, POINTER, NUMBER, NUMBER),
    "rhs": (INTEGER, POINTER, POINTER, NUMBER, POINTER, POINTER, NUMBER, NUMBER),
    "stages": (
        INTEGER, POINTER, POINTER, INTEGER, INTEGER, POINTER, POINTER, NUMBER, NUMBER, NUMBER, NUMBER, POINTER, POINTER,
        INTEGER, NUMBER, NUMBER,
    ),
    "forget": (None, POINTER),
    "gradient": (INTEGER, POINTER, POINTER, POINTER, POINTER),
    "determinant": (None, POINTER, POINTER, POINTER),
    "reduced_mass": (INTEGER, POINTER, POINTER),
    "guard": (NUMBER, POINTER, POINTER),
    "rcond": (NUMBER, POINTER, NUMBER, INTEGER),
    "rcond_everywhere": (NUMBER, POINTER),
    "adams_begin": (INTEGER, POINTER, POINTER),
    "adams": (INTEGER, POINTER, POINTER),
    "adams_value": (INTEGER, POINTER, POINTER, NUMBER, POINTER),
    "runge_kutta": (INTEGER, POINTER, POINTER),
    "newton": (INTEGER, POINTER, POINTER, POINTER),
    "show": (INTEGER, POINTER, POINTER),
    "pass_adams": (INTEGER, POINTER, POINTER, POINTER),
    "pass_runge_kutta": (INTEGER, POINTER, POINTER, POINTER),
    "loop_stages": (
        INTEGER, POINTER, INTEGER, INTEGER, POINTER, POINTER, NUMBER, NUMBER, NUMBER, NUMBER, POINTER, POINTER, POINTER,
        INTEGER, POINTER,
    ),
}  # fmt: skip

# in the order of the second table in engine.c: batches.c, equilibrium.c, rest_newton.c,
# definite.c, linearized.c
ELEMENT_FUNCTIONS: dict[str, tuple[Any, ...]] = {
    "strain": (None, *[POINTER] * 5),
    "convective": (None, *[POINTER] * 4),
    "inertia": (None, *[POINTER] * 6),
    "geometric": (None, *[POINTER] * 4),
    "rates": (None, POINTER, POINTER, POINTER, INTEGER, POINTER),
    "transport": (None, *[POINTER] * 4),
    "inertia_gradient": (None, *[POINTER] * 6),
    "guard": (NUMBER, POINTER, POINTER),
    "equilibrium_begin": (INTEGER, POINTER),
    "equilibrium_end": (None, POINTER),
    "equilibrium_newton": (INTEGER, POINTER),
    "equilibrium_point": (INTEGER, POINTER),
    "equilibrium_factor": (INTEGER, POINTER),
    "equilibrium_sign": (NUMBER, POINTER),
    "equilibrium_definite": (INTEGER, POINTER),
    "equilibrium_linearize": (INTEGER, POINTER, POINTER),
}


def _bind(owner: object, functions: dict[str, tuple[Any, ...]], addresses: Any) -> None:
    """Functions as attributes: their addresses stand behind the first one, in the order of the table."""
    for k, (name, (result, *arguments)) in enumerate(functions.items(), 1):
        setattr(owner, name, ctypes.CFUNCTYPE(result, *arguments)(addresses[k]))


class ElementFunctions:
    """The functions of batches of elements (batches.c), of the widest build for this processor that has them.

    `kinds`: names of the types that have all of them.
    """

    kinds: frozenset[str]

    def __init__(self, loaded: ctypes.CDLL) -> None:
        addresses = loaded.spacar_element_functions()
        self.kinds = frozenset(ctypes.string_at(addresses[0]).decode("ascii").split())
        _bind(self, ELEMENT_FUNCTIONS, addresses)

    strain: Any
    convective: Any
    inertia: Any
    geometric: Any
    rates: Any
    transport: Any
    inertia_gradient: Any
    guard: Any
    equilibrium_begin: Any
    equilibrium_end: Any
    equilibrium_newton: Any
    equilibrium_point: Any
    equilibrium_factor: Any
    equilibrium_sign: Any
    equilibrium_definite: Any
    equilibrium_linearize: Any


def _new_capsule() -> Callable[..., object] | None:
    """PyCapsule_New(pointer, name, destructor), where Python has capsules."""
    try:
        return ctypes.PYFUNCTYPE(ctypes.py_object, POINTER, POINTER, POINTER)(("PyCapsule_New", ctypes.pythonapi))
    except AttributeError:
        return None


class _Owner:
    """The same in another Python."""

    def __init__(self, end: Callable[[int], None], model: int) -> None:
        self.end, self.model = end, model

    def __del__(self) -> None:
        self.end(self.model)


class Engine:
    """The functions of one build, for `lanes` cases at a time. `kinds`: number and count of parameters by name."""

    kinds: dict[str, tuple[int, int]]

    def __init__(self, loaded: ctypes.CDLL, lanes: int) -> None:
        self.lanes = lanes
        addresses = loaded.spacar_functions(lanes)
        self.kinds = {}
        for k, word in enumerate(ctypes.string_at(addresses[0]).decode("ascii").split()):
            name, _, count = word.partition("/")
            self.kinds[name] = k, int(count)
        _bind(self, FUNCTIONS, addresses)
        self._new, self._dropped = _new_capsule(), ctypes.cast(self.dropped, POINTER).value
        if self._new is not None:
            self.capsules(ctypes.cast(ctypes.pythonapi.PyCapsule_GetPointer, POINTER))

    def owner(self, model: int) -> object:
        """What ends a model with its last reference, without a call of Python: within a `__del__` a Ctrl-C is lost."""
        return _Owner(self.end, model) if self._new is None else self._new(model, None, self._dropped)

    begin: Any
    end: Any
    capsules: Any
    dropped: Any
    renew: Any
    state: Any
    start: Any
    evaluate: Any
    rhs: Any
    stages: Any
    forget: Any
    gradient: Any
    determinant: Any
    newton: Any
    reduced_mass: Any
    guard: Any
    rcond: Any
    rcond_everywhere: Any
    adams_begin: Any
    adams: Any
    adams_value: Any
    runge_kutta: Any
    show: Any
    pass_adams: Any
    pass_runge_kutta: Any
    loop_stages: Any


@lru_cache
def _loaded() -> ctypes.CDLL | str:
    """The library, or why there is none."""
    path = HERE / NAME
    if not path.is_file():
        note = HERE / "left_out.txt"  # hatch_build.py
        why = note.read_text("utf-8", "replace") if note.is_file() else "no C compiler"
        return f"the compiled engine was left out when spacar was installed ({why})"
    try:
        loaded = ctypes.CDLL(str(path))
        loaded.spacar_source.restype = loaded.spacar_level.restype = ctypes.c_char_p
        for table in (loaded.spacar_functions, loaded.spacar_element_functions):
            table.restype = ctypes.POINTER(ctypes.c_void_p)
        source = loaded.spacar_source().decode("ascii")
    except (OSError, AttributeError) as error:
        return f"the compiled engine cannot be loaded: {error}"
    if (HERE / "engine.c").is_file() and source != source_digest():
        return (
            "the compiled engine was built from another C text or other element definitions: `make crank` or"
            " `python hatch_build.py` builds it"
        )
    return loaded


def source_digest() -> str:
    """Digest of the C text beside this module and of what it is generated from, as hatch_build.py makes it."""
    text = hashlib.sha256()
    entering = (HERE / name for name in GENERATED_FROM)
    for path in sorted((*HERE.glob("*.c"), *filter(Path.is_file, entering))):
        text.update(path.read_bytes().replace(b"\r\n", b"\n"))
    return text.hexdigest()[:16]


def unavailable() -> str | None:
    """Why the engine cannot be used on this machine, or None."""
    found = _loaded()
    return found if isinstance(found, str) else None


def switched_off() -> bool:
    """Whether the environment asks for the general path."""
    return os.environ.get(GENERAL, "") not in ("", "0")


def why_off() -> str | None:
    """Why every run takes the general path here, or None."""
    return f"the environment variable {GENERAL} asks for it" if switched_off() else unavailable()


@lru_cache
def level() -> str:
    """Level of the processor, by which the build was chosen: 'x86-64-v3', ... Only where the engine is available."""
    name: bytes = _ready().spacar_level()
    return name.decode("ascii")


def lanes_of_processor() -> int:
    """How many cases `engine` evaluates at a time at most."""
    count: int = _ready().spacar_lanes()
    return count


@lru_cache
def engine(lanes: int = 1) -> Engine:
    """The engine for one case or `lanes_of_processor`. Raises UsageError where it is not available."""
    return Engine(_ready(), lanes)


@lru_cache
def element_functions() -> ElementFunctions:
    """Functions of batches of elements. Raises UsageError where the engine is not available."""
    return ElementFunctions(_ready())


def _ready() -> ctypes.CDLL:
    found = _loaded()
    if isinstance(found, str):
        raise UsageError(found, "compiled.unavailable")
    return found
