"""Loads and properties: one function a keyword, which adds it to a model where it can act.

`fits(keyword, type)` asks the keyword table whether a statement may be about an element of a type, or one of its nodes.
"""

from __future__ import annotations

from spacar.deck import ELEMENT_TYPES
from spacar.deck.keyword_table import KEYWORDS
from spacar.deck.table_types import BlockKind, ElementType

from .growth import Growth
from .model import Along, Axial, Drive, Element, Ends, Flow, Node, Pitch, Push, Row, Side, Vector

TUBES = ("PLTUBE", "TUBE")


def keyword_row(name: str, block: int = 0):
    """The row of the table of a keyword."""
    return next(k for (n, kind), k in KEYWORDS.items() if n == name and (not block or kind.number == block))


def fits(name: str, kind: ElementType, block: int = 2) -> bool:
    """Whether the statement may be about this type, or a node of it, or is about no element at all."""
    space = "planar" if kind.planar else "spatial"
    keyword = keyword_row(name, block)
    of = keyword.variants[0].parameters[0].of if keyword.variants[0].parameters else ""
    if of == "element":
        return any(v.fits(space, "", kind.keyword) for v in keyword.variants)
    roles = kind.nodes if of.endswith("node") else ("",)
    if " " in of:  # position node, orientation node
        roles = tuple(r for r in roles if of.startswith(r))
    return any(v.fits(space, role, "") for v in keyword.variants for role in roles)


class Properties:
    """Adds statements to what has grown; `about`: element types that it prefers."""

    def __init__(self, growth: Growth, about: tuple[str, ...]) -> None:
        self.g, self.about = growth, about
        self.r = growth.rng
        self.pushes: list = []
        self.drives: list = []
        self.kind = {r[1]: r[0] for r in growth.blocks[0] if r[0] in ELEMENT_TYPES}
        self.nodes = {
            n: role
            for r in growth.blocks[0]
            if r[0] in ELEMENT_TYPES
            for n, role in zip(r[2:], ELEMENT_TYPES[r[0]].nodes, strict=False)
        }
        self.of = {r[1]: [n for n in r[2:] if isinstance(n, Node)] for r in growth.blocks[0] if r[0] in ELEMENT_TYPES}

    # -- choices ---------------------------------------------------------------------------------------------
    def elements(self, keyword: str, block: int = 2) -> list[Element]:
        """Elements that the statement may be about: preferred ones when there are any."""
        found = [e for e, k in self.kind.items() if fits(keyword, ELEMENT_TYPES[k], block)]
        return [e for e in found if self.kind[e] in self.about] or found

    def free_nodes(self, *roles: str) -> list[Node]:
        """Nodes that can move."""
        held = {r[1] for r in self.g.blocks[0] if r[0] == "FIX"}
        found = [n for n, role in self.nodes.items() if role in roles and n not in held]
        near = {n for e, k in self.kind.items() if k in self.about for n in self.of[e]}
        return [n for n in found if n in near] or found

    def given(self, keyword: str) -> set:
        return {r[1:2] for r in self.g.blocks[1] if r[0] == keyword}

    def soft(self, e: Element) -> list[int]:
        """Modes that are dynamic or released."""
        return [m for m in range(1, len(ELEMENT_TYPES[self.kind[e]].modes) + 1)
                if self.g.classes.get((e, m)) in ("DYNE", "RLSE")]  # fmt: skip

    def of_class(self, *classes: str) -> list[tuple]:
        found = [m for m in self.g.moving if m[2] in classes]
        nodes = {n for e, k in self.kind.items() if k in self.about for n in self.of[e]}
        near = [m for m in found if (self.kind[m[0]] in self.about if isinstance(m[0], Element) else m[0] in nodes)]
        return near or found

    # -- statements ------------------------------------------------------------------------------------------
    def add(self, keyword: str) -> bool:
        """Add the statement; whether there was a place for it."""
        before = [len(rows) for rows in self.g.blocks], len(self.pushes), len(self.drives)
        getattr(self, keyword.lower())()
        return before != ([len(rows) for rows in self.g.blocks], len(self.pushes), len(self.drives))

    def put(self, *row, block: int = 2) -> None:
        once = 1 if keyword_row(row[0], block).unique == 0 else 2
        if any(r[:once] == row[:once] for r in self.g.blocks[block - 1]):
            return
        self.g.add(*row, block=block)

    def one(self, found: list):
        return [self.r.choice(found)] if found else []

    def xm(self) -> None:
        for n in self.one([n for n in self.free_nodes("position", "orientation", "warping")]):
            if (n,) not in self.given("XM"):
                self.g.mass(n, role=self.nodes[n])

    def em(self) -> None:
        for e in self.elements("EM"):
            if self.kind[e] in self.about or self.g.chance(0.6):
                self.put("EM", e, *self.distributed(ELEMENT_TYPES[self.kind[e]]))

    def distributed(self, kind: ElementType) -> list:
        g = self.g
        rotary = [g.number(0.05, 0.1) for _ in range(1 if kind.planar else 3)]
        yz = [] if kind.planar else [Pitch(g.signed(0.03))]
        if kind.carries_flow:
            return [
                g.number(0.3, 0.6),
                g.number(0.2, 0.4),
                Flow(g.signed(0.3)),
                1.1,
                Ends(self.r.randrange(4)),
                *rotary,
                *yz,
            ]
        if kind.mass == "belt":
            return [g.number(0.3, 0.6), g.number(0.5, 1), g.number(0.5, 1)]
        found = [g.number(0.3, 0.6)]
        if kind.mass != "bar" and g.chance(0.7):
            found += [*rotary, *yz]
            if "warping" in kind.mass:
                found.append(g.number(0.01, 0.03))
        return found

    def xgyro(self) -> None:
        for n in self.one(self.free_nodes("orientation")):
            if not self.g.planar:
                omega = Axial(self.g.signed(1.0) for _ in range(3))
                self.put("XGYRO", n, omega, self.g.number(0.01, 0.05), self.r.randrange(2))

    def mee(self) -> None:
        found = [m for m in self.of_class("DYNE", "INPUTE") if m[1] == 1 or self.kind[m[0]] != "HINGE"]
        for e, m, _ in self.one(found):
            if not any(r[:3] == ("MEE", e, m) for r in self.g.blocks[1]):
                self.g.add("MEE", e, m, self.g.number(0.1, 0.3), block=2)

    def edamp(self) -> None:
        for e in self.elements("EDAMP"):
            kind = ELEMENT_TYPES[self.kind[e]]
            if kind.stiffness:
                self.put("EDAMP", e, *(round(0.02 * v, 4) for v in self.g.coefficients(self.kind[e], shear=False)))
            elif kind.slips:
                self.put("EDAMP", e, *(self.g.number(0.1, 0.2) for _ in kind.modes))

    def estiff(self) -> None:
        for e in self.one([e for e in self.elements("ESTIFF") if ELEMENT_TYPES[self.kind[e]].stiffness]):
            self.put("ESTIFF", e, *self.g.coefficients(self.kind[e]))

    def gravity(self) -> None:
        self.put("GRAVITY", self.g.free(0.5))

    def delgrav(self) -> None:
        self.put("DELGRAV", self.g.free(0.3))

    def force(self, keyword: str, size: float) -> None:
        for n in self.one(self.free_nodes("position", "orientation", "warping")):
            role = self.nodes[n]
            if role == "position":
                self.put(keyword, n, self.g.free(size))
            elif role == "warping":
                self.put(keyword, n, Pitch(self.g.signed(0.1 * size)))
            elif self.g.planar:
                self.put(keyword, n, Pitch(self.g.signed(0.5 * size)))
            else:
                moment = Axial(self.g.signed(0.5 * size) for _ in range(3))
                self.put(keyword, n, *(0.0, moment) if self.g.chance(0.4) else (moment,))

    def xf(self) -> None:
        self.force("XF", 0.5)

    def delxf(self) -> None:
        self.force("DELXF", 0.3)

    def preload(self, keyword: str) -> None:
        found = [e for e in self.elements(keyword) if self.soft(e)]
        for e in self.one(found):
            kind = ELEMENT_TYPES[self.kind[e]]
            modes, zero = (
                self.soft(e),
                (2, 3) if kind.keyword == "HINGE" else (3, 4, 5, 6) if kind.keyword == "SCREW" else (),
            )
            values = [
                self.g.signed(0.3) if m in modes and m not in zero else 0.0 for m in range(1, len(kind.modes) + 1)
            ]
            self.put(keyword, e, *values)

    def esig(self) -> None:
        self.preload("ESIG")

    def delesig(self) -> None:
        self.preload("DELESIG")

    def delomf(self) -> None:
        for e in self.one(self.elements("DELOMF")):
            self.put("EM", e, *self.distributed(ELEMENT_TYPES[self.kind[e]]))
            self.put("DELOMF", e, Flow(self.g.signed(0.2)))

    def motion(self, keyword: str, classes: tuple[str, ...], width: int) -> None:
        """Values of what moves: small, and so that a start position can be reached."""
        for owner, m, _ in self.of_class(*classes):
            twins = self.kind.get(owner) in ("HINGE", "SCREW") and m > 1
            if any(r[:3] == (keyword, owner, m) for r in self.g.blocks[1]) or (
                self.kind.get(owner) in ("HINGE", "SCREW") and twins
            ):
                continue
            at = [self.g.signed(0.06), *(self.g.signed(0.3) for _ in range(width - 1))]
            if self.nodes.get(owner) == "position" and isinstance(owner, Node):
                place = next(r[2] for r in self.g.blocks[0] if r[0] == "X" and r[1] == owner)
                at[0] = round(at[0] + place[m - 1], 4)
            if width > 1 and (self.g.still or (self.g.inverse and isinstance(owner, Node))):  # no steady rotation
                at = at[:1]
            self.g.add(keyword, owner, m, *at, block=2)

    def inputx(self) -> None:
        self.motion("INPUTX", ("INPUTX",), 3)

    def inpute(self) -> None:
        self.motion("INPUTE", ("INPUTE",), 3)

    def startdx(self) -> None:
        self.motion("STARTDX", ("DYNX", "KINX"), 2)

    def startde(self) -> None:
        self.motion("STARTDE", ("DYNE", "KINE"), 2)

    def increment(self, keyword: str, klass: str) -> None:
        for owner, m, _ in self.one(self.of_class(klass)):
            self.g.add(keyword, owner, m, self.g.signed(0.05), block=2)

    def delinpx(self) -> None:
        self.increment("DELINPX", "INPUTX")

    def delinpe(self) -> None:
        self.increment("DELINPE", "INPUTE")

    def kinematic(self, keyword: str, count: int = 1) -> list[Element]:
        found = self.elements(keyword, 1)
        return self.r.sample(found, min(count, len(found)))

    def ldeform(self) -> None:
        for e in self.kinematic("LDEFORM"):
            self.put("LDEFORM", e, block=1)

    def adeform(self) -> None:
        if self.g.chance(0.5) and not any(r[0] == "LDEFORM" for r in self.g.blocks[0]):
            self.put("ADEFORM", block=1)
        else:
            for e in self.kinematic("ADEFORM"):
                if ("LDEFORM", e) not in self.g.blocks[0]:
                    self.put("ADEFORM", e, block=1)

    def orpinbod(self) -> None:
        for e in self.kinematic("ORPINBOD"):
            self.put("ORPINBOD", e, *([self.g.free()] if self.g.planar else [self.g.free(), self.g.free()]), block=1)

    def drpinbod(self) -> None:
        """Projections near the true ones are told by a body whose directions are the axes."""
        for e in self.kinematic("DRPINBOD"):
            row: Row = next(r for r in self.g.blocks[0] if r[:2] == (self.kind[e], e))
            if any(r[:2] == ("ORPINBOD", e) for r in self.g.blocks[0]):
                continue
            places = {r[1]: r[2] for r in self.g.blocks[0] if r[0] == "X"}
            d = [b - a for a, b in zip(places[row[2]], places[row[4]], strict=True)]
            axes = [Vector(float(i == k) for i in range(self.g.d)) for k in range(self.g.d)]
            self.g.add("ORPINBOD", e, *axes, block=1)
            self.g.add("DRPINBOD", e, *(round(v + self.g.signed(0.02), 4) for v in d), block=1)

    def ortube(self) -> None:
        for e in self.kinematic("ORTUBE"):
            row = next(r for r in self.g.blocks[0] if r[:2] == (self.kind[e], e))
            places = {r[1]: r[2] for r in self.g.blocks[0] if r[0] == "X"}
            d = [b - a for a, b in zip(places[row[2]], places[row[4]], strict=True)]
            near = [Vector(round(v + self.g.signed(0.15), 3) for v in d) for _ in range(2)]
            if not any(isinstance(v, Vector) for v in row):
                self.g.blocks[0][self.g.blocks[0].index(row)] = (*row[:6], self.g.free(), *row[6:])
            self.g.add("ORTUBE", e, *near, self.g.free(), block=1)

    def usersig(self) -> None:
        for n in self.one(self.free_nodes("position")):
            c = self.r.randrange(1, self.g.d + 1)
            place = next(r[2] for r in self.g.blocks[0] if r[0] == "X" and r[1] == n)
            wave = 0.0 if self.g.still else self.g.signed(0.2)
            spring = self.g.number(2, 4), self.g.number(1, 2), place[c - 1], self.g.number(0.01, 0.1)
            self.pushes.append(Push(n, c, self.g.signed(0.2), wave, *spring))
        loose = [(e, m) for e in self.kind for m in self.soft(e) if m == 1 or self.kind[e] not in ("HINGE", "SCREW")]
        for e, m in self.one([p for p in loose if self.kind[p[0]] in self.about] or loose):
            self.pushes.append(Push(e, m, self.g.signed(0.2), k=-self.g.number(1, 2), d=-self.g.number(0.01, 0.1)))
        if self.pushes:
            self.put("USERSIG", "push")

    def userinp(self) -> None:
        for owner, m, _ in self.of_class("INPUTX", "INPUTE")[:: 1 if self.g.chance(0.5) else 2]:
            z0 = 0.0
            if isinstance(owner, Node) and self.nodes[owner] == "position":
                z0 = next(r[2] for r in self.g.blocks[0] if r[0] == "X" and r[1] == owner)[m - 1]
            if not any(r[0] in ("INPUTX", "INPUTE") and r[1:3] == (owner, m) for r in self.g.blocks[1]):
                self.drives.append(Drive(owner, m, z0, self.g.signed(0.05), self.g.number(2, 4)))
                self.put("USERINP", "drive")

    # -- third block -----------------------------------------------------------------------------------------
    def trajectories(self) -> None:
        """The driven angles move one after the other or together; nominal moments, reference outputs."""
        driven = self.of_class("INPUTE")
        for number in range(1, self.r.randrange(1, 3) + 1):
            self.g.add("TRAJECT", number, block=3)
            turned = {m[0] for m in self.g.moving if m[2] == "INPUTX"}
            for n in turned:
                axis = () if self.g.planar else (Axial(self.g.signed(1.0) for _ in range(3)),)
                self.g.add("TROT", n, (Side if self.g.planar else float)(self.g.signed(0.4)), *axis, block=3)
            for e, _, _ in self.r.sample(driven, self.r.randrange(1, len(driven) + 1)):
                self.g.add("TRE", e, Along(self.g.signed(0.4)), block=3)
                if int(e) not in map(int, turned):  # the front would be that of both
                    self.g.add("TRFRONT", e, self.r.randrange(3), block=3)
                if self.g.chance(0.5):
                    self.g.add("TREPMAX", e, 0.2, block=3)
            self.g.add("TRTIME", 0.5, 3, block=3)
        for i, (e, m, _) in enumerate(driven, 1):
            self.g.add("NOMS", i, e, m, block=3)
        outputs = [(k, e, m) for e, m, _ in driven for k in ("REFE", "REFEP", "REFEDP")]
        outputs += [(k, n, 1) for n in self.free_nodes("position")[:1] for k in ("REFX", "REFXP", "REFXDP")]
        for i, (k, owner, m) in enumerate(self.r.sample(outputs, 3), 1):
            self.g.add(k, i, owner, m, block=3)

    def ports(self) -> None:
        """Inputs and outputs of every kind that the model has a place for."""
        soft = [(e, m) for e in self.kind for m in self.soft(e) if self.kind[e] not in ("HINGE", "SCREW", "BEAMW")]
        free = [(n, c) for n in self.free_nodes("position")[:2] for c in range(1, self.g.d + 1)]
        given = {k: [m[:2] for m in self.of_class(k) if self.kind.get(m[0]) not in ("HINGE", "SCREW")]
                 for k in ("INPUTX", "INPUTE", "DYNX", "KINX")}  # fmt: skip
        free = [p for p in free if p not in (*given["INPUTX"], *given["KINX"])]
        inputs = [("INPUTS", p) for p in soft[:2]] + [("INPUTF", p) for p in free[:2]]
        inputs += [(k, p) for p in given["INPUTE"][:1] for k in ("INE", "INEP", "INEDP")]
        inputs += [(k, p) for p in given["INPUTX"][:1] for k in ("INX", "INXP", "INXDP")]
        outputs = [(k, p) for p in soft[:1] for k in ("OUTE", "OUTEP", "OUTEDP")]
        outputs += [(k, p) for p in free[:1] for k in ("OUTX", "OUTXP", "OUTXDP")]
        for found in (inputs, outputs):
            for i, (k, (owner, m)) in enumerate(self.r.sample(found, min(3, len(found))), 1):
                self.g.add(k, i, owner, m, block=3)


PROPERTIES: tuple[str, ...] = tuple(
    name
    for (name, block), _ in KEYWORDS.items()
    if block in (BlockKind.KINEMATICS, BlockKind.DYNAMICS) and hasattr(Properties, name.lower())
)
