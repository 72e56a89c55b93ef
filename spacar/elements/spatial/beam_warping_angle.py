"""BEAMW in the angle measure (ADEFORM): theory-beam-order4.md section 2.8.

Stiffness and inertia are those of `beam_warping`, limits those of `beam_angle`; the deformations are in
`warping_angle_strain`, with their derivatives. The gradient of the twist belongs to the twist
rates of the nodes, so there is no unknown inside the element, and a fixed plane of bending keeps order 4.
"""

from typing import Any, ClassVar

import numpy as np

from spacar.arrays import Array
from spacar.elements.family import ElementGroup, Internal
from spacar.elements.spatial import warping_angle_strain as strain_of
from spacar.elements.spatial.beam import SpatialBeam
from spacar.elements.spatial.beam_angle import SpatialAngleBeam
from spacar.elements.spatial.beam_warping import BeamWithWarping


class AngleBeamWithWarping(BeamWithWarping, SpatialAngleBeam):
    """All BEAMW elements of a model in the angle measure. Errors as `BeamWithWarping`."""

    definition = "beamw_angle"
    _of: ClassVar[Any] = strain_of
    shear = SpatialBeam.shear

    def _build(self, group: ElementGroup, frame_p: Array, frame_q: Array, f1: Array) -> None:
        super()._build(group, frame_p, frame_q, f1)
        self.angles = self.angles._replace(ratio=np.zeros((2, self.n)))

    def internal(self, c: Any, sigma: Array) -> Internal | None:
        return None
