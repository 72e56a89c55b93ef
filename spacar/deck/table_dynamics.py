"""Keywords of the dynamics block: inertia, stiffness, damping, motion, loading, its increments, preload
(reference/input-language.md sections 5.1 to 5.4 and 5.6)."""

from spacar.deck.table_elements import ELEMENT_TYPES, types_that, types_with
from spacar.deck.table_types import (
    COORDINATE,
    ELEMENT,
    MODE,
    NODE,
    ORIENTATION,
    SURPLUS,
    BlockKind,
    ElementType,
    Keyword,
    Parameter,
    Variant,
    form,
    integer,
    real,
    several,
    span,
    vector,
)

_D = BlockKind.DYNAMICS

# -- inertia -----------------------------------------------------------------------------------------------

_TENSOR = vector("", "Jxx Jxy Jxz Jyy Jyz Jzz", "kg m^2", 0.0)
_MASS = (NODE, real("mass", "kg"))
_TURN = (NODE, real("moment of inertia J", "kg m^2"))
XM_FORMS = (
    form(_MASS, role="position"),
    form(_TURN, space="planar", role="orientation"),
    form((NODE, *_TENSOR), *span(2, 7), space="spatial", role="orientation"),
    form((NODE, real("warping inertia J", "kg m^4")), role="warping"),
)
_PER_LENGTH = real("mass per length", "kg/m")
_JS = vector("", "Jx'x' Jy'y' Jz'z' Jy'z'", "kg m", 0.0)
_FLOW = (
    real("tube mass per length", "kg/m"), real("fluid mass per length", "kg/m", 0.0),
    real("mass flow rate", "kg/s", 0.0), real("flow shape factor", "", 1.0), integer("end condition 0-3", default=0),
)  # fmt: skip
_WOUND = (real("angle wound over the first pulley", "rad", 0.0), real("angle wound over the second pulley", "rad", 0.0))
# Form of EM that a type names -> positions behind the element number.
MASS_FORMS = {
    "bar": (_PER_LENGTH,), "planar beam": (_PER_LENGTH, real("J per length", "kg m", 0.0)),
    "spatial beam": (_PER_LENGTH, *_JS),
    "spatial beam with warping": (_PER_LENGTH, *_JS, real("warping inertia Jw per length", "kg m^3", 0.0)),
    "belt": (_PER_LENGTH, *_WOUND), "planar tube": (*_FLOW, real("J per length", "kg m", 0.0)),
    "spatial tube": (*_FLOW, *_JS),
}  # fmt: skip


def _mass(name: str) -> Variant:
    return form((ELEMENT, *MASS_FORMS[name]), types=types_that(lambda t: t.mass == name))


# -- stiffness and damping ----------------------------------------------------------------------------------


def _coefficients(prefix: str, damping: bool) -> tuple[Variant, ...]:
    d = "d" if damping else ""
    s = " s" if damping else ""
    stretch = real(f"E{d}A", f"N{s}")
    bend2 = real(f"E{d}I", f"N m^2{s}", 0.0)
    torsion, bend_y, bend_z = (real(n, f"N m^2{s}", 0.0) for n in (f"G{d}It", f"E{d}Iy", f"E{d}Iz"))
    generic = tuple(real(f"{prefix}{i}", f"coefficient of mode {i}", None if i == 1 else 0.0) for i in range(1, 7))
    beam2: tuple[Parameter, ...] = (stretch, bend2)
    beam3: tuple[Parameter, ...] = (stretch, torsion, bend_y, bend_z)
    if not damping:
        beam2 = (*beam2, real("shear parameter EI/(GAk)", "m^2", 0.0))
        beam3 = (*beam3, real("shear parameter EIy/(GAkz)", "m^2", 0.0), real("shear parameter EIz/(GAky)", "m^2", 0.0))
    unused = () if not damping else (real("not used", "", 0.0),) * 2
    forms = {"stretch": (stretch,), "planar beam": beam2, "spatial beam": beam3}
    forms["spatial beam with warping"] = (*beam3, *unused, real(f"E{d}Cw", f"N m^4{s}", 0.0))
    forms |= {f"modes {n}": generic[:n] for n in range(1, 7)}

    def types(name: str) -> str:
        return types_that(lambda t: name == _coefficient_form(t, damping))

    return tuple(form((ELEMENT, *p), types=types(name)) for name, p in forms.items() if types(name))


def _coefficient_form(t: ElementType, damping: bool) -> str:
    """Name of the form for this type. With one coefficient a mode it says how many: slips have damping only."""
    return t.coefficients if t.coefficients != "modes" else f"modes {len(t.modes if damping else t.stiffness)}"


# -- motion ------------------------------------------------------------------------------------------------

_MOTION = (real("start value", "", 0.0), real("start rate", "1/s", 0.0), real("constant acceleration", "1/s^2", 0.0))
_FROM_X = (NODE, COORDINATE, real("start value (when left out: the value given with X, for lambda0 1)"), *_MOTION[1:])
_START_E = (
    "A start value is the deformation with respect to the configuration given with X; with DRPINBOD it is counted "
    "from the projections given there."
)
_START_ZERO = "A zero start value and rate of what is neither dynamic nor kinematic has no effect and gives a warning."

# -- loads -------------------------------------------------------------------------------------------------


def _force(text: str) -> tuple[Variant, ...]:
    force = several((f"{text}force {c}" for c in ("Fx", "Fy", "Fz")), "N")
    dual = several((f"{text}force dual to lambda{i}" for i in range(4)), "N m")
    return (
        form((NODE, *force[:2]), space="planar", role="position", components=True),
        form((NODE, *force), space="spatial", role="position"),
        form((NODE, real(f"{text}moment", "N m")), space="planar", role="orientation"),
        form((NODE, *dual), 2, 3, 5, space="spatial", role="orientation"),
        form((NODE, *vector(f"{text}moment", "Mx My Mz", "N m")), space="spatial", role="orientation"),
        form((NODE, real(f"{text}bimoment", "N m^2")), role="warping"),
    )


_XF_NOTES = (
    "Four numbers on a spatial orientation node are dual to lambda0 ... lambda3 (a moment M in the reference "
    "orientation is 0 2Mx 2My 2Mz); exactly three are a moment about the global axes; one or two are "
    "dual to lambda.",
)


def _acceleration(text: str) -> tuple[Variant, ...]:
    g = vector(text, "gx gy gz", "m/s^2", 0.0)
    return (form(g[:2], 1, 2, space="planar", components=True), form(g, 1, 2, 3, space="spatial"))


def _preload(text: str) -> tuple[Variant, ...]:
    groups: dict[int, list[str]] = {}
    for t in ELEMENT_TYPES.values():
        groups.setdefault(len(t.modes), []).append(t.keyword)
    return tuple(
        form((ELEMENT, *several(f"{text} of mode {i}" for i in range(1, n + 1))), types=" ".join(names))
        for n, names in sorted(groups.items())
    )


KEYWORDS = (
    Keyword(
        "XM", _D, "lumped mass or inertia of a node", XM_FORMS, unique=1,
        notes=(
            "Components of the tensor about the global axes in the initial configuration; Jxy etc. carry a minus sign "
            "against the products of inertia.",
        ),
    ),
    Keyword(
        "EM", _D, "distributed mass of an element", tuple(map(_mass, MASS_FORMS)), unique=1,
        notes=("End condition of a tube: 0 spherical flow at p and q, 1 jet at p, 2 jet at q, 3 jets at both.",),
    ),
    Keyword(
        "XGYRO", _D, "gyrostat: a rotor carried by an orientation node",
        (
            form(
                (
                    ORIENTATION, *vector("angular velocity", "Omega1 Omega2 Omega3", "rad/s"),
                    real("rotor inertia J", "kg m^2"), integer("type: 0 free, 1 prescribed", default=0),
                ),
                space="spatial",
            ),
        ),
        unique=1,
        notes=(
            "Free rotor: components of its absolute angular velocity; prescribed: of the constant one relative to the "
            "carrier.",
        ),
    ),
    Keyword(
        "MEE", _D, "fixed entry of the mass matrix for deformations",
        (
            form((ELEMENT, MODE, real("value on the diagonal: kg, kg m or kg m^2"))),
            form((ELEMENT, MODE, ELEMENT, MODE, real("coupling value: kg, kg m or kg m^2"))),
        ),
        unique=-1,
    ),
    Keyword(
        "ESTIFF", _D, "stiffness of an element", _coefficients("S", False), unique=1,
        notes=("Unspecified values are zero; a zero shear parameter means no shear flexibility.", SURPLUS),
    ),
    Keyword("EDAMP", _D, "damping of an element (Kelvin-Voigt)", _coefficients("Sd", True), unique=1, notes=(SURPLUS,)),
    Keyword(
        "TIMESTEP", _D, "length of the time interval and number of time steps",
        (form((real("length of the time interval", "s"), integer("number of time steps"))),), unique=0,
    ),
    Keyword(
        "INPUTX", _D, "time function of a prescribed coordinate", (form(_FROM_X, *span(2, 5)),), unique=2,
        classes=("prescribed",),
    ),
    Keyword(
        "INPUTE", _D, "time function of a prescribed deformation", (form((ELEMENT, MODE, *_MOTION)),), unique=2,
        classes=("prescribed",), notes=(_START_E,),
    ),
    Keyword(
        "STARTDX", _D, "start value of a dynamic coordinate", (form(_FROM_X[:4], *span(2, 4)),), unique=2,
        classes=("dynamic", "kinematic"), notes=(_START_ZERO,),
    ),
    Keyword(
        "STARTDE", _D, "start value of a dynamic deformation", (form((ELEMENT, MODE, *_MOTION[:2])),), unique=2,
        classes=("dynamic", "kinematic"), notes=(_START_E, _START_ZERO),
    ),
    Keyword(
        "USERINP", _D, "user function with prescribed motion", (form((Parameter("name of the function", "name"),)),),
        unique=0,
        notes=(
            "t, e, x = name(t, is), in name.py beside the input file; each row of e and x is number, mode or "
            "coordinate number, value, rate, acceleration.",
        ),
    ),
    Keyword("XF", _D, "external force on a node, constant in time", _force(""), unique=1, notes=_XF_NOTES),
    Keyword(
        "USERSIG", _D, "user function with forces and stresses", (form((Parameter("name of the function", "name"),)),),
        unique=0,
        notes=(
            "time, sig, f = name(t, ne, le, e, ep, nx, lnp, x, xp), in name.py beside the input file.",
            "Each row of sig is element number, mode number, stress [, k, d], each row of f node number, coordinate "
            "number, force [, k, d], in the numbers of the input file (from 1); sig and f may be empty. k and d are "
            "optional: dsigma/de and dsigma/d(ep), or -df/dx and -df/d(xp), for the linearized equations.",
            "e, ep (length ne) and x, xp (length nx) are all deformations and coordinates with their rates. le[i - 1, "
            "m - 1] is the place of mode m of element i in e and ep, lnp[n - 1, c - 1] that of coordinate c of node n "
            "in x and xp: places from 0 (the tables in result files count from 1), -1 for what does not exist. A "
            "negative place in e, ep, x or xp is an error, it does not read the last value.",
            "A stress on a fixed or prescribed mode has no effect, because its stress follows from equilibrium: the "
            "run gives a warning.",
        ),
    ),
    Keyword(
        "GRAVITY", _D, "acceleration of gravity", _acceleration("component"), unique=0,
        notes=("Acts on lumped and distributed mass.",),
    ),
    Keyword(
        "ESIG", _D, "preload of an element", _preload("preload stress"), unique=1,
        notes=(
            SURPLUS,
            "A preload on a fixed mode, or on a prescribed one except in mode 3, has no effect, because its stress "
            "follows from equilibrium: a warning.",
        ),
    ),
    Keyword("DELXF", _D, "increment of the force on a node", _force("increment of the "), unique=1, notes=_XF_NOTES),
    Keyword("DELGRAV", _D, "increment of the acceleration of gravity", _acceleration("increment"), unique=0),
    Keyword(
        "DELOMF", _D, "increment of the mass flow rate of a tube",
        (form((ELEMENT, real("increment of the mass flow rate", "kg/s")), types=types_with("DELOMF")),), unique=1,
    ),
    Keyword("DELESIG", _D, "increment of the preload of an element", _preload("increment of the stress"), unique=1),
    Keyword(
        "DELINPX", _D, "increment of a prescribed coordinate",
        (form((NODE, COORDINATE, real("increment of the start value"))),), unique=2, classes=("prescribed",),
    ),
    Keyword(
        "DELINPE", _D, "increment of a prescribed deformation",
        (form((ELEMENT, MODE, real("increment of the start value"))),), unique=2, classes=("prescribed",),
    ),
)  # fmt: skip
