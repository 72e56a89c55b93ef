"""Ground symbols, drives, pins, nodes, numbers and traces."""

from collections.abc import Sequence

import numpy as np

from spacar.arrays import Array
from spacar_drawing import look as paint
from spacar_drawing.bodies import beam_lines
from spacar_drawing.drawn_shapes import Faces, Label, Line, Mark, Shape, circle, normal_pair, solid
from spacar_drawing.element_pictures import span
from spacar_drawing.look import Look, middle, node_names
from spacar_drawing.scene import ROUND, Element, Pose, Scene

X, Y, Z = np.eye(3)


def support_shapes(scene: Scene, pose: Pose, look: Look) -> list[Shape]:
    """Supports and drives of all position nodes, and the pins of a planar mechanism."""
    shapes: list[Shape] = []
    for node in scene.supported:
        shapes += (planar_support if scene.planar else spatial_support)(scene, pose, look, node)
        shapes += _linear_drive(scene, pose, look, node)
    if look.pins:
        rings = circle(pose.place[np.array(look.pins) - 1, None], X, Y, 0.38 * look.size, 24)
        shapes += [Faces(rings, "#ffffff", None, 1.0, 5, False), Line(rings, paint.INK, 1.1, 5)]
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
            frame = scene.frame_p[e.number - 1] if end == "p" else scene.frame_q[e.number - 1]
            if not frame.any():
                frame = scene.frame_p[e.number - 1]
            best = (held, frame[0] if end == "p" else -frame[0])
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
        a, b = float((low - at) @ along) - 2.2 * s, float((high - at) @ along) + 2.2 * s
        ground = at + 0.75 * s * away
        block = np.array(
            [at + i * 1.1 * s * along + j * 0.75 * s * away for i, j in ((1, 1), (1, -1), (-1, -1), (-1, 1))]
        )
        shapes += _wall(ground + 0.5 * (a + b) * along, along, away, 0.5 * (b - a), s)
        shapes += [
            Faces(block[None], "#e4e9ed", None, 1.0, 0, False),
            Line(np.concatenate((block, block[:1])), paint.GROUND, 1.1, 1),
        ]
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
    start = at + np.linspace(-half, half, n + 1)[1:, None] * along
    shapes: list[Shape] = [Line(np.stack((at - half * along, at + half * along)), paint.GROUND, 1.4, 1)]
    for p in start:
        shapes.append(Line(np.stack((p, p + 0.55 * s * (away - along))), paint.GROUND, 0.7, 1))
    return shapes


def _pinned(at: Array, s: float) -> list[Shape]:
    corners = np.stack((at, at - 0.95 * s * X - 1.5 * s * Y, at + 0.95 * s * X - 1.5 * s * Y))
    return [
        Faces(corners[None], "#e4e9ed", None, 1.0, 0, False),
        Line(np.concatenate((corners, corners[:1])), paint.GROUND, 1.1, 1), *_wall(at - 1.5 * s * Y, X, -Y, 1.7 * s, s),
    ]  # fmt: skip


def _arrow(a: Array, b: Array, side: Array, s: float) -> list[Shape]:
    d = (b - a) / max(float(np.linalg.norm(b - a)), 1e-300)
    head = np.stack((b, b - 0.8 * s * d + 0.32 * s * side, b - 0.8 * s * d - 0.32 * s * side))
    return [
        Line(np.stack((a, b - 0.5 * s * d)), paint.DRIVE, 1.5, 6), Faces(head[None], paint.DRIVE, None, 1.0, 7, False)
    ]


def _turning_drive(at: Array, s: float) -> list[Shape]:
    """An arc with an arrow head, counter-clockwise."""
    r, end = 1.75 * s, 2.75
    arc = circle(at, X, Y, r, 30, (0.55, end - 0.3))
    tip = at + r * np.array([np.cos(end), np.sin(end), 0.0])
    radial = (tip - at) / r
    base = at + r * np.array([np.cos(end - 0.42), np.sin(end - 0.42), 0.0])
    head = np.stack((tip, base + 0.32 * s * radial, base - 0.32 * s * radial))
    return [Line(arc, paint.DRIVE, 1.5, 6), Faces(head[None], paint.DRIVE, None, 1.0, 7, False)]


def _linear_drive(scene: Scene, pose: Pose, look: Look, node: int) -> list[Shape]:
    at, s = pose.place[node - 1], look.size
    shapes: list[Shape] = []
    for k in range(2 if scene.planar else 3):
        if scene.x_class(node, k + 1) == "input":
            side = np.eye(3)[(k + 1) % (2 if scene.planar else 3)]
            shapes += _arrow(at + 0.8 * s * np.eye(3)[k], at + 3.6 * s * np.eye(3)[k], side, s)
    return shapes


def spatial_support(scene: Scene, pose: Pose, look: Look, node: int) -> list[Shape]:
    """Clamp: a plate across the element; held place: a pyramid below it; single directions: a small pyramid each."""
    fixed = scene.fixed_directions(node)
    if not fixed:
        return []
    held, inward = _held(scene, node)
    at, s, light = pose.place[node - 1], look.size, look.settings.light
    if len(fixed) == 3 and held and inward is not None:
        u, v = normal_pair(inward)
        square = 1.7 * s * np.array([[1, 1], [-1, 1], [-1, -1], [1, -1.0]])
        ends = np.stack((at - 0.6 * s * inward, at))
        return list(solid(square, ends, np.stack((u, u)), np.stack((v, v)), "#b9c1c8", light=light, edge=paint.GROUND))
    if len(fixed) == 3:
        return _pyramid(at, -Z, 1.5 * s)
    return [shape for k in fixed for shape in _pyramid(at, -np.eye(3)[k], 0.8 * s)]


def _pyramid(at: Array, down: Array, s: float) -> list[Shape]:
    u, v = normal_pair(down)
    base = at + 1.2 * s * down + 0.8 * s * np.stack((u + v, v - u, -u - v, u - v))
    sides = np.stack([np.stack((at, base[k], base[(k + 1) % 4])) for k in range(4)])
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
        at = _label_places(scene, pose, look, shown)
        shapes += [Label(at[e.number], str(e.number), "#7a3b12", True) for e in shown]
    return shapes


def _label_places(scene: Scene, pose: Pose, look: Look, elements: Sequence[Element]) -> dict[int, Array]:
    """Where the number of each element stands: half-way along the line that is drawn of it."""
    places: dict[int, Array] = {}
    for warping in (False, True):
        beams = [e for e in elements if e.shape == "beam" and e.p and e.q and bool(e.warping) == warping]
        if beams:
            middles = beam_lines(scene, pose, beams, 3)[0][:, 1]
            places |= {e.number: at for e, at in zip(beams, middles, strict=True)}
    for e in elements:
        if e.number in places:
            continue
        if e.shape == "belt" and e.p and e.q:
            places[e.number] = span(scene, pose, e)[0].mean(0)
            continue
        ends = [n for n in (e.p, e.q) if n]
        places[e.number] = middle(pose, tuple(ends) if ends else look.hinges.get(e.number, ()))
    return places


def trace_lines(scene: Scene, xs: Array, nodes: Sequence[int]) -> list[Shape]:
    """Paths of position nodes over the configurations xs (steps, nx)."""
    shapes: list[Shape] = []
    k = 2 if scene.planar else 3
    for n in nodes:
        path = np.zeros((len(xs), 3))
        path[:, :k] = xs[:, scene.lnp[n - 1, :k] - 1]
        shapes.append(Line(path, paint.TRACE, 1.1, 4, dashes=(4, 2)))
    return shapes
