"""Element families by keyword. Imported on demand: a planar model never loads the spatial elements."""

from __future__ import annotations

from importlib import import_module

from spacar.elements.base import Configuration, ElementGroup, Family, GeometryError, Trouble

__all__ = ["FAMILIES", "Configuration", "ElementGroup", "Family", "GeometryError", "Trouble", "family_of"]

FAMILIES = {
    "PLBEAM": "plbeam:PlanarBeam",
    "PLTRUSS": "pltruss:PlanarTruss",
    "PLTOR": "pltor:PlanarHinge",
    "PLPINBOD": "plpinbod:PlanarPinbody",
    "PLRBEAM": "plpinbod:PlanarPinbody",
    "PLWHEEL": "plwheel:PlanarWheel",
    "PLBELT": "plbelt:PlanarBelt",
    "PLTUBE": "pltube:PlanarTube",
    "BEAM": "beam:SpatialBeam",
    "TRUSS": "truss:SpatialTruss",
    "HINGE": "hinge:SpatialHinge",
    "PINBODY": "pinbody:SpatialPinbody",
    "RBEAM": "pinbody:SpatialPinbody",
    "WHEEL": "wheel:DiskWheel",
    "TWHEEL": "wheel:TorusWheel",
    "TUBE": "tube:SpatialTube",
    "SCREW": "screw:Screw",
}


def family_of(keyword: str) -> type[Family]:
    """The class that evaluates all elements of this keyword."""
    module, _, name = FAMILIES[keyword].partition(":")
    family: type[Family] = getattr(import_module(f"spacar.elements.{module}"), name)
    return family
