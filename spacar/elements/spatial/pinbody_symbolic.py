"""PINBODY and RBEAM in SymPy (theory-spatial.md section 6)."""

from spacar.elements.definition_symbolic import Definition, dot
from spacar.elements.rotations.rotation_symbolic import FRAME, frame, rotated


def pinbody_strain(x: list, p: dict) -> list:
    d = [b - a for a, b in zip(x[:3], x[7:], strict=True)]
    return [dot(rotated(x[3:7], c), d) - p[f"r{k}"] for k, c in enumerate(frame(p))]


DEFINITIONS = (Definition("pinbody", 10, (*FRAME, "r0", "r1", "r2"), pinbody_strain),)
