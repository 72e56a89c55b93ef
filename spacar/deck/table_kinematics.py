"""Keywords of the kinematics block other than the elements (reference/input-language.md section 4.2)."""

from spacar.deck.cross_section import MATERIALS, SHAPES
from spacar.deck.table_elements import ELEMENT_TYPES, types_with
from spacar.deck.table_types import (
    COORDINATE,
    ELEMENT,
    MODE,
    NODE,
    BlockKind,
    Keyword,
    Parameter,
    form,
    integer,
    real,
    several,
    span,
    vector,
)

_BODIES2, _BODIES3 = types_with("ORPINBOD", planar=True), types_with("ORPINBOD", planar=False)
_K5 = (
    "Without coordinate numbers: all independent coordinates of the node (x1, x2, x3; the planar angle; lambda1, "
    "lambda2, lambda3). Coordinates are numbered 1 2 3 for positions, 1 for an angle, 1 2 3 4 for lambda0 ... "
    "lambda3, 1 for a warping node."
)
_K6 = "Without mode numbers: all modes of the element."
_DEFAULT_X = "A coordinate without FIX, INPUTX, DYNX or KINX is calculable."
_DEFAULT_E = "A deformation without RLSE, INPUTE, DYNE or KINE is fixed."


_COORDINATES = (
    form((NODE, *(COORDINATE,) * 2), *span(1, 3), space="planar"),
    form((NODE, *(COORDINATE,) * 3), *span(1, 4), space="spatial", role="position"),
    form((NODE, *(COORDINATE,) * 4), *span(1, 5), space="spatial", role="orientation"),
    form((NODE, COORDINATE), 1, 2, space="spatial", role="warping"),
)
_MOST = max(len(t.modes) for t in ELEMENT_TYPES.values())
_MODES = (form((ELEMENT, *(MODE,) * _MOST), *span(1, 1 + _MOST)),)


def _class(name: str, text: str, of: str, note: str = "") -> Keyword:
    variants = _COORDINATES if of == "node" else _MODES
    notes = (_K5, _DEFAULT_X) if of == "node" else (_K6, _DEFAULT_E)
    return Keyword(name, BlockKind.KINEMATICS, text, variants, notes=(*notes, note) if note else notes)


_WHEELS = "Only for mechanisms with wheels: its rate is not an independent velocity."
_X1, _X2, _X3 = (real(f"coordinate {c}", "m", 0.0) for c in ("x1", "x2", "x3"))

KINEMATICS = (
    Keyword(
        "X", BlockKind.KINEMATICS, "position of a node in the reference configuration",
        (
            form((NODE, _X1, _X2), 2, 3, space="planar", components=True),
            form((NODE, _X1, _X2, _X3), 2, 3, 4, space="spatial"),
        ),
        notes=("Nodes without X are at the origin. Initial orientations cannot be chosen.",),
    ),
    _class("FIX", "support: coordinates that keep their reference value", "node"),
    _class("INPUTX", "coordinates that are prescribed functions of time", "node"),
    _class("DYNX", "coordinates that are dynamic degrees of freedom", "node"),
    _class("KINX", "coordinates that are kinematic configuration coordinates", "node", _WHEELS),
    _class("RLSE", "released (calculable) deformations", "element"),
    _class("INPUTE", "deformations that are prescribed functions of time", "element"),
    _class("DYNE", "deformations that are dynamic degrees of freedom", "element"),
    _class("KINE", "deformations that are kinematic configuration coordinates", "element", _WHEELS),
    Keyword(
        "LDEFORM", BlockKind.KINEMATICS, "leave out the non-linear terms in the strains of a beam",
        (form((ELEMENT,), types=types_with("LDEFORM")),),
    ),
    Keyword(
        "ADEFORM", BlockKind.KINEMATICS,
        "measure the deformations of a beam or tube by angles: elements of fourth order",
        (form((integer("element number", "element", 0),), types=types_with("ADEFORM")),), unique=1,
        notes=(
            "Without element number: all beams and tubes of the file. --beams angle and --beams sine replace it.",
            "Recommended for new models: results converge with the fourth power of the element length, with the sine "
            "measure, the default, with the second (theory-beam-order4.md). Digits of the published examples belong to"
            " the sine measure.",
        ),
    ),
    Keyword(
        "ORPINBOD", BlockKind.KINEMATICS, "measuring directions of a pinbody or rigid beam",
        (
            form((ELEMENT, *vector("direction of x',", "x y")), types=_BODIES2),
            form((ELEMENT, *vector("direction of", "x'x x'y y'x y'y")), types=_BODIES2),
            form(
                (ELEMENT, *vector("direction of x',", "x y z"), *vector("vector in the x'y' plane,", "x y z")),
                types=_BODIES3,
            ),
            form((ELEMENT, *vector("direction of", "x'x x'y x'z y'x y'y y'z z'x z'y z'z")), types=_BODIES3),
        ),
        unique=1,
        notes=(
            "Planar, two numbers: x', normalized, y' turned 90 degrees to the left; four: both vectors as they are.",
            "Spatial, six numbers: made orthonormal and completed; nine: three vectors as they are.",
        ),
    ),
    Keyword(
        "DRPINBOD", BlockKind.KINEMATICS,
        "undeformed projections of xq - xp on the directions of a pinbody or rigid beam",
        (
            form(
                (ELEMENT, *vector("undeformed projection on direction", "1 2", "m", 0.0)), 2, 3,
                types=types_with("DRPINBOD", planar=True), components=True,
            ),
            form(
                (ELEMENT, *vector("undeformed projection on direction", "1 2 3", "m", 0.0)), 2, 3, 4,
                types=types_with("DRPINBOD", planar=False),
            ),
        ),
        unique=1,
        notes=(
            "Deformations are counted from these projections: STARTDE or INPUTE with 0.1 on mode 1 means the first "
            "projection plus 0.1, whatever X says. A free deformation without STARTDE, and a fixed one, starts at "
            "zero, so that the mechanism moves from X to these projections before the analysis begins.",
        ),
    ),
    Keyword(
        "ORTUBE", BlockKind.KINEMATICS, "initial tangents and end direction of a curved spatial tube",
        (
            form(
                (
                    ELEMENT, *vector("tangent at p (local x'),", "x y z"), *vector("tangent at q,", "x y z"),
                    *vector("direction of the local y' axis at q,", "x y z"),
                ),
                types=types_with("ORTUBE"),
            ),
        ),
        unique=1,
    ),
    Keyword(
        "OUTLEVEL", BlockKind.KINEMATICS,
        "amount of output in the log and in the .sbd file (sums of flags, -1: everything)",
        (form((integer("level of the log"), integer("level of the .sbd file", default=0))),), unique=0,
        aliases=("LEVELLOG",),
        notes=(
            "Log: 1 first order transfer functions, 2 second order, 4 third order, 8 derivatives of the global "
            "deformation function (2, 4, 8: modes 4, 7, 8, 9).",
            ".sbd: 1 adds de, dx; 2 adds d2e, d2x; 3 both. Without OUTLEVEL: 0, but 1 in modes 7, 8 and 9.",
        ),
    ),
)  # fmt: skip

# -- beams by geometry: UNITS, SECTION, MATERIAL, BEAMSEC (sections.md section 1) ------------------------------------

UNITS = {"m": 1.0, "mm": 1e-3}
_NAME = "A name starts with a letter; capitals and small letters are the same."
_dims = several(f"dimension {k} (see below)" for k in range(1, 8))


def _shape(name: str) -> str:
    shape = SHAPES[name]
    units = [f"{what}{f' [m^{power}]' if power > 1 else ''}" for what, power in shape.dims]
    return f"{name} ({shape.title}): {', '.join(units)}."


_KNOWN = [f"{name} ({m.E / 1e9:g} GPa, nu {m.nu:.3g}, {m.rho:g} kg/m^3)" for name, m in MATERIALS.items()]
SECTIONS = (
    Keyword(
        "UNITS", BlockKind.KINEMATICS, "unit of length of the whole file",
        (form((Parameter("unit: m or mm", "name"),)),), unique=0,
        notes=(
            "With mm every m in the units of this page is read as mm: lengths in mm, E in N/mm^2 (MPa), density in "
            "kg/mm^3, moments in N mm, gravity in mm/s^2. Newton, kilogram, second and radian stay, results are in SI.",
        ),
    ),
    Keyword(
        "SECTION", BlockKind.KINEMATICS, "cross-section by its shape",
        (form((Parameter("name", "name"), Parameter("shape", "name"), *_dims)),), unique=1,
        notes=(
            _NAME, *(_shape(name) for name in SHAPES),
            "y' is the direction of the element statement, the normal of the axis in a planar model. Zero ky or kz: no"
            " shear flexibility.",
        ),
    ),
    Keyword(
        "MATERIAL", BlockKind.KINEMATICS, "elastic material",
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
        "BEAMSEC", BlockKind.KINEMATICS, "section and material of a beam, and of how many equal beams it consists",
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
WORDS = frozenset(k.name for k in SECTIONS)
KEYWORDS = (*KINEMATICS, *SECTIONS)
