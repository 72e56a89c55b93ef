"""A mechanism that grows from the ground: each step adds as many coordinates as deformations that are not released,
so that every model is well-defined whatever the random choices are.

Geometry and coefficients are of order one (m, kg, N), so that conditions stay small.
"""

from __future__ import annotations

import random
from dataclasses import dataclass
from typing import Any

from spacar.deck import ELEMENT_TYPES
from spacar.modes import MODES

from .model import Axial, Element, Model, Node, Pitch, Place, Row, Side, Tensor, Vector

BODIES = {True: ("PLRBEAM", "PLPINBOD"), False: ("RBEAM", "PINBODY")}
WHEELS = ("PLWHEEL", "WHEEL", "TWHEEL")


@dataclass(frozen=True)
class End:
    """Where something can be joined: position node, orientation node (None: a pin), place."""

    p: Node
    o: Node | None
    at: Place


class Growth:
    """Rows so far. `still`: the model shall have a stable equilibrium, so every freedom gets a stiffness."""

    def __init__(self, rng: random.Random, planar: bool, mode: int, still: bool) -> None:
        self.rng, self.planar, self.mode, self.still = rng, planar, mode, still
        self.d = 2 if planar else 3
        self.inverse = MODES[mode].third == "trajectory"  # everything that moves is prescribed: angles of hinges
        self.blocks: list[list[Row]] = [[], [], []]
        self.ends: list[End] = []
        self.driven = 0.12  # part of the freedoms that is prescribed
        self.count = [0, 0]
        self.classes: dict[tuple[int, int], str] = {}  # (element, mode): class
        self.moving: list[tuple[Node | Element, int, str]] = []  # owner, index, class of what is dynamic or prescribed

    # -- numbers ---------------------------------------------------------------------------------------------
    def number(self, low: float, high: float) -> float:
        return round(self.rng.uniform(low, high), 3)

    def signed(self, size: float) -> float:
        return round(self.rng.choice((-1, 1)) * self.rng.uniform(0.3 * size, size), 4)

    def chance(self, p: float) -> bool:
        return self.rng.random() < p

    def free(self, size: float = 1.0) -> Vector:
        return Vector(self.signed(size) for _ in range(self.d))

    def node(self) -> Node:
        self.count[0] += 1
        return Node(self.count[0])

    def add(self, *row: Any, block: int = 1) -> None:
        self.blocks[block - 1].append(row)

    def element(self, keyword: str, *nodes: Node, geometry: tuple[Any, ...] = ()) -> Element:
        self.count[1] += 1
        number = Element(self.count[1])
        self.add(keyword, number, *nodes, *geometry)
        return number

    def place(self, near: Place) -> tuple[Node, Place]:
        """A new position node, 0.5 to 1 m away."""
        while True:
            step = [self.rng.uniform(-1, 1) for _ in range(self.d)]
            length = sum(v * v for v in step) ** 0.5
            at = Place(round(a + v, 3) for a, v in zip(near, step, strict=True))
            if 0.5 < length < 1 and all(
                sum((a - b) ** 2 for a, b in zip(at, e.at, strict=True)) > 0.09 for e in self.ends
            ):
                node = self.node()
                self.add("X", node, at)
                return node, at

    def mass(self, *nodes: Node | None, role: str) -> None:
        for n in (n for n in nodes if n is not None):
            if role == "position":
                self.add("XM", n, self.number(0.5, 2), block=2)
            elif role == "warping":
                self.add("XM", n, self.number(0.02, 0.1), block=2)
            elif self.planar:
                self.add("XM", n, self.number(0.2, 0.5), block=2)
            else:
                jj = [self.number(0.2, 0.4) for _ in range(3)]
                off = [self.signed(0.05) for _ in range(3)]
                self.add("XM", n, Tensor((jj[0], off[0], off[1], jj[1], off[2], jj[2])), block=2)

    # -- classes ---------------------------------------------------------------------------------------------
    def classify(self, e: Element, mode: int, kind: str) -> None:
        """FIX (nothing to write), RLSE, DYNE or INPUTE of one mode."""
        self.classes[e, mode] = kind
        if kind != "FIX":
            self.add(kind, e, mode)
        if kind in ("DYNE", "INPUTE"):
            self.moving.append((e, mode, kind))

    def classed(self, e: Element, keyword: str, free: float) -> None:
        """Random classes of all modes of an element that holds new coordinates."""
        kind = ELEMENT_TYPES[keyword]
        pairs = {q: p for p, q in kind.split or ELEMENT_TYPES[keyword.replace("TUBE", "BEAM")].split}
        twin = {3: 2} if keyword == "HINGE" else {6: 5, 4: 3} if keyword == "SCREW" else {}
        chosen: dict[int, str] = {}
        for m in kind.classed:
            other = twin.get(m) or (pairs.get(m) if self.chance(0.9) else None)
            chosen[m] = chosen[other] if other else self.kind_of(free)
            if twin and m in (*twin, *twin.values()) and chosen[m] == "INPUTE":
                chosen[m] = "FIX"
            self.classify(e, m, chosen[m])
        self.stiffness(e, keyword)

    def kind_of(self, free: float) -> str:
        if self.inverse:
            return "FIX"
        if not self.chance(free):
            return "FIX"
        return "INPUTE" if self.chance(self.driven) else "DYNE"

    def stiffness(self, e: Element, keyword: str) -> None:
        """ESTIFF, where a mode is dynamic or released; EDAMP sometimes."""
        kind = ELEMENT_TYPES[keyword]
        classes = [self.classes.get((e, m), "FIX") for m in range(1, len(kind.modes) + 1)]
        soft = any(c in ("DYNE", "RLSE") for c in classes)
        if kind.stiffness and (soft or self.chance(0.3)) and (self.still or soft or self.chance(0.7)):
            self.add("ESTIFF", e, *self.coefficients(keyword), block=2)
        if kind.stiffness and self.chance(0.4):
            self.add("EDAMP", e, *(round(0.02 * v, 4) for v in self.coefficients(keyword, shear=False)), block=2)

    def coefficients(self, keyword: str, shear: bool = True) -> list[float]:
        kind = ELEMENT_TYPES[keyword]
        if kind.coefficients == "stretch":
            return [self.number(30, 60)]
        if "beam" in kind.coefficients:
            count = 3 if kind.planar is False else 1
            found = [self.number(60, 90), *(self.number(8, 16) for _ in range(count))]
            if "warping" in kind.coefficients:
                between = [self.number(0.01, 0.03), self.number(0.01, 0.03)] if shear else [0.0, 0.0]
                return [*found, *between, self.number(1, 3)]
            if shear and self.chance(0.3):
                found += [self.number(0.01, 0.03) for _ in range(1 if kind.planar else 2)]
            return found
        found = [self.number(8, 16) for _ in kind.stiffness]
        if keyword == "HINGE":
            found[2] = found[1]
        if keyword == "SCREW":
            found[3], found[5] = found[2], found[4]
        return found

    # -- steps -----------------------------------------------------------------------------------------------
    def ground(self, what: str = "") -> End:
        """A support: everything "fixed", or some coordinate "driven", or a "free" body on springs."""
        p, o = self.node(), self.node()
        at = Place(round(self.rng.uniform(-1, 1), 3) for _ in range(self.d))
        self.add("X", p, at)
        end = End(p, o, at)
        self.ends.append(end)
        what = what or ("free" if self.chance(0.12) else "driven" if self.chance(0.2) else "fixed")
        if self.inverse:
            what = "turned" if what == "driven" else "fixed"
        positions = range(1, self.d + 1)
        turns = (1,) if self.planar else (2, 3, 4)
        if what == "turned":  # along a trajectory
            self.add("FIX", p)
            for c in turns:
                self.coordinate(o, c, "INPUTX")
            self.add("XM", o, 0.3 if self.planar else Tensor((0.3, 0.0, 0.0, 0.3, 0.0, 0.3)), block=2)
        elif what == "fixed":
            self.add("FIX", p)
            self.add("FIX", o)
        elif what == "driven":
            moved = self.rng.choice([(p, c) for c in positions] + [(o, c) for c in turns])
            for n, every in ((p, positions), (o, turns)):
                fixed = [c for c in every if (n, c) != moved]
                if fixed:
                    self.add("FIX", n, *fixed)
            self.coordinate(*moved, "INPUTX")
        else:
            for n, every in ((p, positions), (o, turns)):
                for c in every:
                    self.coordinate(n, c, "DYNX")
            self.mass(p, role="position")
            self.mass(o, role="orientation")
        return end

    def coordinate(self, n: Node, c: int, keyword: str) -> None:
        self.add(keyword, n, c)
        self.moving.append((n, c, keyword))

    def held(self, end: End) -> None:
        """Springs to the ground for a free body: every freedom has a stiffness."""
        anchor = self.node()
        at = Place(round(a + self.signed(1.0), 3) for a in end.at)
        self.add("X", anchor, at)
        self.add("FIX", anchor)
        turn = self.node()
        self.add("FIX", turn)
        beam = "PLBEAM" if self.planar else "BEAM"
        assert end.o is not None
        self.spring(beam, anchor, turn, end.p, end.o)

    def spring(self, keyword: str, *nodes: Node) -> Element:
        """An element all of whose modes are released: stiffness and damping, no constraint."""
        e = self.element(keyword, *nodes, geometry=self.geometry(keyword, *nodes))
        for m in ELEMENT_TYPES[keyword].classed:
            self.classify(e, m, "RLSE")
        self.stiffness(e, keyword)
        return e

    def geometry(self, keyword: str, *nodes: Node) -> tuple[Any, ...]:
        """What follows the nodes in the statement."""
        if keyword in ("BEAM", "TUBE", "BEAMW"):
            y = (self.free(),) if keyword == "BEAMW" or self.chance(0.7) else ()
            return (*y, self.number(0.01, 0.03)) if self.chance(0.4) else y
        if keyword in ("HINGE", "SCREW"):
            axis = Axial(self.free())
            return (axis,) if keyword == "HINGE" else (axis, Pitch(self.signed(0.2)))
        if keyword == "PLBELT":
            return (Side(self.signed(0.15)), Side(self.signed(0.15)))
        if keyword == "PLTUBE":
            return (Side(self.signed(0.2)), Side(self.signed(0.2))) if self.chance(0.7) else ()
        if keyword in ("RBEAM", "PINBODY") and self.chance(0.5):
            return (self.free(),)
        return ()

    def beam(self, keyword: str, end: End, free: float = 0.7) -> End:
        """A beam or tube from an end with orientation to a new one."""
        q, at = self.place(end.at)
        o = self.node()
        assert end.o is not None
        if keyword == "BEAMW":
            w = self.node(), self.node()
            nodes = (end.p, end.o, w[0], q, o, w[1])
            for n, fixed in zip(w, (0.6, 0.0), strict=True):
                if self.inverse or self.chance(fixed):
                    self.add("FIX", n)
                else:
                    self.mass(n, role="warping")
        else:
            nodes = (end.p, end.o, q, o)
        e = self.element(keyword, *nodes, geometry=self.geometry(keyword, *nodes))
        self.classed(e, keyword, free)
        if keyword == "BEAMW" and not any(r[0] == "ESTIFF" and r[1] == e for r in self.blocks[1]):
            self.add("ESTIFF", e, *self.coefficients(keyword), block=2)
        self.mass(q, role="position")
        self.mass(o, role="orientation")
        return self.joined(End(q, o, at))

    def joined(self, end: End) -> End:
        self.ends.append(end)
        return end

    def body(self, keyword: str, end: End) -> End:
        """A rigid (or soft) body with a pin at its end."""
        q, at = self.place(end.at)
        assert end.o is not None
        e = self.element(keyword, end.p, end.o, q, geometry=self.geometry(keyword, end.p, end.o, q))
        self.classed(e, keyword, max(0.25, self.driven))
        self.mass(q, role="position")
        return self.joined(End(q, None, at))

    def hinge(self, end: End, free: float = 0.85) -> End:
        """A new orientation at the same place."""
        o, keyword = self.node(), "PLTOR" if self.planar else "HINGE"
        assert end.o is not None
        e = self.element(keyword, end.o, o, geometry=self.geometry(keyword, end.o, o))
        self.classify(e, 1, "INPUTE" if self.inverse else self.kind_of(free))
        if not self.planar:
            kind = "DYNE" if self.chance(0.2) and not self.inverse else "FIX"
            self.classify(e, 2, kind)
            self.classify(e, 3, kind)
        self.stiffness(e, keyword)
        self.mass(o, role="orientation")
        return self.joined(End(end.p, o, end.at))

    def turned(self, end: End) -> End:
        """A pin: a new orientation whose coordinates are dynamic, on a hinge that is a spring."""
        o, keyword = self.node(), "PLTOR" if self.planar else "HINGE"
        for c in (1,) if self.planar else (2, 3, 4):
            self.coordinate(o, c, "DYNX")
        base = next(e.o for e in self.ends if e.o is not None)
        self.spring(keyword, base, o)
        self.mass(o, role="orientation")
        return self.joined(End(end.p, o, end.at))

    def screw(self, end: End) -> End:
        q, at = self.place(end.at)
        o = self.node()
        assert end.o is not None
        nodes = (end.p, end.o, q, o)
        e = self.element("SCREW", *nodes, geometry=self.geometry("SCREW", *nodes))
        self.classed(e, "SCREW", 0.3)
        self.mass(q, role="position")
        self.mass(o, role="orientation")
        return self.joined(End(q, o, at))

    def belt(self, end: End) -> End:
        """A pulley at the end of a body: the belt turns it."""
        carrier = self.body(self.rng.choice(BODIES[True]), end)
        o = self.node()
        assert end.o is not None
        base = next(e.o for e in self.ends if e.o is not None and e.p == end.p)
        e = self.element("PLBELT", end.p, base, carrier.p, o, geometry=self.geometry("PLBELT"))
        self.classed(e, "PLBELT", 0.7)
        self.mass(o, role="orientation")
        return self.joined(End(carrier.p, o, carrier.at))

    def trussed(self) -> End:
        """A point that trusses hold."""
        base = self.rng.choice(self.ends)
        q, at = self.place(base.at)
        keyword, bases = "PLTRUSS" if self.planar else "TRUSS", [base]
        while len(bases) < self.d:
            anchor, place = self.place(at)
            self.add("FIX", anchor)
            bases.append(End(anchor, None, place))
        for b in bases:
            e = self.element(keyword, *(self.rng.choice(((b.p, q), (q, b.p)))))
            self.classed(e, keyword, 0.6)
        self.mass(q, role="position")
        return self.joined(End(q, None, at))

    def looped(self, end: End) -> None:
        """A rigid bar from the end to the ground closes a loop: a dynamic freedom of the tree becomes calculable."""
        open_ = [(n, m, k) for n, m, k in self.moving if k == "DYNE" and self.closable(n, m)]
        if not open_ or end.p in {e.p for e in self.ends[:1]}:
            return
        given = open_[-1]
        anchor, _ = self.place(end.at)
        self.add("FIX", anchor)
        self.element("PLTRUSS" if self.planar else "TRUSS", end.p, anchor)
        row = next(r for r in self.blocks[0] if r == ("DYNE", given[0], given[1]))
        self.blocks[0][self.blocks[0].index(row)] = ("RLSE", *row[1:])
        self.moving.remove(given)
        self.classes[given[0], given[1]] = "RLSE"

    def closable(self, owner: Any, mode: int) -> bool:
        """A hinge angle, or a bending mode: released it lets its end move sideways."""
        keyword = next(r[0] for r in self.blocks[0] if r[0] in ELEMENT_TYPES and r[1] == owner)
        return keyword in ("PLTOR", "HINGE") and mode == 1

    def pruned(self) -> None:
        """Leave out statements about nodes that no element uses."""
        used = {n for r in self.blocks[0] if r[0] in ELEMENT_TYPES for n in r[2:] if isinstance(n, Node)}
        for rows in self.blocks:
            rows[:] = [r for r in rows if len(r) < 2 or not isinstance(r[1], Node) or r[1] in used]
        self.moving = [m for m in self.moving if not isinstance(m[0], Node) or m[0] in used]

    def model(self, options: dict[str, Any] | None = None, **more: Any) -> Model:
        blocks = tuple(tuple(rows) for rows in self.blocks)
        return Model(blocks, mode=self.mode, options=options or {}, **more)
