"""Spatial truss, keyword TRUSS: the bar of `planar.pltruss` in space (theory-spatial.md sections 3.3 and 4)."""

from spacar.elements.family import ElementGroup
from spacar.elements.planar.pltruss import PlanarTruss
from spacar.elements.rotations.local_frames import chords


class SpatialTruss(PlanarTruss):
    """All TRUSS elements of a model. Raises GeometryError for zero length."""

    definition = "truss"
    n_coordinates = 6
    position_rows = (0, 1, 2, 3, 4, 5)  # type: ignore[assignment]

    def _chords(self, group: ElementGroup) -> None:
        self.length, _ = chords(group.x0[3:] - group.x0[:3], group.x0)
