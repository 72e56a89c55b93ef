"""Pictures that follow each other quickly: shapes straight to the pixels, without an artist for each of them.

One artist holds a whole picture. Its shapes become a handful of calls of the renderer: all opaque polygons and lines of
a spatial picture as triangles sorted by depth (painter's algorithm), lines that look alike as one path with gaps,
polygons of one colour as one path. Stills use `paint`, whose collections also suit svg and pdf.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.path import Path
from matplotlib.transforms import Affine2D, IdentityTransform

from spacar.arrays import Array
from spacar_drawing.drawn_shapes import Faces, Line, Mark, Shape, marks_alike, together, unit
from spacar_drawing.paint import brightness, in_front, rgba
from spacar_drawing.stage import Camera

DILATED = 1.0  # pixels that the renderer adds to the width of a triangle, so that neighbours leave no gap
Call = Callable[[Any, Any], None]  # of a renderer and a graphics context


def can_raster(canvas: Any) -> bool:
    """The canvas draws pixels with Agg, as those of files and of the usual windows do."""
    return hasattr(canvas, "buffer_rgba")


class Raster(Artist):
    """The shapes of one picture as one artist of the axes.

    turn (2, 2), shift (2,)  from the plane of the picture to pixels;  point  pixels in a point: of the draw under way
    """

    turn: Array
    shift: Array
    point: float

    def __init__(self, axes: Axes, camera: Camera) -> None:
        super().__init__()
        self.camera = camera
        self.shapes: Sequence[Shape] = ()
        self.set_animated(True)
        self.set_zorder(10)
        axes.add_artist(self)

    def draw(self, renderer: Any) -> None:
        assert self.axes is not None
        matrix = self.axes.transData.get_affine().get_matrix()
        self.turn, self.shift, self.point = matrix[:2, :2].T, matrix[:2, 2], renderer.points_to_pixels(1.0)
        gc = renderer.new_gc()
        gc.set_clip_rectangle(self.axes.bbox)
        for _, call in sorted(self.planar() if self.camera.planar else self.spatial(), key=lambda pair: pair[0]):
            call(renderer, gc)
        gc.restore()

    def pixels(self, points: Array) -> Array:
        return self.camera.project(points) @ self.turn + self.shift

    def planar(self) -> list[tuple[float, Call]]:
        """The shapes as calls of a renderer with the height at which they lie."""
        calls = [(10.0 + s.layer, self.areas(s)) for s in self.shapes if isinstance(s, Faces)]
        return calls + self.lines([s for s in self.shapes if isinstance(s, Line)], None) + self.marks()

    def spatial(self) -> list[tuple[float, Call]]:
        front, behind = in_front(self.shapes)
        calls = [(10.0, self.solids(behind))] if behind else []
        return calls + self.lines(front, 15.0) + self.marks()

    def lines(self, lines: Sequence[Line], height: float | None) -> list[tuple[float, Call]]:
        """Those that look alike as one path: nothing is drawn twice where pale ones meet."""
        kinds = together(
            ((10.5 + s.layer if height is None else height, s.colour, s.width, s.dashes, s.alpha), s) for s in lines
        )
        return [(key[0], self._stroke(found)) for key, found in kinds.items()]

    def _stroke(self, lines: Sequence[Line]) -> Call:
        every = [self.pixels(s.points.reshape(-1, *s.points.shape[-2:])) for s in lines]
        parts = [np.pad(p, ((0, 0), (0, 1), (0, 0)), constant_values=np.nan).reshape(-1, 2) for p in every]  # gaps
        path, look = Path(np.concatenate(parts)), lines[0]
        colour = tuple(rgba(look.colour, look.alpha)[0])

        def call(renderer: Any, gc: Any) -> None:
            gc.set_linewidth(look.width)
            gc.set_foreground(colour, isRGBA=True)
            gc.set_dashes(0, [d * look.width for d in look.dashes] or None)
            gc.set_capstyle("round" if look.alpha >= 1 and not look.dashes else "butt")
            gc.set_joinstyle("round")
            renderer.draw_path(gc, path, IdentityTransform(), None)

        return call

    def areas(self, s: Faces) -> Call:
        """Polygons of one colour as one path; of many colours as triangles."""
        if isinstance(s.colour, np.ndarray):
            return self.solids([s])
        corners = self.pixels(s.corners)
        x, y = corners[..., 0], corners[..., 1]
        area = np.sum(x * np.roll(y, -1, axis=1) - np.roll(x, -1, axis=1) * y, axis=1)
        corners = np.where(area[:, None, None] < 0, corners[:, ::-1], corners)  # else opposite ones would cut holes
        points = np.concatenate((corners, corners[:, :1]), axis=1)
        codes = np.full(points.shape[:2], Path.LINETO, Path.code_type)
        codes[:, 0], codes[:, -1] = Path.MOVETO, Path.CLOSEPOLY
        path = Path(points.reshape(-1, 2), codes.ravel())
        face, edge = (*rgba(s.colour, s.alpha)[0],), s.edge

        def call(renderer: Any, gc: Any) -> None:
            gc.set_linewidth(s.width if edge is not None else 0.0)
            gc.set_foreground(tuple(rgba(edge or s.colour, 1.0)[0]), isRGBA=True)
            gc.set_dashes(0, None)
            gc.set_joinstyle("miter")
            renderer.draw_path(gc, path, IdentityTransform(), face)

        return call

    def marks(self) -> list[tuple[float, Call]]:
        return [(10.0 + look.layer, self._dots(look, places)) for look, places in marks_alike(self.shapes)]

    def _dots(self, look: Mark, at: Array) -> Call:
        places = Path(self.pixels(at))
        face, edge = tuple(rgba(look.face, 1.0)[0]), tuple(rgba(look.edge, 1.0)[0])
        size = 0.5 * look.size * self.point

        def call(renderer: Any, gc: Any) -> None:
            gc.set_linewidth(0.8)
            gc.set_foreground(edge, isRGBA=True)
            gc.set_dashes(0, None)
            renderer.draw_markers(gc, Path.unit_circle(), Affine2D().scale(size), places, IdentityTransform(), face)

        return call

    def solids(self, shapes: Sequence[Line | Faces]) -> Call:
        """Triangles of all faces and lines, the far ones first."""
        found: list[tuple[Array, Array, Array]] = []
        for s in shapes:
            if isinstance(s, Faces):
                found += self._faces(s)
            else:
                pieces = s.pieces
                depth = self.camera.depth(pieces).mean(axis=1)
                found += self._bands(pieces, depth, s.width, rgba(s.colour, s.alpha, len(pieces)))
        corners, depths, colours = (np.concatenate([t[i] for t in found]) for i in range(3))
        order = np.argsort(depths, kind="stable")
        triangles = np.ascontiguousarray(corners[order])
        shades = np.ascontiguousarray(np.repeat(colours[order, None], 3, axis=1))

        def call(renderer: Any, gc: Any) -> None:
            renderer.draw_gouraud_triangles(gc, triangles, shades, IdentityTransform())

        return call

    def _faces(self, s: Faces) -> list[tuple[Array, Array, Array]]:
        """(corners (n, 3, 2), depth (n,), colours (n, 4)) of the polygons that can be seen, and of their edges."""
        faces = s.corners
        colour = rgba(s.colour, s.alpha, len(faces))
        if s.closed and s.alpha >= 1:
            normal = np.cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0])
            seen = normal @ self.camera.near > 0
            faces, colour = faces[seen], colour[seen]
        if s.light and not self.camera.planar:
            colour[:, :3] *= brightness(self.camera, faces)[:, None]
        k = faces.shape[1]
        depth = self.camera.depth(faces).mean(axis=1)
        flat = self.pixels(faces)
        fan = np.array([(0, i, i + 1) for i in range(1, k - 1)])
        parts = [(flat[:, fan].reshape(-1, 3, 2), np.repeat(depth, k - 2), np.repeat(colour, k - 2, axis=0))]
        if s.edge is not None:
            around = np.stack((faces, np.roll(faces, -1, axis=1)), axis=2).reshape(-1, 2, 3)
            parts += self._bands(around, np.repeat(depth, k), s.width, rgba(s.edge, 1.0, k * len(faces)))
        return parts

    def _bands(self, pieces: Array, depth: Array, width: float, colour: Array) -> list[tuple[Array, Array, Array]]:
        """Straight pieces (n, 2, 3) as bands of a width [points]."""
        ends = self.pixels(pieces)
        along = unit(ends[:, 1] - ends[:, 0])
        half = 0.5 * max(width * self.point - DILATED, 0.05)
        side = half * np.stack((-along[:, 1], along[:, 0]), axis=1)
        a, b = ends[:, 0], ends[:, 1]
        both = np.stack((a + side, b + side, b - side, a + side, b - side, a - side), axis=1)
        return [(both.reshape(-1, 3, 2), np.repeat(depth, 2), np.repeat(colour, 2, axis=0))]
