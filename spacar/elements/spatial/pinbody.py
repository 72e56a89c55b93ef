"""Spatial pinbody and rigid beam, keywords PINBODY and RBEAM (theory-spatial.md section 6).

Coordinates x_p (3), lambda_p (4), x_q (3). e_i = (R(lam_p) c_i).(x_q - x_p) - r_i [m], c_i the measuring
directions, r_i their projections at the start or the DRPINBOD values. Inertia of an RBEAM: straight uniform
rod on x_p, x_q, the rotary inertia of its section on lambda_p. Without direction the c_i of a PINBODY are the
global axes, those of an RBEAM the default axes of a BEAM: x' from p to q (input-language.md section 4.1).
"""

from typing import NamedTuple

import numpy as np

from spacar.arrays import Array
from spacar.elements.family import ElementGroup, Family, GeometryError
from spacar.elements.planar.pltruss import rod_mass
from spacar.elements.rotations.local_frames import chord_frames, chords, rows, section_tensor, supplemented, unit
from spacar.elements.rotations.rotation import director_tensor

_einsum = np.einsum
DEPENDENT = 1e-8  # smallest determinant of three unit directions: sqrt(eps), where the position loses half its digits
POSITIONS = [0, 1, 2, 7, 8, 9]


class PinState(NamedTuple):
    """Projections of d = x_q - x_p on body-fixed directions."""

    K: Array  # (3, 3, 4, 4, n) director tensors of the c_i
    d: Array  # (3, n)
    B: Array  # (3, 3, 4, n) d(R c_i)/dlam


class Sliding:
    """e_i of the directions of frames (3, 3, n) with projections r (3, n), and derivatives, as `Family` has them."""

    def __init__(self, frame: Array, r: Array) -> None:
        self.r, self.directors = r, np.stack([director_tensor(frame[:, i]) for i in range(3)])

    def strain(self, x: Array, branch: Array, e: Array, V: Array) -> PinState:
        lam, d = parts_of(x)
        B = _einsum("aijk...,k...->aij...", self.directors, lam)
        U = _einsum("aij...,j...->ai...", B, 0.5 * lam)
        np.subtract(_einsum("ai...,i...->a...", U, d), self.r, out=e)
        _put(V, U, _einsum("aij...,i...->aj...", B, d))
        return PinState(self.directors, d, B)

    def convective_strain(self, c: PinState, v: Array, out: Array) -> None:
        lam1, d1 = parts_of(v)
        B1 = _einsum("aijk...,k...->aij...", c.K, lam1)
        U1, U2 = (_einsum("aij...,j...->ai...", of, lam1) for of in (c.B, B1))
        out[...] = _einsum("ai...,i...->a...", U1, 2.0 * d1) + _einsum("ai...,i...->a...", U2, c.d)

    def gradient_rate(self, c: PinState, v: Array, out: Array) -> None:
        lam1, d1 = parts_of(v)
        B1 = _einsum("aijk...,k...->aij...", c.K, lam1)
        by_lam = _einsum("aij...,i...->aj...", c.B, d1) + _einsum("aij...,i...->aj...", B1, c.d)
        _put(out, _einsum("aij...,j...->ai...", c.B, lam1), by_lam)

    def rate_gradient(self, c: PinState, v: Array, out: Array) -> None:
        lam1, d1 = parts_of(v)
        B1 = _einsum("aijk...,k...->aij...", c.K, lam1)
        _put(out, _einsum("aij...,j...->ai...", B1, lam1), _einsum("aij...,i...->aj...", B1, 2.0 * d1))

    def geometric_stiffness(self, c: PinState, sigma: Array, out: Array) -> None:
        mixed = _einsum("a...,aij...->ij...", sigma, c.B)
        K = _einsum("a...,aijk...->ijk...", sigma, c.K)
        out[3:7, 3:7] = _einsum("i...,ijk...->jk...", c.d, K)
        put_mixed(mixed, out)


def put_mixed(mixed: Array, out: Array) -> None:
    """Write the block (3, 4, n) of a symmetric matrix by x_q (minus: x_p) and lambda, and its transpose."""
    out[7:, 3:7] = mixed
    out[:3, 3:7] = -mixed
    out[3:7, 7:] = mixed.swapaxes(0, 1)
    out[3:7, :3] = -mixed.swapaxes(0, 1)


def parts_of(x: Array) -> tuple[Array, Array]:
    """lambda_p (4, n) and x_q - x_p (3, n)."""
    return x[3:7], x[7:] - x[:3]


def _put(out: Array, by_d: Array, by_lam: Array) -> None:
    """Write rows from their parts by x_q (minus: x_p) and by lambda."""
    out[:, 7:] = by_d
    np.negative(by_d, out=out[:, :3])
    out[:, 3:7] = by_lam


class SpatialPinbody(Sliding, Family):
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
        self._take(group)
        d = group.x0[7:] - group.x0[:3]
        if group.keyword == "RBEAM":  # a rod; a PINBODY may join two nodes at one place
            chords(d, group.x0[POSITIONS])
        self.length = np.sqrt((d * d).sum(0))
        frame = _frames(group, d)
        self.frame_p = self.frame_q = rows(frame)
        Sliding.__init__(self, frame, np.einsum("ian,in->an", frame, d))
        for k, given in enumerate(group.projections):
            if given is not None:
                if len(given) != 3:
                    raise GeometryError(k, f"DRPINBOD needs 3 projections of a spatial element, {len(given)} are given")
                self.r[:, k] = given
        self.data = self.r.T.copy()
        self.has_mass = bool(np.any(group.em[:, 0] != 0.0))
        self._mass = rod_mass(group.em[:, 0] * self.length, 3)
        self._inertia = _rod_inertia(group, d) if group.em[:, 1:5].any() else None

    def parameters(self) -> Array:
        return np.vstack((self.frame_p.T, self.r))

    def mass(self, c: PinState, out: Array) -> None:
        out[np.ix_(POSITIONS, POSITIONS)] = self._mass

    def inertia_force(self, c: PinState, v: Array, a: Array | None) -> Array:
        f = np.zeros_like(v)
        if a is not None:
            f[POSITIONS] = np.einsum("ijn,jn->in", self._mass, a[POSITIONS])
        return f

    def orientation_inertia(self) -> tuple[tuple[int, Array], ...]:
        return () if self._inertia is None else ((3, self._inertia),)


def _frames(group: ElementGroup, d: Array) -> Array:
    """Measuring directions (3, 3, n), columns, of elements with the lines d (3, n) from p to q."""
    frames = np.zeros((3, 3, group.n), d.dtype)
    along = []  # elements whose x' is that of the line
    for k, (given, direction) in enumerate(zip(group.directions, group.geometry, strict=True)):
        if given is not None:
            frames[:, :, k] = _given_frame(given, k)
        elif direction and len(direction) != 3:
            raise GeometryError(k, f"the direction of the local y' axis needs 3 components, {len(direction)} are given")
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
        raise GeometryError(k, f"the three ORPINBOD directions are linearly dependent (unit volume {volume:.1e})")
    return np.array(given).reshape(3, 3).T


def _rod_inertia(group: ElementGroup, d: Array) -> Array:
    """Rotary inertia (n, 3, 3) of rods: section values refer to the line pq and the y' of the statement."""
    length, n = chords(d, group.x0[POSITIONS])
    frame = chord_frames(n, group.geometry)
    return section_tensor(frame, group.em[:, 1:5], length)
