"""Constants of cross-sections: area, second moments, torsion, shear and warping constants (sections.md section 2).

y' and z' are the principal axes of the beam: Iy = integral z'^2 dA belongs to bending in the x'z' plane, Iz to the
x'y' plane. Shear coefficients k by Cowper (J. Appl. Mech. 33, 1966, 335-340). The torsion constant of a rectangle with
half sides a <= b by Saint-Venant's series (Timoshenko and Goodier, art. 109):

    It = (2a)^3 (2b)/3 [1 - 192/pi^5 (a/b) sum tanh(n pi b/(2a))/n^5, n = 1, 3, 5, ...]

Closed thin walls by Bredt's formula, I sections as three rectangles. Warping constants: rectangle w^3 t^3/144 (narrow,
theory-warping.md section 1), I section tf b^3 (h - tf)^2/24; circles do not warp, that of closed sections is neglected.
"""

from cmath import tanh as complex_tanh
from collections.abc import Callable
from dataclasses import dataclass
from math import pi, tanh
from typing import NamedTuple

from spacar.deck.outline import Outline
from spacar.deck.statement import Statement

TERMS = 60  # odd terms of the series: the first left out is below 1e-11 of the sum


@dataclass(frozen=True)
class SectionConstants:
    """A [m^2], Iy, Iz, It [m^4], Cw [m^6]; shear coefficients ky, kz for forces along y', z' (0: rigid in shear)."""

    A: float
    Iy: float
    Iz: float
    It: float
    ky: float
    kz: float
    Cw: float


def _right(unit: str, *dims: float) -> str:
    return ""


@dataclass(frozen=True)
class Shape:
    """A kind of section: names of its dimensions with the exponent of the metre, and its constants.

    `constants` takes the dimensions [m] and Poisson's ratio. `wrong` takes the unit of length of the file and the
    dimensions in it, and gives "" or why no section has them.
    """

    title: str
    dims: tuple[tuple[str, int], ...]
    constants: Callable[..., SectionConstants]
    wrong: Callable[..., str] = _right


def rectangle_torsion(w: float, t: float) -> float:
    """Torsion constant of a rectangle [m^4]."""
    a, b = sorted((0.5 * w, 0.5 * t))
    function: Callable[[float], float] = tanh
    if isinstance(b / a, complex):  # a direction (spacar.deck.directed)
        function = complex_tanh  # type: ignore[assignment]
    series = sum(function(n * pi * b / (2 * a)) / n**5 for n in range(1, 2 * TERMS, 2))
    return (2 * a) ** 3 * 2 * b / 3 * (1 - 192 / pi**5 * a / b * series)


def rectangle(w: float, t: float, nu: float) -> SectionConstants:
    k = 10 * (1 + nu) / (12 + 11 * nu)
    return SectionConstants(w * t, w * t**3 / 12, t * w**3 / 12, rectangle_torsion(w, t), k, k, (w * t) ** 3 / 144)


def _ring(d: float, inner: float, nu: float) -> SectionConstants:
    """Circle with a concentric hole (0: none)."""
    A, I = pi / 4 * (d**2 - inner**2), pi / 64 * (d**4 - inner**4)
    m = (inner / d) ** 2
    k = 6 * (1 + nu) * (1 + m) ** 2 / ((7 + 6 * nu) * (1 + m) ** 2 + (20 + 12 * nu) * m)
    return SectionConstants(A, I, I, 2 * I, k, k, 0.0)


def hollow_rectangle(w: float, h: float, wi: float, hi: float, nu: float) -> SectionConstants:
    """Outer w along y', h along z', inner wi, hi; k of thin walls, It by Bredt with the line midway in the walls."""
    t_w, t_h = 0.5 * (w - wi), 0.5 * (h - hi)  # walls across y' and across z'
    wm, hm = w - t_w, h - t_h
    It = 4 * (wm * hm) ** 2 / (2 * hm / t_w + 2 * wm / t_h)
    kz = _thin(wm, hm, wm * t_h / (hm * t_w), nu, box=True)
    ky = _thin(hm, wm, hm * t_w / (wm * t_h), nu, box=True)
    Iy, Iz = (w * h**3 - wi * hi**3) / 12, (h * w**3 - hi * wi**3) / 12
    return SectionConstants(w * h - wi * hi, Iy, Iz, It, ky, kz, 0.0)


def i_section(b: float, h: float, tw: float, tf: float, nu: float) -> SectionConstants:
    """Flanges b x tf along y', total height h along z', web tw; k along z' of thin walls, along y' of the flanges."""
    web = h - 2 * tf
    A = 2 * b * tf + web * tw
    Iy = (b * h**3 - (b - tw) * web**3) / 12
    Iz = (2 * tf * b**3 + web * tw**3) / 12
    It = 2 * rectangle_torsion(b, tf) + rectangle_torsion(web, tw)
    hm = h - tf
    kz = _thin(b, hm, 2 * b * tf / (hm * tw), nu, box=False)
    ky = 10 * (1 + nu) / (12 + 11 * nu) * 2 * b * tf / A
    return SectionConstants(A, Iy, Iz, It, ky, kz, tf * b**3 * hm**2 / 24)


def _thin(b: float, h: float, m: float, nu: float, *, box: bool) -> float:
    """Cowper's k of a thin-walled box or I section for a force along h; m: area of the flanges by that of the webs."""
    n = b / h
    below = 12 + 72 * m + 150 * m**2 + 90 * m**3 + nu * (11 + 66 * m + 135 * m**2 + 90 * m**3)
    if box:
        below += 10 * n**2 * ((3 + nu) * m + 3 * m**2)
    else:
        below += 30 * n**2 * (m + m**2) + 5 * nu * n**2 * (8 * m + 9 * m**2)
    return 10 * (1 + nu) * (1 + 3 * m) ** 2 / below


def _wall(unit: str, d: float, t: float) -> str:
    return "" if 2 * t < d else f"wall {t:g} {unit}, at least half of the width of the tube ({d:g} {unit})"


def _inside(unit: str, w: float, h: float, wi: float, hi: float) -> str:
    if wi < w and hi < h:
        return ""
    return f"the hole {wi:g} x {hi:g} {unit} does not fit into {w:g} x {h:g} {unit}"


def _web(unit: str, b: float, h: float, tw: float, tf: float) -> str:
    if 2 * tf >= h:
        return f"two flanges of {tf:g} {unit} do not fit into the height {h:g} {unit}"
    return "" if tw <= b else f"web {tw:g} {unit} thicker than the flanges are wide ({b:g} {unit})"


SHAPES = {
    "RECT": Shape("rectangle", (("w along y'", 1), ("t along z'", 1)), rectangle),
    "CIRC": Shape("circle", (("diameter d", 1),), lambda d, nu: _ring(d, 0.0, nu)),
    "TUBE": Shape(
        "tube", (("outer diameter d", 1), ("wall t", 1)), lambda d, t, nu: _ring(d, d - 2 * t, nu), _wall
    ),
    "RECTHOL": Shape(
        "hollow rectangle", (("w along y'", 1), ("h along z'", 1), ("inner w", 1), ("inner h", 1)), hollow_rectangle,
        _inside,
    ),
    "I": Shape(
        "I section", (("flange b along y'", 1), ("height h along z'", 1), ("web tw", 1), ("flange tf", 1)), i_section,
        _web,
    ),
    "CUSTOM": Shape(
        "constants as given", (("A", 2), ("Iy", 4), ("Iz", 4), ("It", 4), ("ky", 0), ("kz", 0), ("Cw", 6)),
        lambda *given: SectionConstants(*given[:-1]),
    ),
}  # fmt: skip


def pictured_constants(crosstype: str, dims: tuple[float, ...]) -> SectionConstants | None:
    """Constants of a cross-section as pictures name it (CROSSTYPE, with inner diameters), None for one without any."""
    nu = 0.3  # in the shear coefficients only
    if crosstype == "CIRCHOL":
        outer, inner = dims
        return _ring(outer, inner, nu)
    shape = SHAPES.get(crosstype)
    return None if shape is None else shape.constants(*dims, nu)


ZERO_ALLOWED = ("ky", "kz", "Cw")
LEAST = {"CUSTOM": 4}  # dimensions that must be given; the others are zero


@dataclass(frozen=True)
class Material:
    """E, G [N/m^2], rho [kg/m^3]."""

    E: float
    G: float
    rho: float

    @property
    def nu(self) -> float:
        """Poisson's ratio of an isotropic material, E/(2G) - 1."""
        return self.E / (2.0 * self.G) - 1.0


def isotropic(E: float, nu: float, rho: float) -> Material:
    return Material(E, E / (2.0 * (1.0 + nu)), rho)


# Handbook values at room temperature, rounded: E [N/m^2], nu, rho [kg/m^3].
MATERIALS = {
    "steel": isotropic(210e9, 0.3, 7850.0), "stainless": isotropic(193e9, 0.29, 8000.0),
    "aluminium": isotropic(70e9, 0.33, 2700.0), "titanium": isotropic(114e9, 0.34, 4430.0),
    "brass": isotropic(100e9, 0.34, 8500.0), "copper": isotropic(120e9, 0.34, 8960.0),
}  # fmt: skip


def planar_rows(s: SectionConstants, m: Material) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Values of ESTIFF and EM behind the element number for PLBEAM, which bends in its x'y' plane."""
    shear = m.E * s.Iz / (m.G * s.A * s.ky) if s.ky else 0.0
    return (m.E * s.A, m.E * s.Iz, shear), (m.rho * s.A, m.rho * s.Iz)


def spatial_rows(s: SectionConstants, m: Material) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Values of ESTIFF and EM behind the element number for BEAM."""
    shear_z = m.E * s.Iy / (m.G * s.A * s.kz) if s.kz else 0.0
    shear_y = m.E * s.Iz / (m.G * s.A * s.ky) if s.ky else 0.0
    stiffness = (m.E * s.A, m.G * s.It, m.E * s.Iy, m.E * s.Iz, shear_z, shear_y)
    return stiffness, (m.rho * s.A, m.rho * (s.Iy + s.Iz), m.rho * s.Iy, m.rho * s.Iz, 0.0)


def warping_rows(s: SectionConstants, m: Material) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Values of ESTIFF and EM behind the element number for BEAMW."""
    stiffness, mass = spatial_rows(s, m)
    return (*stiffness, m.E * s.Cw), (*mass, m.rho * s.Cw)


@dataclass(frozen=True)
class BeamSection:
    """What one BEAMSEC says: the element, its parts (the first is the element), names, shape and dimensions [m]."""

    element: int
    parts: tuple[int, ...]
    section: str
    material_name: str
    shape: str
    dims: tuple[float, ...]
    constants: SectionConstants
    material: Material

    @property
    def picture(self) -> tuple[str, tuple[float, ...]] | None:
        """CROSSTYPE and CROSSDIM of pictures, None for a shape that has none."""
        if self.shape == "TUBE":
            d, t = self.dims
            return "CIRCHOL", (d, d - 2 * t)
        return None if self.shape == "CUSTOM" else (self.shape, self.dims)


class Expansion(NamedTuple):
    """Plain statements, the outline of their model, what was expanded, and lines for pictures."""

    statements: tuple[Statement, ...]
    outline: Outline
    sections: tuple[BeamSection, ...]
    visualization: tuple[str, ...]
