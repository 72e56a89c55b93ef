"""Numbering of coordinates and deformations, exactly as files.md section 3 states it.

x is ordered by class: fixed, calculable, input, dynamic, kinematic; inside a class by node, then coordinate.
e is ordered by class: fixed (the normalizations of Euler parameters last, by node), input, dynamic, kinematic,
calculable; inside a class by element, then mode. With this order every class is a slice.
The tables lnp, le, ln hold the 1-based numbers that result files show; 0 means "does not exist".
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import accumulate
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import Index
from spacar.deck import ELEMENT_TYPES, coordinates_of

CLASSES = ("fixed", "calculable", "input", "dynamic", "kinematic")
E_ORDER = ("fixed", "input", "dynamic", "kinematic", "calculable")
ABSENT = -1  # class of a coordinate or deformation that does not exist


class Node(NamedTuple):
    """One node: kind 'position', 'orientation' or 'warping', and how many coordinates it has."""

    number: int
    kind: str
    size: int


@dataclass(frozen=True)
class Numbering:
    """Where everything is. `nodes` and `elements` are sorted by user number."""

    planar: bool
    nodes: tuple[Node, ...]
    elements: tuple[tuple[int, str, tuple[int, ...]], ...]  # number, keyword, node numbers
    nxp: Index  # (5,) coordinates per class in the order of CLASSES
    nep: Index  # (5,) deformations per class in the order of CLASSES
    lnp: Index  # (highest node, 4)
    le: Index  # (highest element, 6; 8 in a model with warping)
    ln: Index  # (highest element, 4; 6 in a model with warping)
    it: Index  # (highest element,) type codes
    normalization: Index  # (n spatial orientation nodes, 2): node number, 0-based row of e
    slips: NDArray[np.bool_] = field(repr=False)  # (ne,) rows that exist as rates only

    @cached_property
    def nx(self) -> int:
        return int(self.nxp.sum())

    @cached_property
    def ne(self) -> int:
        return int(self.nep.sum())

    def _slices(self, counts: Mapping[str, int], order: Sequence[str]) -> dict[str, slice]:
        edges = list(accumulate((counts[c] for c in order), initial=0))
        return {c: slice(a, b) for c, a, b in zip(order, edges, edges[1:], strict=False)}

    @cached_property
    def x_class(self) -> dict[str, slice]:
        return self._slices(dict(zip(CLASSES, self.nxp.tolist(), strict=True)), CLASSES)

    @cached_property
    def e_class(self) -> dict[str, slice]:
        return self._slices(dict(zip(CLASSES, self.nep.tolist(), strict=True)), E_ORDER)

    @cached_property
    def _x_names(self) -> list[tuple[int, int]]:
        names = [(0, 0)] * self.nx
        for number_, row in enumerate(self.lnp, 1):
            for coordinate, i in enumerate(row, 1):
                if i:
                    names[i - 1] = (number_, coordinate)
        return names

    @cached_property
    def _e_names(self) -> list[tuple[int, int]]:
        names = [(0, 0)] * self.ne
        for element, row in enumerate(self.le, 1):
            for mode, i in enumerate(row, 1):
                if i:
                    names[i - 1] = (element, mode)
        for node, i in self.normalization:
            names[i] = (-int(node), 0)
        return names

    @cached_property
    def keyword(self) -> dict[int, str]:
        return {number: keyword for number, keyword, _ in self.elements}

    @cached_property
    def kind(self) -> dict[int, str]:
        return {node.number: node.kind for node in self.nodes}

    def x_owner(self, i: int) -> tuple[int, int]:
        """(node, coordinate number) of the 0-based coordinate i."""
        return self._x_names[i]

    def e_owner(self, i: int) -> tuple[int, int]:
        """(element, mode number) of the 0-based deformation i; (-node, 0) for a normalization."""
        return self._e_names[i]

    def x_name(self, i: int) -> str:
        node, coordinate = self._x_names[i]
        if self.kind[node] == "position":
            return f"node {node} {'xyz'[coordinate - 1]}"
        if self.kind[node] == "warping":
            return f"node {node} w"
        return f"node {node} phi" if self.planar else f"node {node} lambda{coordinate - 1}"

    def e_name(self, i: int) -> str:
        element, mode = self._e_names[i]
        if element < 0:
            return f"normalization of node {-element}"
        keyword = self.keyword[element]
        return f"element {element} ({keyword}) e{mode} {ELEMENT_TYPES[keyword].modes[mode - 1][0]}"

    @cached_property
    def twist_rates(self) -> Index:
        """Degrees of freedom (places in q) that are coordinates of warping nodes."""
        found = [k for k, i in enumerate(self.q_x) if self.kind[self.x_owner(int(i))[0]] == "warping"]
        return np.array(found, np.int64)

    @cached_property
    def warped(self) -> bool:
        """True when some element has warping nodes."""
        return any(node.kind == "warping" for node in self.nodes)

    @cached_property
    def positions(self) -> Index:
        """0-based coordinates of the position nodes, (n, 2 or 3)."""
        rows = [node.number - 1 for node in self.nodes if node.kind == "position"]
        return self.lnp[rows, : 2 if self.planar else 3] - 1

    @cached_property
    def holonomic(self) -> bool:
        """True when no deformation exists as a rate only."""
        return not bool(self.slips.any())

    @cached_property
    def q_names(self) -> list[str]:
        """Degrees of freedom in the order of files.md: x input, x dynamic, e input, e dynamic."""
        return [self.x_name(i) for i in self.q_x] + [self.e_name(i) for i in self.q_e]

    @cached_property
    def k_names(self) -> list[str]:
        """Kinematic configuration coordinates: x, then e."""
        x, e = self.x_class["kinematic"], self.e_class["kinematic"]
        return [self.x_name(i) for i in range(x.start, x.stop)] + [self.e_name(i) for i in range(e.start, e.stop)]

    @cached_property
    def q_x(self) -> Index:
        """Coordinates that are degrees of freedom: input, then dynamic."""
        a, b = self.x_class["input"], self.x_class["dynamic"]
        return _ranges((a.start, a.stop), (b.start, b.stop))

    @cached_property
    def q_e(self) -> Index:
        """Deformations that are degrees of freedom: input, then dynamic."""
        a, b = self.e_class["input"], self.e_class["dynamic"]
        return _ranges((a.start, a.stop), (b.start, b.stop))

    @cached_property
    def ndof(self) -> int:
        return int(self.nxp[2] + self.nxp[3] + self.nep[2] + self.nep[3])

    @cached_property
    def nddof(self) -> int:
        return int(self.nxp[3] + self.nep[3])

    @cached_property
    def nk(self) -> int:
        return int(self.nxp[4] + self.nep[4])

    @cached_property
    def nkdof(self) -> int:
        return self.ndof + self.nk

    @cached_property
    def nkddof(self) -> int:
        return self.nddof + self.nk

    @cached_property
    def dynamic(self) -> Index:
        """Rows of q that are dynamic: x dynamic, then e dynamic (files.md section 3)."""
        r, m, s = int(self.nxp[2]), int(self.nxp[3]), int(self.nep[2])
        return _ranges((r, r + m), (r + m + s, self.ndof))

    @cached_property
    def rheonomic(self) -> Index:
        """Rows of q that are prescribed: x input, then e input."""
        r, m, s = int(self.nxp[2]), int(self.nxp[3]), int(self.nep[2])
        return _ranges((0, r), (r + m, r + m + s))

    @cached_property
    def all_dynamic(self) -> Numbering:
        """The same, with the degrees of freedom that are prescribed as dynamic ones; all keep their places."""
        nxp, nep = self.nxp.copy(), self.nep.copy()
        for counts in (nxp, nep):
            counts[3] += counts[2]
            counts[2] = 0
        return replace(self, nxp=nxp, nep=nep)

    # Equations and unknowns of both levels (theory-system.md 1.1): what is given of e determines what depends on it.
    @cached_property
    def velocity_equations(self) -> Index:
        """Rows E of V that determine velocities: fixed, input and dynamic deformations, slips included."""
        return np.arange(self.e_class["dynamic"].stop)

    @cached_property
    def velocity_unknowns(self) -> Index:
        """Columns U of V: calculable and kinematic coordinates."""
        a, b = self.x_class["calculable"], self.x_class["kinematic"]
        return _ranges((a.start, a.stop), (b.start, b.stop))

    @cached_property
    def position_equations(self) -> Index:
        """Rows h: the holonomic ones of fixed, input, dynamic and kinematic deformations."""
        return np.flatnonzero(~self.slips[: self.e_class["kinematic"].stop])

    @cached_property
    def position_unknowns(self) -> Index:
        """Columns c: calculable coordinates."""
        a = self.x_class["calculable"]
        return np.arange(a.start, a.stop)

    @property
    def is_square(self) -> bool:
        """Whether there are as many equations as unknowns, at both levels."""
        x, e = self.x_class, self.e_class
        calculable = x["calculable"].stop - x["calculable"].start
        kinematic = x["kinematic"].stop - x["kinematic"].start
        position = e["kinematic"].stop - int(np.count_nonzero(self.slips[: e["kinematic"].stop]))
        return position == calculable and e["dynamic"].stop == calculable + kinematic

    def x_index(self, node: int, coordinate: int) -> int:
        """0-based index of a coordinate; KeyError if it does not exist."""
        if 1 <= node <= len(self.lnp) and 1 <= coordinate <= 4:
            found = self.lnp.item(node - 1, coordinate - 1)
            if found:
                return found - 1
        raise KeyError((node, coordinate))

    def e_index(self, element: int, mode: int) -> int:
        """0-based index of a deformation; KeyError if it does not exist."""
        if 1 <= element <= len(self.le) and 1 <= mode <= self.le.shape[1]:
            found = self.le.item(element - 1, mode - 1)
            if found:
                return found - 1
        raise KeyError((element, mode))


def _ranges(*ranges: tuple[int, int]) -> Index:
    """Consecutive numbers from each first to before each last one."""
    return np.concatenate([np.arange(first, last) for first, last in ranges])


def number(
    elements: Sequence[tuple[int, str, tuple[int, ...]]],
    x_class: Mapping[tuple[int, int], str],
    e_class: Mapping[tuple[int, int], str],
) -> Numbering:
    """Number a mechanism. `x_class` maps (node, coordinate), `e_class` (element, mode) to classes.

    Defaults (input-language.md section 4.3): coordinates calculable, deformations fixed.
    """
    elements = tuple(sorted(elements))
    planar = ELEMENT_TYPES[elements[0][1]].planar
    kinds: dict[int, str] = {}
    by_keyword: dict[str, list[tuple[int, tuple[int, ...]]]] = {}
    for element, keyword, nodes in elements:
        kinds.update(zip(nodes, ELEMENT_TYPES[keyword].nodes, strict=True))
        by_keyword.setdefault(keyword, []).append((element, nodes))
    nodes_ = tuple(Node(n, kind, coordinates_of(kind, planar)) for n, kind in sorted(kinds.items()))
    highest = elements[-1][0]

    x_default = np.full((nodes_[-1].number, 4), ABSENT)
    for kind in set(kinds.values()):
        here = [node.number - 1 for node in nodes_ if node.kind == kind]
        x_default[here, : coordinates_of(kind, planar)] = CLASSES.index("calculable")
    types = [ELEMENT_TYPES[keyword] for keyword in by_keyword]
    e_default = np.full((highest, max(6, *(len(t.modes) for t in types))), ABSENT)
    ln = np.zeros((highest, max(4, *(len(t.nodes) for t in types))), np.int64)
    it = np.zeros(highest, np.int64)
    for keyword, found in by_keyword.items():
        kind_, rows = ELEMENT_TYPES[keyword], [element - 1 for element, _ in found]
        e_default[rows, : len(kind_.modes)] = E_ORDER.index("fixed")
        ln[rows, : len(kind_.nodes)] = [nodes for _, nodes in found]
        it[rows] = kind_.code
    lnp, nxp = _in_order(x_default, x_class, CLASSES)
    le, nep = _in_order(e_default, e_class, E_ORDER)
    # normalizations come after the other fixed deformations
    lambdas = [] if planar else [m.number for m in nodes_ if m.kind == "orientation"]
    first = int(nep[0])
    le[le > first] += len(lambdas)
    nep[0] += len(lambdas)
    slips = np.zeros(int(nep.sum()), bool)
    for keyword, found in by_keyword.items():
        for mode in ELEMENT_TYPES[keyword].slips:
            slips[le[[element - 1 for element, _ in found], mode] - 1] = True
    return Numbering(
        planar=planar,
        nodes=nodes_,
        elements=elements,
        nxp=nxp,
        nep=nep[[E_ORDER.index(c) for c in CLASSES]],
        lnp=lnp,
        le=le,
        ln=ln,
        it=it,
        normalization=np.array([(n, first + k) for k, n in enumerate(lambdas)], np.int64).reshape(-1, 2),
        slips=slips,
    )


def _in_order(
    classes: Index, given: Mapping[tuple[int, int], str], order: Sequence[str]
) -> tuple[Index, Index]:
    """1-based numbers by class, then row, then column, and how many each class has.

    `classes` (rows, columns) holds the place of the default class in `order`, or ABSENT; `given` maps (row, column)
    from 1 to another class.
    """
    rank = {name: k for k, name in enumerate(order)}
    for (row, column), name in given.items():
        if classes[row - 1, column - 1] != ABSENT:
            classes[row - 1, column - 1] = rank[name]
    there = np.flatnonzero(classes != ABSENT)
    of = classes.flat[there]
    numbers = np.zeros(classes.size, np.int64)
    numbers[there[np.argsort(of, kind="stable")]] = np.arange(1, len(there) + 1)
    return numbers.reshape(classes.shape), np.bincount(of, minlength=len(order))
