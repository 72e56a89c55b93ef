"""How things look: colours, and the choices that hold for a whole series of pictures.

Where elements without position nodes (hinges) are drawn, and which joints a planar mechanism has.
"""

from collections import defaultdict
from dataclasses import dataclass, field

import numpy as np

from spacar.arrays import Array
from spacar_drawing.drawn_shapes import Colour, together
from spacar_drawing.picture_source import PictureSource
from spacar_drawing.scene import ROUND, Element, Pose, Scene, positions
from spacar_drawing.settings import PictureSettings


def attachments(scene: Scene, whole_bodies: bool) -> dict[int, tuple[int, ...]]:
    """Orientation node -> position nodes that it is attached to, nearest meaning first.

    Directly: the two are one end of an element. With `whole_bodies` also every position node of the same rigid body
    (rigid beams, and beams whose deformations are all fixed).
    """
    found: dict[int, list[int]] = defaultdict(list)
    for e in scene.elements:
        pairs = [(e.p_turn, e.p), (e.q_turn, e.q)]
        if e.shape == "planar wheel":  # both angles are those of the one place that it has
            pairs = [(e.p_turn, e.p), (e.q_turn, e.p)]
        elif e.shape == "body" and scene.rigid[e.number - 1]:
            pairs.append((e.p_turn, e.q))
        for turn, place in pairs:
            if turn and place and place not in found[turn]:
                found[turn].append(place)
    if whole_bodies:
        body = {turn: {turn} for turn in found}
        for e in scene.elements:
            if e.shape == "beam" and scene.rigid[e.number - 1]:
                together = body[e.p_turn] | body[e.q_turn]
                body |= dict.fromkeys(together, together)
        return {turn: tuple(dict.fromkeys(n for t in sorted(body[turn]) for n in found[t])) for turn in found}
    return {turn: tuple(nodes) for turn, nodes in found.items()}


def node_names(scene: Scene) -> dict[int, str]:
    """What stands beside the position nodes: their number, and in brackets those of the orientation nodes there."""
    turning = together((places[0], str(turn)) for turn, places in sorted(attachments(scene, False).items()))
    return {n: f"{n} ({','.join(turning[n])})" if n in turning else str(n) for n in scene.position_nodes.tolist()}


def places_of_hinges(scene: Scene, place: Array) -> dict[int, tuple[int, ...]]:
    """Element without position nodes -> position nodes (none, one or two) in whose middle it is drawn.

    A node that both sides share; else the end of the one side that is nearest to the other side, which may be several
    hinges away. `place` (highest node, 3) are the places of the nodes in the first configuration [m].
    """
    direct, whole = attachments(scene, False), attachments(scene, True)
    hinges = [e for e in scene.elements if not e.p and not e.q and e.p_turn and e.q_turn]
    neighbours: dict[int, list[int]] = defaultdict(list)
    for e in hinges:
        neighbours[e.p_turn].append(e.q_turn)
        neighbours[e.q_turn].append(e.p_turn)

    def reach(start: int, away_from: int) -> tuple[int, ...]:
        """Position nodes of the nearest orientation node that has some, going through hinges away from `away_from`."""
        seen, level = {away_from, start}, [start]
        while level:
            for node in level:
                if whole.get(node):
                    return whole[node]
            level = [m for node in level for m in neighbours[node] if m not in seen]
            seen.update(level)
        return ()

    def places(e: Element) -> tuple[int, ...]:
        for table in (direct, whole):
            common = [n for n in table.get(e.p_turn, ()) if n in table.get(e.q_turn, ())]
            if common:
                return (common[0],)
        p, q = reach(e.p_turn, e.q_turn), reach(e.q_turn, e.p_turn)
        if not p or not q:
            return (direct.get(e.p_turn) or direct.get(e.q_turn) or p or q)[:1]
        pairs = ((a, b) for a in p for b in q)
        a, b = min(pairs, key=lambda ab: np.linalg.norm(place[ab[0] - 1] - place[ab[1] - 1]))
        if (e.p_turn in whole) == (e.q_turn in whole):
            return (a, b)
        return (a,) if e.p_turn in whole else (b,)

    return {e.number: places(e) for e in hinges}


def pin_joints(scene: Scene) -> tuple[int, ...]:
    """Position nodes of a planar mechanism where parts can turn with respect to each other."""
    parts: dict[int, set[int]] = defaultdict(set)
    for e in scene.elements:
        for place, turn in ((e.p, e.p_turn), (e.q, e.q_turn)):
            if place and e.shape == "truss":
                holds = scene.e_class(e.number, 1) in ("fixed", "input")
                if holds or scene.stiffness[e.number - 1, 0] or scene.damping[e.number - 1, 0]:  # else it measures only
                    parts[place].add(-e.number)
            elif place and turn:
                parts[place].add(turn)
            elif place and e.shape == "body":
                parts[place].add(e.p_turn)
    belts = {n for e in scene.elements if e.shape in ROUND for n in (e.p, e.q)}
    found = {n for n, joined in parts.items() if len(joined) > 1 and n not in belts}
    for n, joined in parts.items():  # a pinned support
        turning = [t for t in joined if t > 0]
        held = any(scene.orientation_class(t) == "fixed" for t in turning)
        if len(scene.fixed_directions(n)) == 2 and not held:
            found.add(n)
    return tuple(sorted(found))


FLEXIBLE, RIGID, TRUSS, SPRING = "#2f74b5", "#3c4a57", "#5d6d7a", "#3d8b5f"
HINGE, BELT, PULLEY, WHEEL, SCREW = "#c2703d", "#6b4a2b", "#c9d2da", "#4a5560", "#8a97a3"
GROUND, DRIVE, TRACE, GHOST, NODE, INK = "#6f7880", "#c0272d", "#d0812a", "#aab4bd", "#1d262e", "#1d262e"
DEFAULT_POINTS = 25  # on one elastic line
MOST_POINTS = 4000  # on all elastic lines together, unless STEPLINE says otherwise
MOST_FACES = 4000  # on all solids of a spatial picture, as long as every beam gets LEAST_POINTS
LEAST_POINTS = 3
ROD_SIDES = 12  # of the rod that stands for a spatial beam without a cross-section
SYMBOL = 0.022  # size of symbols, of the extent of the mechanism


@dataclass(frozen=True)
class Look:
    """Choices for a series of pictures of one scene.

    size      length of symbols [m];  points  on an elastic line
    hinges    hinge element -> position nodes where it is drawn;  pins  position nodes that are joints
    ranges    (highest node, 2, 3) smallest and largest places of the nodes over the series, for guides
    tints     element -> colour instead of its own;  faint elements are drawn thin and pale
    """

    settings: PictureSettings
    size: float
    points: int
    hinges: dict[int, tuple[int, ...]]
    pins: tuple[int, ...]
    ranges: Array
    tints: dict[int, Colour] = field(default_factory=dict)

    def colour(self, element: int, default: Colour) -> Colour:
        return self.tints.get(element) or self.settings.colour(element) or default


def look_of(scene: Scene, xs: Array, settings: PictureSettings) -> Look:
    """The look for drawing the configurations xs (steps, nx)."""
    places = positions(scene, xs)
    rows = scene.position_nodes - 1
    ranges = np.stack((places.min(0), places.max(0)), axis=1)
    first = places[0][rows]
    extent = float(np.linalg.norm(np.ptp(first, axis=0))) if len(first) else 0.0
    extent = extent or np.max(scene.length, initial=0.0) or 1.0
    beams = sum(e.shape == "beam" for e in scene.elements)
    if settings.step_line is not None:
        points = int(np.clip(round(1.0 / settings.step_line) + 1, 3, 1001))
    else:
        most = MOST_POINTS if scene.planar else MOST_FACES // ROD_SIDES
        points = int(np.clip(most // max(beams, 1), LEAST_POINTS if not scene.planar else 4, DEFAULT_POINTS))
    return Look(
        settings, SYMBOL * extent, points, places_of_hinges(scene, places[0]),
        pin_joints(scene) if scene.planar else (), ranges,
    )  # fmt: skip


def extent_of(source: PictureSource, step: int) -> float:
    """Size of the mechanism [m] at a step."""
    return look_of(source.scene, source.x(step)[None], source.settings).size / SYMBOL


def middle(pose: Pose, nodes: tuple[int, ...]) -> Array:
    """Mean place of nodes; the origin for none."""
    return pose.place[[n - 1 for n in nodes]].mean(0) if nodes else np.zeros(3)
