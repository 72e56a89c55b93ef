"""Numbering of coordinates and deformations, exactly as files.md section 3 states it.

x is ordered by class: fixed, calculable, input, dynamic, kinematic; inside a class by node, then coordinate.
e is ordered by class: fixed (the normalizations of Euler parameters last, by node), input, dynamic, kinematic,
calculable; inside a class by element, then mode. With this order every class is a slice.
Here places count from 0 and -1 means "does not exist"; the rows of `x_places` and `e_places` are the numbers of nodes
and elements, so that row 0 belongs to nobody. The tables lnp, le, ln hold the 1-based numbers that result files show,
their first row is that of number 1, and 0 means "does not exist".
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import accumulate, pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import Index
from spacar.deck import ELEMENT_TYPES, Deck, coordinates_of
from spacar.mechanism.element_rows import ABSENT, E_ORDER, ROLES, X_ORDER, ElementRows, class_codes

CLASSES = X_ORDER


class Node(NamedTuple):
    """One node: kind 'position', 'orientation' or 'warping', and how many coordinates it has."""

    number: int
    kind: str
    size: int


@dataclass(frozen=True, eq=False, repr=False)
class Numbering:
    """Where everything is. What few analyses ask for is made when it is."""

    planar: bool
    types: tuple[ElementRows, ...]
    roles: NDArray[np.uint8]  # (1 + highest node,) place in ROLES of every node
    nx: int
    ne: int
    x_class: dict[str, slice]
    e_class: dict[str, slice]
    x_places: Index  # (1 + highest node, 4) places of the coordinates in x
    e_places: Index  # (1 + highest element, 6; 8 in a model with warping) places of the deformations in e
    turning: Index  # (n,) numbers of the spatial orientation nodes
    normalized: slice  # rows of e with the normalizations of their Euler parameters

    @cached_property
    def normalization(self) -> Index:
        """(n spatial orientation nodes, 2): node number, 0-based row of e."""
        return np.array((self.turning, np.arange(self.normalized.start, self.normalized.stop))).T

    @cached_property
    def euler(self) -> Index:
        """(4, n spatial orientation nodes) places of the Euler parameters in x."""
        return self.x_places.take(self.turning, 0).T

    @cached_property
    def slips(self) -> NDArray[np.bool_]:
        """(ne,) rows that exist as rates only."""
        found = np.zeros(self.ne, bool)
        for rows in self.types:
            for mode in rows.kind.slips:
                found[self.e_places[rows.numbers, mode]] = True
        return found

    @cached_property
    def nxp(self) -> Index:
        """(5,) coordinates per class in the order of CLASSES."""
        return np.array([_count(self.x_class[c]) for c in CLASSES], np.int64)

    @cached_property
    def nep(self) -> Index:
        """(5,) deformations per class in the order of CLASSES."""
        return np.array([_count(self.e_class[c]) for c in CLASSES], np.int64)

    @cached_property
    def lnp(self) -> Index:
        """(highest node, 4) numbers of the coordinates."""
        return self.x_places[1:] + 1

    @cached_property
    def le(self) -> Index:
        """(highest element, 6; 8 in a model with warping) numbers of the deformations."""
        return self.e_places[1:] + 1

    @cached_property
    def nodes(self) -> tuple[Node, ...]:
        """Sorted by number."""
        size = [coordinates_of(role, self.planar) if role else 0 for role in ROLES]
        return tuple(Node(n, ROLES[r], size[r]) for n, r in enumerate(self.roles.tolist()) if r)

    @cached_property
    def elements(self) -> tuple[tuple[int, str, tuple[int, ...]], ...]:
        """Number, keyword, node numbers, sorted by number."""
        found = [
            (number, rows.kind.keyword, tuple(nodes))
            for rows in self.types
            for number, nodes in zip(rows.numbers.tolist(), rows.nodes.tolist(), strict=True)
        ]
        return tuple(sorted(found))

    @cached_property
    def ln(self) -> Index:
        """(highest element, 4; 6 in a model with warping) node numbers."""
        ln = np.zeros((len(self.e_places) - 1, max(4, *(len(rows.kind.nodes) for rows in self.types))), np.int64)
        for rows in self.types:
            ln[rows.numbers - 1, : len(rows.kind.nodes)] = rows.nodes
        return ln

    @cached_property
    def it(self) -> Index:
        """(highest element,) type codes."""
        it = np.zeros(len(self.e_places) - 1, np.int64)
        for rows in self.types:
            it[rows.numbers - 1] = rows.kind.code
        return it

    @cached_property
    def x_node(self) -> Index:
        """(nx,) number of the node that a coordinate belongs to."""
        nodes, coordinates = (self.x_places >= 0).nonzero()
        found = np.empty(self.nx, np.int64)
        found.put(self.x_places[nodes, coordinates], nodes)
        return found

    @cached_property
    def _x_names(self) -> list[tuple[int, int]]:
        return owners(self.x_places, self.nx)

    @cached_property
    def _e_names(self) -> list[tuple[int, int]]:
        names = owners(self.e_places, self.ne)
        for node, i in self.normalization:
            names[i] = (-int(node), 0)
        return names

    @cached_property
    def keyword(self) -> dict[int, str]:
        return {number: keyword for number, keyword, _ in self.elements}

    @cached_property
    def kind(self) -> dict[int, str]:
        return {number: ROLES[role] for number, role in enumerate(self.roles.tolist()) if role}

    def role(self, node: int) -> str:
        """Role of a node by its number: 'position', 'orientation' or 'warping'."""
        return ROLES[self.roles.item(node)]

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
        return any([rows.kind.warping for rows in self.types])

    @cached_property
    def positions(self) -> Index:
        """0-based coordinates of the position nodes, (n, 2 or 3)."""
        return self.x_places.take(_with_role(self.roles, "position"), 0)[:, : 2 if self.planar else 3]

    @cached_property
    def translations(self) -> Index:
        """(nx,) translation of joined position nodes that a coordinate takes part in: the place of the first of these
        coordinates; -1 of orientations and warping."""
        part = np.arange(len(self.roles))
        position = self.roles == ROLES.index("position")
        joined = [rows.nodes[:, position[rows.nodes[0]]] for rows in self.types]
        before = part[:0]
        while not np.array_equal(before, part):
            before = part.copy()
            for nodes in joined:
                if nodes.shape[1] > 1:
                    np.minimum.at(part, nodes, part[nodes].min(axis=1)[:, None])
            part = part[part]
        found = np.full(self.nx, -1)
        found[self.positions] = self.x_places[part[position], : self.positions.shape[1]]
        return found

    @cached_property
    def holonomic(self) -> bool:
        """True when no deformation exists as a rate only."""
        return not any([rows.kind.slips for rows in self.types])

    @cached_property
    def q_names(self) -> list[str]:
        """Degrees of freedom in the order of files.md: x input, x dynamic, e input, e dynamic."""
        return [*map(self.x_name, self.q_x), *map(self.e_name, self.q_e)]

    @cached_property
    def k_names(self) -> list[str]:
        """Kinematic configuration coordinates: x, then e."""
        x, e = _ranges(self.x_class["kinematic"]), _ranges(self.e_class["kinematic"])
        return [*map(self.x_name, x), *map(self.e_name, e)]

    @property
    def dynamic_names(self) -> list[str]:
        """Names of the dynamic degrees of freedom."""
        return [self.q_names[i] for i in self.dynamic]

    @property
    def state_names(self) -> list[str]:
        """The state: configuration (dynamic degrees of freedom, kinematic coordinates), then velocities."""
        dynamic = self.dynamic_names
        return [*dynamic, *self.k_names, *(f"d/dt {name}" for name in dynamic)]

    @cached_property
    def q_x(self) -> Index:
        """Coordinates that are degrees of freedom: input, then dynamic, which follow each other."""
        return np.arange(self.x_class["input"].start, self.x_class["dynamic"].stop)

    @cached_property
    def q_e(self) -> Index:
        """Deformations that are degrees of freedom: input, then dynamic."""
        return np.arange(self.e_class["input"].start, self.e_class["dynamic"].stop)

    @cached_property
    def ndof(self) -> int:
        return len(self.q_x) + len(self.q_e)

    @cached_property
    def nddof(self) -> int:
        return _count(self.x_class["dynamic"]) + _count(self.e_class["dynamic"])

    @cached_property
    def nk(self) -> int:
        return _count(self.x_class["kinematic"]) + _count(self.e_class["kinematic"])

    @cached_property
    def nkdof(self) -> int:
        return self.ndof + self.nk

    @cached_property
    def nkddof(self) -> int:
        return self.nddof + self.nk

    @cached_property
    def dynamic(self) -> Index:
        """Rows of q that are dynamic: x dynamic, then e dynamic (files.md section 3)."""
        m = len(self.q_x)
        return _ranges(slice(_count(self.x_class["input"]), m), slice(m + _count(self.e_class["input"]), self.ndof))

    @cached_property
    def rheonomic(self) -> Index:
        """Rows of q that are prescribed: x input, then e input."""
        m = len(self.q_x)
        return _ranges(slice(0, _count(self.x_class["input"])), slice(m, m + _count(self.e_class["input"])))

    @cached_property
    def all_dynamic(self) -> Numbering:
        """The same, with the degrees of freedom that are prescribed as dynamic ones; all keep their places."""
        classes = []
        for places in (self.x_class, self.e_class):
            first, last = places["input"].start, places["dynamic"].stop
            classes.append(places | {"input": slice(first, first), "dynamic": slice(first, last)})
        return replace(self, x_class=classes[0], e_class=classes[1])

    # Equations and unknowns of both levels (theory-system.md 1.1): what is given of e determines what depends on it.
    @cached_property
    def velocity_equations(self) -> Index:
        """Rows E of V that determine velocities: fixed, input and dynamic deformations, slips included."""
        return np.arange(self.e_class["dynamic"].stop)

    @cached_property
    def velocity_unknowns(self) -> Index:
        """Columns U of V: calculable and kinematic coordinates."""
        return _ranges(self.x_class["calculable"], self.x_class["kinematic"])

    @cached_property
    def position_equations(self) -> Index:
        """Rows h: the holonomic ones of fixed, input, dynamic and kinematic deformations."""
        stop = self.e_class["kinematic"].stop
        return np.arange(stop) if self.holonomic else (~self.slips[:stop]).nonzero()[0]

    @cached_property
    def position_unknowns(self) -> Index:
        """Columns c: calculable coordinates."""
        return _ranges(self.x_class["calculable"])

    @property
    def is_square(self) -> bool:
        """Whether there are as many equations as unknowns, at both levels."""
        levels = (self.position_equations, self.position_unknowns), (self.velocity_equations, self.velocity_unknowns)
        return all(len(equations) == len(unknowns) for equations, unknowns in levels)

    def x_index(self, node: int, coordinate: int) -> int:
        """0-based index of a coordinate; KeyError if it does not exist."""
        return _index(self.x_places, node, coordinate)

    def e_index(self, element: int, mode: int) -> int:
        """0-based index of a deformation; KeyError if it does not exist."""
        return _index(self.e_places, element, mode)


def _index(places: Index, number: int, part: int) -> int:
    if 1 <= number < len(places) and 1 <= part <= places.shape[1]:
        found = places.item(number, part - 1)
        if found >= 0:
            return found
    raise KeyError((number, part))


def owners(places: Index, count: int) -> list[tuple[int, int]]:
    """Row and column (from 1) of every place in a table; (0, 0) of those that are not in it."""
    found = [(0, 0)] * count
    for row, column in np.argwhere(places >= 0).tolist():
        found[places.item(row, column)] = row, column + 1
    return found


def places_in(n: int, of: Index, to: Index | int | None = None) -> Index:
    """(n,) places by number: those of the numbers `of` in this list, or in `to`; -1 of all others."""
    found = np.full(n, -1)
    found[of] = np.arange(len(of)) if to is None else to
    return found


def _count(places: slice) -> int:
    found: int = places.stop - places.start
    return found


def _ranges(*parts: slice) -> Index:
    """The places of all parts."""
    return np.concatenate([np.arange(part.start, part.stop) for part in parts])


def number(deck: Deck, types: Sequence[ElementRows], prescribed: bool = False) -> Numbering:
    """Number the mechanism of a deck with these elements. `prescribed`: every dynamic coordinate and deformation is an
    input (modes that follow a nominal motion)."""
    planar = types[0].kind.planar
    codes, of_nodes, width, roles = class_codes(deck, types, prescribed)
    table = np.frombuffer(codes, np.uint8)
    counts = np.bincount(table, None, ABSENT).tolist()
    x_counts, e_counts = counts[: len(X_ORDER)], counts[len(X_ORDER) : ABSENT]
    turning = NO_PLACES if planar else _with_role(roles, "orientation")
    first, more = e_counts[0], len(turning)  # normalizations come after the other fixed deformations
    e_counts[0] += more
    nx, ne = sum(x_counts), sum(e_counts)
    # by class and then as the codes stand; the absent come last
    order, ascending = table.argsort(kind="stable"), np.arange(max(nx, ne))
    places = np.empty(len(codes), np.int64)
    places.fill(-1)
    places[order[:nx]] = ascending[:nx]
    places[order[nx : nx + first]] = ascending[:first]
    places[order[nx + first : nx + ne - more]] = ascending[first + more : ne]
    return Numbering(
        planar=planar, types=tuple(types), roles=roles, nx=nx, ne=ne, x_class=_slices(x_counts, X_ORDER),
        e_class=_slices(e_counts, E_ORDER), x_places=places[:of_nodes].reshape(-1, 4),
        e_places=places[of_nodes:].reshape(-1, width), turning=turning, normalized=slice(first, first + more),
    )  # fmt: skip


NO_PLACES = np.zeros(0, np.int64)
NO_PLACES.setflags(write=False)


def _slices(counts: Sequence[int], order: Sequence[str]) -> dict[str, slice]:
    ends = pairwise(accumulate(counts, initial=0))
    return {name: slice(first, last) for name, (first, last) in zip(order, ends, strict=True)}


def _with_role(roles: NDArray[np.uint8], role: str) -> Index:
    return (roles == ROLES.index(role)).nonzero()[0]
