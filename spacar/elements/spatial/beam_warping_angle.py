"""BEAMW in the angle measure (ADEFORM): theory-beam-order4.md section 2.8.

Stiffness and inertia are those of `beam_warping`, limits those of `beam_angle`; the deformations are in
`warping_angle_strain`, with their derivatives. The gradient of the twist belongs to the twist
rates of the nodes, so there is no unknown inside the element, and a fixed plane of bending keeps order 4.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from spacar.arrays import Array
from spacar.elements.family import ElementGroup, Internal
from spacar.elements.rotations.rotation import expand
from spacar.elements.spatial import warping_angle_strain as strain_of
from spacar.elements.spatial.angle_measure import AngleConstants
from spacar.elements.spatial.beam import SpatialBeam
from spacar.elements.spatial.beam_angle import AngleConfiguration, SpatialAngleBeam
from spacar.elements.spatial.beam_inertia import LineConstants, line_state
from spacar.elements.spatial.beam_warping import BeamWithWarping


class AngleBeamWithWarping(BeamWithWarping, SpatialAngleBeam):
    """All BEAMW elements of a model in the angle measure. Errors as `BeamWithWarping`."""

    definition = "beamw_angle"
    shear = SpatialBeam.shear

    def _build(self, group: ElementGroup, frame_p: Array, frame_q: Array, f1: Array) -> None:
        super()._build(group, frame_p, frame_q, f1)
        self.angles = self.angles._replace(ratio=np.zeros((2, self.n)))

    def strain(self, x: Array, branch: Array, e: Array, V: Array) -> Any:
        c = strain_of.state(AngleConstants(*expand(self.angles, x.ndim)), x)
        e[...] = strain_of.values(c)
        strain_of.first(c, V)
        line = None
        if self.has_mass:
            line = line_state(LineConstants(*expand(self.line, x.ndim)), x[strain_of.BEAM])
        return AngleConfiguration(c, line)  # type: ignore[arg-type]

    def convective_strain(self, c: Any, v: Array, out: Array) -> None:
        out[...] = strain_of.second_rate(c.strain, v)

    def gradient_rate(self, c: Any, v: Array, out: Array) -> None:
        strain_of.derivative_of_rows(c.strain, v, 1, out)

    def rate_gradient(self, c: Any, v: Array, out: Array) -> None:
        strain_of.derivative_of_rows(c.strain, v, 2, out)

    def geometric_stiffness(self, c: Any, sigma: Array, out: Array) -> None:
        strain_of.hessian(c.strain, sigma, out)

    def internal(self, c: Any, sigma: Array) -> Internal | None:
        return None
