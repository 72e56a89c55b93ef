"""PLTOR in SymPy."""

from spacar.elements.definition_symbolic import Definition


def pltor_strain(x: list, p: dict) -> list:
    return [x[1] - x[0]]


DEFINITIONS = (Definition("pltor", 2, (), pltor_strain),)
