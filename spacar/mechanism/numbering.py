"""Numbering of coordinates and deformations, exactly as files.md section 3 states it.

x is ordered by class: fixed, calculable, input, dynamic, kinematic; inside a class by node, then coordinate.
e is ordered by class: fixed (the normalizations of Euler parameters last, by node), input, dynamic, kinematic,
calculable; inside a class by element, then mode. With this order every class is a slice.
The tables lnp, le, ln hold the 1-based numbers that result files show; 0 means "does not exist".
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from spacar.deck import ELEMENT_TYPES

Index = NDArray[np.int64]

CLASSES = ("fixed", "calculable", "input", "dynamic", "kinematic")
E_ORDER = ("fixed", "input", "dynamic", "kinematic", "calculable")


@dataclass(frozen=True)
class Node:
    """One node: kind 'position' or 'orientation', and how many coordinates it has."""

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
    le: Index  # (highest element, 6)
    ln: Index  # (highest element, 4)
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
        edges = np.concatenate(([0], np.cumsum([counts[c] for c in order])))
        return {c: slice(int(a), int(b)) for c, a, b in zip(order, edges, edges[1:], strict=False)}

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
        return f"node {node} phi" if self.planar else f"node {node} lambda{coordinate - 1}"

    def e_name(self, i: int) -> str:
        element, mode = self._e_names[i]
        if element < 0:
            return f"normalization of node {-element}"
        keyword = self.keyword[element]
        return f"element {element} ({keyword}) e{mode} {ELEMENT_TYPES[keyword].modes[mode - 1][0]}"

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
        return len(self.q_x) + len(self.q_e)

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

    def x_index(self, node: int, coordinate: int) -> int:
        """0-based index of a coordinate; KeyError if it does not exist."""
        if 1 <= node <= len(self.lnp) and 1 <= coordinate <= 4 and self.lnp[node - 1, coordinate - 1]:
            return int(self.lnp[node - 1, coordinate - 1]) - 1
        raise KeyError((node, coordinate))

    def e_index(self, element: int, mode: int) -> int:
        """0-based index of a deformation; KeyError if it does not exist."""
        if 1 <= element <= len(self.le) and 1 <= mode <= 6 and self.le[element - 1, mode - 1]:
            return int(self.le[element - 1, mode - 1]) - 1
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

    Defaults (keywords.md 4.3): coordinates calculable, deformations fixed.
    """
    elements = tuple(sorted(elements))
    planar = ELEMENT_TYPES[elements[0][1]].planar
    kinds: dict[int, str] = {}
    for _, keyword, nodes in elements:
        for node, role in zip(nodes, ELEMENT_TYPES[keyword].nodes, strict=True):
            kinds[node] = role
    size = {"position": 2 if planar else 3, "orientation": 1 if planar else 4}
    nodes_ = tuple(Node(n, kinds[n], size[kinds[n]]) for n in sorted(kinds))

    x_list: dict[str, list[tuple[int, int]]] = {c: [] for c in CLASSES}
    for n in nodes_:
        for coordinate in range(1, n.size + 1):
            x_list[x_class.get((n.number, coordinate), "calculable")].append((n.number, coordinate))
    e_list: dict[str, list[tuple[int, int]]] = {c: [] for c in CLASSES}
    for element, keyword, _ in elements:
        for mode in range(1, len(ELEMENT_TYPES[keyword].modes) + 1):
            e_list[e_class.get((element, mode), "fixed")].append((element, mode))
    lambdas = [] if planar else [m.number for m in nodes_ if m.kind == "orientation"]
    first_normalization = len(e_list["fixed"])
    e_list["fixed"] += [(-node, 0) for node in lambdas]

    lnp = np.zeros((nodes_[-1].number, 4), np.int64)
    for i, (owner, coordinate) in enumerate((key for c in CLASSES for key in x_list[c]), 1):
        lnp[owner - 1, coordinate - 1] = i
    highest = elements[-1][0]
    le = np.zeros((highest, 6), np.int64)
    slips = []
    slips_of = {element: ELEMENT_TYPES[k].slips for element, k, _ in elements}
    for i, (element, mode) in enumerate((key for c in E_ORDER for key in e_list[c]), 1):
        if element > 0:
            le[element - 1, mode - 1] = i
        slips.append(element > 0 and mode - 1 in slips_of[element])
    ln = np.zeros((highest, 4), np.int64)
    it = np.zeros(highest, np.int64)
    for element, keyword, nodes in elements:
        ln[element - 1, : len(nodes)] = nodes
        it[element - 1] = ELEMENT_TYPES[keyword].code
    return Numbering(
        planar=planar,
        nodes=nodes_,
        elements=elements,
        nxp=np.array([len(x_list[c]) for c in CLASSES], np.int64),
        nep=np.array([len(e_list[c]) for c in CLASSES], np.int64),
        lnp=lnp,
        le=le,
        ln=ln,
        it=it,
        normalization=np.array([(n, first_normalization + k) for k, n in enumerate(lambdas)], np.int64).reshape(-1, 2),
        slips=np.array(slips, bool),
    )
