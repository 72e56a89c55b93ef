"""Spatial pinbody and rigid beam, keywords PINBODY and RBEAM (theory-spatial.md section 6).

Coordinates x_p (3), lambda_p (4), x_q (3). e_i = (R(lam_p) c_i).(x_q - x_p) - r_i [m], c_i the measuring
directions, r_i their projections at the start or the DRPINBOD values. Inertia of an RBEAM: straight uniform
rod on x_p, x_q, the rotary inertia of its section on lambda_p. Without direction the c_i of a PINBODY are the
global axes, those of an RBEAM the default axes of a BEAM: x' from p to q (input-language.md section 4.1).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from spacar.arrays import Array
from spacar.elements.family import ElementGroup, Family, GeometryError
from spacar.elements.planar.pltruss import rod_mass
from spacar.elements.rotations.local_frames import chord_frames, chords, rows, section_tensor, supplemented, unit
from spacar.elements.rotations.rotation import director_tensor
from spacar.elements.spatial.hinge import diagonal

_einsum = np.einsum
DEPENDENT = 1e-8  # smallest determinant of three unit directions: sqrt(eps), where the position loses half its digits
POSITIONS = [0, 1, 2, 7, 8, 9]


class PinState(NamedTuple):
    """Projections of d = x_q - x_p on body-fixed directions."""

    K: Array  # (3, 3, 4, 4, n) director tensors of the c_i
    lam: Array  # (4, n)
    d: Array  # (3, n)
    B: Array  # (3, 3, 4, n) dU/dlam
    U: Array  # (3, 3, n) R c_i


class Projections(NamedTuple):
    """Rows of the derivatives of the projections: with respect to x_q (minus: x_p) and lambda."""

    d: Array  # (m, 3, n)
    lam: Array  # (m, 4, n)


def pin_state(K: Array, lam: Array, d: Array) -> PinState:
    """State for lam (4, n), d (3, n)."""
    B = _einsum("aijk...,k...->aij...", K, lam)
    return PinState(K, lam, d, B, _einsum("aij...,j...->ai...", B, 0.5 * lam))


def pin_values(c: PinState) -> Array:
    """(R c_i).d (m, n)."""
    return np.asarray(_einsum("ai...,i...->a...", c.U, c.d))


def pin_gradient(c: PinState) -> Projections:
    return Projections(c.U, _einsum("aij...,i...->aj...", c.B, c.d))


def pin_convective(c: PinState, lam1: Array, d1: Array) -> Array:
    """Second rate at zero accelerations (m, n) for rates lam1 (4, n), d1 (3, n)."""
    B1 = _einsum("aijk...,k...->aij...", c.K, lam1)
    U1 = _einsum("aij...,j...->ai...", c.B, lam1)
    U2 = _einsum("aij...,j...->ai...", B1, lam1)
    return np.asarray(_einsum("ai...,i...->a...", U1, 2.0 * d1) + _einsum("ai...,i...->a...", U2, c.d))


def pin_rate_rows(c: PinState, lam1: Array, d1: Array) -> Projections:
    """[v, .]."""
    B1 = _einsum("aijk...,k...->aij...", c.K, lam1)
    U1 = _einsum("aij...,j...->ai...", c.B, lam1)
    return Projections(U1, _einsum("aij...,i...->aj...", c.B, d1) + _einsum("aij...,i...->aj...", B1, c.d))


def pin_second_rate_rows(c: PinState, lam1: Array, d1: Array) -> Projections:
    """Third derivative [v, v, .]."""
    B1 = _einsum("aijk...,k...->aij...", c.K, lam1)
    return Projections(_einsum("aij...,j...->ai...", B1, lam1), _einsum("aij...,i...->aj...", B1, 2.0 * d1))


def pin_hessian(c: PinState, sigma: Array) -> tuple[Array, Array]:
    """Blocks of sum sigma_a d2(e_a): d-lambda (3, 4, n) and lambda-lambda (4, 4, n)."""
    mixed = _einsum("a...,aij...->ij...", sigma, c.B)
    K = _einsum("a...,aijk...->ijk...", sigma, c.K)
    return mixed, _einsum("i...,ijk...->jk...", c.d, K)


def directors(frame: Array) -> Array:
    """Director tensors (3, 3, 4, 4, n) of the columns of frames (3, 3, n)."""
    return np.stack([director_tensor(frame[:, i]) for i in range(3)])


class SpatialPinbody(Family):
    """All PINBODY or all RBEAM elements of a model.

    Raises GeometryError for dependent directions, a direction along the line pq, and an RBEAM of zero length.
    """

    definition = "pinbody"
    n_coordinates = 10
    frame_p: Array
    n_deformations = 3
    position_rows = (0, 1, 2, 7, 8, 9)
    # M acts on the positions only and is constant
    constant_mass = True

    def __init__(self, group: ElementGroup) -> None:
        self.keyword, self.numbers = group.keyword, group.numbers
        d = group.x0[7:] - group.x0[:3]
        if group.keyword == "RBEAM":  # a rod; a PINBODY may join two nodes at one place
            chords(d, group.x0[POSITIONS])
        self.length = np.sqrt((d * d).sum(0))
        frame = _frames(group, d)
        self.frame_p = self.frame_q = rows(frame)
        self.r = np.einsum("ian,in->an", frame, d)
        for k, given in enumerate(group.projections):
            if given is not None:
                if len(given) != 3:
                    raise GeometryError(
                        k, f"DRPINBOD needs 3 projections of a spatial element, {len(given)} are given"
                    )
                self.r[:, k] = given
        self.data = self.r.T.copy()
        self.directors = directors(frame)
        self._coefficients = group.estiff[:, :3], group.edamp[:, :3]
        self.has_mass = bool(np.any(group.em[:, 0] != 0.0))
        self._mass = rod_mass(group.em[:, 0] * self.length, 3)
        self._inertia = _rod_inertia(group, d) if group.em[:, 1:5].any() else None

    def parameters(self) -> Array:
        return np.vstack((self.frame_p.T, self.r))

    def strain(self, x: Array, branch: Array, e: Array, V: Array) -> PinState:
        c = pin_state(self.directors, x[3:7], x[7:] - x[:3])
        np.subtract(pin_values(c), self.r, out=e)
        _put(pin_gradient(c), V)
        return c

    def convective_strain(self, c: PinState, v: Array, out: Array) -> None:
        out[...] = pin_convective(c, v[3:7], v[7:] - v[:3])

    def gradient_rate(self, c: PinState, v: Array, out: Array) -> None:
        _put(pin_rate_rows(c, v[3:7], v[7:] - v[:3]), out)

    def rate_gradient(self, c: PinState, v: Array, out: Array) -> None:
        _put(pin_second_rate_rows(c, v[3:7], v[7:] - v[:3]), out)

    def geometric_stiffness(self, c: PinState, sigma: Array, out: Array) -> None:
        mixed, out[3:7, 3:7] = pin_hessian(c, sigma)
        out[7:, 3:7] = mixed
        out[:3, 3:7] = -mixed
        out[3:7, 7:] = mixed.swapaxes(0, 1)
        out[3:7, :3] = -mixed.swapaxes(0, 1)

    def stiffness(self) -> tuple[Array, Array]:
        """S1..S3 [N/m] and Sd1..Sd3 [N s/m]."""
        S, S_d = (diagonal(k) for k in self._coefficients)
        return S, S_d

    def mass(self, c: PinState, out: Array) -> None:
        out[np.ix_(POSITIONS, POSITIONS)] = self._mass

    def inertia_force(self, c: PinState, v: Array, a: Array | None) -> Array:
        f = np.zeros_like(v)
        if a is not None:
            f[POSITIONS] = np.einsum("ijn,jn->in", self._mass, a[POSITIONS])
        return f

    def orientation_inertia(self) -> tuple[tuple[int, Array], ...]:
        return () if self._inertia is None else ((3, self._inertia),)


def _put(row: Projections, out: Array) -> None:
    out[:, 7:] = row.d
    np.negative(row.d, out=out[:, :3])
    out[:, 3:7] = row.lam


def _frames(group: ElementGroup, d: Array) -> Array:
    """Measuring directions (3, 3, n), columns, of elements with the lines d (3, n) from p to q."""
    frames = np.zeros((3, 3, group.n), d.dtype)
    along = []  # elements whose x' is that of the line
    for k, (given, direction) in enumerate(zip(group.directions, group.geometry, strict=True)):
        if given is not None:
            frames[:, :, k] = _given_frame(given, k)
        elif direction and len(direction) != 3:
            raise GeometryError(
                k, f"the direction of the local y' axis needs 3 components, {len(direction)} are given"
            )
        elif direction or group.keyword != "PINBODY":
            along.append(k)
        else:
            frames[[0, 1, 2], [0, 1, 2], k] = 1.0
    if along:
        try:
            ex = unit(d[:, along], 0, "line from p to q, which is the local x' axis,")
            frames[:, :, along] = chord_frames(ex, [group.geometry[k] for k in along])
        except GeometryError as error:
            raise GeometryError(along[error.index], str(error)) from None
    return frames


def _given_frame(given: tuple[float, ...], k: int) -> Array:
    """ORPINBOD: six values are made orthonormal, nine are taken as they are but must be independent."""
    if len(given) == 6:
        ex = unit(given[:3], k, "first ORPINBOD direction")
        return supplemented(ex, np.asarray(given[3:]), k, "second ORPINBOD direction")
    if len(given) != 9:
        raise GeometryError(k, f"ORPINBOD needs 6 or 9 values for a spatial element, {len(given)} are given")
    names = ("first", "second", "third")
    units = [unit(given[3 * i : 3 * i + 3], k, f"{names[i]} ORPINBOD direction") for i in range(3)]
    volume = abs(np.linalg.det(np.column_stack(units)))
    if volume < DEPENDENT:
        raise GeometryError(
            k, f"the three ORPINBOD directions are linearly dependent (unit volume {volume:.1e})"
        )
    return np.array(given).reshape(3, 3).T


def _rod_inertia(group: ElementGroup, d: Array) -> Array:
    """Rotary inertia (n, 3, 3) of rods: section values refer to the line pq and the y' of the statement."""
    length, n = chords(d, group.x0[POSITIONS])
    frame = chord_frames(n, group.geometry)
    return section_tensor(frame, group.em[:, 1:5], length)
