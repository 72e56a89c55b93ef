"""A result as one mesh that moves: what the page of `spacar view` draws.

Every corner of the mesh is p + a X + b Y + c Z with a fixed place (a, b, c) in one of n frames (p; X, Y, Z) that move
from picture to picture. Along beams and lines there is a frame at every point of the elastic line; a part that keeps
its shape (a hinge, a wheel, a support) has one frame, found by the rotation that fits its corners best (singular value
decomposition of their covariance: reference/bibliography.md, Kabsch); anything else has a frame for every corner. Only
the frames are stored for every picture.
"""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import Array
from spacar_drawing.bodies import alike_bodies, beam_lines, open_ends
from spacar_drawing.drawn_shapes import Faces, Line, Mark, Shape, convex_pieces, disc_outline, placed, unit
from spacar_drawing.element_pictures import divided, wound_arcs
from spacar_drawing.look import SYMBOL, Look
from spacar_drawing.paint import rgba
from spacar_drawing.scene import Pose, Scene
from spacar_drawing.sections import outline
from spacar_drawing.supports import support_shapes

RIGID = 1e-6  # of the extent: corners that stay within this of a turned and moved part belong to a rigid one
THICKNESS = 0.09  # radius of a line of one point, of the symbol size
SIDES = 8  # of a rod; half of them where there are many
MANY = 500  # beams
PLACE, NORMAL, COLOUR, FRAME, ELEMENT = slice(3), slice(3, 6), slice(6, 9), 9, 10  # columns of corners
Draw = Callable[[Pose], list[Shape]]


class TriangleMesh:
    """Parts that were added, one after the other, in pictures with symbols of a size [m].

    frames, corners   how many there are
    lines   of frames on elastic lines, which follow each other: the first one, numbers of elements, points on each
    """

    def __init__(self, size: float, pictures: int) -> None:
        self.size, self.frames, self.corners = size, 0, 0
        self._moving, self._corner = [np.zeros((3, pictures, 0, 3))], [np.zeros((0, ELEMENT + 1))]
        self._triangles = [np.zeros((0, 3), np.int64)]
        self.lines: list[tuple[int, list[int], int]] = []

    @property
    def moving(self) -> Array:
        """(3, pictures, frames, 3) p, Y, Z of the frames."""
        return np.concatenate(self._moving, axis=2)

    @property
    def corner(self) -> Array:
        """(corners, 11) in columns PLACE, NORMAL, COLOUR (0 to 1), FRAME, ELEMENT."""
        return np.concatenate(self._corner)

    @property
    def triangles(self) -> NDArray[np.int64]:
        """(n, 3) corners."""
        return np.concatenate(self._triangles)

    @property
    def owner(self) -> NDArray[np.int64]:
        """(frames,) elements, 0 for none."""
        found, corner = np.zeros(self.frames, np.int64), self.corner
        found[corner[:, FRAME].astype(np.int64)] = corner[:, ELEMENT]
        return found

    def add(
        self, moving: Sequence[Array], frame: Array, place: Array, colour: Array, element: Array, triangles: Array,
        normal: Array | None = None,
    ) -> None:  # fmt: skip
        """Frames p, Y, Z (pictures, n, 3) each and the corners in them; both are counted from 0 here."""
        normal = np.zeros_like(place) if normal is None else normal
        self._moving.append(np.stack(moving))
        self._corner.append(np.column_stack((place, normal, colour, frame + self.frames, element)))
        self._triangles.append(np.asarray(triangles, np.int64) + self.corners)
        self.frames += moving[0].shape[1]
        self.corners += len(place)

    def tubes(
        self, points: Array, y: Array, z: Array, contour: Array, colour: Array, elements: Array, round_: bool,
        ends: NDArray[np.bool_] | None = None,
    ) -> None:  # fmt: skip
        """An outline (k, 2) along m lines: points, y, z (pictures, m, n, 3); colour (3,); elements (m,) numbers; ends
        (m, 2) which of them are closed, default all."""
        pictures, m, n, _ = points.shape
        k = len(contour)
        corner, sides = _sides(m, n, k)
        fan = np.array([(q[0], q[i], q[i + 1]) for q in convex_pieces(contour) for i in range(1, len(q) - 1)])
        closed = np.ones((m, 2), bool) if ends is None else ends
        caps = [corner[closed[:, i], at][:, fan].reshape(-1, 3) for i, at in enumerate((0, -1))]
        place = np.zeros((m * n * k, 3))
        place[:, 1:] = np.tile(contour, (m * n, 1))
        normal = unit(place) if round_ else None
        self.add(
            [v.reshape(pictures, -1, 3) for v in (points, y, z)], np.repeat(np.arange(m * n), k), place,
            np.tile(colour, (m * n * k, 1)), np.repeat(elements, n * k), np.concatenate([sides, *caps]), normal,
        )  # fmt: skip

    def part(self, corners: Array, colour: Array, element: int, triangles: Array, extent: float) -> None:
        """Corners (pictures, n, 3) of one part: as a rigid one when they keep their distances, else as they are."""
        centre, turn, rest = rigid_motion(corners)
        n = corners.shape[1]
        if np.max(np.abs(rest), initial=0.0) <= RIGID * extent:
            frames = centre[:, None], turn[:, None, :, 1], turn[:, None, :, 2]
            frame, place = np.zeros(n), corners[0] - centre[0]
        else:
            y, z = (np.broadcast_to(np.eye(3)[i], corners.shape) for i in (1, 2))
            frames, frame, place = (corners, y, z), np.arange(float(n)), np.zeros((n, 3))
        self.add(frames, frame, place, colour, np.full(n, element), triangles)


def _sides(m: int, n: int, k: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Numbers (m, n, k) of the corners of m tubes with n rings of k corners, and the triangles (..., 3) of sides."""
    corner = np.arange(m * n * k).reshape(m, n, k)
    after = np.roll(corner, -1, axis=2)
    a, b, c, d = corner[:, :-1], after[:, :-1], after[:, 1:], corner[:, 1:]
    return corner, np.stack((a, b, c, a, c, d), axis=-1).reshape(-1, 3)


def rigid_motion(corners: Array) -> tuple[Array, Array, Array]:
    """centre (k, 3), turn (k, 3, 3) of the motions that fit the corners (k, n, 3) best, from those of the first
    picture, and rest (k, n, 3), what they leave; least squares."""
    centre = corners.mean(axis=1)
    first, every = corners[0] - centre[0], corners - centre[:, None]
    u, _, v = np.linalg.svd(np.swapaxes(every, 1, 2) @ first)
    proper = np.sign(np.linalg.det(u @ v))
    u[:, :, 2] *= np.where(proper == 0, 1.0, proper)[:, None]
    turn = u @ v
    return centre, turn, every - first @ np.swapaxes(turn, 1, 2)


def mesh_of(scene: Scene, xs: Array, look: Look, more: Sequence[Draw] = ()) -> TriangleMesh:
    """The mechanism at the configurations xs (pictures, nx), and what `more` draws."""
    mesh = TriangleMesh(look.size, len(xs))
    poses = [Pose.of(scene, x) for x in xs]
    lines, single = divided(scene, look)
    groups = alike_bodies(scene, look, lines)
    few = sum(len(g.elements) for g in groups) < MANY
    for group in groups:
        contour = outline(group.section)
        round_ = contour is None or (group.section is not None and group.section.shape.startswith("CIRC"))
        if contour is None:
            contour = disc_outline(group.radius * mesh.size, SIDES if few else SIDES // 2)
        parts = [beam_lines(scene, pose, group.elements, group.n) for pose in poses]
        points, y, z = (np.stack(part) for part in zip(*parts, strict=True))
        numbers = np.array([e.number for e in group.elements])
        mesh.lines.append((mesh.frames, numbers.tolist(), group.n))
        ends = open_ends(scene, group.elements, points[0])
        mesh.tubes(points, y, z, contour, rgba(group.colour, 1.0)[0, :3], numbers, round_, ends)
    for draw, e in single:
        _shapes(mesh, [draw(scene, pose, look, e) for pose in poses], e.number)
    for what in (wound_arcs, support_shapes):
        _shapes(mesh, [what(scene, pose, look) for pose in poses], 0)
    for extra in more:
        _shapes(mesh, [extra(pose) for pose in poses], 0)
    return mesh


def _shapes(mesh: TriangleMesh, every: Sequence[Sequence[Shape]], element: int) -> None:
    """The shapes of every picture, matched from one to the next; what comes and goes is left out."""
    extent = mesh.size / SYMBOL
    for alike in zip(*every, strict=False):
        first = alike[0]
        if any(type(s) is not type(first) for s in alike) or isinstance(first, Mark):
            continue
        if isinstance(first, Faces):
            faces = [s.corners for s in alike if isinstance(s, Faces)]
            if any(f.shape != faces[0].shape for f in faces):
                continue
            m, k, _ = faces[0].shape
            corner = np.arange(m * k).reshape(m, k)
            fan = np.stack([corner[:, [0, i, i + 1]] for i in range(1, k - 1)], axis=1).reshape(-1, 3)
            colour = np.repeat(rgba(first.colour, 1.0, m)[:, :3], k, axis=0)
            mesh.part(np.stack(faces).reshape(len(every), -1, 3), colour, element, fan, extent)
        elif isinstance(first, Line):
            lines = [s.points for s in alike if isinstance(s, Line)]
            if all(p.shape == lines[0].shape for p in lines):
                _line(mesh, np.stack(lines), first, element, extent)


def _line(mesh: TriangleMesh, points: Array, look: Line, element: int, extent: float) -> None:
    """A polyline, or several, (pictures, ..., n, 3) as thin tubes."""
    points = points.reshape(len(points), -1, *points.shape[-2:])
    tangent = unit(np.gradient(points, axis=-2))
    y = unit(np.cross(np.where(np.abs(tangent[..., 2:]) < 0.9, [0, 0, 1.0], [1.0, 0, 0]), tangent))
    z = np.cross(tangent, y)
    contour = disc_outline(THICKNESS * look.width * mesh.size, 4)
    m, n = points.shape[1:3]
    rigid = placed(contour, points, y, z).reshape(len(points), -1, 3)
    if np.max(np.abs(rigid_motion(rigid)[2]), initial=0.0) <= RIGID * extent:
        colour = np.tile(rgba(look.colour, 1.0)[0, :3], (m * n * 4, 1))
        mesh.part(rigid, colour, element, _sides(m, n, 4)[1], extent)
        return
    mesh.tubes(points, y, z, contour, rgba(look.colour, 1.0)[0, :3], np.full(m, element), True)
