"""PLTOR: planar hinge. Coordinates phi_p, phi_q; deformation e1 = phi_q - phi_p [rad], whole turns included.

Formulas: theory-planar.md section 4: sigma1 = S1 e1 + Sd1 de1/dt [N m]. No mass.
"""

import numpy as np

from spacar.arrays import Array
from spacar.elements.family import ElementGroup, Family


class PlanarHinge(Family):
    definition = "pltor"
    n_coordinates = 2
    n_deformations = 1
    constant_gradient = True

    def __init__(self, group: ElementGroup) -> None:
        self._take(group)

    def strain(self, x: Array, branch: Array, e: Array, V: Array) -> None:
        np.subtract(x[1], x[0], out=e[0])
        V[0, 0] = -1.0
        V[0, 1] = 1.0
