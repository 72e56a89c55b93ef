"""The same model written in another way, and how its results come back: relations that need no reference.

A transformation gives the other model and a `Back`: what of its result is what of the first one.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from spacar.deck import ELEMENT_TYPES

from .model import Axial, Element, Ends, Flow, Model, Node, Pitch, Place, Row, Side, Tensor, Vector

MIRRORED = {
    "PLBEAM": (1, -1, -1), "PLTUBE": (1, -1, -1), "PLTOR": (-1,), "BEAM": (1, -1, -1, -1, 1, 1), "PLWHEEL": (-1, 1),
    "TUBE": (1, -1, -1, -1, 1, 1), "BEAMW": (1, -1, -1, -1, 1, 1, -1, -1), "SCREW": (1, -1, 0, 0, 0, 0),
    "HINGE": (1, 0, 0), "WHEEL": (1, -1, 1, 1, 1, -1), "TWHEEL": (1, -1, 1, 1, 1, -1),
}  # fmt: skip
"""Sign of every deformation in the mirror; 0: its direction is not one of the model. All others: 1."""
EXCHANGED = {
    "PLBEAM": (1, -3, -2), "PLTUBE": (1, -3, -2), "PLTOR": (-1,), "BEAM": (1, 2, -4, -3, 6, 5), "HINGE": (1, 0, 0),
    "TUBE": (1, 2, -4, -3, 6, 5), "BEAMW": (1, 2, -4, -3, 6, 5, -8, -7), "PLBELT": (1,), "TRUSS": (1,), "PLTRUSS": (1,),
}  # fmt: skip
"""Which deformation (from 1) with which sign is the one of the first model after p and q are exchanged."""
QUARTER = {k: (1, 2, -5, -6, 3, 4) for k in ("BEAM", "TUBE")} | {"BEAMW": (1, 2, -5, -6, 3, 4, 7, 8)}
"""The same when z' takes the place of y'."""
POSITIONS = ("FIX", "INPUTX", "DYNX", "KINX")


@dataclass(frozen=True)
class Back:
    """How results of the other model are those of the first: numbers, frame of reference, deformations.

    turn  columns are the images of the axes;  shift  of positions;  modes  keyword -> deformations with sign, from 1
    """

    nodes: dict[int, int] = field(default_factory=dict)
    elements: dict[int, int] = field(default_factory=dict)
    turn: Any = None
    shift: Any = 0.0
    modes: dict[str, tuple[int, ...]] = field(default_factory=dict)

    def node(self, role: str, values: np.ndarray, positions: bool) -> np.ndarray:
        """(steps, coordinates) of a node in the frame of the first model."""
        if role == "position":
            values = values - self.shift * positions
            return values if self.turn is None else values @ self.turn
        if self.turn is None:
            return values
        sense = np.linalg.det(self.turn)
        if values.shape[1] == 4:
            return np.hstack([values[:, :1], sense * values[:, 1:] @ self.turn])
        return sense * values

    def element(self, keyword: str, values: np.ndarray) -> np.ndarray:
        """(steps, modes) of an element; nan where nothing is known."""
        order = self.modes.get(keyword)
        if order is None:
            return values
        found = [np.sign(k) * values[:, abs(k) - 1] if k else np.full(len(values), np.nan) for k in order]
        return np.stack(found, 1)


# -- numbers and order -----------------------------------------------------------------------------------------


def renumbered(model: Model, rng: random.Random) -> tuple[Model, Back]:
    """Other numbers for nodes and elements, some of them equal to each other and to other integers."""
    nodes, elements = sorted(model.roles), sorted(model.types)
    spread = rng.choice((1, 1, 3))
    to = dict(zip(nodes, rng.sample(range(1, spread * len(nodes) + 1), len(nodes)), strict=True))
    if model.has("TRFRONT"):  # names an element or a node with a path: both would have its front
        to = {old: 100 + new for old, new in to.items()}
    te = dict(zip(elements, rng.sample(range(1, spread * len(elements) + 1), len(elements)), strict=True))

    def new(v: Any) -> Any:
        return Node(to[v]) if isinstance(v, Node) else Element(te[v]) if isinstance(v, Element) else v

    pushes = tuple(replace(p, owner=new(p.owner)) for p in model.pushes)
    drives = tuple(replace(d, owner=new(d.owner)) for d in model.drives)
    changed = model.mapped(lambda r, b: [tuple(map(new, r))], pushes=pushes, drives=drives)
    return changed, Back(to, te)


def reordered(model: Model, rng: random.Random) -> tuple[Model, Back]:
    """Statements in another order; those of a trajectory stay together."""
    blocks = tuple(rows if ("TRAJECT", 1) in rows else tuple(rng.sample(rows, len(rows))) for rows in model.blocks)
    return replace(model, blocks=blocks), Back()


# -- frame of reference ----------------------------------------------------------------------------------------


def turned(model: Model, rng: random.Random) -> tuple[Model, Back]:
    """Axes exchanged and their senses changed: turns by quarters, mirrors, both; and moved."""
    d = 2 if model.planar else 3
    ground = model.has("WHEEL", "TWHEEL")
    order = [*rng.sample(range(2), 2), 2] if ground else rng.sample(range(d), d)
    signs = [rng.choice((-1, 1)) for _ in range(d)]
    if ground:
        signs[2] = 1
    turn = np.zeros((d, d))
    for i, (k, s) in enumerate(zip(order, signs, strict=True)):
        turn[k, i] = s
    shift = np.array([rng.randint(-8, 8) / 4 for _ in range(d)])
    if ground:
        shift[2] = 0.0
    return moved(model, turn, shift)


def moved(model: Model, turn: np.ndarray, shift: np.ndarray) -> tuple[Model, Back]:
    """x -> turn x + shift, where every axis becomes an axis."""
    roles, sense = model.roles, round(float(np.linalg.det(turn)))
    axis = [int(np.argmax(np.abs(c))) for c in turn.T]
    sign = [float(c[k]) for c, k in zip(turn.T, axis, strict=True)]

    def vector(v: Vector) -> Vector:
        if isinstance(v, Tensor):
            j = np.array([[v[0], v[1], v[2]], [v[1], v[3], v[4]], [v[2], v[4], v[5]]])
            j = turn @ j @ turn.T
            return Tensor(j[np.triu_indices(3)].tolist())
        values = turn @ np.array(v) * (sense if isinstance(v, Axial) else 1) + (shift if isinstance(v, Place) else 0)
        return type(v)((values + 0.0).tolist())

    def coordinate(node: int, c: int) -> tuple[int, float, float]:
        """Coordinate of the other model, its sign and shift."""
        role = roles[node]
        if role == "position":
            return axis[c - 1] + 1, sign[c - 1], float(shift[axis[c - 1]])
        if role == "orientation" and not model.planar:
            return (1, 1.0, 0.0) if c == 1 else (axis[c - 2] + 2, sense * sign[c - 2], 0.0)
        return 1, float(sense), 0.0

    def row(r: Row, block: int) -> list[Row]:
        r = tuple(
            type(v)(sense * v) if isinstance(v, Pitch | Side) else vector(v) if isinstance(v, Vector) else v for v in r
        )
        if block == 1 and r[0] in POSITIONS:
            return [(*r[:2], *sorted(coordinate(r[1], c)[0] for c in r[2:]))]
        if block == 2 and r[0] in ("INPUTX", "STARTDX", "DELINPX"):
            c, s, moved_by = coordinate(r[1], r[2])
            first = s * r[3] + (moved_by if r[0] != "DELINPX" else 0.0)
            return [(*r[:2], c, first, *(s * v for v in r[4:]))]
        if block == 3 and r[0] == "TRE" and sense < 0:
            return [(*r[:2], type(r[2])(MIRRORED.get(model.types[r[1]], (1,))[0] * r[2]))]
        if block == 3 and len(r) == 4 and isinstance(r[2], Node):
            return [(*r[:3], coordinate(r[2], r[3])[0])]
        if r[0] in ("ESIG", "DELESIG", "STARTDE", "INPUTE", "DELINPE") and block == 2 and sense < 0:
            return [with_signs(r, MIRRORED.get(model.types[r[1]], (1,) * 8))]
        return [r]

    pushes = tuple(turned_function(p, coordinate, model, sense) for p in model.pushes)
    drives = tuple(turned_function(p, coordinate, model, sense) for p in model.drives)
    other = explicit(model).mapped(row, pushes=pushes, drives=drives)
    signs = {k: tuple(s * m if s else 0 for m, s in enumerate(v, 1)) for k, v in MIRRORED.items()}
    free = {k: v for k, v in signs.items() if 0 in v} if sense > 0 else signs
    free = {k: tuple(abs(m) for m in v) for k, v in free.items()} if sense > 0 else free
    return other, Back(turn=turn, shift=shift, modes=free)


def with_signs(r: Row, signs: tuple[int, ...]) -> Row:
    if r[0] in ("ESIG", "DELESIG"):
        return (*r[:2], *(s * v for s, v in zip(signs, r[2:], strict=False)))
    return (*r[:3], *(signs[r[2] - 1] * v for v in r[3:]))


def turned_function(p: Any, coordinate: Any, model: Model, sense: int) -> Any:
    """What a user function says about a node or an element."""
    if isinstance(p.owner, Node):
        return p.turned(*coordinate(p.owner, p.index))
    sign = MIRRORED.get(model.types[p.owner], (1,) * 8)[p.index - 1] if sense < 0 else 1
    return p.turned(p.index, sign)


def explicit(model: Model) -> Model:
    """Directions that the program chooses, written down: of bodies, by the rules of the input language."""
    places = {r[1]: r[2] for r in model.rows("X", block=1)}
    zero = Place((0.0,) * (2 if model.planar else 3))
    given = {r[1]: r[2:] for r in model.rows("ORPINBOD")}

    def row(r: Row, block: int) -> list[Row]:
        if r[0] == "ORPINBOD":
            return []
        if r[0] in ("BEAM", "TUBE", "RBEAM"):
            p, q = (r[2], r[4])
            line = unit(np.subtract(places.get(q, zero), places.get(p, zero)))
            n = 5 if r[0] == "RBEAM" else 6
            if not any(isinstance(v, Vector) for v in r):
                r = (*r[:n], Vector(np.eye(3)[farthest(line)].tolist()), *r[n:])
        if r[0] not in ("PLPINBOD", "PLRBEAM", "PINBODY", "RBEAM"):
            return [r]
        line = np.subtract(places.get(r[4], zero), places.get(r[2], zero))
        axes = directions(r[0], line, [np.array(v) for v in r[5:]], [np.array(v) for v in given.get(r[1], ())])
        return [r, ("ORPINBOD", r[1], *(Vector(a.tolist()) for a in axes))]

    return model.mapped(row)


def farthest(x: np.ndarray) -> int:
    """The basis vector that makes the largest angle with x; of equals the last."""
    return max(range(3), key=lambda i: (-round(abs(x[i]), 9), i))


def directions(keyword: str, line: np.ndarray, hint: list[np.ndarray], given: list[np.ndarray]) -> list[np.ndarray]:
    """Measuring directions of a body (input-language.md notes k1, k4, k7)."""
    if len(line) == 2:
        if len(given) == 2:
            return given
        if not given and keyword == "PLPINBOD":
            return [np.array([1.0, 0.0]), np.array([0.0, 1.0])]
        x = unit(given[0] if given else line)
        return [x, np.array([-x[1], x[0]])]
    if len(given) == 3:
        return given
    if not given and not hint and keyword == "PINBODY":
        return list(np.eye(3))
    x = unit(given[0] if given else line)
    if given:
        y = given[1]
    elif hint:
        y = hint[0]
    else:
        y = np.eye(3)[farthest(x)]
    y = unit(y - (y @ x) * x)
    return [x, y, np.cross(x, y)]


def unit(v: np.ndarray) -> np.ndarray:
    return v / np.linalg.norm(v)


# -- p and q ---------------------------------------------------------------------------------------------------


def exchanged(model: Model, rng: random.Random) -> tuple[Model, Back]:
    """p and q of every element that has two equal ends; of hinges only where they do not yield. (A screw has its axis
    in the body at p.)"""
    soft = {r[1] for r in model.rows("DYNE", "RLSE") for m in r[2:] if model.types[r[1]] == "HINGE" and m > 1}
    kinds = {k for k in set(model.types.values()) & set(EXCHANGED) if rng.random() < 0.7}
    chosen = {e for e, k in model.types.items() if k in kinds}
    if any(e in soft for e in chosen) or not chosen:
        kinds -= {"HINGE"}
        chosen = {e for e, k in model.types.items() if k in kinds}

    def statement(r: Row) -> Row:
        if r[0] in ELEMENT_TYPES:
            return swapped(r)
        if r[0] == "ORTUBE":
            p, q, _y = r[2:]
            own = next(s for s in model.blocks[0] if s[:2] == ("TUBE", r[1]))
            return (*r[:2], negative(q), negative(p), own[6])
        if r[0] == "TRE":
            return (*r[:2], type(r[2])(np.sign(EXCHANGED[model.types[r[1]]][0]) * r[2]))
        if r[0] == "EM":
            return (*r[:2], *exchanged_mass(model.types[r[1]], r[2:]))
        return (*r[:2], Flow(-r[2])) if r[0] == "DELOMF" else r

    def end_of_tube(r: Row, block: int) -> list[Row]:
        """y' at q of a curved tube becomes that of p."""
        if r[0] == "TUBE" and r[1] in chosen:
            y = [s[4] for s in model.rows("ORTUBE") if s[1] == r[1]]
            return [(*r[:6], *y, *r[7:])] if y else [r]
        return [r]

    order = {e: EXCHANGED[model.types[e]] for e in chosen}
    return with_order(model, order, statement).mapped(end_of_tube), Back(modes={k: EXCHANGED[k] for k in kinds})


def quartered(model: Model, rng: random.Random) -> tuple[Model, Back]:
    """z' of every spatial beam where y' was: what belonged to one plane of bending belongs to the other one."""
    places = {r[1]: r[2] for r in model.rows("X", block=1)}
    zero = Place((0.0,) * 3)
    kinds = set(model.types.values()) & set(QUARTER)
    kinds -= {model.types[r[1]] for r in model.rows("BEAMSEC")}  # sides of a section are not exchanged here
    chosen = {e: QUARTER[k] for e, k in model.types.items() if k in kinds}

    def statement(r: Row) -> Row:
        if r[0] in ELEMENT_TYPES:
            n = len(ELEMENT_TYPES[r[0]].nodes)
            line = next((s[2] for s in model.rows("ORTUBE") if s[1] == r[1]), None)
            if line is None:
                line = np.subtract(places.get(r[2 + n // 2], zero), places.get(r[2], zero))
            return (*r[: 2 + n], Vector(np.cross(line, r[2 + n]).tolist()), *r[3 + n :])
        if r[0] == "ORTUBE":
            return (*r[:4], Vector(np.cross(r[3], r[4]).tolist()))
        if r[0] in ("ESTIFF", "EDAMP"):
            v = [*r[2:]]
            v[2:4] = v[3], v[2]
            if len(v) > 5:
                v[4:6] = v[5], v[4]
            return (*r[:2], *v)
        if r[0] == "EM":
            v = [*r[2:]]
            for i in (i for i, value in enumerate(v) if isinstance(value, Pitch)):
                v[i - 2 : i + 1] = v[i - 1], v[i - 2], Pitch(-v[i])
            return (*r[:2], *v)
        return r

    return with_order(explicit(model), chosen, statement), Back(modes={k: QUARTER[k] for k in kinds})


def with_order(model: Model, order: dict[int, tuple[int, ...]], statement: Callable[[Row], Row]) -> Model:
    """Deformations of these elements in another order and sense; `statement` changes the rows about no deformation."""

    def row(r: Row, block: int) -> list[Row]:
        if len(r) < 2 or not isinstance(r[1], Element) or r[1] not in order:
            if block == 3 and len(r) == 4 and isinstance(r[2], Element) and r[2] in order:
                return [(*r[:3], abs(order[r[2]][r[3] - 1]))]
            return [r]
        own = order[r[1]]
        if r[0] in ("ESIG", "DELESIG"):
            values = dict.fromkeys(range(1, 1 + len(own)), 0.0)
            values |= {abs(k): float(np.sign(k)) * v for k, v in zip(own, r[2:], strict=False) if k}
            return [(*r[:2], *values.values())]
        if r[0] in ("RLSE", "DYNE", "INPUTE", "KINE") and block == 1:
            return [(*r[:2], *(abs(own[m - 1]) or m for m in r[2:]))]
        if r[0] in ("STARTDE", "INPUTE", "DELINPE", "MEE"):
            k = own[r[2] - 1]
            values = r[3:] if r[0] == "MEE" else tuple(np.sign(k) * v for v in r[3:])
            return [(*r[:2], abs(k), *values)]
        return [statement(r)]

    def about(p: Any) -> Any:
        if isinstance(p.owner, Node) or p.owner not in order:
            return p
        k = order[p.owner][p.index - 1]
        return p.turned(abs(k), float(np.sign(k)))

    return model.mapped(row, pushes=tuple(map(about, model.pushes)), drives=tuple(map(about, model.drives)))


def swapped(r: Row) -> Row:
    """The statement of an element with p and q exchanged."""
    kind = ELEMENT_TYPES[r[0]]
    n = len(kind.nodes)
    nodes, rest = r[2 : 2 + n], list(r[2 + n :])
    if r[0] == "HINGE":
        rest[0] = Axial(-v for v in rest[0])
    elif r[0] == "PLBELT":
        rest = [Side(-rest[1]), Side(-rest[0])]
    elif r[0] == "PLTUBE":
        rest.reverse()
    return (*r[:2], *nodes[n // 2 :], *nodes[: n // 2], *rest)


def negative(v: Vector) -> Vector:
    return Vector(-c for c in v)


def exchanged_mass(keyword: str, values: tuple[Any, ...]) -> list[Any]:
    """Flow in the other direction, ends exchanged, Jy'z' about axes of which one has turned; wound angles."""
    if keyword == "PLBELT":
        return [values[0], values[2], values[1]]
    flipped = {Flow: lambda v: Flow(-v), Pitch: lambda v: Pitch(-v), Ends: lambda v: Ends((v >> 1) | ((v & 1) << 1))}
    return [flipped[type(v)](v) if type(v) in flipped else v for v in values]
