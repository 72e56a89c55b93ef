"""PLTRUSS in SymPy; TRUSS is the same in space."""

from spacar.elements.definition_symbolic import LEFT, Definition, length


def half_difference(x: list) -> list:
    """Second half of a list less the first."""
    half = len(x) // 2
    return [b - a for a, b in zip(x[:half], x[half:], strict=True)]


def truss_strain(x: list, p: dict) -> list:
    return [length(half_difference(x)) - p["l0"]]


def truss_guard(x: list, p: dict) -> list:
    """Length."""
    return [length(half_difference(x)) / p["l0"] + LEFT]


DEFINITIONS = (Definition("pltruss", 4, ("l0",), truss_strain, guard=truss_guard),)
