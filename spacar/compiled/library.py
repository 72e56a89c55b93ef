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
from typing import TYPE_CHECKING, Any

from spacar.arrays import Array
from spacar.compiled.interface import POINTER, STRUCTURES, functions, structure
from spacar.errors import UsageError

HERE = Path(__file__).parent
NAME = {"win32": "engine.dll", "darwin": "engine.dylib"}.get(sys.platform, "engine.so")
GENERAL = "SPACAR_GENERAL"  # environment variable: anything but empty or 0 switches the engine off

# What kernels.c and derivatives.c are derived from: an element that is not in the library must not be taken for one
# that is
GENERATED_FROM = (  # two modules for GUARD and LARGE_ANGLE, which enter the texts
    "compiled/generator/*.py", "elements/**/*_symbolic.py", "elements/family.py", "elements/spatial/beam.py",
)  # fmt: skip


WIDTH = ctypes.sizeof(ctypes.c_double)  # of a number in memory
_NOTHING = ctypes.c_char * 0


def address_of(array: Array) -> int:
    """Address of the first number of a contiguous array that may be written to; `array.ctypes` takes three times as
    long."""
    return ctypes.addressof(_NOTHING.from_buffer(array))  # type: ignore[arg-type]


class BoundTable:
    """Functions as attributes, by the table of engine.h. `text` (names of types), `sizes`, and then they, are at the
    addresses."""

    def __init__(self, table: str, addresses: Any) -> None:
        self.text = ctypes.string_at(addresses[0]).decode("ascii").split()
        for k, (name, (result, *arguments)) in enumerate(functions(table).items(), 2):
            setattr(self, name.removeprefix("elements_"), ctypes.CFUNCTYPE(result, *arguments)(addresses[k]))

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any: ...


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


class Engine(BoundTable):
    """The functions of one build, for `lanes` cases at a time. `kinds`: number and count of parameters by name."""

    def __init__(self, loaded: ctypes.CDLL, lanes: int) -> None:
        super().__init__("FUNCTIONS", loaded.spacar_functions(lanes))
        self.lanes = lanes
        named = [word.partition("/") for word in self.text]
        self.kinds = {name: (k, int(count)) for k, (name, _, count) in enumerate(named)}
        self._new, self._dropped = _new_capsule(), ctypes.cast(self.dropped, POINTER).value
        if self._new is not None:
            self.capsules(ctypes.cast(ctypes.pythonapi.PyCapsule_GetPointer, POINTER))

    def owner(self, model: int) -> object:
        """What ends a model with its last reference, without a call of Python: within a `__del__` a Ctrl-C is lost."""
        return _Owner(self.end, model) if self._new is None else self._new(model, None, self._dropped)


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
        sizes = ctypes.cast(loaded.spacar_functions(1)[1], ctypes.POINTER(ctypes.c_size_t))
    except (OSError, AttributeError) as error:
        return f"the compiled engine cannot be loaded: {error}"
    if (HERE / "engine.c").is_file() and source != source_digest():
        return (
            "the compiled engine was built from another C text or other element definitions: `make crank` or"
            " `python hatch_build.py` builds it"
        )
    wrong = [name for k, name in enumerate(STRUCTURES) if sizes[k] != ctypes.sizeof(structure(name))]
    return f"the compiled engine and Python count the bytes of {wrong[0]} differently" if wrong else loaded


def source_digest() -> str:
    """Digest of the C text beside this module and of what it is generated from, as hatch_build.py makes it."""
    text = hashlib.sha256()
    entering = (path for pattern in GENERATED_FROM for path in sorted(HERE.parent.glob(pattern)))
    for path in (*sorted(HERE.glob("*.[ch]")), *entering):
        text.update(path.read_bytes().replace(b"\r\n", b"\n"))
    return text.hexdigest()[:16]


def unavailable() -> str | None:
    """Why the engine cannot be used on this machine, or None."""
    found = _loaded()
    return found if isinstance(found, str) else None


def why_off() -> str | None:
    """Why every run takes the general path here, or None."""
    switched_off = os.environ.get(GENERAL, "") not in ("", "0")
    return f"the environment variable {GENERAL} asks for it" if switched_off else unavailable()


@lru_cache
def level() -> str:
    """Level of the processor, by which the build was chosen: 'x86-64-v3', ... Only where the engine is available."""
    return str(_ready().spacar_level(), "ascii")


def lanes_of_processor() -> int:
    """How many cases `engine` evaluates at a time at most."""
    return int(_ready().spacar_lanes())


@lru_cache
def engine(lanes: int = 1) -> Engine:
    """The engine for one case or `lanes_of_processor`. Raises UsageError where it is not available."""
    return Engine(_ready(), lanes)


@lru_cache
def element_functions() -> BoundTable:
    """Functions of batches of elements (batches.c), of the widest build for this processor that has them; `text`: names
    of the types that have all of them. Raises UsageError where the engine is not available."""
    return BoundTable("ELEMENT_FUNCTIONS", _ready().spacar_element_functions())


def _ready() -> ctypes.CDLL:
    found = _loaded()
    if isinstance(found, str):
        raise UsageError(found, "compiled.unavailable")
    return found
