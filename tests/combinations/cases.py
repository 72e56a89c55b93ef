"""The model of a seed: a mechanism, its loads, the mode and the options of its run."""

from __future__ import annotations

import random
from collections.abc import Sequence
from functools import cache

from spacar.deck import ELEMENT_TYPES
from spacar.modes import MODES

from .growth import BODIES, WHEELS, End, Growth
from .model import Axial, Model, Place, Vector
from .properties import PROPERTIES, Properties

TYPES = tuple(k for k, t in ELEMENT_TYPES.items() if t.supported)
BEAMS = {True: ("PLBEAM", "PLTUBE"), False: ("BEAM", "TUBE", "BEAMW")}
SPRINGS = {True: ("PLTRUSS", "PLBEAM"), False: ("TRUSS", "BEAM")}


def model_of(seed: int, types: Sequence[str] = (), properties: Sequence[str] = (), mode: int = 1) -> Model:
    """A random mechanism that has elements of these types and these statements where they can be."""
    rng = random.Random(f"combinations {seed} {types} {properties} {mode}")
    planar = ELEMENT_TYPES[types[0]].planar if types else rng.random() < 0.5
    row = MODES[mode]
    growth = Growth(rng, planar, mode, still=row.stationary)
    if {"INPUTE", "USERINP", "DELINPE"} & {*properties}:
        growth.driven = 0.5
    wheel = next((t for t in types if t in WHEELS), None)
    support = {"INPUTX": "driven", "DELINPX": "driven", "USERINP": "driven", "STARTDX": "free"}
    hints = [support[name] for name in properties if name in support] or [""]
    end = rolling(growth, wheel, properties) if wheel else growth.ground(rng.choice(hints))
    if not wheel and ("DYNX", end.p, 1) in growth.blocks[0]:
        growth.held(end)
    wanted = [t for t in types if t not in WHEELS] + rng.sample(kinds(planar), rng.randrange(0, 3))
    rng.shuffle(wanted)
    for keyword in wanted:
        grown(growth, keyword)
    if growth.inverse:
        growth.hinge(next(e for e in growth.ends if e.o is not None))
    if rng.random() < 0.3 and not wheel:
        growth.looped(growth.ends[-1])
    growth.pruned()
    about = Properties(growth, tuple(types))
    if wheel in ("WHEEL", "TWHEEL"):  # it stays on the ground
        growth.add("GRAVITY", Vector((0.02, 0.03, -1.0)), block=2)
    some = {"XM", "EM", "GRAVITY", "STARTDE", "STARTDX", "INPUTX", "INPUTE"} | set(rng.sample(PROPERTIES, 3))
    for name in sorted(PROPERTIES, key=lambda p: p != "USERINP"):  # before all else is prescribed by INPUTX, INPUTE
        if name in properties or (name in some and not name.startswith("DEL") and rng.random() < 0.7):
            about.add(name)
    settings(growth, any(name.startswith("DEL") for name in properties))
    {"trajectory": about.trajectories, "linearization": about.ports}.get(row.third or "", lambda: None)()
    return growth.model(pushes=tuple(about.pushes), drives=tuple(about.drives))


@cache
def kinds(planar: bool) -> list[str]:
    """Element types that a mechanism can grow by."""
    return [t for t in TYPES if ELEMENT_TYPES[t].planar == planar and t not in WHEELS]


def grown(growth: Growth, keyword: str) -> None:
    """One step with an element of this type."""
    ends = [e for e in growth.ends if e.o is not None]
    end = growth.rng.choice(ends[-2:])
    if growth.ends[-1].o is None and growth.chance(0.5) and not growth.inverse:
        end = growth.turned(growth.ends[-1])
    if keyword in BEAMS[growth.planar]:
        if growth.chance(0.12) and keyword != "BEAMW" and len({e.p for e in ends}) > 1:
            a, b = growth.rng.sample(sorted({e.p: e for e in ends}.values(), key=lambda e: e.p), 2)
            growth.spring(keyword, a.p, a.o, b.p, b.o)
        else:
            growth.beam(keyword, end)
    elif keyword in BODIES[growth.planar]:
        growth.body(keyword, end)
    elif keyword in ("PLTOR", "HINGE"):
        growth.hinge(end)
    elif keyword == "SCREW":
        growth.screw(end)
    elif keyword == "PLBELT":
        growth.belt(end)
    elif growth.chance(0.5):
        growth.trussed()
    else:
        anchor, _ = growth.place(growth.ends[-1].at)
        growth.add("FIX", anchor)
        growth.spring(keyword, growth.ends[-1].p, anchor)


def rolling(growth: Growth, keyword: str, properties: Sequence[str]) -> End:
    """A wheel on the ground, held by springs where there must be an equilibrium. It skids, or its tyre yields, where
    statements about deformations are asked for."""
    turned = bool({"INPUTX", "DELINPX"} & {*properties})
    radial = "INPUTE" if {"INPUTE", "DELINPE"} & {*properties} else "DYNE"
    yields = growth.chance(0.3) or bool({"INPUTE", "STARTDE", "DELINPE", "MEE", "ESIG", "DELESIG"} & {*properties})
    p, o = growth.node(), growth.node()
    if keyword == "PLWHEEL":
        q, spin, at = growth.node(), growth.node(), Place((0.1, 0.2))
        growth.add("X", p, at)
        growth.add("X", q, Place((0.5, 0.3)))
        growth.add("INPUTX" if turned else "DYNX", o)
        growth.add("DYNX", spin)
        growth.add("KINX", p, *((1,) if yields else (1, 2)))
        growth.moving += [(o, 1, "INPUTX" if turned else "DYNX"), (spin, 1, "DYNX"), (p, 1, "KINX")]
        if yields:
            growth.coordinate(p, 2, "DYNX")
        growth.element("PLRBEAM", p, o, q)
        e = growth.element(keyword, q, o, spin, geometry=(growth.number(0.2, 0.4), Vector((0.3, 1.0))))
        if yields:
            growth.classify(e, 2, "RLSE")
        growth.mass(p, q, role="position")
        growth.mass(o, spin, role="orientation")
    else:
        q, at = growth.node(), Place((0.1, 0.2, 0.5))
        growth.add("X", p, at)
        growth.add("X", q, Place((0.1, 0.2, 0.0)))
        slips = growth.chance(0.5)
        for c in (2, 3, 4):
            growth.coordinate(o, c, "INPUTX" if turned and c == 4 else "DYNX")
        growth.add("KINX", p, *((1,) if slips else (1, 2)))
        if slips:
            growth.add("DYNX", p, 2)
        axis = Axial((0.3, 1.0, 0.0))
        geometry = (axis,) if keyword == "WHEEL" else (0.5, 0.1, axis)
        e = growth.element(keyword, p, o, q, geometry=geometry)
        if slips:
            growth.classify(e, 6, "RLSE")
        if yields:
            growth.classify(e, 1, radial)
            growth.add("ESTIFF", e, *(growth.number(60, 90) for _ in range(6)), block=2)
        growth.add("XM", p, growth.number(5, 6), block=2)
        growth.mass(o, role="orientation")
    end = growth.joined(End(p, o, at))
    if growth.still:
        growth.held(end)
        if keyword == "PLWHEEL":
            anchor = growth.node()
            growth.add("FIX", anchor)
            growth.spring("PLTOR", anchor, spin)
    return end


def settings(growth: Growth, additional: bool) -> None:
    """TIMESTEP and ITERSTEP."""
    row = MODES[growth.mode]
    if row.integrated:
        growth.add("TIMESTEP", 0.2, 4, block=2)
        growth.add("INTEGRAT", 140, 0.025, block=2)
    if row.stationary:
        growth.add("ITERSTEP", 400, 2, 1e-12, 1, 2 if additional else 0, block=2)
