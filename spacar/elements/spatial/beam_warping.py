"""Spatial beam with warping, keyword BEAMW (theory-warping.md): a BEAM whose sections may leave their planes.

Coordinates x_p (3), lambda_p (4), w_p, x_q (3), lambda_q (4), w_q in m, 1 and rad/m; w is the twist rate of the section
at a node. Deformations 1 to 6 as the beam, 7 and 8 warping at p and q, all in m. The twist angle is cubic along the
element (section 4), the warping inertia is lumped to the nodes (section 6).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from spacar.arrays import Array
from spacar.elements.family import ElementGroup, Trouble
from spacar.elements.rotations.rotation import expand
from spacar.elements.spatial import warping_strain as strain_of
from spacar.elements.spatial.beam import SpatialBeam, SpatialBeamConfiguration
from spacar.elements.spatial.beam_inertia import LineConstants, LineState, line_state
from spacar.elements.spatial.beam_strain import BeamConstants, put

_BEAM = np.array([0, 1, 2, 3, 4, 5, 6, 8, 9, 10, 11, 12, 13, 14])  # coordinates that a BEAM has too
ECW = 6  # column of the warping rigidity in ESTIFF and EDAMP
JW = 5  # column of the warping inertia in EM


class WarpingConfiguration(NamedTuple):
    """Deformation state and, if the group has mass, the inertia state of its centre lines."""

    strain: strain_of.WarpingState
    line: LineState | None


class BeamWithWarping(SpatialBeam):
    """All BEAMW elements of a model. Raises GeometryError for zero length and impossible direction vectors."""

    definition = "beamw"
    n_coordinates = 16
    n_deformations = 8
    position_rows = (0, 1, 2, 8, 9, 10)
    _position_index = np.array(position_rows)
    _correction_coefficients = staticmethod(strain_of.correction_coefficients)

    def __init__(self, group: ElementGroup) -> None:
        super().__init__(group)
        self._warping = 0.5 * self.length * group.em[:, JW]

    @property
    def shear(self) -> Array:
        """Ones: the published element leaves shear out of its second order terms (its cross hinge, table E5)."""
        return np.ones((2, self.n), self._estiff.dtype)

    def parameters(self) -> Array:
        return super().parameters()[:28]

    # -- deformations --------------------------------------------------------------------------------------
    def strain(self, x: Array, branch: Array, e: Array, V: Array) -> WarpingConfiguration:  # type: ignore[override]
        c = strain_of.warping_state(BeamConstants(*expand(self.constants, x.ndim)), x, self._second)
        W = c.W
        if c.Q is None:
            e[...] = c.raw
        else:
            e[...] = c.raw + 0.5 * _product(c.Q, c.raw)
            W = W + _rows(c.Q, W)
        put(W, V)
        line = line_state(LineConstants(*expand(self.line, x.ndim)), x[_BEAM]) if self.has_mass else None
        return WarpingConfiguration(c, line)

    def convective_strain(self, c: WarpingConfiguration, v: Array, out: Array) -> None:  # type: ignore[override]
        state = c.strain
        r = strain_of.warping_rates(state, v)
        out[...] = r.raw2
        if state.Q is not None:
            out += _product(state.Q, r.raw2) + _product(strain_of.correction(state.beam.p, r.raw1), r.raw1)

    def gradient_rate(self, c: WarpingConfiguration, v: Array, out: Array) -> None:  # type: ignore[override]
        state = c.strain
        r = strain_of.warping_rates(state, v)
        W = strain_of.rate_rows(state, r)
        if state.Q is not None:
            W = W + _rows(state.Q, W) + _rows(strain_of.correction(state.beam.p, r.raw1), state.W)
        put(W, out)

    def rate_gradient(self, c: WarpingConfiguration, v: Array, out: Array) -> None:  # type: ignore[override]
        state = c.strain
        r = strain_of.warping_rates(state, v)
        W = strain_of.second_rate_rows(state, r)
        if state.Q is not None:
            p = state.beam.p
            W = (
                W
                + _rows(state.Q, W)
                + _rows(strain_of.correction(p, r.raw2), state.W)
                + 2.0 * _rows(strain_of.correction(p, r.raw1), strain_of.rate_rows(state, r))
            )
        put(W, out)

    def geometric_stiffness(self, c: WarpingConfiguration, sigma: Array, out: Array) -> None:  # type: ignore[override]
        strain_of.hessian(c.strain, sigma, out)

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
    def mass(self, c: WarpingConfiguration, out: Array) -> None:  # type: ignore[override]
        M = np.zeros((14, 14, *out.shape[2:]), out.dtype)
        super().mass(_of_beam(c), M)
        out[np.ix_(_BEAM, _BEAM)] = M

    def inertia_force(self, c: WarpingConfiguration, v: Array, a: Array | None) -> Array:  # type: ignore[override]
        force = super().inertia_force(_of_beam(c), v[_BEAM], None if a is None else a[_BEAM])
        out = np.zeros((16, *force.shape[1:]), force.dtype)
        out[_BEAM] = force
        return out

    def inertia_gradient(self, c: WarpingConfiguration, v: Array, a: Array) -> tuple[Array, Array]:  # type: ignore[override]
        found = []
        for gradient in super().inertia_gradient(_of_beam(c), v[_BEAM], a[_BEAM]):
            out = np.zeros((16, 16, *gradient.shape[2:]), gradient.dtype)
            out[np.ix_(_BEAM, _BEAM)] = gradient
            found.append(out)
        return found[0], found[1]

    def orientation_inertia(self) -> tuple[tuple[int, Array], ...]:
        return tuple((3 if row == 3 else 11, J) for row, J in super().orientation_inertia())

    def lumped_inertia(self) -> tuple[tuple[int, Array], ...]:
        if not self._warping.any():
            return ()
        return (7, self._warping), (15, self._warping)

    # -- limits --------------------------------------------------------------------------------------------
    def troubles(self, c: WarpingConfiguration, e: Array, sigma: Array) -> list[Trouble]:  # type: ignore[override]
        return super().troubles(_of_beam(c), e, sigma)


def _of_beam(c: WarpingConfiguration) -> SpatialBeamConfiguration:
    return SpatialBeamConfiguration(c.strain.beam, c.line)


def _product(Q: Array, e: Array) -> Array:
    return np.asarray(np.einsum("kj...,j...->k...", Q, e))


def _rows(Q: Array, W: Array) -> Array:
    return np.asarray(np.einsum("kj...,jsi...->ksi...", Q, W))
