"""TRUSS in SymPy: as the planar one."""

from spacar.elements.definition_symbolic import Definition
from spacar.elements.planar.pltruss_symbolic import truss_guard, truss_strain

DEFINITIONS = (Definition("truss", 6, ("l0",), truss_strain, guard=truss_guard),)
