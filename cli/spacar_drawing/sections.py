"""Cross-sections of beams as outlines, with their areas and moments. Coordinates (y, z) along local y', z' [m]."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from spacar.arrays import Array
from spacar_drawing.drawn_shapes import disc_outline
from spacar_drawing.settings import SectionShape


def rectangle(w: float, h: float) -> Array:
    return 0.5 * np.array([[w, h], [-w, h], [-w, -h], [w, -h]])


def outline(section: SectionShape, n: int = 20) -> Array | None:
    """(k, 2) outer contour; None for LINE."""
    if section.shape in ("RECT", "RECTHOL"):
        return rectangle(*section.dims[:2])
    if section.shape in ("CIRC", "CIRCHOL"):
        return disc_outline(0.5 * section.dims[0], n)
    return None


def hole(section: SectionShape, n: int = 20) -> Array | None:
    """(k, 2) inner contour; None when the section is full."""
    if section.shape == "RECTHOL":
        return rectangle(*section.dims[2:4])
    if section.shape == "CIRCHOL":
        return disc_outline(0.5 * section.dims[1], n)
    return None


def breadth(section: SectionShape | None) -> float:
    """Width along y' [m]: what a planar picture shows; 0 for LINE and for no section."""
    return section.dims[0] if section is not None and section.dims else 0.0


@dataclass(frozen=True)
class Moments:
    """Area [m^2], second moments Iy (bending in x'z'), Iz (in x'y') and torsion constant It [m^4]."""

    A: float
    Iy: float
    Iz: float
    It: float


def moments(section: SectionShape) -> Moments | None:
    """Area and second moments; It of a rectangle by the series of later-versions.md, of a hollow rectangle by
    Bredt's formula with the wall between the two rectangles. None for LINE."""
    d = section.dims
    if section.shape == "RECT":
        w, h = d
        return Moments(w * h, w * h**3 / 12, h * w**3 / 12, rectangle_torsion(w, h))
    if section.shape == "RECTHOL":
        w, h, wi, hi = d
        t_w, t_h = 0.5 * (w - wi), 0.5 * (h - hi)
        wm, hm = w - t_w, h - t_h
        It = 4 * (wm * hm) ** 2 / (2 * hm / t_w + 2 * wm / t_h) if t_w > 0 and t_h > 0 else 0.0
        return Moments(w * h - wi * hi, (w * h**3 - wi * hi**3) / 12, (h * w**3 - hi * wi**3) / 12, It)
    if section.shape in ("CIRC", "CIRCHOL"):
        inner = d[1] if section.shape == "CIRCHOL" else 0.0
        second = np.pi / 64 * (d[0] ** 4 - inner**4)
        return Moments(np.pi / 4 * (d[0] ** 2 - inner**2), second, second, 2 * second)
    return None


def rectangle_torsion(w: float, h: float) -> float:
    """Torsion constant of a rectangle: (1/3)(2a)^3 (2b) (1 - 192/pi^5 (a/b) sum tanh(n pi b/2a)/n^5, n odd), a <= b."""
    a, b = sorted((0.5 * w, 0.5 * h))
    n = np.arange(1, 40, 2)
    return float(
        (2 * a) ** 3 * 2 * b / 3 * (1 - 192 / np.pi**5 * a / b * np.sum(np.tanh(n * np.pi * b / (2 * a)) / n**5))
    )


def rectangle_twist_stress(w: float, h: float, y: Array, z: Array) -> tuple[Array, Array]:
    """Shear stresses (tau_xy, tau_xz) at the points y, z of a rectangle per unit torque [1/m^3].

    Saint-Venant's series (Timoshenko and Goodier, art. 109) with the stress function phi, tau_xy = d phi/dz,
    tau_xz = -d phi/dy, for the side w along y, h along z; solved across the shorter side, where it converges fast.
    """
    if w > h:
        t_z, t_y = rectangle_twist_stress(h, w, z, y)
        return -t_y, -t_z
    a, b = 0.5 * w, 0.5 * h  # a <= b
    n = np.arange(1, 60, 2)[:, None]
    k = n * np.pi / (2 * a)
    sign = (-1.0) ** ((n - 1) // 2)
    # cosh(kz)/cosh(kb) without overflow
    zz = np.clip(np.abs(z.ravel()), 0, b)
    decay = np.exp(k * (zz - b))
    ratio_c = decay * (1 + np.exp(-2 * k * zz)) / (1 + np.exp(-2 * k * b))
    ratio_s = decay * (1 - np.exp(-2 * k * zz)) / (1 + np.exp(-2 * k * b)) * np.sign(z.ravel())
    yy = y.ravel()
    factor = 16 * a / np.pi**2  # per G theta
    t_xy = -factor * np.sum(sign / n**2 * np.cos(k * yy) * ratio_s, axis=0)
    t_xz = 2 * yy - factor * np.sum(sign / n**2 * np.sin(k * yy) * ratio_c, axis=0)
    It = rectangle_torsion(w, h)
    return t_xy.reshape(y.shape) / It, t_xz.reshape(y.shape) / It
