"""Import of models made with `sympy.physics.mechanics`: equations of a `KanesMethod` as a program source.

SymPy's own derivation becomes `SymbolicEquations`, so that the program, the emitters and the simulation serve
it too, and the two derivations can be compared.
"""

import sympy as sp
from sympy.physics.mechanics import KanesMethod

from spacar.symbolic.collect import ZTable
from spacar.symbolic.symbolic_equations import SymbolicEquations
from spacar.symbolic.system import MultibodySystem
from spacar.symbolic.transform import DirectionCosines
from spacar.symbolic.unit_vectors import TIME


def from_kanes_method(kane: KanesMethod, title: str = "") -> SymbolicEquations:
    """Equations of a KanesMethod whose `kanes_equations` were formed; dependent speeds are not supported.

    Raises ValueError for systems with dependent speeds or coordinates.
    """
    if len(kane.u) != kane.mass_matrix.rows or getattr(kane, "_udep", None):
        raise ValueError("systems with dependent speeds are not supported: use MultibodySystem.constraint")
    system = MultibodySystem(title=title)
    kinematics = kane.kindiffdict()
    system.coordinates, system.speeds = list(kane.q), list(kane.u)
    system.rates = {q.diff(TIME): kinematics[q.diff(TIME)] for q in kane.q}
    return SymbolicEquations(
        system=system, strategy="kane", coordinates=tuple(kane.q), speeds=tuple(kane.u),
        kinematics={q: kinematics[q.diff(TIME)] for q in kane.q}, definitions={},
        mass_matrix=sp.ImmutableMatrix(kane.mass_matrix), rhs=sp.ImmutableMatrix(kane.forcing), held_by_speed={},
        table=ZTable(), cosines=DirectionCosines(), seconds=0.0,
    )  # fmt: skip
