"""Screw, keyword SCREW (theory-spatial.md section 7).

Coordinates x_p (3), lambda_p (4), x_q (3), lambda_q (4). With the axis x', the pitch h [m/rad], the hinge
deformations phi, misalignments (section 5) and s = (R_p R0)^T (x_q - x_p) - r:

    e1 = phi [rad],   e2 = s_x - h phi,   e3 = s_y,   e4 = s_z [m],   e5, e6 = misalignments [rad]

phi counts over many turns, so the translation does not jump.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from spacar.arrays import Array
from spacar.elements.family import ElementGroup, Family, GeometryError
from spacar.elements.rotations.local_frames import axis_frame, rows
from spacar.elements.rotations.rotation import relative_parameters
from spacar.elements.spatial import hinge as turning
from spacar.elements.spatial import pinbody as sliding


class ScrewState(NamedTuple):
    """Rotation, translation and pitch (n,)."""

    hinge: turning.HingeState
    pin: sliding.PinState
    h: Array


class Screw(Family):
    """All SCREW elements of a model. Raises GeometryError for a missing or zero axis."""

    definition = "screw"
    n_coordinates = 14
    frame_p: Array
    n_deformations = 6
    position_rows = (0, 1, 2, 7, 8, 9)

    def __init__(self, group: ElementGroup) -> None:
        self.keyword, self.numbers = group.keyword, group.numbers
        self.length = np.zeros(group.n)
        self.pitch = np.zeros(group.n, group.x0.dtype)
        for k, values in enumerate(group.geometry):
            if len(values) not in (3, 4):
                raise GeometryError(
                    k, f"needs 3 components of its axis and the pitch, {len(values)} are given"
                )
            self.pitch[k] = values[3] if len(values) == 4 else 0.0
        frame = axis_frame(np.array([values[:3] for values in group.geometry]).T, 0, "screw axis")
        self.frame_p = self.frame_q = rows(frame)
        self.r = np.einsum("ian,in->an", frame, group.x0[7:10] - group.x0[:3])
        self.data = np.column_stack((self.pitch, self.r.T))
        self.constants = relative_parameters(frame, frame), sliding.directors(frame), self.r, self.pitch
        self._coefficients = group.estiff[:, :6], group.edamp[:, :6]

    def parameters(self) -> Array:
        return np.vstack((self.frame_p.T, self.r, self.pitch))

    def strain(self, x: Array, branch: Array, e: Array, V: Array) -> ScrewState:
        F, K, r, h = self.constants
        x7 = x.reshape(2, 7, *x.shape[1:])
        hinge = turning.hinge_state(F, x7[:, 3:])
        pin = sliding.pin_state(K, x7[0, 3:], x7[1, :3] - x7[0, :3])
        c = ScrewState(hinge, pin, h)
        e[[0, 4, 5]] = turning.hinge_deformations(hinge, branch[0])
        e[1:4] = sliding.pin_values(pin) - r
        e[1] -= h * e[0]
        _put(c, turning.hinge_gradient(hinge), sliding.pin_gradient(pin), V)
        return c

    def convective_strain(self, c: ScrewState, v: Array, out: Array) -> None:
        lam, d = _rates(v)
        out[[0, 4, 5]] = turning.hinge_convective(c.hinge, lam)
        out[1:4] = sliding.pin_convective(c.pin, lam[0], d)
        out[1] -= c.h * out[0]

    def gradient_rate(self, c: ScrewState, v: Array, out: Array) -> None:
        lam, d = _rates(v)
        _put(c, turning.hinge_rate_rows(c.hinge, lam), sliding.pin_rate_rows(c.pin, lam[0], d), out)

    def rate_gradient(self, c: ScrewState, v: Array, out: Array) -> None:
        lam, d = _rates(v)
        turn = turning.hinge_second_rate_rows(c.hinge, lam)
        _put(c, turn, sliding.pin_second_rate_rows(c.pin, lam[0], d), out)

    def geometric_stiffness(self, c: ScrewState, sigma: Array, out: Array) -> None:
        H = out.reshape(2, 7, 2, 7, *sigma.shape[1:])
        moments = np.stack((sigma[0] - c.h * sigma[1], sigma[4], sigma[5]))
        H[:, 3:, :, 3:] = turning.hinge_hessian(c.hinge, moments)
        mixed, turned = sliding.pin_hessian(c.pin, sigma[1:4])
        H[0, 3:, 0, 3:] += turned
        H[1, :3, 0, 3:] = mixed
        H[0, :3, 0, 3:] = -mixed
        H[0, 3:, 1, :3] = mixed.swapaxes(0, 1)
        H[0, 3:, 0, :3] = -mixed.swapaxes(0, 1)

    def stiffness(self) -> tuple[Array, Array]:
        """Coefficients S1..S6 and Sd1..Sd6 as given: N m/rad for modes 1, 5, 6, N/m for 2, 3, 4."""
        S, S_d = (turning.diagonal(k) for k in self._coefficients)
        return S, S_d


def _rates(v: Array) -> tuple[Array, Array]:
    """Rates of lambda (2, 4, n) and of x_q - x_p (3, n)."""
    v7 = v.reshape(2, 7, *v.shape[1:])
    return v7[:, 3:], v7[1, :3] - v7[0, :3]


def _put(c: ScrewState, turn: Array, slide: sliding.Projections, out: Array) -> None:
    view = out.reshape(6, 2, 7, *out.shape[2:])
    view[[0, 4, 5], :, 3:] = turn
    view[1:4, 1, :3] = slide.d
    np.negative(slide.d, out=view[1:4, 0, :3])
    view[1:4, 0, 3:] = slide.lam
    view[1, 0, 3:] -= c.h * turn[0, 0]
    view[1, 1, 3:] = -c.h * turn[0, 1]
