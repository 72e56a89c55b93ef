"""Ground symbols, drives, pins, nodes, numbers and traces."""

from collections.abc import Sequence

import numpy as np

from spacar.arrays import Array
from spacar_drawing import look as paint
from spacar_drawing.bodies import beam_lines
from spacar_drawing.drawn_shapes import (
    Faces,
    Label,
    Line,
    Mark,
    Shape,
    arrow_head,
    bordered,
    circle,
    normal_pair,
    placed,
    solid,
)
from spacar_drawing.element_pictures import span
from spacar_drawing.look import Look, middle, node_names
from spacar_drawing.scene import ROUND, Pose, Scene

X, Y, Z = np.eye(3)
SQUARE = np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]])


def support_shapes(scene: Scene, pose: Pose, look: Look) -> list[Shape]:
    """Supports and drives of all position nodes, and the pins of a planar mechanism."""
    shapes: list[Shape] = []
    for node in scene.supported:
        shapes += (planar_support if scene.planar else spatial_support)(scene, pose, look, node)
        for k in range(scene.dimension):
            if scene.x_class(node, k + 1) == "input":  # driven along an axis
                at, along = pose.place[node - 1], look.size * np.eye(3)[k]
                side = 0.32 * look.size * np.eye(3)[(k + 1) % scene.dimension]
                shapes.append(Line(at + np.outer((0.8, 3.1), along), paint.DRIVE, 1.5, 6))
                shapes.append(arrow_head(at + 3.6 * along, at + 2.8 * along, side, paint.DRIVE))
    if look.pins:
        rings = circle(pose.place[np.array(look.pins) - 1, None], X, Y, 0.38 * look.size, 24)[:, :-1]
        shapes += bordered(rings, "#ffffff", paint.INK, 1.1, (5, 5))
    return shapes


def _held(scene: Scene, node: int) -> tuple[str, Array | None]:
    """How the orientation at a position node is held (fixed, input, ""), and the element direction there at the start,
    pointing into the element."""
    best: tuple[str, Array | None] = ("", None)
    for e, end in scene.ends.get(node, ()):
        turn = e.p_turn if end == "p" else e.q_turn
        if not turn or e.shape in ROUND:
            continue
        held = scene.orientation_class(turn)
        if held and best[0] != "fixed":
            first, last = scene.frame_p[e.number - 1], scene.frame_q[e.number - 1]
            best = (held, first[0] if end == "p" else -(last if last.any() else first)[0])
    return best


def planar_support(scene: Scene, pose: Pose, look: Look, node: int) -> list[Shape]:
    fixed = scene.fixed_directions(node)
    held, inward = _held(scene, node)
    at, s = pose.place[node - 1], look.size
    shapes: list[Shape] = []
    if len(fixed) == 2 and held == "fixed" and inward is not None:
        shapes += _wall(at, np.cross(Z, inward), -inward, 2.2 * s, s)
    elif len(fixed) == 2:
        shapes += _pinned(at, s)
    elif len(fixed) == 1:
        k = fixed[0]
        along, away = (X, -Y) if k == 1 else (Y, -X)
        low, high = look.ranges[node - 1]
        a, b = (low - at) @ along - 2.2 * s, (high - at) @ along + 2.2 * s
        ground = at + 0.75 * s * away
        block = placed(SQUARE * [1.1 * s, 0.75 * s], at, along, away)
        shapes += _wall(ground + 0.5 * (a + b) * along, along, away, 0.5 * (b - a), s)
        shapes += bordered(block, "#e4e9ed", paint.GROUND, 1.1, (0, 1))
    elif held == "fixed" and inward is not None:  # guided: free to move, not to turn
        v, w = np.cross(Z, inward), -0.45 * s * inward
        shapes += [
            Line(np.stack((at + 1.6 * s * v + k * w, at - 1.6 * s * v + k * w)), paint.GROUND, 1.2, 1) for k in (0, 1)
        ]
    if held == "input":
        shapes += _turning_drive(at, s)
    return shapes


def _wall(at: Array, along: Array, away: Array, half: float, s: float) -> list[Shape]:
    """A ground line of length 2 half with hatching on the side `away`."""
    n = max(round(2 * half / (0.55 * s)), 3)
    start = at + np.linspace(-half, half, n + 1)[:, None] * along
    hatches = np.stack((start[1:], start[1:] + 0.55 * s * (away - along)), axis=1)
    return [Line(start[[0, -1]], paint.GROUND, 1.4, 1), Line(hatches, paint.GROUND, 0.7, 1)]


def _pinned(at: Array, s: float) -> list[Shape]:
    corners = np.stack((at, at - 0.95 * s * X - 1.5 * s * Y, at + 0.95 * s * X - 1.5 * s * Y))
    ground = _wall(at - 1.5 * s * Y, X, -Y, 1.7 * s, s)
    return [*bordered(corners, "#e4e9ed", paint.GROUND, 1.1, (0, 1)), *ground]


def _turning_drive(at: Array, s: float) -> list[Shape]:
    """An arc with an arrow head, counter-clockwise."""
    r, end = 1.75 * s, 2.75
    arc = circle(at, X, Y, r, 30, (0.55, end - 0.3))
    base, tip = circle(at, X, Y, r, 2, (end - 0.42, end))
    return [Line(arc, paint.DRIVE, 1.5, 6), arrow_head(tip, base, 0.32 * s * (tip - at) / r, paint.DRIVE)]


def spatial_support(scene: Scene, pose: Pose, look: Look, node: int) -> list[Shape]:
    """Clamp: a plate across the element; held place: a pyramid below it; single directions: a small pyramid each."""
    fixed = scene.fixed_directions(node)
    if not fixed:
        return []
    held, inward = _held(scene, node)
    at, s, light = pose.place[node - 1], look.size, look.settings.light
    if len(fixed) == 3 and held and inward is not None:
        u, v = (np.stack((w, w)) for w in normal_pair(inward))
        ends = np.stack((at - 0.6 * s * inward, at))
        return solid(1.7 * s * SQUARE, ends, u, v, "#b9c1c8", light=light, edge=paint.GROUND)
    if len(fixed) == 3:
        return _pyramid(at, -Z, 1.5 * s)
    return [shape for k in fixed for shape in _pyramid(at, -np.eye(3)[k], 0.8 * s)]


def _pyramid(at: Array, down: Array, s: float) -> list[Shape]:
    base = placed(0.8 * s * SQUARE, at + 1.2 * s * down, *normal_pair(down))
    sides = np.stack((np.tile(at, (4, 1)), base, np.roll(base, -1, axis=0)), axis=1)
    return [Faces(sides, "#b9c1c8", paint.GROUND, width=0.5), Faces(base[None], "#b9c1c8", paint.GROUND, width=0.5)]


def node_marks(scene: Scene, pose: Pose, look: Look) -> list[Shape]:
    """Small dots at the position nodes that are no joints of a planar mechanism."""
    if not scene.planar:
        return []
    rows = np.setdiff1d(scene.position_nodes, look.pins).astype(int) - 1
    return [Mark(pose.place[rows], 2.6, paint.NODE, paint.NODE)] if len(rows) else []


def number_labels(scene: Scene, pose: Pose, look: Look, nodes: bool, elements: bool) -> list[Shape]:
    """Numbers of the nodes (orientation nodes in brackets behind their place) and of the elements (boxed)."""
    shapes: list[Shape] = []
    if nodes:
        shapes += [Label(pose.place[n - 1], text, "#33414d") for n, text in node_names(scene).items()]
    if elements:
        shown = [e for e in scene.elements if e.number not in look.settings.hidden]
        at: dict[int, Array] = {}  # half-way along the line that is drawn of it
        for warping in (False, True):
            beams = [e for e in shown if e.shape == "beam" and e.p and e.q and bool(e.warping) == warping]
            if beams:
                at |= dict(zip((e.number for e in beams), beam_lines(scene, pose, beams, 3)[0][:, 1], strict=True))
        for e in shown:
            if e.shape == "belt" and e.p and e.q:
                at[e.number] = span(scene, pose, e)[0].mean(0)
            elif e.number not in at:
                at[e.number] = middle(pose, tuple(n for n in (e.p, e.q) if n) or look.hinges.get(e.number, ()))
        shapes += [Label(at[e.number], str(e.number), "#7a3b12", True) for e in shown]
    return shapes


def trace_lines(scene: Scene, xs: Array, nodes: Sequence[int]) -> list[Shape]:
    """Paths of position nodes over the configurations xs (steps, nx)."""
    shapes: list[Shape] = []
    for n in nodes:
        path = np.zeros((len(xs), 3))
        path[:, : scene.dimension] = xs[:, scene.lnp[n - 1, : scene.dimension] - 1]
        shapes.append(Line(path, paint.TRACE, 1.1, 4, dashes=(4, 2)))
    return shapes
