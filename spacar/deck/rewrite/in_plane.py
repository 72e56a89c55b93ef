"""The planar model of a spatial mechanism that moves in the x-y plane.

BEAM, TRUSS, HINGE about z and RBEAM become PLBEAM, PLTRUSS, PLTOR and PLRBEAM with the same numbers of elements and
nodes. What says something about motion out of the plane is left out when it says that there is none: fixed or released
coordinates and modes, start values of zero. With z' or y' of a beam normal to the plane, modes 5, 6 or 3, 4 are the
bending modes 2, 3 (`spacar.elements.planar.plbeam`, theory-spatial.md section 3) but for a sign; stiffness, damping and
rotary inertia are those about that normal.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from spacar.arrays import Array
from spacar.deck.deck import Deck
from spacar.deck.keyword_table import ELEMENT_TYPES
from spacar.deck.rewrite.rebuild import Row, rebuilt
from spacar.deck.statement import Statement, Value
from spacar.errors import UsageError

COUNTERPARTS = {"BEAM": "PLBEAM", "TRUSS": "PLTRUSS", "HINGE": "PLTOR", "RBEAM": "PLRBEAM"}
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
            if s.keyword not in COUNTERPARTS:
                raise self.refusal(s)
            for k, role in enumerate(ELEMENT_TYPES[s.keyword].nodes):
                self.position[s.integer(1 + k)] = role == "position"
        heights = {self.place.get(n, np.zeros(3))[2] for n, is_position in self.position.items() if is_position}
        if not elements or len(heights) != 1:
            raise UsageError(f"{deck.source} is no spatial model in a plane z = constant", "study.planar")
        for s in elements:
            self.modes[s.integer(0)] = self._modes(s)

    def refusal(self, s: Statement) -> UsageError:
        return UsageError(f"{self.deck.where(s)}: {s.subject} has no counterpart in the x-y plane", "study.planar")

    def _modes(self, s: Statement) -> dict[int, tuple[int, float]]:
        number, x = s.integer(0), np.zeros(3)
        if s.keyword == "TRUSS":
            return {1: (1, 1.0)}
        if s.keyword == "HINGE":
            x[:] = s.reals(3, 3)
            if max(abs(x[:2])) > ALIGNED * abs(x[2]):
                raise self.refusal(s)
            return {1: (1, float(np.sign(x[2])))}
        ends = [s.integer(1 + k) for k, role in enumerate(ELEMENT_TYPES[s.keyword].nodes) if role == "position"]
        x = self.place.get(ends[1], x) - self.place.get(ends[0], x)
        given = len(s.values) > (6 if s.keyword == "BEAM" else 4)
        y = _normalized(np.array(s.reals(5 if s.keyword == "BEAM" else 4, 3) if given else (0.0, 0.0, 1.0)), x)
        left = np.array((-x[1], x[0], 0.0)) / np.linalg.norm(x)
        self.normal_is_y[number] = upright = abs(y[2]) > 0.5
        if (s.keyword == "BEAM" and s.real(8 if given else 5)) or abs(y @ left if upright else y[2]) > ALIGNED:
            raise self.refusal(s)
        if s.keyword == "RBEAM":
            return {}
        if upright:
            return {1: (1, 1.0), 3: (2, -float(np.sign(y[2]))), 4: (3, -float(np.sign(y[2])))}
        return {1: (1, 1.0), 5: (2, -float(np.sign(y @ left))), 6: (3, -float(np.sign(y @ left)))}

    def row(self, s: Statement) -> Iterator[Row]:
        """The statement in the plane, if it has a meaning there. Raises UsageError."""
        word, values = s.keyword, s.values
        if word in COUNTERPARTS:
            yield COUNTERPARTS[word], *values[: 1 + len(ELEMENT_TYPES[word].nodes)]
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


def _normalized(v: Array, x: Array) -> Array:
    """The unit vector of v normal to x."""
    y = v - (v @ x) / (x @ x) * x
    return y / np.linalg.norm(y)
