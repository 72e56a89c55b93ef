"""Slender parts - beams, rigid bodies, bars - as shapes: all that look alike in one piece, without a loop over them.

The true elastic line of a beam: Hermite cubic through both ends, with the shear deflection added.

Centre line r(xi) = sum N_k(xi) y_k, y = (x_p, l0 t_p, x_q, l0 t_q), t the directions normal to the end sections
(theory-planar.md 3.4 (9), theory-spatial.md 3.6). With shear flexibility the sections are not normal to the centre
line; the exact shape functions of a Timoshenko beam without distributed load are (N_k + Phi L_k)/(1 + Phi) with
L = (1 - xi, (xi - xi^2)/2, xi, -(xi - xi^2)/2) and Phi = 12 EI/(GAk l0^2). The difference to the cubic,
Phi/(1 + Phi) sum (L_k - N_k) y_k, is taken in each of the two bending directions with its own Phi.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import Array, Index
from spacar_drawing import look as paint
from spacar_drawing.drawn_shapes import Colour, Faces, Line, Shape, bordered, disc_outline, solid, together, unit
from spacar_drawing.look import Look
from spacar_drawing.scene import Element, Pose, Scene
from spacar_drawing.sections import breadth, hole, outline
from spacar_drawing.settings import SectionShape


def shape_functions(xi: Array) -> tuple[Array, Array]:
    """N and L, each (4, n), at xi (n,) from 0 to 1."""
    s2, s3, b = xi**2, xi**3, 0.5 * (xi - xi**2)
    N = np.stack((1 - 3 * s2 + 2 * s3, xi - 2 * s2 + s3, 3 * s2 - 2 * s3, s3 - s2))
    return N, np.stack((1 - xi, b, xi, -b))


def elastic_line(ends: Array, tangents: Array, l0: Array | float, across: Array, Phi: Array, n: int) -> Array:
    """(..., n, 3) points of elastic lines [m]; any number of beams in the leading axes.

    ends (..., 2, 3) x_p, x_q [m]; tangents (..., 2, 3) unit vectors normal to the end sections; l0 (...) undeformed
    length [m]; across (..., 2, 3) unit vectors of the bending directions y', z'; Phi (..., 2) shear parameters of
    bending along y', z'.
    """
    N, L = shape_functions(np.linspace(0.0, 1.0, n))
    y = np.stack((ends, np.asarray(l0)[..., None, None] * tangents), axis=-2)  # (..., 2 ends, place and slope, 3)
    y = y.reshape(*y.shape[:-3], 4, 3)
    points = N.T @ y
    if np.any(Phi):
        shear = (L - N).T @ y
        for k in (0, 1):
            direction, value = across[..., k, :], Phi[..., k]
            share = (value / (1.0 + value))[..., None, None]
            points = points + share * (shear @ direction[..., :, None]) * direction[..., None, :]
    return points


def section_axes(points: Array, y_p: Array, y_q: Array, slopes: Array | None = None) -> tuple[Array, Array]:
    """y', z' (..., n, 3) along lines of points (..., n, 3), y' normal to the line.

    It turns linearly from y_p to y_q (..., 3); with `slopes` (..., 2) [rad], twist rates at the ends times the length,
    as the cubic with these slopes (theory-warping.md section 3).
    """
    tangent = unit(np.gradient(points, axis=-2))
    xi = np.linspace(0.0, 1.0, points.shape[-2])[:, None]
    y = (1 - xi) * y_p[..., None, :] + xi * y_q[..., None, :]
    y = unit(y - np.sum(y * tangent, axis=-1, keepdims=True) * tangent)
    z = np.cross(tangent, y)
    if slopes is not None:
        last, first = y[..., -1, :], (y[..., 0, :], z[..., 0, :])
        twist = np.arctan2(np.sum(last * first[1], axis=-1), np.sum(last * first[0], axis=-1))[..., None, None]
        p, q = slopes[..., 0, None, None], slopes[..., 1, None, None]
        N = shape_functions(xi)[0]
        cubic = twist * N[2] + p * N[1] + q * N[3]
        more = cubic - twist * xi
        y, z = np.cos(more) * y + np.sin(more) * z, np.cos(more) * z - np.sin(more) * y
    return y, z


def chord_axes(ends: Array, y_p: Array, y_q: Array) -> Array:
    """(..., 2, 3) y', z' normal to the chords of ends (..., 2, 3), midway between them: where the shear part acts."""
    d = unit(ends[..., 1, :] - ends[..., 0, :])
    y = y_p + y_q
    y = unit(y - np.sum(y * d, axis=-1, keepdims=True) * d)
    return np.stack((y, np.cross(d, y)), axis=-2)


Z = np.array([0.0, 0.0, 1.0])
# radius of spatial beams without a cross-section, of the symbol size
DRAWN_ONLY, THIN_BEAM, THICK_BEAM = 0.20, 0.28, 0.40
SMOOTH = 0.1  # two bodies whose directions differ by less than this many radians need no closed ends where they meet


def rows_of(elements: Sequence[Element]) -> Index:
    return np.array([e.number - 1 for e in elements], int)


def beam_lines(scene: Scene, pose: Pose, elements: Sequence[Element], n: int) -> tuple[Array, Array, Array]:
    """Points and axes y', z' (m, n, 3) of the elastic lines of elements of one shape; straight lines pq if no beams.

    All of them, or none, have warping nodes.
    """
    rows = rows_of(elements)
    nodes = scene.node_table[rows]
    ends = pose.place[nodes[:, [0, 2]] - 1]
    frame_p = pose.frames(scene, rows, "p")
    frame_q = np.where(nodes[:, 3, None, None] > 0, pose.frames(scene, rows, "q"), frame_p)
    y_p, y_q = frame_p[:, 1], frame_q[:, 1]
    if elements[0].shape == "beam":
        tangents = np.stack((frame_p[:, 0], frame_q[:, 0]), axis=1)
        across = chord_axes(ends, y_p, y_q)
        points = elastic_line(ends, tangents, scene.length[rows], across, scene.shear[rows], n)
    else:
        points = ends[:, :1] + np.linspace(0.0, 1.0, n)[:, None] * (ends[:, 1:] - ends[:, :1])
    y = np.where(np.any(y_p, axis=1, keepdims=True), y_p, Z)
    slopes = None
    if elements[0].warping:
        warping = np.array([e.warping for e in elements], int)
        slopes = scene.length[rows, None] * pose.rate[warping - 1]
    y, z = section_axes(points, y, np.where(np.any(y_q, axis=1, keepdims=True), y_q, y), slopes)
    return points, y, z


@dataclass(frozen=True)
class Alike:
    """Slender parts that look alike: n points on a line; width [points] of a line, or radius of a rod [symbol size]."""

    elements: Sequence[Element]
    n: int
    colour: Colour
    width: float
    radius: float
    section: SectionShape | None


def alike_bodies(scene: Scene, look: Look, elements: Sequence[Element]) -> list[Alike]:
    """Beams, rigid bodies and straight trusses by how they look; of bodies that hold nothing those that lie beside
    another one are not drawn."""

    def items() -> Iterable[tuple[tuple[Any, ...], Element]]:
        for e in elements:
            i = e.number - 1
            rigid = e.shape == "body" or bool(scene.rigid[i])
            width, radius, usual = (2.8, THICK_BEAM, paint.RIGID) if rigid else (2.2, THIN_BEAM, paint.FLEXIBLE)
            if e.shape == "truss":
                width, radius = 2.2, THIN_BEAM
                usual = paint.DRIVE if scene.e_class(e.number, 1) == "input" else paint.TRUSS
            elif e.shape == "body" and scene.free[i]:
                if scene.doubled[i]:
                    continue
                width, radius = 1.2, DRAWN_ONLY
            dress = look.settings.section(e.number, e.shape), look.settings.opacity_of(e.number)
            yield (e.shape, width, radius, look.colour(e.number, usual), dress, bool(e.warping)), e

    found = []
    for (shape, width, radius, colour, (section, _), _), alike in together(items()).items():
        short = 2 if scene.planar or shape == "truss" else 25  # short pieces sort better by depth
        found.append(Alike(alike, look.points if shape == "beam" else short, colour, width, radius, section))
    return found


def bodies(scene: Scene, pose: Pose, look: Look, elements: Sequence[Element]) -> list[Shape]:
    """Beams and rigid bodies along their elastic lines, trusses by their cross-section or as lines."""
    shapes: list[Shape] = []
    for g in alike_bodies(scene, look, elements):
        if g.elements[0].shape == "truss" and outline(g.section) is None:
            nodes = scene.node_table[rows_of(g.elements)][:, [0, 2]]
            shapes.append(Line(pose.place[nodes - 1], g.colour, g.width, 2))
        else:
            shapes += slender(scene, pose, look, g.elements, g.n, g.colour, g.width, g.radius)
    return shapes


def slender(
    scene: Scene, pose: Pose, look: Look, alike: Sequence[Element], n: int, colour: Colour | Array, width: float,
    radius: float,
) -> list[Shape]:  # fmt: skip
    """Slender parts of one shape, cross-section and opacity along their elastic lines: with the section, or as a line
    or thin rod.

    colour  of all, or (m, n - 1, 3), one for every piece of the lines;  width [points] of a line
    radius  of a rod, of the symbol size

    In the plane strips of the width of the section, or lines when it has none.
    """
    settings, first = look.settings, alike[0]
    section, alpha = settings.section(first.number, first.shape), settings.opacity_of(first.number)
    points, y, z = beam_lines(scene, pose, alike, n)
    if scene.planar:
        if not breadth(section):
            return _pieces(points, colour, width, alpha)
        half = 0.5 * breadth(section) * y
        left, right = points + half, points - half
        if isinstance(colour, np.ndarray):
            quads = np.stack((left[:, :-1], left[:, 1:], right[:, 1:], right[:, :-1]), axis=2)
            return [Faces(quads.reshape(-1, 4, 3), colour.reshape(-1, 3), None, alpha, 1, False)]
        return bordered(np.concatenate((left, right[:, ::-1]), axis=1), colour, colour, 0.8, (1, 2), 0.75 * alpha)
    ends = open_ends(scene, alike, points) if len(alike) > 1 and alpha >= 1 else None
    contour = outline(section)
    if contour is not None and section is not None:
        return solid(contour, points, y, z, colour, alpha, settings.light, hole(section), None, ends)
    if section is not None:  # LINE
        return _pieces(points, colour, width, alpha)
    sides = paint.ROD_SIDES if n > paint.LEAST_POINTS else paint.ROD_SIDES // 2
    return solid(disc_outline(radius * look.size, sides), points, y, z, colour, alpha, settings.light, ends=ends)


def open_ends(scene: Scene, alike: Sequence[Element], points: Array) -> NDArray[np.bool_]:
    """(m, 2) whether an end can be seen: not where two of these bodies go on smoothly in each other."""
    nodes = scene.node_table[rows_of(alike)][:, [0, 2]]
    inward = unit(np.stack((points[:, 1] - points[:, 0], points[:, -2] - points[:, -1]), axis=1))
    total, count = np.zeros((len(scene.lnp), 3)), np.zeros(len(scene.lnp), int)
    np.add.at(total, nodes - 1, inward)
    np.add.at(count, nodes - 1, 1)
    smooth = (count == 2) & (np.linalg.norm(total, axis=1) < SMOOTH)
    return ~smooth[nodes - 1]


def _pieces(points: Array, colour: Colour | Array, width: float, alpha: float) -> list[Shape]:
    if not isinstance(colour, np.ndarray):
        return [Line(points, colour, width, 2, alpha=alpha)]
    pairs, colours = Line(points).pieces, colour.reshape(-1, 3)
    return [Line(pair, (c[0], c[1], c[2]), width, 2, alpha=alpha) for pair, c in zip(pairs, colours, strict=True)]
