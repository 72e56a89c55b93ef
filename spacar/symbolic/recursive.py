"""Strategy `recursive`: the formulas (A), (B) of `held.py` with every component in the body's own frame a Z variable.

The motion of frames and points: `recursion.py`; of beams: `recursive_beam.py`. Source: `symbolic.md`, section 4.4.
"""

from __future__ import annotations

import sympy as sp

from spacar.symbolic.derivation import Derivation
from spacar.symbolic.description import Description
from spacar.symbolic.recursion import Recursion, Sums
from spacar.symbolic.recursive_beam import add_beam


def derive_recursive(system: Description) -> Derivation:
    """Mass matrix and right-hand side for all speeds of the system."""
    recursion = Recursion(system)
    sums = Sums(list(system.speeds))
    for body in system.bodies:
        recursion.body(body, sums)
    for beam in system.beams:
        add_beam(recursion, beam, sums)
    for load in system.all_loads():
        recursion.load(load, sums)
    n = len(system.speeds)
    I, f = sp.zeros(n, n), sp.zeros(n, 1)
    for (i, j), parts in sums.mass.items():
        I[i, j] = I[j, i] = sp.Add(*parts)
    for i, parts in sums.force.items():
        f[i] = sp.Add(*parts)
    return Derivation(I, f, recursion.table, recursion.cosines, recursion.values)
