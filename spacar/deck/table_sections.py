"""Keywords that describe beams by geometry: UNITS, SECTION, MATERIAL, BEAMSEC (sections.md section 1)."""

from __future__ import annotations

from spacar.deck.cross_section import MATERIALS, SHAPES
from spacar.deck.table_types import ELEMENT, BlockKind, Keyword, Parameter, form, integer, real

_K = BlockKind.KINEMATICS
UNITS = {"m": 1.0, "mm": 1e-3}
_NAME = "A name starts with a letter; capitals and small letters are the same."
_dims = tuple(real(f"dimension {k} (see below)", "", None if k == 1 else 0.0) for k in range(1, 8))


def _shape(name: str) -> str:
    shape = SHAPES[name]
    units = [f"{what}{f' [m^{power}]' if power > 1 else ''}" for what, power in shape.dims]
    return f"{name} ({shape.title}): {', '.join(units)}."


_KNOWN = [f"{name} ({m.E / 1e9:g} GPa, nu {m.nu:.3g}, {m.rho:g} kg/m^3)" for name, m in MATERIALS.items()]
KEYWORDS = (
    Keyword(
        "UNITS", _K, "unit of length of the whole file", (form((Parameter("unit: m or mm", "name"),)),), unique=0,
        notes=(
            "With mm every m in the units of this page is read as mm: lengths in mm, E in N/mm^2 (MPa), density in "
            "kg/mm^3, moments in N mm, gravity in mm/s^2. Newton, kilogram, second and radian stay, results are in SI.",
        ),
    ),
    Keyword(
        "SECTION", _K, "cross-section by its shape",
        (form((Parameter("name", "name"), Parameter("shape", "name"), *_dims), *range(3, 10)),), unique=1,
        notes=(
            _NAME, *(_shape(name) for name in SHAPES),
            "y' is the direction of the element statement, the normal of the axis in a planar model. Zero ky or kz: no"
            " shear flexibility.",
        ),
    ),
    Keyword(
        "MATERIAL", _K, "elastic material",
        (
            form(
                (
                    Parameter("name", "name"), real("Young's modulus E", "N/m^2"),
                    real("shear modulus G, or Poisson's ratio up to 0.5", "N/m^2"), real("density rho", "kg/m^3", 0.0),
                ),
            ),
        ),
        unique=1,
        notes=(
            _NAME,
            f"Known without a statement: {', '.join(_KNOWN)}.",
        ),
    ),
    Keyword(
        "BEAMSEC", _K, "section and material of a beam, and of how many equal beams it consists",
        (
            form(
                (
                    ELEMENT, Parameter("name of a section", "name"), Parameter("name of a material", "name"),
                    integer("number of beams in its place", default=1),
                ),
            ),
        ),
        unique=1,
        notes=(
            "Stands for ESTIFF and EM of the element (without a density for ESTIFF alone), which must not be given "
            "then. `spacar check --expand` prints the input without these keywords.",
            "With several beams the first one keeps the number of the element; further elements and nodes get numbers "
            "above all others. Statements about the element hold for all its beams.",
        ),
    ),
)  # fmt: skip
WORDS = frozenset(k.name for k in KEYWORDS)
