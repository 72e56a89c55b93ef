"""Screw, keyword SCREW (theory-spatial.md section 7).

Coordinates x_p (3), lambda_p (4), x_q (3), lambda_q (4). With the axis x', the pitch h [m/rad], the hinge
deformations phi, misalignments (section 5) and s = (R_p R0)^T (x_q - x_p) - r:

    e1 = phi [rad],   e2 = s_x - h phi,   e3 = s_y,   e4 = s_z [m],   e5, e6 = misalignments [rad]

phi counts over many turns, so the translation does not jump.
"""

from typing import NamedTuple

import numpy as np

from spacar.arrays import Array
from spacar.elements.family import ElementGroup, Family, GeometryError
from spacar.elements.rotations.local_frames import axis_frame, rows
from spacar.elements.spatial.hinge import HingeState, Turning
from spacar.elements.spatial.pinbody import PinState, Sliding

LAMBDAS = np.array([3, 4, 5, 6, 10, 11, 12, 13])  # coordinates of the rotation; the translation has the first ten
TURNED = np.array([0, 4, 5])  # rows of its deformations


class ScrewState(NamedTuple):
    """Rotation and translation."""

    turn: HingeState
    slide: PinState


class Screw(Family):
    """All SCREW elements of a model. Raises GeometryError for a missing or zero axis."""

    definition = "screw"
    n_coordinates = 14
    frame_p: Array
    n_deformations = 6
    position_rows = (0, 1, 2, 7, 8, 9)

    def __init__(self, group: ElementGroup) -> None:
        self._take(group)
        self.pitch = np.zeros(group.n, group.x0.dtype)
        for k, values in enumerate(group.geometry):
            if len(values) not in (3, 4):
                raise GeometryError(k, f"needs 3 components of its axis and the pitch, {len(values)} are given")
            self.pitch[k] = values[3] if len(values) == 4 else 0.0
        frame = axis_frame(np.array([values[:3] for values in group.geometry]).T, 0, "screw axis")
        self.frame_p = self.frame_q = rows(frame)
        self.r = np.einsum("ian,in->an", frame, group.x0[7:10] - group.x0[:3])
        self.data = np.column_stack((self.pitch, self.r.T))
        self.turn, self.slide = Turning(frame), Sliding(frame, self.r)

    def parameters(self) -> Array:
        return np.vstack((self.frame_p.T, self.r, self.pitch))

    def strain(self, x: Array, branch: Array, e: Array, V: Array) -> ScrewState:
        V_turn, V_slide = _rows(V)
        e_turn = np.empty((3, *e.shape[1:]), e.dtype)
        turn = self.turn.strain(x[LAMBDAS], branch, e_turn, V_turn)
        slide = self.slide.strain(x[:10], branch, e[1:4], V_slide)
        e[TURNED] = e_turn
        e[1] -= self.pitch * e[0]
        self._put(V_turn, V_slide, V)
        return ScrewState(turn, slide)

    def convective_strain(self, c: ScrewState, v: Array, out: Array) -> None:
        turn = np.empty((3, *out.shape[1:]), out.dtype)
        self.turn.convective_strain(c.turn, v[LAMBDAS], turn)
        self.slide.convective_strain(c.slide, v[:10], out[1:4])
        out[TURNED] = turn
        out[1] -= self.pitch * out[0]

    def gradient_rate(self, c: ScrewState, v: Array, out: Array) -> None:
        turn, slide = _rows(out)
        self.turn.gradient_rate(c.turn, v[LAMBDAS], turn)
        self.slide.gradient_rate(c.slide, v[:10], slide)
        self._put(turn, slide, out)

    def rate_gradient(self, c: ScrewState, v: Array, out: Array) -> None:
        turn, slide = _rows(out)
        self.turn.rate_gradient(c.turn, v[LAMBDAS], turn)
        self.slide.rate_gradient(c.slide, v[:10], slide)
        self._put(turn, slide, out)

    def geometric_stiffness(self, c: ScrewState, sigma: Array, out: Array) -> None:
        H = np.empty((8, 8, *out.shape[2:]), out.dtype)
        moments = np.stack((sigma[0] - self.pitch * sigma[1], sigma[4], sigma[5]))
        self.turn.geometric_stiffness(c.turn, moments, H)
        self.slide.geometric_stiffness(c.slide, sigma[1:4], out[:10, :10])
        turned = out[3:7, 3:7].copy()
        out[np.ix_(LAMBDAS, LAMBDAS)] = H
        out[3:7, 3:7] += turned

    def _put(self, turn: Array, slide: Array, out: Array) -> None:
        """Write rows of the rotation (3, 8, n) and of the translation (3, 10, n)."""
        out[1:4, :10], out[1, 10:] = slide, 0.0
        out[np.ix_(TURNED, LAMBDAS)] = turn
        out[1, LAMBDAS] -= self.pitch * turn[0]


def _rows(out: Array) -> tuple[Array, Array]:
    """Room for the rows of the rotation (3, 8, n) and of the translation (3, 10, n) in rows (6, 14, n)."""
    return np.empty((3, 8, *out.shape[2:]), out.dtype), np.empty((3, 10, *out.shape[2:]), out.dtype)
