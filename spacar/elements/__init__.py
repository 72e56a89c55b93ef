"""Element families. Imported on demand: a planar model loads no spatial elements, a run no definition in SymPy."""

from __future__ import annotations

from functools import cache
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from spacar.elements.family import Configuration, ElementGroup, Family, GeometryError, Trouble

if TYPE_CHECKING:
    from spacar.elements.definition_symbolic import Definition

__all__ = ["Configuration", "ElementGroup", "Family", "GeometryError", "Trouble", "definitions", "family_of"]


@cache
def family_of(place: str) -> type[Family]:
    """The class at "module:Class", as a row of the element types names it."""
    module, _, name = place.partition(":")
    family: type[Family] = getattr(import_module(f"spacar.elements.{module}"), name)
    return family


@cache
def definitions() -> tuple[Definition, ...]:
    """Of all types, in the order of their numbers in the engine: what the modules `NAME_symbolic.py` state."""
    home = Path(__file__).parent
    modules = [f"{path.parent.name}.{path.stem}" for path in sorted(home.glob("*/*_symbolic.py"))]
    stated = [getattr(import_module(f"spacar.elements.{name}"), "DEFINITIONS", ()) for name in modules]
    return tuple(definition for several in stated for definition in several)
