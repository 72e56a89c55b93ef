"""The node whose stiffness and motion are asked for: its coordinates, and those of the orientation node beside it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from spacar.arrays import Array, Index
from spacar.deck import ELEMENT_TYPES
from spacar.errors import UsageError
from spacar.linear.node_compliance import directions, planar_maps, spatial_maps
from spacar.mechanism.numbering import Numbering


@dataclass(frozen=True)
class ObservedNode:
    """Numbers of the position and of the orientation node (0: none), and their 0-based rows of x."""

    position: int
    orientation: int
    planar: bool
    rows: Index

    @classmethod
    def of(cls, numbering: Numbering, number: int, orientation: int = 0) -> ObservedNode:
        """From the number of either node; `orientation` names the other one where no element has both. A body with
        several position nodes is observed at the one with the lowest number. Raises UsageError."""
        kind = numbering.kind.get(number)
        if kind not in ("position", "orientation"):
            raise UsageError(f"there is no position or orientation node {number}", "flexure.node")
        if kind == "orientation":
            found = _partners(numbering, number, -1)
            if not found:
                text = f"orientation node {number}: no element has a position node beside it; name one (node)"
                raise UsageError(text, "flexure.node")
            number, orientation = min(found), number
        elif not orientation:
            beside = _partners(numbering, number, 1) or _bodies(numbering, number)
            if len(beside) > 1:
                text = f"node {number}: name its orientation node (one of {', '.join(map(str, sorted(beside)))})"
                raise UsageError(text, "flexure.node")
            orientation = beside.pop() if beside else 0
        elif numbering.kind.get(orientation) != "orientation":
            raise UsageError(f"node {orientation} is no orientation node", "flexure.node")
        k = 2 if numbering.planar else 3
        rows = list(numbering.lnp[number - 1, :k] - 1)
        if orientation:
            rows += list(numbering.lnp[orientation - 1, : 1 if numbering.planar else 4] - 1)
        return cls(number, orientation, numbering.planar, np.array(rows, np.int64))

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the displacements and small rotations: ux, uy, uz, phix, phiy, phiz; planar ux, uy, phi."""
        every = directions(self.planar)
        return every if self.orientation else every[: self.points]

    @property
    def points(self) -> int:
        """How many of them are displacements."""
        return 2 if self.planar else 3

    def map(self, x: Array) -> Array:
        """T (m, rows): displacements and small rotations along the global axes of changes of the coordinates."""
        if not self.orientation:
            return np.eye(self.points)
        return (planar_maps if self.planar else spatial_maps)(x[self.rows[self.points :]])[0]

    def place(self, x: Array) -> Array:
        """(3,) position [m]."""
        place = np.zeros(3)
        place[: self.points] = x[self.rows[: self.points]]
        return place

    def turn(self, x: Array) -> Array:
        """(4,) Euler parameters; those of no rotation without an orientation node."""
        if not self.orientation:
            return np.array([1.0, 0.0, 0.0, 0.0])
        angle = x[self.rows[self.points :]]
        return np.array([np.cos(angle[0] / 2), 0.0, 0.0, np.sin(angle[0] / 2)]) if self.planar else angle.copy()

    def spatial(self, twist: Array) -> tuple[Array, Array]:
        """Displacement and rotation, (3,) each, from a row of the m directions of the node."""
        move, turn = np.zeros(3), np.zeros(3)
        move[: self.points] = twist[: self.points]
        rest = twist[self.points :]
        if len(rest):
            turn[-len(rest) :] = rest
        return move, turn


def _bodies(numbering: Numbering, number: int) -> set[int]:
    """Orientation nodes of rigid bodies (position, orientation, position) whose second place is the node."""
    found = set()
    for element, keyword, nodes in numbering.elements:
        kinds = ELEMENT_TYPES[keyword].nodes
        if kinds == ("position", "orientation", "position") and nodes[2] == number:
            rows = numbering.le[element - 1]
            if (rows[rows > 0] <= numbering.e_class["fixed"].stop).all():
                found.add(nodes[1])
    return found


def _partners(numbering: Numbering, number: int, side: int) -> set[int]:
    """Nodes of the other kind at the same end of an element: the next (side 1) or the one before."""
    wanted = "orientation" if side > 0 else "position"
    return {
        nodes[k + side]
        for _, keyword, nodes in numbering.elements
        for k, node in enumerate(nodes)
        if node == number and 0 <= k + side < len(nodes) and ELEMENT_TYPES[keyword].nodes[k + side] == wanted
    }
