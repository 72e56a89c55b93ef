"""Spatial beam with warping, keyword BEAMW (theory-warping.md): a BEAM whose sections may leave their planes.

Coordinates x_p (3), lambda_p (4), w_p, x_q (3), lambda_q (4), w_q in m, 1 and rad/m; w is the twist rate of the section
at a node. Deformations 1 to 6 as the beam, 7 and 8 warping at p and q, all in m. The twist angle is cubic along the
element (section 4), the warping inertia is lumped to the nodes (section 6).
"""

from typing import Any, ClassVar

import numpy as np

from spacar.arrays import Array
from spacar.elements.family import ElementGroup, Trouble
from spacar.elements.spatial import warping_strain as strain_of
from spacar.elements.spatial.beam import SpatialBeam, SpatialBeamConfiguration
from spacar.elements.spatial.warping_strain import BEAM

ECW = 6  # column of the warping rigidity in ESTIFF and EDAMP
JW = 5  # column of the warping inertia in EM


class BeamWithWarping(SpatialBeam):
    """All BEAMW elements of a model. Raises GeometryError for zero length and impossible direction vectors."""

    definition = "beamw"
    n_coordinates = 16
    n_deformations = 8
    position_rows = (0, 1, 2, 8, 9, 10)
    _position_index = np.array(position_rows)
    _of: ClassVar[Any] = strain_of
    _of_beam: ClassVar[Any] = BEAM

    def __init__(self, group: ElementGroup) -> None:
        super().__init__(group)
        self._warping = 0.5 * self.length * group.em[:, JW]

    @property
    def shear(self) -> Array:
        """Ones: the published element leaves shear out of its second order terms (its cross hinge, table E5)."""
        return np.ones((2, self.n), self._estiff.dtype)

    def parameters(self) -> Array:
        return super().parameters()[:28]

    # -- stresses ------------------------------------------------------------------------------------------
    def stiffness(self) -> tuple[Array, Array]:
        """S [N/m] and S_d [N s/m] of section 4: those of the beam, and for warping GIt and ECw with cubic twist."""
        parts = super().stiffness(), (self._estiff, self._edamp)
        full = []
        for S6, rigidity in zip(*parts, strict=True):
            S = np.zeros((8, 8, self.n), rigidity.dtype)
            S[:6, :6] = S6
            torsion = rigidity[:, 1] / (30.0 * self.length**3)
            warping = rigidity[:, ECW] / self.length**5
            S[6, 6] = S[7, 7] = 4.0 * (warping + torsion)
            S[6, 7] = S[7, 6] = torsion - 2.0 * warping
            full.append(S)
        return full[0], full[1]

    # -- inertia -------------------------------------------------------------------------------------------
    def mass(self, c: SpatialBeamConfiguration, out: Array) -> None:
        M = np.zeros((14, 14, self.n), out.dtype)
        super().mass(c, M)
        out[np.ix_(BEAM, BEAM)] = M

    def inertia_force(self, c: SpatialBeamConfiguration, v: Array, a: Array | None) -> Array:
        force = super().inertia_force(c, v[BEAM], None if a is None else a[BEAM])
        out = np.zeros((16, self.n), force.dtype)
        out[BEAM] = force
        return out

    def inertia_gradient(self, c: SpatialBeamConfiguration, v: Array, a: Array) -> tuple[Array, Array]:
        found = []
        for gradient in super().inertia_gradient(c, v[BEAM], a[BEAM]):
            out = np.zeros((16, 16, self.n), gradient.dtype)
            out[np.ix_(BEAM, BEAM)] = gradient
            found.append(out)
        return found[0], found[1]

    def orientation_inertia(self) -> tuple[tuple[int, Array], ...]:
        return tuple((3 if row == 3 else 11, J) for row, J in super().orientation_inertia())

    def lumped_inertia(self) -> tuple[tuple[int, Array], ...]:
        if not self._warping.any():
            return ()
        return (7, self._warping), (15, self._warping)

    # -- limits --------------------------------------------------------------------------------------------
    def troubles(self, c: SpatialBeamConfiguration, e: Array, sigma: Array) -> list[Trouble]:
        return super().troubles(c._replace(strain=c.strain.beam), e, sigma)
