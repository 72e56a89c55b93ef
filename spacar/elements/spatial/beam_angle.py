"""BEAM and TUBE in the angle measure (ADEFORM): theory-beam-order4.md section 2.

Stiffness, inertia and fluid are those of `beam` and `tube`; the deformations are in `angle_measure`, their
derivatives in `beam_angle_strain`. The twist gradient is an unknown of the element that is eliminated: it needs torsion
and bending with finite stiffness. Where one of the modes 2 to 6 is fixed or prescribed, or GIt = 0, it is zero.

A tube that is curved at the start is counted from its start values, with the length of its arc (section 2.5)
l0 = chord/(1 - (psi_y^2 + psi_z^2)/24 - (A_y^2 + A_z^2)/40) in the place of the chord.
"""

from typing import Any, ClassVar

import numpy as np

from spacar.arrays import Array
from spacar.elements.family import ElementGroup, Internal, Trouble
from spacar.elements.planar.chord import short_troubles
from spacar.elements.spatial import beam_angle_strain as strain_of
from spacar.elements.spatial.angle_measure import AngleConstants, outer
from spacar.elements.spatial.beam import SpatialBeam, SpatialBeamConfiguration
from spacar.elements.spatial.tube import SpatialTube

LARGE_ANGLE = np.pi / 2  # of the ends to each other; beyond it the error of one element exceeds a few per cent
LARGE_CHORD = np.pi / 4  # of the chord to the orientation half way
LIMIT_ANGLE, LIMIT_CHORD = np.radians(350.0), np.radians(85.0)  # G is infinite at 360, the chord angle jumps at 180


class SpatialAngleBeam(SpatialBeam):
    """All BEAM elements of a model in the angle measure. Errors as `SpatialBeam`."""

    measure = "angle"
    _of: ClassVar[Any] = strain_of
    definition = "beam_angle"

    def _build(self, group: ElementGroup, frame_p: Array, frame_q: Array, f1: Array) -> None:
        super()._build(group, frame_p, frame_q, f1)
        GIt, EIy, EIz = group.estiff[:, 1:4].T
        elastic = np.ones(self.n, bool) if group.elastic is None else group.elastic[1:].all(0)
        gradient = elastic & group.nonlinear & (GIt > 0.0)
        twisted = group.nonlinear & (GIt > 0.0) & (group.elastic is None or group.elastic[1])
        self._twisting = np.where(twisted, 3.0 * GIt / self.length, np.inf)
        torsion = np.where(gradient, GIt, 1.0)
        self.angles = AngleConstants(
            C=strain_of.orientations(frame_p, frame_q),
            l0=self.length,
            second=group.nonlinear.astype(float),
            f=f1,
            shear=self.shear,
            ratio=np.stack((EIy, EIz)) * gradient / torsion,
            start=np.zeros((2, self.n)),
        )

    def parameters(self) -> Array:
        return np.vstack((super().parameters(), self.angles.ratio, self.angles.start))

    def strain(self, x: Array, branch: Array, e: Array, V: Array) -> Any:
        c = self._of.state(self.angles, x)
        e[...] = self._of.values(c)
        self._of.first(c, V)
        return SpatialBeamConfiguration(c, self._line_state(x))

    def convective_strain(self, c: Any, v: Array, out: Array) -> None:
        out[...] = self._of.second_rate(c.strain, v)

    def gradient_rate(self, c: Any, v: Array, out: Array) -> None:
        self._of.derivative_of_rows(c.strain, v, 1, out)

    def rate_gradient(self, c: Any, v: Array, out: Array) -> None:
        self._of.derivative_of_rows(c.strain, v, 2, out)

    def internal(self, c: Any, sigma: Array) -> Internal | None:
        """The twist gradient A_x (section 2.6): stiffness 3 GIt/l0, coupling

        l0 [(s5 + s6) dpsi_y - (s3 + s4) dpsi_z]/4.
        """
        _, psi_y, psi_z = strain_of.rotation_rows(c.strain)
        coupling = 0.25 * self.length * ((sigma[4] + sigma[5]) * psi_y - (sigma[2] + sigma[3]) * psi_z)
        return Internal(coupling, self._twisting, np.asarray(self.angles.ratio.any(0)))

    def troubles(self, c: Any, e: Array, sigma: Array) -> list[Trouble]:
        """Collapsed length; too large rotations of the ends to each other, and of the chord."""
        y = c.strain.inner.y
        found = short_troubles(y[7], self.length)
        turned = 2.0 * np.arctan2(np.sqrt((y[1:4] ** 2).sum(0)), y[0])
        chord = np.arctan2(np.hypot(y[5], y[6]), y[4])
        for what, value, large, limit in (
            ("its ends are rotated to each other", turned, LARGE_ANGLE, LIMIT_ANGLE),
            ("the line between its nodes is rotated to its middle", chord, LARGE_CHORD, LIMIT_CHORD),
        ):
            for k in np.flatnonzero(~(value <= large)):
                fatal = not value[k] <= limit
                bound = np.degrees(limit if fatal else large)
                text = f"{what} by {np.degrees(value[k]):.0f} degrees (limit {bound:.0f}); use more elements"
                found.append(Trouble(int(k), text, fatal))
        return found


class SpatialAngleTube(SpatialTube, SpatialAngleBeam):
    """All TUBE elements of a model in the angle measure. Errors as `SpatialTube`."""

    definition = "tube_angle"

    def _build(self, group: ElementGroup, frame_p: Array, frame_q: Array, f1: Array) -> None:
        C = strain_of.orientations(frame_p, frame_q)
        self.length = self.length / strain_of.chord_of_arc(C, group.x0)
        super()._build(group, frame_p, frame_q, f1)
        c = strain_of.state(self.angles, group.x0)
        o = outer(self.angles, c.inner.y, c.G[0])
        self.angles = self.angles._replace(start=np.stack((o.By, o.Bz)))
