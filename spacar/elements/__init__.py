"""Element families. Imported on demand: a planar model never loads the spatial elements."""

from __future__ import annotations

from functools import cache
from importlib import import_module

from spacar.elements.family import Configuration, ElementGroup, Family, GeometryError, Trouble

__all__ = ["Configuration", "ElementGroup", "Family", "GeometryError", "Trouble", "family_of"]


@cache
def family_of(place: str) -> type[Family]:
    """The class at "module:Class", as a row of the element types names it."""
    module, _, name = place.partition(":")
    family: type[Family] = getattr(import_module(f"spacar.elements.{module}"), name)
    return family
