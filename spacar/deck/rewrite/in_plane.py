"""The planar model of a spatial mechanism that moves in the x-y plane.

Every element becomes its planar counterpart (`ElementType.counterpart`), with the same numbers of elements and nodes;
the axis of a hinge is z. What says something about motion out of the plane is left out when it says that there is none:
fixed or released coordinates and modes, start values of zero. With z' or y' of a beam normal to the plane, modes 5, 6
or 3, 4 are the bending modes 2, 3 (`spacar.elements.planar.plbeam`, theory-spatial.md section 3) but for a sign;
stiffness, damping and rotary inertia are those about that normal. Torsion is zero, so its coupling is left out.
"""

from collections.abc import Iterator

import numpy as np

from spacar.deck.checks_geometry import direction_of
from spacar.deck.deck import Deck, rebuilt
from spacar.deck.deck_writer import Row
from spacar.deck.keyword_table import ELEMENT_TYPES
from spacar.deck.statement import Statement, Value
from spacar.errors import UsageError

ALIKE = ("TIMESTEP", "ERROR", "ITERSTEP", "INTEGRAT", "OUTLEVEL", "MODES", "LDEFORM", "ADEFORM")
ALIGNED = 1e-9  # of a unit vector, given with the digits of a file, out of a direction
LAMBDA3 = 4  # of the Euler parameters, the one of a rotation about z


def planar(deck: Deck) -> Deck:
    """Raises UsageError when there is no such model, or the file says something that this program cannot rewrite."""
    model = _Planar(deck)
    blocks: list[list[Row]] = [[], [], []]
    for s in deck.statements:
        blocks[s.block - 1] += model.row(s)
    return rebuilt(deck, *blocks, what=" (planar)")


class _Planar:
    """Of every node whether it is a position node, of every element its planar modes: mode -> planar mode, sign."""

    def __init__(self, deck: Deck) -> None:
        self.deck = deck
        self.place = {s.integer(0): np.array(s.reals(1, 3)) for s in deck.of("X", block=1)}
        self.position: dict[int, bool] = {}
        self.modes: dict[int, dict[int, tuple[int, float]]] = {}
        self.normal_is_y: dict[int, bool] = {}
        elements = deck.of(*ELEMENT_TYPES, block=1)
        if deck.sections:  # the stresses of a section are told from the axes of its beam
            raise UsageError(f"{deck.source} has beams with sections (BEAMSEC)", "study.planar")
        for s in elements:
            kind = ELEMENT_TYPES[s.keyword]
            if not kind.counterpart:
                raise self.refusal(s)
            for k, role in enumerate(kind.nodes):
                self.position[s.integer(1 + k)] = role == "position"
        heights = {self.place.get(n, np.zeros(3))[2] for n, is_position in self.position.items() if is_position}
        if not elements or len(heights) != 1:
            raise UsageError(f"{deck.source} is no spatial model in a plane z = constant", "study.planar")
        for s in elements:
            self.modes[s.integer(0)] = self._modes(s)

    def refusal(self, s: Statement) -> UsageError:
        return UsageError(f"{self.deck.where(s)}: {s.subject} has no counterpart in the x-y plane", "study.planar")

    def _modes(self, s: Statement) -> dict[int, tuple[int, float]]:
        kind = ELEMENT_TYPES[s.keyword]
        if kind.direction is None:
            return {1: (1, 1.0)}
        given = direction_of(s, kind) or (0.0, 0.0, 1.0)
        if kind.direction[2] == "axis":
            if max(map(abs, given[:2])) > ALIGNED * abs(given[2]):
                raise self.refusal(s)
            return {1: (1, float(np.sign(given[2])))}
        p, q = (self.place.get(s.integer(i), np.zeros(3)) for i in kind.position_places)
        x = q - p
        y = np.array(given) - (np.array(given) @ x) / (x @ x) * x
        y /= np.linalg.norm(y)
        left = np.array((-x[1], x[0], 0.0)) / np.linalg.norm(x)
        self.normal_is_y[s.integer(0)] = upright = abs(y[2]) > 0.5
        if abs(y @ left if upright else y[2]) > ALIGNED:
            raise self.refusal(s)
        if not kind.split:
            return {}
        sign = -float(np.sign(y[2] if upright else y @ left))
        at_p, at_q = kind.split[0 if upright else 1]
        return {1: (1, 1.0), at_p: (2, sign), at_q: (3, sign)}

    def row(self, s: Statement) -> Iterator[Row]:
        """The statement in the plane, if it has a meaning there. Raises UsageError."""
        word, values = s.keyword, s.values
        if word in ELEMENT_TYPES:
            kind = ELEMENT_TYPES[word]
            yield kind.counterpart, *values[: 1 + len(kind.nodes)]
        elif word in ALIKE:
            yield word, *values
        elif s.block == 1 and word in ("RLSE", "DYNE", "KINE", "INPUTE"):
            modes = self.modes[s.integer(0)]
            kept = [modes[m][0] for m in s.integers(1) if m in modes]
            if kept or len(values) == 1:
                yield word, values[0], *kept
        elif s.block == 1 and word in ("FIX", "DYNX", "KINX", "INPUTX"):
            yield from self._coordinates(s)
        elif word in ("X", "XF", "DELXF", "XM", "GRAVITY", "DELGRAV"):
            yield from self._components(s)
        elif word in ("STARTDX", "INPUTX", "DELINPX") and self.position[s.integer(0)] and s.integer(1) < 3:
            yield word, *values
        elif word in ("STARTDE", "INPUTE", "DELINPE") and s.integer(1) in self.modes[s.integer(0)]:
            mode, sign = self.modes[s.integer(0)][s.integer(1)]
            yield word, values[0], mode, *(sign * v for v in s.reals(2, len(values) - 2))
        elif word in ("STARTDX", "INPUTX", "DELINPX", "STARTDE", "INPUTE", "DELINPE"):
            if any(s.reals(2, 4)):
                raise self.refusal(s)
        elif word in ("EM", "ESTIFF", "EDAMP", "ESIG", "DELESIG"):
            yield self._of_element(s)
        else:
            raise self.refusal(s)

    def _coordinates(self, s: Statement) -> Iterator[Row]:
        node, *which = s.integers()
        if self.position[node]:
            kept = [c for c in which if c < 3]
            if kept or not which:
                yield s.keyword, node, *kept
        elif not which or LAMBDA3 in which:
            yield s.keyword, node

    def _components(self, s: Statement) -> Iterator[Row]:
        """Those of a vector or, of an orientation node, of a moment or tensor of inertia."""
        head, given = (s.values[:1], s.reals(1, 6)) if s.keyword not in ("GRAVITY", "DELGRAV") else ((), s.reals(0, 3))
        if head and not self.position[s.integer(0)]:
            if s.keyword == "XM" and not given[2] and not given[4]:
                yield s.keyword, *head, given[5]
            elif s.keyword in ("XF", "DELXF") and len(s.values) == 4 and not any(given[:2]):
                yield s.keyword, *head, given[2]
            else:
                raise self.refusal(s)
        elif s.keyword == "XM":
            yield s.keyword, *s.values
        elif s.keyword != "X" and given[2]:
            raise self.refusal(s)
        else:
            yield s.keyword, *head, *given[:2]

    def _of_element(self, s: Statement) -> Row:
        number, given = s.integer(0), s.reals(1, 6)
        upright = self.normal_is_y.get(number)  # None: a truss or a hinge
        found: tuple[Value, ...] = given[:1]
        if s.keyword in ("ESIG", "DELESIG"):
            modes = self.modes[number]
            if any(v and m not in modes for m, v in enumerate(given, 1)):
                raise self.refusal(s)
            found = tuple(sign * given[m - 1] for m, (_, sign) in modes.items())
        elif s.keyword == "EM" and upright is not None:
            if given[4]:
                raise self.refusal(s)
            found += (given[2 if upright else 3],)
        elif upright is not None and self.modes[number]:
            found += (given[2 if upright else 3],)
            if s.keyword == "ESTIFF" and any(given[4:]):
                found += (given[4 if upright else 5],)
        elif upright is not None or any(given[1:]):
            raise self.refusal(s)
        return s.keyword, number, *found
