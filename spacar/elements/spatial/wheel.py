"""Wheels on the flat ground z = 0, keywords WHEEL (disk) and TWHEEL (torus) (theory-spatial.md section 8).

Coordinates x_p (3, centre), lambda_p (4), x_q (3, contact point). With the spin axis a = R a0, n = (0, 0, 1),
d = x_q - x_p, the transverse radius rho (0 for a disk), r = d + rho n from the centre to the centre of the tread
circle:

    e1 = |r| - r0   radial [m]            e3 = z of x_q     height above the ground [m]
    e2 = a.r        axial [m]             e4 = r.(a x n)    the contact is the lowest point [m]
    de5/dt = t.(dx_p + w x d), t = r x a  longitudinal slip, |t| = r0 on the ground
    de6/dt = s.(dx_q - rho w x n), s = n x t                lateral slip, |s| = |t|

The slips are rates only: e5 = e6 = 0, and their rows W of V are no gradients (`slip_hessian`).
"""

from typing import NamedTuple

import numpy as np

from spacar.arrays import Array
from spacar.elements.family import ElementGroup, Family, GeometryError, Trouble
from spacar.elements.rotations.local_frames import rows, unit
from spacar.elements.rotations.rotation import cross, director_tensor, global_matrix, identity
from spacar.elements.spatial.pinbody import parts_of, put_mixed

_einsum = np.einsum
UP = np.array([0.0, 0.0, 1.0])
_AROUND = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
# Chosen bounds, not of rounding: digits of the file, the meaning of `on the ground`, of `lies flat`.
START = 1e-4  # largest error of the given contact point as a fraction of the radius
LEFT = 1e-6  # largest height of the contact point over the ground as a fraction of the radius
FLAT = 1e-3  # smallest sine of the angle between spin axis and vertical


class WheelState(NamedTuple):
    """Vectors of the wheels at x."""

    K: Array  # (3, 4, 4, n) director tensor of a0
    rho: Array  # (n,)
    lam: Array  # (4, n)
    d: Array  # (3, n)
    B: Array  # (3, 4, n) da/dlam
    a: Array  # (3, n)
    r: Array  # (3, n)
    l: Array  # (n,) |r|
    G: Array  # (3, 4, n) w = G dlam
    t: Array  # (3, n)
    s: Array  # (3, n)


class WheelRates(NamedTuple):
    """Rates for velocities v at zero accelerations."""

    lam: Array  # (4, n)
    p: Array  # (3, n) dx_p
    q: Array  # (3, n) dx_q
    d: Array  # (3, n)
    B: Array  # (3, 4, n)
    a: Array  # (3, n)
    a2: Array  # (3, n) second rate of a
    n1: Array  # (3, n) rate of r/|r|
    w: Array  # (3, n)
    t: Array  # (3, n)


def around(v: Array) -> Array:
    """n x v for the vertical n; v x n is its opposite."""
    return np.asarray(_einsum("ij,j...->i...", _AROUND, v))


def _dot(a: Array, b: Array) -> Array:
    return np.asarray(_einsum("i...,i...->...", a, b))


def _down(B: Array, w: Array) -> Array:
    """B^T w."""
    return np.asarray(_einsum("ai...,a...->i...", B, w))


def wheel_state(K: Array, rho: Array, x: Array) -> WheelState:
    """State at x (10, n)."""
    lam, d = parts_of(x)
    B = _einsum("ijk...,k...->ij...", K, lam)
    a = _einsum("ij...,j...->i...", B, 0.5 * lam)
    r = d.copy()
    r[2] += rho
    t = cross(r, a)
    return WheelState(K, rho, lam, d, B, a, r, np.sqrt(_dot(r, r)), 2.0 * global_matrix(lam), t, around(t))


def wheel_rates(c: WheelState, v: Array) -> WheelRates:
    """Rates for v (10, n)."""
    lam, d = parts_of(v)
    B = _einsum("ijk...,k...->ij...", c.K, lam)
    a = _einsum("ij...,j...->i...", c.B, lam)
    n = c.r / c.l
    n1 = (d - _dot(n, d) * n) / c.l
    w = _einsum("ij...,j...->i...", c.G, lam)
    t = cross(d, c.a) + cross(c.r, a)
    return WheelRates(lam, v[:3], v[7:], d, B, a, _einsum("ij...,j...->i...", B, lam), n1, w, t)


def slip_hessian(c: WheelState) -> Array:
    """H[e, i, j] = dW_e,i/dx_j of the two slips, (2, 10, 10, n); not symmetric in i, j."""
    at, y = _along_coordinates(c)
    a, r, t, s, d, G, rho, B = at.a, at.r, at.t, at.s, at.d, at.G, at.rho, at.B
    ylam, yd = parts_of(y)
    da = _einsum("ij...,j...->i...", B, ylam)
    dt = cross(yd, a) + cross(r, da)
    ds = around(dt)
    dG = 2.0 * global_matrix(ylam)
    H = np.zeros((2, 10, *da.shape[1:]), da.dtype)
    H[0, :3] = dt
    H[0, 3:7] = _down(dG, cross(d, t)) + _down(G, cross(yd, t) + cross(d, dt))
    H[1, 3:7] = -rho * (_down(dG, around(s)) + _down(G, around(ds)))
    H[1, 7:] = ds
    return H


def slip_rate_gradient(c: WheelState, k: WheelRates) -> Array:
    """Gradient of the slip accelerations at zero accelerations, (2, 10, n)."""
    at, y = _along_coordinates(c)
    k = WheelRates(*_spread(k, c.l.ndim))
    ylam, yd = parts_of(y)
    da = _einsum("ij...,j...->i...", at.B, ylam)
    dt = cross(yd, at.a) + cross(at.r, da)
    dt1 = cross(k.d, da) + cross(yd, k.a) + cross(at.r, _einsum("ij...,j...->i...", k.B, ylam))
    dw = 2.0 * _einsum("ij...,j...->i...", global_matrix(ylam), k.lam)
    out = np.empty((2, *dt.shape[1:]), dt.dtype)
    out[0] = _dot(dt1, k.p + cross(k.w, at.d)) + _dot(k.t, cross(dw, at.d) + cross(k.w, yd))
    out[0] += _dot(dt, cross(k.w, k.d)) + _dot(at.t, cross(dw, k.d))
    out[1] = _dot(around(dt1), k.q + at.rho * around(k.w)) + at.rho * _dot(around(k.t), around(dw))
    return out


def _along_coordinates(c: WheelState) -> tuple[WheelState, Array]:
    """The state with an axis for ten directions before the element axis, and these: the unit vectors."""
    axes = c.l.ndim
    return WheelState(*_spread(c, axes)), identity(10, axes)


def _spread(parts: tuple[Array, ...], axes: int) -> list[Array]:
    return [np.expand_dims(a, a.ndim - axes) for a in parts]


class _Wheel(Family):
    """What disk and torus share; the subclasses read the element statement."""

    definition = "wheel"
    n_coordinates = 10
    frame_p: Array
    n_deformations = 6
    slips = (4, 5)
    position_rows = (0, 1, 2, 7, 8, 9)

    def __init__(self, group: ElementGroup) -> None:
        self._take(group)
        d = group.x0[7:] - group.x0[:3]
        axes, self.radius, self.rho = self._read(group, np.sqrt((d * d).sum(0)))
        frame = np.stack([_frame(axis, k) for k, axis in enumerate(axes)], axis=-1)
        self.frame_p = self.frame_q = rows(frame)
        self.data = np.column_stack((self.radius, self.rho))
        self.constants = director_tensor(frame[:, 2]), self.radius, self.rho
        self._check_start(group.x0.real)

    def parameters(self) -> Array:
        return np.vstack((self.frame_p[:, 6:].T, self.radius, self.rho, LEFT * (self.radius + self.rho)))

    def _read(self, group: ElementGroup, distance: Array) -> tuple[list[tuple[float, ...]], Array, Array]:
        """Spin axes, radii r0 (n,) of the tread circle and transverse radii rho (n,) [m]."""
        raise NotImplementedError

    def _check_start(self, x0: Array) -> None:
        e, V = np.zeros((6, self.n)), np.zeros((6, 10, self.n))
        K, radius, rho = self.constants
        directed, self.constants = self.constants, (K.real, radius.real, rho.real)
        c = self.strain(x0, e, e, V)
        self.constants = directed
        below = c.r[2] < 0.0
        allowed = START * (radius.real + rho.real)
        axial, lowest = e[1], e[3]
        places = (
            (axial, "off the plane of the wheel"),
            (e[2], "above the ground z = 0"),
            (lowest, "beside the lowest point of the wheel"),
        )
        for k in range(self.n):
            if not below[k]:
                raise GeometryError(k, f"the contact point is not below the centre but {c.r[2, k]:.3g} m above it")
            for error, place in places:
                if abs(error[k]) > allowed[k]:
                    text = f"the contact point is {error[k]:.6g} m {place}; correct its coordinates"
                    raise GeometryError(k, text)

    # -- deformations --------------------------------------------------------------------------------------
    def strain(self, x: Array, branch: Array, e: Array, V: Array) -> WheelState:
        K, radius, rho = self.constants
        c = wheel_state(K, rho, x)
        m = around(c.r)
        e[0] = c.l - radius
        e[1] = _dot(c.a, c.r)
        e[2] = x[9]
        e[3] = _dot(c.a, m)
        _put(V, c.r / c.l, c.a, _down(c.B, c.r), -around(c.a), _down(c.B, m))
        V[2, 9] = 1.0
        V[4, :3] = c.t
        V[4, 3:7] = _down(c.G, cross(c.d, c.t))
        V[5, 3:7] = -rho * _down(c.G, around(c.s))
        V[5, 7:] = c.s
        return c

    def convective_strain(self, c: WheelState, v: Array, out: Array) -> None:
        k = wheel_rates(c, v)
        out[0] = _dot(k.d, k.n1)
        out[1] = 2.0 * _dot(k.a, k.d) + _dot(k.a2, c.r)
        out[2] = 0.0
        out[3] = 2.0 * _dot(k.a, around(k.d)) + _dot(k.a2, around(c.r))
        out[4] = _dot(k.t, k.p + cross(k.w, c.d)) + _dot(c.t, cross(k.w, k.d))
        out[5] = _dot(around(k.t), k.q + c.rho * around(k.w))

    def _holonomic_rate(self, c: WheelState, k: WheelRates, out: Array) -> None:
        """[v, .] of the first four modes."""
        beside = _down(c.B, around(k.d)) + _down(k.B, around(c.r))
        _put(out, k.n1, k.a, _down(c.B, k.d) + _down(k.B, c.r), -around(k.a), beside)

    def gradient_rate(self, c: WheelState, v: Array, out: Array) -> None:
        self._holonomic_rate(c, wheel_rates(c, v), out)
        out[4:] = _einsum("eij...,i...->ej...", slip_hessian(c), v)

    def gradient_transport(self, c: WheelState, v: Array, out: Array) -> None:
        self._holonomic_rate(c, wheel_rates(c, v), out)
        out[4:] = _einsum("eij...,j...->ei...", slip_hessian(c), v)

    def rate_gradient(self, c: WheelState, v: Array, out: Array) -> None:
        k = wheel_rates(c, v)
        n = c.r / c.l
        radial = -(2.0 * _dot(n, k.d) * k.n1 + _dot(k.d, k.n1) * n) / c.l
        _put(out, radial, k.a2, 2.0 * _down(k.B, k.d), -around(k.a2), 2.0 * _down(k.B, around(k.d)))
        out[4:] = slip_rate_gradient(c, k)

    def geometric_stiffness(self, c: WheelState, sigma: Array, out: Array) -> None:
        n = c.r / c.l
        P = -(sigma[0] / c.l) * n[:, None] * n
        for i in range(3):
            P[i, i] += sigma[0] / c.l
        mixed = sigma[1] * c.B - sigma[3] * around(c.B)  # d-lambda block of modes 2 and 4
        out[:3, :3] = out[7:, 7:] = P
        out[:3, 7:] = out[7:, :3] = -P
        put_mixed(mixed, out)
        out[3:7, 3:7] = _einsum("i...,ijk...->jk...", sigma[1] * c.r + sigma[3] * around(c.r), c.K)
        out += _einsum("e...,eij...->ij...", sigma[4:], slip_hessian(c))

    # -- limits ----------------------------------------------------------------------------------------------
    def troubles(self, c: WheelState, e: Array, sigma: Array) -> list[Trouble]:
        """Contact point off the ground; wheel that lies flat, which has no lowest point."""
        size = self.radius + self.rho
        found = [
            Trouble(int(k), f"leaves the ground plane: its contact point is at z = {e[2, k]:.3g} m", True)
            for k in np.flatnonzero(~(np.abs(e[2]) <= LEFT * size))
        ]
        for k in np.flatnonzero(np.hypot(c.a[0], c.a[1]) < FLAT):
            found.append(Trouble(int(k), "lies flat on the ground: its contact point is not defined", True))
        return found


class DiskWheel(_Wheel):
    """All WHEEL elements: thin disks with the start distance from centre to contact as radius.

    Raises GeometryError for a missing, zero or vertical spin axis, a zero radius and a contact point that is
    not the lowest point of the wheel on the ground.
    """

    def _read(self, group: ElementGroup, distance: Array) -> tuple[list[tuple[float, ...]], Array, Array]:
        for k, values in enumerate(group.geometry):
            if len(values) != 3:
                raise GeometryError(k, f"needs 3 components of the spin axis, {len(values)} are given")
            if not distance[k].real > 0.0:
                raise GeometryError(k, "the radius, the distance between centre and contact point, is zero")
        return list(group.geometry), distance, np.zeros(group.n)


class TorusWheel(_Wheel):
    """All TWHEEL elements: tread circles of radius (equatorial radius - transverse radius) with a round tread.

    Raises GeometryError as `DiskWheel`, and for radii that are not equatorial > transverse >= 0.
    """

    def _read(self, group: ElementGroup, distance: Array) -> tuple[list[tuple[float, ...]], Array, Array]:
        for k, values in enumerate(group.geometry):
            if len(values) != 5:
                raise GeometryError(k, f"needs two radii and 3 components of its axis, {len(values)} are given")
            if not values[0] > values[1] >= 0.0:
                text = f"the equatorial radius {values[0]:g} m must exceed the transverse radius {values[1]:g} m"
                raise GeometryError(k, f"{text}, and neither may be negative")
        radii = np.array([values[:2] for values in group.geometry]).reshape(-1, 2)
        return [values[2:] for values in group.geometry], radii[:, 0] - radii[:, 1], radii[:, 1]


def _put(out: Array, radial: Array, axial: Array, axial_lam: Array, beside: Array, beside_lam: Array) -> None:
    """Rows 1, 2 and 4: parts with respect to x_q (minus: x_p) and lambda."""
    for row, part in ((0, radial), (1, axial), (3, beside)):
        out[row, 7:] = part
        out[row, :3] = -part
    out[1, 3:7] = axial_lam
    out[3, 3:7] = beside_lam


def _frame(axis: tuple[float, ...], k: int) -> Array:
    """Columns x' = a0 x n (direction of travel), y', z' = a0, the spin axis."""
    ez = unit(axis, k, "spin axis")
    ex = np.cross(ez, UP)
    sine = np.sqrt(ex @ ex)
    if sine.real < FLAT:
        raise GeometryError(k, "the spin axis is vertical: the wheel lies flat and has no contact point")
    ex /= sine
    return np.column_stack((ex, np.cross(ez, ex), ez))
