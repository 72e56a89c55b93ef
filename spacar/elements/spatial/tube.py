"""Fluid-conveying spatial tube, keyword TUBE (theory-spatial.md section 10).

Deformations, stiffness and damping are those of the spatial beam; with ORTUBE the ends have frames of their
own and e is counted from its start value. The forces of the fluid on the cubic centre line y of `beam_inertia` are
those of `fluid`.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from spacar.arrays import Array
from spacar.elements.family import ElementGroup, GeometryError
from spacar.elements.fluid import CarriesFlow, Fluid
from spacar.elements.rotations.local_frames import chord_frame, stack, supplemented, unit
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
        frames = [_frames(group.directions[k], n[:, k], direction[k], k) for k in range(group.n)]
        frame_p, frame_q = stack([p for p, _ in frames]), stack([q for _, q in frames])
        self._build(group, frame_p, frame_q, f1)
        tube, *fluid = group.em[:, :5].T
        self.fluid = Fluid(*fluid)
        self._set_flow()
        self._set_mass(tube + self.fluid.mass, group.em[:, 5:9])
        self.start: Array | None = None
        if any(given is not None for given in group.directions):
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


def _frames(
    given: tuple[float, ...] | None, chord: Array, direction: tuple[float, ...] | None, k: int
) -> tuple[Array, Array]:
    """Frames (3, 3) at p and q: ORTUBE gives the tangent at p, the tangent at q and the y' direction at q."""
    if given is None:
        frame = chord_frame(chord, direction, k)
        return frame, frame
    if len(given) != 9:
        raise GeometryError(k, f"ORTUBE needs 9 values, {len(given)} are given")
    at_p = chord_frame(unit(given[:3], k, "tangent at p"), direction, k)
    at_q = supplemented(unit(given[3:6], k, "tangent at q"), np.asarray(given[6:]), k, "y' direction at q")
    return at_p, at_q
