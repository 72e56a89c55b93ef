"""Fluid-conveying spatial tube, keyword TUBE (theory-spatial.md section 10).

Deformations, stiffness and damping are those of the spatial beam; with ORTUBE the ends have frames of their
own and e is counted from its start value. The forces of the fluid on the cubic centre line y of `beam_inertia` are
those of `fluid`.
"""

from functools import cached_property

import numpy as np

from spacar.arrays import Array
from spacar.elements.family import ElementGroup, GeometryError
from spacar.elements.fluid import CarriesFlow, Fluid
from spacar.elements.rotations.local_frames import chord_frames, supplemented, unit
from spacar.elements.spatial.beam import SpatialBeam, SpatialBeamConfiguration, statement_values
from spacar.elements.spatial.beam_inertia import LineConstants


class SpatialTube(CarriesFlow, SpatialBeam):
    """All TUBE elements of a model.

    Raises GeometryError for impossible frames, a mass flow without fluid mass and an unknown end condition.
    """

    definition = "tube"

    def __init__(self, group: ElementGroup) -> None:
        n = self._chords(group)
        direction, f1 = statement_values(group)
        curved = [(k, given) for k, given in enumerate(group.directions) if given is not None]
        for k, given in curved:  # ORTUBE: the tangent at p, the tangent at q and the y' direction at q
            if len(given) != 9:
                raise GeometryError(k, f"ORTUBE needs 9 values, {len(given)} are given")
            n[:, k] = unit(given[:3], k, "tangent at p")
        frame_p = chord_frames(n, direction)
        frame_q = frame_p.copy()
        for k, given in curved:
            tangent = unit(given[3:6], k, "tangent at q")
            frame_q[:, :, k] = supplemented(tangent, given[6:], k, "y' direction at q")
        self._build(group, frame_p, frame_q, f1)
        tube, *fluid = group.em[:, :5].T
        self.fluid = Fluid(*fluid)
        self._set_flow()
        self._set_mass(tube + self.fluid.mass, group.em[:, 5:9])
        self.start: Array | None = None
        if curved:
            kind = group.x0.dtype
            start, V = np.zeros((6, group.n), kind), np.zeros((6, 14, group.n), kind)
            super().strain(group.x0, start, start, V)
            self.start = start

    def parameters(self) -> Array:
        return np.vstack((super().parameters(), self.fluid.parameters(self.length)))

    def _set_flow(self) -> None:
        self.fluid.check(self.keyword)
        vars(self).pop("line", None)

    def strain(self, x: Array, branch: Array, e: Array, V: Array) -> SpatialBeamConfiguration:
        c = super().strain(x, branch, e, V)
        if self.start is not None:
            e -= self.start
        return c

    @cached_property
    def line(self) -> LineConstants:
        line = super().line
        if not self.fluid.flow.any():
            return line
        D, A = self.fluid.matrices(self.length)
        return line._replace(D=D, A=A)
