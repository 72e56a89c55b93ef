"""Keywords of the dynamics block: loading, its increments, preload (reference/input-language.md sections 5.2, 5.3 and
5.6)."""

from __future__ import annotations

from spacar.deck.table_elements import ELEMENT_TYPES, types_with
from spacar.deck.table_types import (
    COORDINATE,
    ELEMENT,
    MODE,
    NODE,
    SURPLUS,
    BlockKind,
    Keyword,
    Parameter,
    Variant,
    form,
    real,
    vector,
)

_D = BlockKind.DYNAMICS


def _force(text: str) -> tuple[Variant, ...]:
    force = tuple(real(f"{text}force {c}", "N", None if c == "Fx" else 0.0) for c in ("Fx", "Fy", "Fz"))
    dual = tuple(real(f"{text}force dual to lambda{i}", "N m", None if i == 0 else 0.0) for i in range(4))
    return (
        form((NODE, *force[:2]), 2, 3, space="planar", role="position", components=True),
        form((NODE, *force), 2, 3, 4, space="spatial", role="position"),
        form((NODE, real(f"{text}moment", "N m")), 2, space="planar", role="orientation"),
        form((NODE, *dual), 2, 3, 5, space="spatial", role="orientation"),
        form((NODE, *vector(f"{text}moment", "Mx My Mz", "N m")), 4, space="spatial", role="orientation"),
        form((NODE, real(f"{text}bimoment", "N m^2")), 2, role="warping"),
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
        form(
            (ELEMENT, *(real(f"{text} of mode {i}", "", None if i == 1 else 0.0) for i in range(1, n + 1))),
            types=" ".join(names),
        )
        for n, names in sorted(groups.items())
    )


KEYWORDS = (
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
