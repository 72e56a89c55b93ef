"""Cross-sections of beams as outlines, with their areas and moments. Coordinates (y, z) along local y', z' [m]."""

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import Array
from spacar.deck.cross_section import SectionConstants, pictured_constants, rectangle_torsion
from spacar_drawing.drawn_shapes import disc_outline
from spacar_drawing.settings import SectionShape


def rectangle(w: float, h: float) -> Array:
    return 0.5 * np.array([[w, h], [-w, h], [-w, -h], [w, -h]])


def outline(section: SectionShape | None, n: int = 20) -> Array | None:
    """(k, 2) outer contour; None for LINE and for no section."""
    if section is None:
        return None
    if section.shape in ("RECT", "RECTHOL"):
        return rectangle(*section.dims[:2])
    if section.shape in ("CIRC", "CIRCHOL"):
        return disc_outline(0.5 * section.dims[0], n)
    if section.shape == "I":
        b, h, tw, tf = section.dims
        inner = h - 2 * tf  # counter-clockwise from the upper right corner
        y = np.array([b, -b, -b, -tw, -tw, -b, -b, b, b, tw, tw, b])
        z = np.array([h, h, inner, inner, -inner, -inner, -h, -h, -inner, -inner, inner, inner])
        return 0.5 * np.stack((y, z), axis=1)
    return None


def hole(section: SectionShape) -> Array | None:
    """(k, 2) inner contour; None when the section is full."""
    if section.shape == "RECTHOL":
        return rectangle(*section.dims[2:4])
    if section.shape == "CIRCHOL":
        return disc_outline(0.5 * section.dims[1], 20)
    return None


def inside(section: SectionShape, y: Array, z: Array) -> NDArray[np.bool_]:
    """Whether points lie in the material of a section, its outline included. False everywhere for LINE."""
    d, a, b = (*section.dims, 0.0, 0.0), np.abs(y), np.abs(z)
    edge = 1.0 + 1e-9  # points on the outline are in it, whatever the rounding
    if section.shape in ("RECT", "RECTHOL"):
        return (a <= 0.5 * d[0] * edge) & (b <= 0.5 * d[1] * edge) & ~((a < 0.5 * d[2]) & (b < 0.5 * d[3]))
    if section.shape in ("CIRC", "CIRCHOL"):
        r = np.hypot(y, z)
        return (r <= 0.5 * d[0] * edge) & (r * edge >= 0.5 * d[1])
    if section.shape == "I":
        flange = (a <= 0.5 * d[0] * edge) & (b >= (0.5 * d[1] - d[3]) / edge)
        return (flange | (a <= 0.5 * d[2] * edge)) & (b <= 0.5 * d[1] * edge)
    return np.zeros(np.shape(y), bool)


def breadth(section: SectionShape | None) -> float:
    """Width along y' [m]: what a planar picture shows; 0 for LINE and for no section."""
    return section.dims[0] if section is not None and section.dims else 0.0


def moments(section: SectionShape) -> SectionConstants | None:
    """The constants that beams of this section are computed with (sections.md section 2). None for LINE."""
    return pictured_constants(section.shape, section.dims)


def warping_function(section: SectionShape, y: Array, z: Array) -> Array | None:
    """Unit warping omega [m^2] at points of a section (theory-warping.md section 2), None where it does not warp.

    Rectangle -y z, thin along z (+y z, thin along y); I section y z_m in the flanges, z_m their middle lines, and zero
    in the web: in the middle line of a wall no shear strain, d omega/dy = z.
    """
    if section.shape == "RECT":
        return -y * z if section.dims[0].real >= section.dims[1].real else y * z
    if section.shape == "I":
        _, h, _, tf = section.dims
        return np.where(np.abs(z.real) >= (0.5 * h - tf).real, y * np.sign(z.real) * 0.5 * (h - tf), 0.0)
    return None


def warping_shear(section: SectionShape, y: Array, z: Array) -> tuple[Array, Array] | None:
    """Shear stresses (tau_xy, tau_xz) [1/m^3] at points of a section per warping torque -dB/dx; None without warping.

    They balance the change of the normal stress B omega/Cw along the beam, d tau_xz/dz = T_w omega/Cw, and vanish on
    the faces; their torque is the warping torque. Rectangle, as in a plate: tau_xz = T_w y (t^2 - 4 z^2)/(8 Cw), thin
    along z; 9 T_w/(w^2 t) in the middle of the edges. I section: the shear force T_w/(h - tf) of a flange, parabolic.
    """
    if section.shape == "RECT":
        w, h = section.dims[:2]
        Cw = (w * h) ** 3 / 144.0
        if w.real >= h.real:
            return np.zeros_like(y), y * (h**2 - 4.0 * z**2) / (8.0 * Cw)
        return -z * (w**2 - 4.0 * y**2) / (8.0 * Cw), np.zeros_like(y)
    if section.shape == "I":
        b, h, _, tf = section.dims
        flange = np.abs(z.real) >= (0.5 * h - tf).real
        peak = 1.5 / ((h - tf) * b * tf)
        return np.where(flange, -np.sign(z.real) * peak * (1.0 - (2.0 * y / b) ** 2), 0.0), np.zeros_like(y)
    return None


def rectangle_twist_stress(w: float, h: float, y: Array, z: Array) -> tuple[Array, Array]:
    """Shear stresses (tau_xy, tau_xz) at the points y, z of a rectangle per unit torque [1/m^3].

    Saint-Venant's series (Timoshenko and Goodier, art. 109) with the stress function phi, tau_xy = d phi/dz,
    tau_xz = -d phi/dy, for the side w along y, h along z; solved across the shorter side, where it converges fast.
    """
    if w.real > h.real:
        t_z, t_y = rectangle_twist_stress(h, w, z, y)
        return -t_y, -t_z
    a, b = 0.5 * w, 0.5 * h  # a <= b
    n = np.arange(1, 60, 2)[:, None]
    k = n * np.pi / (2 * a)
    sign = (-1.0) ** ((n - 1) // 2)
    # cosh(kz)/cosh(kb) without overflow
    side = np.sign(z.real.ravel())
    zz = side * z.ravel()
    zz = np.where(zz.real > b.real, b, zz)
    decay = np.exp(k * (zz - b))
    near, far = np.exp(-2 * k * zz), 1 + np.exp(-2 * k * b)
    ratio_c = decay * (1 + near) / far
    ratio_s = decay * (1 - near) / far * side
    yy = y.ravel()
    factor = 16 * a / np.pi**2  # per G theta
    t_xy = -factor * np.sum(sign / n**2 * np.cos(k * yy) * ratio_s, axis=0)
    t_xz = 2 * yy - factor * np.sum(sign / n**2 * np.sin(k * yy) * ratio_c, axis=0)
    It = rectangle_torsion(w, h)
    return t_xy.reshape(y.shape) / It, t_xz.reshape(y.shape) / It
