"""The structures and functions of the engine as ctypes has them, read from engine.h."""

from __future__ import annotations

import ctypes
import re
from functools import cache
from pathlib import Path
from typing import Any

# Addresses are plain: typed pointers cost more to make than small models to evaluate
POINTER, NUMBER, INTEGER, WHOLE = ctypes.c_void_p, ctypes.c_double, ctypes.c_int, ctypes.c_int64
SCALARS: dict[str, Any] = {"double": NUMBER, "int": INTEGER, "int64_t": WHOLE}  # of others only addresses are shared

_text = (Path(__file__).parent / "engine.h").read_text("utf-8")
_text = re.sub(r"/\*.*?\*/|\\\n", " ", _text, flags=re.DOTALL)
_constants = {name: int(value) for name, value in re.findall(r"[{,]\s+(\w+) = (-?\d+)", _text)}
_bodies = {name: body for body, name in re.findall(r"typedef struct \{([^}]*)\} (\w+);", _text)}
STRUCTURES = tuple(_bodies)


def _type(base: str, declarator: str) -> Any:
    return POINTER if "*" in declarator else SCALARS.get(base, POINTER)


def constants(*names: str) -> tuple[int, ...]:
    """Values of names."""
    return tuple(_constants[name] for name in names)


@cache
def structure(name: str) -> Any:
    """As ctypes has it."""
    found = []
    for declaration in filter(str.strip, _bodies[name].split(";")):
        base, members = declaration.replace("const ", "").split(None, 1)
        for member in members.split(","):
            field, *sizes = re.findall(r"\w+", member)
            kind = _type(base, member)
            for count in sizes:
                kind *= _constants.get(count) or int(count)
            found.append((field, kind))
    return type(name, (ctypes.Structure,), {"_fields_": found})


def functions(table: str) -> dict[str, tuple[Any, ...]]:
    """Result and arguments of the functions of a table, in its order."""
    found: dict[str, tuple[Any, ...]] = {}
    listed = re.search(rf"#define {table}\(F\)(.*)", _text)
    assert listed
    for result, name, arguments in re.findall(r"F\(([\w *]+), (\w+), \((.*?)\)\)", listed[1]):
        types = [_type(a.replace("const ", "").split()[0], a) for a in arguments.split(",")]
        found[name] = (None if result == "void" else _type(result, result), *types)
    return found
