"""Stress resultants along beams, and stresses in their cross-sections.

Resultants (theory-spatial.md 3.5, theory-planar.md 3.1): torque T = l0 sigma2; moments linear between the ends, My from
l0 sigma3 to l0 sigma4, Mz from l0 sigma5 to l0 sigma6, with My = -EIy w_z'', Mz = EIz w_y''. Planar beams: e2, e3 have
the opposite sign of e5, e6, so Mz runs from -l0 cos a_p (sigma2 + Q_2 sigma1) to -l0 cos a_q (sigma3 + Q_3 sigma1),
with a the end rotations to the chord and Q of (5), which is exact at the ends.

N, Qy, Qz are the force that the element exerts on its nodes, D^T sigma, so that they balance the loads and reactions of
the run, along the axes of either end and linear between these. In the axes half way between those of the ends
(theory-beam-order4.md 2), to the first order in the rotations, with psi = (e2, e3 + e4, e5 + e6)/l0 from p to q, the
chord n = (1, (e5 - e6)/(2 l0), (e4 - e3)/(2 l0)), s = 1/(1 + Phi), a_y = s_z (e4 - e3)/l0, a_z = s_y (e6 - e5)/l0:

    F_y = (sigma5 - sigma6 - s_y [sigma1 a_z/10 + (sigma3 + sigma4) psi_x/2 - sigma2 psi_y]) l0/l        across n
    F_z = (sigma4 - sigma3 - s_z [-sigma1 a_y/10 + (sigma5 + sigma6) psi_x/2 - sigma2 psi_z]) l0/l       l = l0 + e1

and sigma1 along n. In a BEAMW s = 1, and sigma2 + sigma7 - sigma8 stands for sigma2. Without second order terms
(LDEFORM) sigma1 and sigma2 have no part across n; of the rest the sine measure has s = 1, the angle measure nothing.
A planar beam has (Mz_p - Mz_q)/l across its chord. Differences of the end moments alone, in axes that turn with a
twisted beam, are no shear forces. Loads between the nodes (inertia, gravity) act at the nodes: the force is that of
the element.

With warping (theory-warping.md section 5): the bimoment runs linearly from l0^2 sigma7 to l0^2 sigma8, the torque is
l0 (sigma2 + sigma7 - sigma8), of which GIt times the local twist rate has Saint-Venant's shear stresses; the rest, the
warping torque, has those that balance the change of the normal stress B omega/Cw (`sections.warping_shear`).

Stresses at the points of a cross-section: sigma_x = N/A - Mz y/Iz + My z/Iy; shear of the torque (circle T r/J,
rectangle by Saint-Venant's series, hollow rectangle by Bredt) and of the shear forces (parabola with the peak 3/2 Q/A
of a rectangle, 4/3 Q/A of a circle; mean value over the walls that carry them, Q/A times 2, for hollow sections); von
Mises sqrt(sigma_x^2 + 3 tau^2). Points: a grid over the section, its outline included.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from spacar.arrays import Array
from spacar.deck.cross_section import SectionConstants
from spacar_drawing.scene import Element, Scene
from spacar_drawing.sections import moments, rectangle_twist_stress, warping_function, warping_shear
from spacar_drawing.settings import SectionShape

GIVEN_BY = "BEAMSEC with a shape (CUSTOM has none), BEAMVIS or CROSSTYPE"  # the cross-section of an element
GRID = 15  # points across a section in each direction
RESULTANTS = {
    "N": ("normal force", "N"),
    "Qy": ("shear force along y'", "N"),
    "Qz": ("shear force along z'", "N"),
    "T": ("torque", "N m"),
    "My": ("bending moment about y'", "N m"),
    "Mz": ("bending moment about z'", "N m"),
    "B": ("bimoment", "N m\N{SUPERSCRIPT TWO}"),
}
STRESSES = {
    "mises": ("von Mises stress", "N/m\N{SUPERSCRIPT TWO}"),
    "normal": ("largest normal stress", "N/m\N{SUPERSCRIPT TWO}"),
    "shear": ("largest shear stress", "N/m\N{SUPERSCRIPT TWO}"),
}
QUANTITIES = RESULTANTS | STRESSES


@dataclass(frozen=True)
class Resultants:
    """Along one element, each (n,): N, Qy, Qz [N], T, My, Mz [N m].

    With warping also the bimoment B [N m^2] and the part Ts of the torque T that has Saint-Venant's shear stresses;
    None for other beams, where there is no bimoment and Ts is T.
    """

    N: Array
    Qy: Array
    Qz: Array
    T: Array
    My: Array
    Mz: Array
    B: Array | None = None
    Ts: Array | None = None

    def of(self, name: str) -> Array:
        """(n,) one of RESULTANTS."""
        value: Array | None = getattr(self, name)
        return np.zeros_like(self.N) if value is None else value

    def part(self, places: slice) -> Resultants:
        found: dict[str, Any] = {name: None if v is None else v[places] for name, v in vars(self).items()}
        return Resultants(**found)

    @classmethod
    def joined(cls, parts: Sequence[Resultants]) -> Resultants:
        """Those of several steps as those of one long element."""
        every = {name: [getattr(r, name) for r in parts] for name in vars(parts[0])}
        found: dict[str, Any] = {k: None if v[0] is None else np.concatenate(v) for k, v in every.items()}
        return cls(**found)


def planar_end_moments(scene: Scene, e: Element, s: Array, deformation: Array) -> tuple[float, float]:
    """Internal moments EI w'' at p and q [N m] of stresses s and deformations (6,) (theory-planar.md 3.1 (3) to (5)).

    The strain e2 = l0 sin a_p gives cos a_p (for a curved tube the angles are counted from the start); in the angle
    measure it is l0 a_p, and 1 stands for the cosine (theory-beam-order4.md 1).
    """
    i = e.number - 1
    l0 = scene.length[i]
    e2, e3 = deformation[1], deformation[2]
    Phi = 12.0 * scene.stiffness[i, 2] / l0**2
    measure = int(scene.quadratic[i])  # kdform: 0, 1 sines without and with Q; 2, 3 angles with and without Q
    scale = float(measure in (1, 2)) / (60.0 * l0 * (1.0 + Phi) ** 2)
    A, B = (4 + 5 * Phi + 2.5 * Phi**2) * scale, (2 + 10 * Phi + 5 * Phi**2) * scale
    cosine = np.sqrt(np.maximum(1.0 - (deformation[1:3] / l0) ** 2, 0.0)) if measure < 2 else np.ones(2)
    p = -l0 * cosine[0] * (s[1] + (2 * A * e2 + B * e3) * s[0])
    q = -l0 * cosine[1] * (s[2] + (2 * A * e3 + B * e2) * s[0])
    return p, q


def section_forces(scene: Scene, e: Element, s: Array, d: Array, ends: tuple[float, float] | None) -> Array:
    """N, Qy, Qz [N] at p and q, (3, 2), of stresses s and deformations d (6,); `ends`: end moments of a planar beam."""
    i = e.number - 1
    l0, length = scene.length[i], scene.length[i] + d[0]
    if ends is not None:
        d = np.array([d[0], 0.0, 0.0, 0.0, -d[1], -d[2]])
        across = np.array([(ends[0] - ends[1]) / length, 0.0])
    else:
        measure = scene.quadratic[i]  # as in `planar_end_moments`
        Phi = np.zeros(2) if e.warping else 12.0 * scene.stiffness[i, 4:6] / l0**2  # Phi_z, Phi_y
        sz, sy = 1.0 / (1.0 + Phi) if measure in (1, 2) else np.full(2, float(measure == 0))
        second = float(measure in (1, 2)) / l0
        torque = s[1] + (s[6] - s[7] if e.warping else 0.0)
        by_y = 0.5 * (s[2] + s[3]) * d[1] / l0 - second * (torque * (d[2] + d[3]) - 0.1 * s[0] * sy * (d[5] - d[4]))
        by_z = 0.5 * (s[4] + s[5]) * d[1] / l0 - second * (torque * (d[4] + d[5]) + 0.1 * s[0] * sz * (d[3] - d[2]))
        across = np.array([s[4] - s[5] - sy * by_y, s[3] - s[2] - sz * by_z]) * (l0 / length)
    tilt = np.array([d[4] - d[5], d[3] - d[2]]) / (2.0 * l0)
    n = np.array([np.sqrt(np.maximum(1.0 - tilt @ tilt, 0.0)), *tilt])
    force = (s[0] - across @ tilt) * n + np.array([0.0, *across])
    h = np.array([d[1], d[2] + d[3], d[4] + d[5]]) / (4.0 * l0)  # tangents of a quarter of the rotation from p to q
    once = np.cross(h, force)
    twice = np.cross(h, once)
    part = 2.0 / (1.0 + h @ h)
    return np.stack((force + part * (twice + once), force + part * (twice - once)), axis=1)


def resultants(scene: Scene, e: Element, sig: Array, e_values: Array, n: int) -> Resultants:
    """Stress resultants of a beam or truss at n places from p to q. sig, e_values (ne,)."""
    rows = scene.le[e.number - 1]
    s = np.where(rows > 0, sig[np.maximum(rows - 1, 0)], 0.0)
    l0 = scene.length[e.number - 1]
    xi, zero = np.linspace(0.0, 1.0, n), np.zeros(n)
    if e.shape == "truss":
        return Resultants(s[0] + zero, zero, zero, zero, zero, zero)
    d = np.where(rows > 0, e_values[np.maximum(rows - 1, 0)], 0.0)
    ends = planar_end_moments(scene, e, s, d) if scene.planar else None
    at_p, at_q = section_forces(scene, e, s, d, ends).T
    N, Qy, Qz = np.outer(at_p, 1.0 - xi) + np.outer(at_q, xi)
    if ends is not None:
        return Resultants(N, Qy, Qz, zero, zero, ends[0] + (ends[1] - ends[0]) * xi)
    y, z = l0 * s[2:4], l0 * s[4:6]
    torque = l0 * s[1] + zero
    warping: tuple[Array, ...] = ()
    if e.warping:
        # twist rate of the cubic twist angle less its mean, and the linear bimoment
        uneven = (d[7] * (3 * xi**2 - 2 * xi) - d[6] * (1 - 4 * xi + 3 * xi**2)) / l0**2
        warping = l0**2 * (s[6] + (s[7] - s[6]) * xi), torque + scene.stiffness[e.number - 1, 1] * uneven
        torque = torque + l0 * (s[6] - s[7])
    return Resultants(N, Qy, Qz, torque, y[0] + (y[1] - y[0]) * xi, z[0] + (z[1] - z[0]) * xi, *warping)


def section_points(section: SectionShape) -> tuple[Array, Array]:
    """Places y, z (m,) [m] over a section."""
    if section.shape in ("RECT", "RECTHOL"):
        w, h = section.dims[:2]
        y, z = _grid(np.linspace(-0.5, 0.5, GRID) * w, np.linspace(-0.5, 0.5, GRID) * h)
        if section.shape == "RECTHOL":
            inner = (np.abs(y.real) < 0.5 * section.dims[2].real) & (np.abs(z.real) < 0.5 * section.dims[3].real)
            y, z = y[~inner], z[~inner]
        return y, z
    if section.shape == "I":  # both flanges and the web
        b, h, tw, tf = section.dims
        y, z = _grid(np.linspace(-0.5, 0.5, GRID) * b, 0.5 * h - np.linspace(0.0, 1.0, 5) * tf)
        web = _grid(np.linspace(-0.5, 0.5, 5) * tw, np.linspace(-0.5, 0.5, GRID)[1:-1] * (h - 2 * tf))
        return np.concatenate((y, y, web[0])), np.concatenate((z, -z, web[1]))
    inside = 0.5 * section.dims[1] if section.shape == "CIRCHOL" else 0.0
    r, a = _grid(np.linspace(inside, 0.5 * section.dims[0], 6), np.linspace(0, 2 * np.pi, 24, endpoint=False))
    return r * np.cos(a), r * np.sin(a)


def _grid(y: Array, z: Array) -> tuple[Array, Array]:
    """The points with all these coordinates."""
    Y, Z = np.meshgrid(y, z)
    return Y.ravel(), Z.ravel()


def stress_field(
    section: SectionShape, r: Resultants, points: tuple[Array, Array] | None = None
) -> tuple[Array, Array]:
    """Normal stress and shear stress, each (places along the element, points of the section) [N/m^2].

    `points`: y, z (m,) instead of those of `section_points`.
    """
    m = moments(section)
    if m is None:
        raise ValueError("a LINE has no stresses")
    y, z = section_points(section) if points is None else points
    normal = (r.N / m.A)[:, None] - np.outer(r.Mz, y) / m.Iz + np.outer(r.My, z) / m.Iy
    omega = warping_function(section, y, z)
    if r.B is not None and omega is not None:
        normal = normal + np.outer(r.B, omega) / m.Cw
    twisting = r.T if r.Ts is None else r.Ts
    d = section.dims
    shear_y = shear_z = np.full(len(y), 2.0 / m.A)  # of hollow sections
    if section.shape == "RECT":
        ty, tz = rectangle_twist_stress(d[0], d[1], y, z)
        shear_y, shear_z = (1.5 / m.A * (1 - (2 * v / side) ** 2) for v, side in ((y, d[0]), (z, d[1])))
    elif section.shape in ("CIRC", "CIRCHOL"):
        ty, tz = -z / m.It, y / m.It
        if section.shape == "CIRC":
            shear_y = shear_z = 4 / (3 * m.A) * (1 - (y**2 + z**2) / (0.5 * d[0]) ** 2)
    elif section.shape == "I":
        ty, tz, shear_y, shear_z = _i_shear(section, m, y, z)
    else:
        t_w, t_h = 0.5 * (d[0] - d[2]), 0.5 * (d[1] - d[3])
        area = (d[0] - t_w) * (d[1] - t_h)
        side = np.abs(y.real) >= 0.5 * d[2].real
        ty = np.where(side, 0.0, -np.sign(z.real) / (2 * area * t_h))
        tz = np.where(side, np.sign(y.real) / (2 * area * t_w), 0.0)
    tau_y = np.outer(twisting, ty) + np.outer(r.Qy, shear_y)
    tau_z = np.outer(twisting, tz) + np.outer(r.Qz, shear_z)
    warped = None if r.Ts is None else warping_shear(section, y, z)
    if r.Ts is not None and warped is not None:
        tau_y = tau_y + np.outer(r.T - r.Ts, warped[0])
        tau_z = tau_z + np.outer(r.T - r.Ts, warped[1])
    if np.iscomplexobj(normal):  # a direction (spacar_drawing.stress_numbers)
        return normal, np.sqrt(tau_y * tau_y + tau_z * tau_z)
    return normal, np.hypot(tau_y, tau_z)


def _i_shear(section: SectionShape, m: SectionConstants, y: Array, z: Array) -> tuple[Array, Array, Array, Array]:
    """Shear stresses of an I section along y', z': per unit torque, where every plate has its part as a thin rectangle
    (2 G theta times the distance from its middle line), and per unit shear force (flanges 3/2 parabola, web mean)."""
    b, h, tw, tf = section.dims
    flange = np.abs(z.real) >= (0.5 * h - tf).real
    middle = np.sign(z.real) * 0.5 * (h - tf)
    ty = np.where(flange, -2 * (z - middle) / m.It, 0.0)
    tz = np.where(flange, 0.0, 2 * y / m.It)
    shear_y = np.where(flange, 1.5 / (2 * b * tf) * (1 - (2 * y / b) ** 2), 0.0)
    shear_z = np.where(flange, 0.0, 1.0 / ((h - tf) * tw))
    return ty, tz, shear_y, shear_z


def along(quantity: str, r: Resultants, section: SectionShape | None) -> Array | None:
    """(n,) a quantity of QUANTITIES along an element; None when it needs a cross-section that is not given."""
    if quantity in RESULTANTS:
        return r.of(quantity)
    if section is None or moments(section) is None:
        return None
    normal, shear = stress_field(section, r)
    return worst(quantity, normal, shear)[0]


def worst(quantity: str, normal: Array, shear: Array) -> tuple[Array, Array]:
    """The largest of STRESSES among the points of a section, (n,) with the sign of a normal stress, and which point.

    normal, shear   (n, points) as `stress_field` gives them
    """
    field = of_quantity(quantity, normal, shear)
    point = np.argmax(np.abs(field), axis=1)
    return field[np.arange(len(field)), point], point


def of_quantity(quantity: str, normal: Array, shear: Array) -> Array:
    """One of STRESSES at every point: normal, shear, or von Mises sqrt(normal^2 + 3 shear^2)."""
    given = {"normal": normal, "shear": shear}.get(quantity)
    return np.sqrt(normal**2 + 3 * shear**2) if given is None else given
