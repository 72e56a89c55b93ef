"""Where elements without position nodes (hinges) are drawn, and which joints a planar mechanism has."""

from __future__ import annotations

from collections import defaultdict

import numpy as np

from spacar.arrays import Array
from spacar_drawing.scene import ROUND, Element, Scene


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
        elif e.shape == "body" and scene.is_rigid(e.number):
            pairs.append((e.p_turn, e.q))
        for turn, place in pairs:
            if turn and place and place not in found[turn]:
                found[turn].append(place)
    if whole_bodies:
        body = {turn: {turn} for turn in found}
        for e in scene.elements:
            if e.shape == "beam" and scene.is_rigid(e.number):
                together = body[e.p_turn] | body[e.q_turn]
                body |= dict.fromkeys(together, together)
        return {turn: tuple(dict.fromkeys(n for t in sorted(body[turn]) for n in found[t])) for turn in found}
    return {turn: tuple(nodes) for turn, nodes in found.items()}


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
    return {e.number: _hinge_place(e, direct, whole, neighbours, place) for e in hinges}


def _hinge_place(
    e: Element,
    direct: dict[int, tuple[int, ...]],
    whole: dict[int, tuple[int, ...]],
    neighbours: dict[int, list[int]],
    place: Array,
) -> tuple[int, ...]:
    for table in (direct, whole):
        common = [n for n in table.get(e.p_turn, ()) if n in table.get(e.q_turn, ())]
        if common:
            return (common[0],)
    p = _reach(e.p_turn, e.q_turn, whole, neighbours)
    q = _reach(e.q_turn, e.p_turn, whole, neighbours)
    if not p or not q:
        own = direct.get(e.p_turn) or direct.get(e.q_turn) or p or q
        return own[:1] if own else ()
    a, b = min(
        ((a, b) for a in p for b in q), key=lambda ab: float(np.linalg.norm(place[ab[0] - 1] - place[ab[1] - 1]))
    )
    if e.p_turn in whole and e.q_turn in whole:
        return (a, b)
    return (a,) if e.p_turn in whole else (b,) if e.q_turn in whole else (a, b)


def _reach(
    start: int, away_from: int, table: dict[int, tuple[int, ...]], neighbours: dict[int, list[int]]
) -> tuple[int, ...]:
    """Position nodes of the nearest orientation node that has some, going through hinges away from `away_from`."""
    seen, level = {away_from, start}, [start]
    while level:
        for node in level:
            if table.get(node):
                return table[node]
        level = [m for node in level for m in neighbours[node] if m not in seen]
        seen.update(level)
    return ()


def pin_joints(scene: Scene) -> tuple[int, ...]:
    """Position nodes of a planar mechanism where parts can turn with respect to each other."""
    parts: dict[int, set[int]] = defaultdict(set)
    for e in scene.elements:
        for place, turn in ((e.p, e.p_turn), (e.q, e.q_turn)):
            if place and e.shape == "truss":
                if not measures_only(scene, e):
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


def measures_only(scene: Scene, e: Element) -> bool:
    """A truss that is free to change its length and carries no force."""
    free = scene.e_class(e.number, 1) not in ("fixed", "input")
    return free and not scene.stiffness[e.number - 1, 0] and not scene.damping[e.number - 1, 0]
