"""A planar model with spatial elements: nodes keep to the plane by FIX, deformations out of it are released."""

from __future__ import annotations

from typing import Any

import numpy as np

from spacar.deck.rewrite.in_plane import planar
from spacar.errors import SpacarError, UsageError

from .case import GENERAL, NOTHING, Case, Found
from .model import Axial, Element, Model, Node, Place, Row, Tensor, Vector

KINDS = {"PLBEAM": "BEAM", "PLTRUSS": "TRUSS", "PLTOR": "HINGE", "PLRBEAM": "RBEAM", "PLPINBOD": "PINBODY",
         "PLTUBE": "TUBE"}  # fmt: skip
BEAMS = ("PLBEAM", "PLTUBE")
MODES = dict.fromkeys(BEAMS, (1, 5, 6)) | {"PLTRUSS": (1,), "PLTOR": (1,), "PLRBEAM": (1, 2), "PLPINBOD": (1, 2)}
OUT = dict.fromkeys(BEAMS, (2, 3, 4)) | {"PLTRUSS": (), "PLTOR": (2, 3), "PLRBEAM": (3,), "PLPINBOD": (3,)}


def as_spatial(case: Case) -> Found:
    """Positions, velocities, accelerations and forces of position nodes, stresses in the plane."""
    angle = case.model.has("ADEFORM") or case.model.options.get("beams") == "angle"
    if angle:  # rotary inertia is consistent there, lumped in space (docs/decisions.md)
        if case.model.has("BEAMSEC"):  # its sections have some
            return NOTHING
        case = Case(without_rotary_inertia(case.model), case.folder, case.rng)
    model = spatial(case.model)
    if model is None:
        return NOTHING
    try:
        result = case.run(model)
    except SpacarError as error:  # parts of divided beams need their rotary inertia
        massless = angle and case.divides and error.code == "dynamics.singular-mass"
        if error.code != "study.refine" and not massless:
            raise
        return NOTHING
    if result.mechanism.deck.divided.keys() != case.base.mechanism.deck.divided.keys():
        return NOTHING  # beams whose bending out of the plane is released without stiffness are not divided
    want, got = {}, {}
    for (kind, n, variable), v in case.values.items():
        if kind == "node" and case.model.roles[n] == "position":
            want[kind, n, variable] = v
            got[kind, n, variable] = result.node(n, variable=variable)[:, :2]
        elif kind == "element":
            keyword = case.model.types[n]
            modes = [m - 1 for m in MODES[keyword]]
            want[kind, n, variable] = v
            got[kind, n, variable] = result.element(n, variable=variable)[:, modes] * sign(keyword, np.array(modes))
    return case.same(want, got, GENERAL * case.condition)


def planar_again(case: Case) -> Found:
    """`spacar.deck.rewrite.in_plane` makes the model itself of its spatial twin."""
    model = None if case.model.pushes or case.model.drives else spatial(case.model)
    if model is None:
        return NOTHING
    try:
        deck = planar(case.deck(model))
    except UsageError:
        return NOTHING
    return case.agrees(case.result(deck), error=GENERAL * case.condition)


def sign(keyword: str, mode: Any) -> Any:
    """e5, e6 of BEAM are -e2, -e3 of PLBEAM; `mode` counts from 0."""
    return np.where((mode > 0) & (keyword in BEAMS), -1.0, 1.0)


def without_rotary_inertia(model: Model) -> Model:
    """Planar beams and tubes have none."""
    of_beams = {"PLBEAM": 3, "PLTUBE": 7}  # words of EM before it
    return model.mapped(lambda r, _: [r[: of_beams.get(model.types[r[1]], len(r))] if r[0] == "EM" else r])


def spatial(model: Model) -> Model | None:
    """None where an element has no counterpart, or a prescribed angle is no polynomial of an Euler parameter."""
    types, roles = model.types, model.roles
    turning = {n for n, role in roles.items() if role == "orientation"}
    told = (*model.pushes, *model.drives)
    if set(types.values()) - set(KINDS) or any(isinstance(p.owner, Node) and p.owner in turning for p in told):
        return None
    if any(r[1] in turning for r in model.rows("INPUTX", "DYNX", "STARTDX", "DELINPX")):
        return None
    out_of_plane = {n: (3,) if role == "position" else (2, 3) for n, role in roles.items()}

    def flat(v):
        if isinstance(v, Vector):
            return type(v)((*v, 0.0))
        return v

    def row(r, block):
        r = tuple(flat(v) for v in r)
        if r[0] in KINDS:
            e: Element = r[1]
            released = [("RLSE", e, *OUT[r[0]])] if OUT[r[0]] else []
            if r[0] == "PLTUBE":
                (px, py), (qx, qy) = (directions(model, r, angle) for angle in (*r[6:], 0.0, 0.0)[:2])
                return [("TUBE", *r[1:6], py), ("ORTUBE", e, px, qx, qy), *released]
            more = [Axial((0.0, 0.0, 1.0))] if r[0] == "PLTOR" else []
            more = [directions(model, r, 0.0)[1]] if r[0] in ("PLBEAM", "PLRBEAM") else more
            return [(KINDS[r[0]], *r[1:], *more), *released]
        if block == 3:
            return [(*r[:3], MODES[types[r[2]]][r[3] - 1]) if isinstance(r[2], Element) else r]
        if r[0] == "FIX":
            n = r[1]
            if n in turning:
                return [("FIX", n, 4)]
            return [("FIX", n, *(r[2:] or (1, 2)))]
        if block == 1 and r[0] in ("RLSE", "DYNE", "INPUTE"):
            every = MODES[types[r[1]]]
            return [(*r[:2], *([every[m - 1] for m in r[2:]] or every))]
        if r[0] in ("STARTDE", "INPUTE", "DELINPE"):
            keyword = types[r[1]]
            return [(*r[:2], MODES[keyword][r[2] - 1], *(float(v * sign(keyword, r[2] - 1)) for v in r[3:]))]
        if r[0] == "MEE":
            return [(*r[:2], MODES[types[r[1]]][r[2] - 1], *r[3:])]
        if r[0] in ("ESIG", "DELESIG"):
            values = [0.0] * 6
            for m, v in zip(MODES[types[r[1]]], r[2:], strict=False):
                values[m - 1] = float(v * sign(types[r[1]], m - 1))
            return [(*r[:2], *values[: {"PLBEAM": 6, "PLTUBE": 6, "PLTRUSS": 1}.get(types[r[1]], 3)])]
        if r[0] in ("XF", "DELXF") and r[1] in turning:
            return [(*r[:2], Axial((0.0, 0.0, float(r[2]))))]
        if r[0] == "XM" and r[1] in turning:
            return [("XM", r[1], Tensor((1.0, 0.0, 0.0, 1.0, 0.0, r[2])))]
        if r[0] == "EM" and types[r[1]] in ("PLBEAM", "PLRBEAM") and len(r) > 3:
            return [(*r[:3], 0.1, 0.1, r[3], 0.0)]
        if r[0] == "EM" and types[r[1]] == "PLTUBE" and len(r) > 7:
            return [(*r[:7], 0.1, 0.1, r[7], 0.0)]
        if r[0] in ("ESTIFF", "EDAMP") and types[r[1]] in BEAMS:
            _, ei, *shear = (*r[2:], 0.0)[: len(r[2:])] if len(r) > 3 else (r[2], 0.0)
            return [(*r[:3], 1.0, 1.0, ei, *((0.0, *shear) if shear and r[0] == "ESTIFF" else ()))]
        if r[0] == "ORPINBOD" and len(r) == 3:
            x = r[2]
            return [(*r, Vector((-x[1], x[0], 0.0)))]
        if r[0] == "ORPINBOD":
            return [(*r, Vector((0.0, 0.0, 1.0)))]
        if r[0] == "DRPINBOD":
            return [(*r, 0.0)]
        return [r]

    def lifted(p):
        if isinstance(p.owner, Node):
            return p
        keyword = types[p.owner]
        return p.turned(MODES[keyword][p.index - 1], float(sign(keyword, p.index - 1)))

    other = model.mapped(row, pushes=tuple(map(lifted, model.pushes)), drives=tuple(map(lifted, model.drives)))
    extra = [("FIX", Node(n), *which) for n, which in out_of_plane.items()]
    return other.more(1, *extra)


def directions(model: Model, r: Row, angle: float) -> tuple[Vector, Vector]:
    """Of the axis of a planar element at the start, turned by the angle, and the normal to its left, which is y'."""
    places = {s[1]: s[2] for s in model.rows("X", block=1)}
    zero = Place((0.0, 0.0))
    x = np.subtract(places.get(r[4], zero), places.get(r[2], zero))
    c, s = np.cos(angle), np.sin(angle)
    a, b = float(c * x[0] - s * x[1]), float(s * x[0] + c * x[1])
    return Vector((a, b, 0.0)), Vector((-b, a, 0.0))
