"""What a picture needs to know of a mechanism: the header of a `.sbd` file in one record (reference/files.md 3, 4).

Everything is drawn in three dimensions; a planar mechanism lies in the plane z = 0. Rows of the tables are node or
element number minus 1, as in the files.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import Array, Index
from spacar.deck import ELEMENT_TYPES
from spacar.elements.rotations.rotation import rotate
from spacar.errors import UsageError
from spacar.expressions.result_places import listed
from spacar.modes import Mode, find_mode
from spacar_drawing.drawn_shapes import together, unit

Flags = NDArray[np.bool_]
CLASSES = ("fixed", "calculable", "input", "dynamic", "kinematic")
E_ORDER = (0, 2, 3, 4, 1)  # order of the classes inside e, as places in CLASSES
ROUND = ("belt", "planar wheel", "wheel")  # shapes that turn about a node: no body from p to q, no clamp, no joint


@dataclass(frozen=True)
class Element:
    """One element: number, keyword, shape (of the element table), nodes at its ends (0: none), its warping nodes."""

    number: int
    keyword: str
    shape: str
    p: int
    p_turn: int
    q: int
    q_turn: int
    warping: tuple[int, ...] = ()


@dataclass(frozen=True)
class Scene:
    """A mechanism to be drawn.

    keywords  one per element number ("": unused);  lnp (nodes, 4), le (elements, 6; 8), ln (elements, 4; 6) as filed
    frame_p, frame_q  (elements, 3, 3) rows x', y', z' of the start frames, zero where none exists
    length    (elements,) undeformed length [m];  data (elements, k) radii, pitch;  stiffness, damping (elements, 6)
    quadratic (elements,) measure of the strains and whether they have second order terms, table kdform (files.md 4)
    nxp, nep  (5,) coordinates and deformations per class
    metre     unit of length on axes and scales of pictures [m]
    """

    planar: bool
    mode: int
    title: str
    keywords: tuple[str, ...]
    lnp: Index
    le: Index
    ln: Index
    frame_p: Array
    frame_q: Array
    length: Array
    data: Array
    stiffness: Array
    damping: Array
    quadratic: Index
    nxp: Index
    nep: Index
    metre: float = 1.0

    @property
    def analysis(self) -> Mode:
        """The mode that computed the result. Raises UsageError for a number that no mode has."""
        return find_mode(self.mode)

    @classmethod
    def of_header(cls, header: Mapping[str, Any], title: str, metre: float = 1.0) -> Scene:
        """The scene of the header variables of a `.sbd` file (identifiers in capitals)."""

        def table(name: str, dtype: type = float) -> Any:
            return np.atleast_2d(np.asarray(header[name], dtype))

        keywords = tuple(word.strip() for word in header["ETYPE"])
        n = len(keywords)
        return cls(
            planar=all(ELEMENT_TYPES[w].planar for w in keywords if w in ELEMENT_TYPES),
            mode=int(np.ravel(header["MODE"])[0]), title=title, keywords=keywords, lnp=table("LNP", int).reshape(-1, 4),
            le=table("LE", int).reshape(n, -1), ln=table("LN", int).reshape(n, -1),
            frame_p=table("RXYZ").reshape(n, 3, 3), frame_q=table("RQ").reshape(n, 3, 3), length=np.ravel(table("RL0")),
            data=table("DR0").reshape(n, -1), stiffness=table("STIF").reshape(n, -1),
            damping=table("EDAMP").reshape(n, -1), quadratic=np.ravel(table("KDEF", int)),
            nxp=np.ravel(table("NXP", int)), nep=np.ravel(table("NEP", int)), metre=metre,
        )  # fmt: skip

    @cached_property
    def elements(self) -> tuple[Element, ...]:
        found = []
        for i, keyword in enumerate(self.keywords):
            kind = ELEMENT_TYPES.get(keyword)
            if kind is not None:
                p, p_turn, q, q_turn = (0 if c is None else int(self.ln[i, c]) for c in kind.ends)
                warping = tuple(int(self.ln[i, c]) for c in kind.warping)
                found.append(Element(i + 1, keyword, kind.shape, p, p_turn, q, q_turn, warping))
        return tuple(found)

    @cached_property
    def bars(self) -> dict[int, Element]:
        return {e.number: e for e in self.elements if e.shape in ("beam", "truss")}

    def bar(self, number: int, asked: str = "", code: str = "stress.element") -> Element:
        """One of `bars`. Raises UsageError for another number; `asked` stands before its text."""
        if number not in self.bars:
            known = ", ".join(map(str, self.bars)) or "none"
            raise UsageError(f"{asked}element {number} is no beam or truss; these are {known}", code)
        return self.bars[number]

    @cached_property
    def ends(self) -> dict[int, list[tuple[Element, str]]]:
        """Position node -> the elements that end there, with the end, p or q."""
        ends = ((place, (e, end)) for e in self.elements for end, place in (("p", e.p), ("q", e.q)))
        return together((place, end) for place, end in ends if place)

    @cached_property
    def position_nodes(self) -> Index:
        return np.flatnonzero((self.lnp[:, 1] > 0) & (self.lnp[:, 3] == 0)) + 1

    @cached_property
    def orientation_nodes(self) -> Index:
        full = self.lnp[:, 3] > 0 if not self.planar else (self.lnp[:, 0] > 0) & (self.lnp[:, 1] == 0)
        return np.flatnonzero(full) + 1

    @property
    def dimension(self) -> int:
        return 2 if self.planar else 3

    @cached_property
    def place_columns(self) -> Index:
        """(position nodes, dimension) where their coordinates are in x."""
        return self.lnp[self.position_nodes - 1, : self.dimension] - 1

    @cached_property
    def held(self) -> Flags:
        """(nx,) coordinates that are fixed or prescribed."""
        return np.isin(self._x_class, (CLASSES.index("fixed"), CLASSES.index("input")))

    @cached_property
    def _x_class(self) -> Index:
        return np.repeat(np.arange(5), self.nxp)

    @cached_property
    def _e_class(self) -> Index:
        return np.repeat(E_ORDER, self.nep[list(E_ORDER)])

    def x_class(self, node: int, coordinate: int) -> str:
        """Class of a coordinate (from 1), "" when it does not exist."""
        i = int(self.lnp[node - 1, coordinate - 1]) if 1 <= node <= len(self.lnp) else 0
        return CLASSES[self._x_class[i - 1]] if i else ""

    def e_class(self, element: int, mode: int) -> str:
        """Class of a deformation mode (from 1), "" when it does not exist."""
        i = int(self.le[element - 1, mode - 1])
        return CLASSES[self._e_class[i - 1]] if i else ""

    @cached_property
    def node_table(self) -> Index:
        """(elements, 4) node numbers of every element number: p, orientation of p, q, orientation of q; 0: none."""
        table = np.zeros((len(self.keywords), 4), int)
        for e in self.elements:
            table[e.number - 1] = e.p, e.p_turn, e.q, e.q_turn
        return table

    @cached_property
    def shear(self) -> Array:
        """(elements, 2) shear parameters Phi of bending along y' and z' (input-language.md 5.3): 12 EI/(GAk l0^2),
        ESTIFF position 4 or 7 and 6."""
        columns = [2, 2] if self.planar else [5, 4]
        values = self.stiffness[:, columns] * ([1, 0] if self.planar else [1, 1])
        square = np.where(self.length > 0, self.length, np.inf) ** 2
        return 12.0 * values / square[:, None]

    @cached_property
    def rigid(self) -> Flags:
        """(elements,) all deformations are fixed."""
        return self._all_of("fixed")

    @cached_property
    def free(self) -> Flags:
        """(elements,) all deformations are calculable: the element holds nothing."""
        return self._all_of("calculable") & np.any(self.le > 0, axis=1)

    def _all_of(self, name: str) -> Flags:
        classes = np.append(self._e_class, CLASSES.index(name))[self.le - 1]  # what does not exist counts as the class
        return np.all(classes == CLASSES.index(name), axis=1)

    @cached_property
    def doubled(self) -> Flags:
        """(elements,) another element ends in the same two position nodes."""
        pairs = np.sort(self.node_table[:, [0, 2]], axis=1)
        _, which, count = np.unique(pairs, axis=0, return_inverse=True, return_counts=True)
        return (count[which.ravel()] > 1) & (pairs[:, 0] > 0)

    @cached_property
    def warping_rows(self) -> Index:
        """Rows of the warping nodes in lnp."""
        return np.array([n - 1 for e in self.elements for n in e.warping], int)

    @cached_property
    def supported(self) -> tuple[int, ...]:
        """Position nodes with something that holds or drives them, or one of the orientations there."""
        turns = {n for n in self.orientation_nodes.tolist() if self.orientation_class(n)}
        found = {n for e in self.elements for n, turn in ((e.p, e.p_turn), (e.q, e.q_turn)) if turn in turns}
        found.update(self.position_nodes[self.held[self.place_columns].any(axis=1)].tolist())
        return tuple(n for n in self.position_nodes.tolist() if n in found)

    def fixed_directions(self, node: int) -> tuple[int, ...]:
        """Coordinates (0, 1, 2) of a position node that are supported."""
        return tuple(k for k in range(self.dimension) if self.x_class(node, k + 1) == "fixed")

    def orientation_class(self, node: int) -> str:
        """fixed, input or "" of an orientation node: what keeps it from turning freely."""
        found = {self.x_class(node, k) for k in ((1,) if self.planar else (2, 3, 4))}
        return "fixed" if found == {"fixed"} else "input" if "input" in found else ""


def positions(scene: Scene, x: Array) -> Array:
    """(..., highest node, 3) places of the position nodes [m], zero for the others, from x (..., nx)."""
    place = np.zeros((*x.shape[:-1], len(scene.lnp), 3))
    place[..., scene.position_nodes - 1, : scene.dimension] = x[..., scene.place_columns]
    return place


def rotations(scene: Scene, x: Array) -> Array:
    """(highest node, 3, 3) rotation matrices of the orientation nodes, unity for the others.

    Spatial: R of the normalized Euler parameters (theory-spatial.md section 1); planar: turn by phi about z.
    """
    R = np.tile(np.eye(3), (len(scene.lnp), 1, 1))
    rows = scene.orientation_nodes - 1
    x = np.ravel(x)
    if scene.planar:
        phi = x[scene.lnp[rows, 0] - 1]
        R[rows, 0, 0] = R[rows, 1, 1] = np.cos(phi)
        R[rows, 1, 0] = np.sin(phi)
        R[rows, 0, 1] = -np.sin(phi)
        return R
    quaternions = unit(x[scene.lnp[rows] - 1]).T
    every = np.tile(np.eye(3)[:, :, None], len(rows))  # component, axis, node
    R[rows] = rotate(quaternions[:, None], every).transpose(2, 0, 1)
    return R


@dataclass(frozen=True)
class Pose:
    """A scene at one configuration: places (highest node, 3), turns (highest node, 3, 3) and twist rates (highest
    node,) [rad/m] of the nodes, zero for those that have none."""

    place: Array
    turn: Array
    rate: Array

    @classmethod
    def of(cls, scene: Scene, x: Array) -> Pose:
        rate = np.zeros(len(scene.lnp))
        rows = scene.warping_rows
        rate[rows] = np.ravel(x)[scene.lnp[rows, 0] - 1]
        return cls(positions(scene, x), rotations(scene, x), rate)

    def frame(self, scene: Scene, element: Element, end: str = "p") -> Array:
        """(3, 3) rows x', y', z' of the element's frame at an end, in space."""
        return self.frames(scene, np.array([element.number - 1]), end)[0]

    def frames(self, scene: Scene, rows: Index, end: str = "p") -> Array:
        """(m, 3, 3) the same of the elements in these rows (number minus 1)."""
        table, column = (scene.frame_p, 1) if end == "p" else (scene.frame_q, 3)
        start = table[rows]
        start = np.where(np.any(start, axis=(1, 2), keepdims=True), start, scene.frame_p[rows])
        nodes = scene.node_table[rows, column]
        turn = np.where(nodes[:, None, None] > 0, self.turn[nodes - 1], np.eye(3))
        return start @ np.swapaxes(turn, 1, 2)


def check_numbers(numbers: Sequence[int], known: Sequence[int], option: str) -> None:
    """Raises UsageError for a number of a node or element that is not among the known ones."""
    for n in numbers:
        if n not in known:
            raise UsageError(f"{option} {n} does not exist; the model has {listed(known)}", "draw.missing")
