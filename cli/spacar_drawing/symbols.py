"""Loads, reactions, lumped masses, gravity and local axes as symbols on the mechanism.

Loads: the prescribed nodal forces fx. Reactions: fxt at prescribed and fixed coordinates, what support and drive exert
on the mechanism (theory-system.md section 2.4). On Euler parameters a moment M appears as f = 2 L^T M, so M = L f/2
with L = [-l, l0 I + l~] (reference/files.md section 5). The longest arrow of a series of pictures is ARROW long.

Deflections enlarged: configurations that lie further away from the start than the computed ones.

Positions and planar angles: x0 + f (x - x0). Euler parameters: the rotation from the start, exp(f theta), with theta
its rotation vector, q = (cos f|theta|/2, sin f|theta|/2 theta/|theta|) o q0 (theory-spatial.md section 1). For small
deflections both are what a linear theory enlarges; of a large one f = 1 alone is the truth.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from spacar.arrays import Array
from spacar.elements.rotations.rotation import global_matrix, right_product
from spacar.errors import UsageError
from spacar_drawing.bodies import beam_lines, rows_of
from spacar_drawing.drawn_shapes import Colour, Line, Mark, Shape, arrow_head, circle, normal_pair, unit
from spacar_drawing.look import Look, attachments
from spacar_drawing.picture_source import PictureSource
from spacar_drawing.scene import Pose, Scene, positions


def start_of(source: PictureSource) -> Array:
    """(nx,) the coordinates at the start. Raises UsageError for a result that does not hold them."""
    return np.ravel(stored(source, "X0", "the coordinates at the start"))


def stored(source: PictureSource, name: str, what: str) -> Array:
    """A table of the header. Raises UsageError when the result was written before there was such a table."""
    if name not in source.header:
        text = f"{source.name} does not hold {what} ({name.lower()}): an earlier version wrote it;"
        raise UsageError(f"{text} run the analysis again", "draw.missing")
    return np.asarray(source.header[name], float)


def magnified(scene: Scene, x0: Array, x: Array, factor: float) -> Array:
    """(nx,) the configuration whose deflection from x0 is `factor` times that of x."""
    y = x0 + factor * (np.ravel(x) - x0)
    if scene.planar:
        return y
    rows = scene.lnp[scene.orientation_nodes - 1] - 1
    q0, q = x0[rows], np.ravel(x)[rows]
    turn = product(q, q0 * [1, -1, -1, -1])
    turn = turn * np.where(turn[:, :1] < 0, -1.0, 1.0)  # the shorter way round
    sine = np.linalg.norm(turn[:, 1:], axis=1, keepdims=True)
    angle = factor * np.arctan2(sine, turn[:, :1])
    axis = turn[:, 1:] / np.maximum(sine, 1e-300)
    y[rows] = product(np.concatenate((np.cos(angle), np.sin(angle) * axis), axis=1), q0)
    return y


def product(a: Array, b: Array) -> Array:
    """(n, 4) products of quaternions: the rotation b, then a."""
    return np.einsum("ijn,nj->ni", right_product(b.T), a)


KINDS = ("loads", "reactions", "masses", "gravity", "axes")
LOAD, REACTION, MASS, GRAVITY = "#7b3fa0", "#1f7a5c", "#1d262e", "#6b5b2a"
AXES = ("#b3372f", "#2f8f4e", "#2f6fb5")
STORED = {"masses": ("XM", "lumped masses"), "gravity": ("GRAV", "gravity")}  # of a kind: variable, and what it holds
ARROW = 7.0  # length of the largest force, of the symbol size; a moment has an arc of a third of it as radius
LEAST = 1e-6  # of the largest: smaller forces are rounding
MOST_AXES = 150  # elements whose axes can be told apart


@dataclass(frozen=True)
class Forces:
    """One kind of force at one step: at position nodes (n, 3) [N], moments (m, 3) [N m] at the places of nodes."""

    nodes: tuple[int, ...]
    force: Array
    turning: tuple[int, ...]  # position nodes where the orientation nodes are
    moment: Array


@dataclass(frozen=True)
class Symbols:
    """What is drawn beside the mechanism in a series of pictures: kinds, and largest force and moment of each kind."""

    source: PictureSource
    kinds: tuple[str, ...]
    largest: dict[str, tuple[float, float]]

    @classmethod
    def of(cls, source: PictureSource, kinds: Sequence[str], steps: Sequence[int]) -> Symbols:
        """Raises UsageError for a kind that there is not, and when the result does not hold what a kind needs."""
        for kind in kinds:
            if kind not in KINDS:
                raise UsageError(f"there are no symbols '{kind}'; expected {', '.join(KINDS)}", "draw.symbols")
            if kind in STORED:
                stored(source, *STORED[kind])
        largest = {}
        for kind in ("loads", "reactions"):
            if kind in kinds:
                found = [forces(source, kind, k) for k in steps]
                most = [
                    [np.max(np.linalg.norm(v, axis=1), initial=0.0) for v in (f.force, f.moment)] for f in found
                ]
                force, moment = np.max(most, axis=0).tolist()
                largest[kind] = force, moment
        return cls(source, tuple(dict.fromkeys(kinds)), largest)

    def shapes(self, k: int, x: Array, look: Look) -> list[Shape]:
        """Those of step k, on the configuration x (nx,) that is drawn."""
        scene, shapes = self.source.scene, list[Shape]()
        if not self.kinds:
            return shapes
        pose = Pose.of(scene, x)
        for kind, colour in (("loads", LOAD), ("reactions", REACTION)):
            if kind in self.kinds:
                shapes += self._forces(scene, pose, look, forces(self.source, kind, k), kind, colour)
        if "masses" in self.kinds:
            shapes += _masses(scene, pose, look, stored(self.source, *STORED["masses"]))
        if "gravity" in self.kinds:
            shapes += _gravity(scene, pose, look, np.ravel(stored(self.source, *STORED["gravity"])))
        if "axes" in self.kinds:
            shapes += _axes(scene, pose, look)
        return shapes

    def _forces(self, scene: Scene, pose: Pose, look: Look, found: Forces, kind: str, colour: Colour) -> list[Shape]:
        shapes: list[Shape] = []
        force, moment = self.largest[kind]
        for node, value in zip(found.nodes, found.force, strict=True):
            size = np.linalg.norm(value)
            if size > LEAST * force:
                along = ARROW * look.size / force * value
                at = pose.place[node - 1]
                ends = (at - along, at) if kind == "reactions" else (at, at + along)
                shapes += arrow(*ends, look.size, colour, scene.planar)
        for node, value in zip(found.turning, found.moment, strict=True):
            if np.linalg.norm(value) > LEAST * moment:
                draw = turning if scene.planar else double_arrow
                shapes += draw(pose.place[node - 1], value / moment, look.size, colour)
        return shapes

    @property
    def legend(self) -> str:
        """What the sizes mean, and what there is none of."""
        parts = []
        for kind, (force, moment) in self.largest.items():
            sizes = [f"{v:.4g} {unit}" for v, unit in ((force, "N"), (moment, "N m")) if v > 0]
            parts.append(f"{kind}: largest {', '.join(sizes)}" if sizes else f"no {kind}")
        if "masses" in self.kinds:
            masses = node_masses(self.source.scene, stored(self.source, *STORED["masses"]))
            parts.append(f"masses: largest {max(masses.values()):.4g} kg" if masses else "no lumped masses")
        if "gravity" in self.kinds:
            size = np.linalg.norm(stored(self.source, *STORED["gravity"]))
            parts.append(f"gravity {size:.4g} m/s\N{SUPERSCRIPT TWO}" if size else "no gravity")
        if "axes" in self.kinds:
            few = "" if len(_framed(self.source.scene)) <= MOST_AXES else " of some elements"
            parts.append(f"local axes{few}: x' red, y' green" + ("" if self.source.scene.planar else ", z' blue"))
        half = (len(parts) + 1) // 2 if len(parts) > 3 else len(parts)
        return "\n".join("   ".join(line) for line in (parts[:half], parts[half:]) if line)


def forces(source: PictureSource, kind: str, k: int) -> Forces:
    """Loads or reactions of step k. Raises UsageError when the result does not hold them."""
    scene = source.scene
    f = np.ravel(source.get("fx" if kind == "loads" else "fxtot", k)).astype(float)
    if kind == "reactions":
        f = np.where(scene.held, f, 0.0)
    force = positions(scene, f)[scene.position_nodes - 1]
    where = {turn: places[0] for turn, places in attachments(scene, True).items() if places}
    nodes = [t for t in scene.orientation_nodes.tolist() if t in where]
    turn = scene.lnp[np.array(nodes, int) - 1]
    if scene.planar:
        moment = np.zeros((len(nodes), 3))
        moment[:, 2] = f[turn[:, 0] - 1]
    else:
        moment = moments(np.ravel(source.x(k))[turn - 1], f[turn - 1])
    return Forces(tuple(scene.position_nodes.tolist()), force, tuple(where[t] for t in nodes), moment)


def moments(euler: Array, f: Array) -> Array:
    """(n, 3) global moments of generalized forces f (n, 4) on Euler parameters (n, 4): L f/2 (files.md section 5)."""
    return 0.5 * np.einsum("ijn,nj->ni", global_matrix(euler.T), f)


def arrow(a: Array, b: Array, size: float, colour: Colour, flat: bool) -> list[Shape]:
    """A straight arrow from a to b; a short one has a head of its own length. `flat`: in a planar picture."""
    length, u = float(np.linalg.norm(b - a)), unit(b - a)
    if not length:
        return []
    head = min(1.1 * size, length)
    side, up = normal_pair(u) if abs(u[2]) > 1e-9 else (np.cross([0, 0, 1.0], u), np.array([0, 0, 1.0]))
    base = b - head * u
    if flat:
        shaft = Line(np.stack((a, base + 0.1 * head * u)), colour, 1.8, 6)
        return [shaft, arrow_head(b, base, 0.36 * head * side, colour)]
    blades = np.stack([np.stack((base + 0.36 * head * w, b, base - 0.36 * head * w)) for w in (side, up)])
    return [Line(np.stack((a, b)), colour, 1.8, 6), Line(blades, colour, 1.8, 6)]  # in front of solids


def double_arrow(at: Array, share: Array, size: float, colour: Colour) -> list[Shape]:
    """A moment in space: an arrow along its axis (right-hand rule) with two heads."""
    tip = at + ARROW * size * share
    u = share / np.linalg.norm(share)
    return [*arrow(at, tip, size, colour, False), *arrow(at, tip - 0.8 * size * u, size, colour, False)]


def turning(at: Array, share: Array, size: float, colour: Colour) -> list[Shape]:
    """A moment in the plane: an arc with a head; its length is the share of the largest one."""
    value = share[2]
    r = ARROW / 3 * size
    end = 0.5 + np.sign(value) * (0.4 + 4.4 * abs(value))
    x, y, _ = np.eye(3)
    arc = circle(at, x, y, r, 40, (0.5, end))
    radial = (arc[-1] - at) / r
    before = arc[-1] - np.sign(value) * 1.1 * size * np.cross((0.0, 0.0, 1.0), radial)
    return [Line(arc, colour, 1.6, 6), arrow_head(arc[-1], before, 0.4 * size * radial, colour)]


def node_masses(scene: Scene, xm: Array) -> dict[int, float]:
    """Mass [kg] of the position nodes that have one."""
    return {n: float(xm[n - 1, 0]) for n in scene.position_nodes.tolist() if n <= len(xm) and xm[n - 1, 0] > 0}


def _masses(scene: Scene, pose: Pose, look: Look, xm: Array) -> list[Shape]:
    """Discs whose volume as balls goes with the mass."""
    found = node_masses(scene, xm)
    top = max(found.values(), default=1.0)
    return [
        Mark(pose.place[n - 1], 4.0 + 10.0 * np.cbrt(mass / top), MASS, "#ffffff", 5)
        for n, mass in found.items()
    ]


def _gravity(scene: Scene, pose: Pose, look: Look, g: Array) -> list[Shape]:
    """An arrow beside the mechanism."""
    size = np.linalg.norm(g)
    if not size:
        return []
    places = pose.place[scene.position_nodes - 1]
    low, high = (places.min(0), places.max(0)) if len(places) else (np.zeros(3), np.zeros(3))
    down = g / size
    corner = np.where(down > 0.5, low, high) + 2.5 * look.size * (1 - np.abs(down)) * ([1, 1, 0] if scene.planar else 1)
    half = 0.3 * ARROW * look.size * down
    return arrow(corner - half, corner + half, look.size, GRAVITY, scene.planar)


def _framed(scene: Scene) -> list[int]:
    return [e.number for e in scene.elements if scene.frame_p[e.number - 1].any() and e.p]


def _axes(scene: Scene, pose: Pose, look: Look) -> list[Shape]:
    """Local axes x', y', z' of elements with a frame, a little way from p on the drawn line, x' along it."""
    numbers = set(_framed(scene))
    every = max(1, -(-len(numbers) // MOST_AXES))
    shown = [e for e in scene.elements if e.number in numbers and e.number not in look.settings.hidden][::every]
    if not shown:
        return []
    frames = pose.frames(scene, rows_of(shown)).copy()
    ends = pose.place[scene.node_table[rows_of(shown)][:, [0, 2]] - 1]
    ends[:, 1] = np.where(np.array([[e.q > 0] for e in shown]), ends[:, 1], ends[:, 0])
    at = 0.7 * ends[:, 0] + 0.3 * ends[:, 1]
    for i, e in enumerate(shown):
        if e.shape == "beam" and e.q:
            points, y, z = (part[0] for part in beam_lines(scene, pose, [e], 11))
            along = points[4] - points[2]
            size = np.linalg.norm(along)
            if size > 0.0:
                at[i], frames[i] = points[3], (along / size, y[3], z[3])
    return [
        Line(np.stack((at, at + 2.2 * look.size * frames[:, k]), axis=1), AXES[k], 1.6, 6)
        for k in range(scene.dimension)
    ]
