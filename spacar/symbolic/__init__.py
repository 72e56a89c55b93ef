"""Equations of motion in vector and dyad notation (optional extra: `pip install 'spacar[symbolic]'`).

"The paper" in this room is that of A. A. Barhorst, bibliography.md; formulas and tables without a page are its.
"""

from spacar.symbolic import beam_shapes
from spacar.symbolic.collect import ZTable, gather_dots, gather_scalars, gather_vectors
from spacar.symbolic.printing import latex, text, unicode
from spacar.symbolic.reference_frames import ReferenceFrame, dvdt, omega, partial_velocity, set_omega
from spacar.symbolic.system import MultibodySystem
from spacar.symbolic.transform import from_sympy, to_sympy, transform
from spacar.symbolic.unit_vectors import TIME
from spacar.symbolic.vectors import Dyad, Vector, cross, dot, outer

__all__ = [
    "TIME", "Dyad", "MultibodySystem", "ReferenceFrame", "Vector", "ZTable", "beam_shapes", "cross", "dot", "dvdt",
    "from_sympy", "gather_dots", "gather_scalars", "gather_vectors", "latex", "omega", "outer", "partial_velocity",
    "set_omega", "text", "to_sympy", "transform", "unicode",
]  # fmt: skip
