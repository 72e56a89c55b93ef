"""Elements as shapes: one function per kind of element, and the table that says which."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from spacar.arrays import Array
from spacar_drawing import look as paint
from spacar_drawing import machine_parts as machine
from spacar_drawing.drawn_shapes import Colour, Faces, Line, Mark, Shape, disc_outline, solid
from spacar_drawing.elastic_line import chord_axes, elastic_line, section_axes
from spacar_drawing.look import Look, middle
from spacar_drawing.scene import Element, Pose, Scene
from spacar_drawing.sections import breadth, hole, outline

Z = np.array([0.0, 0.0, 1.0])
# radius of spatial beams without a cross-section, of the symbol size
DRAWN_ONLY, THIN_BEAM, THICK_BEAM = 0.20, 0.28, 0.40


def element_shapes(scene: Scene, pose: Pose, look: Look) -> list[Shape]:
    """All elements at one configuration, except those that the settings hide."""
    shapes: list[Shape] = []
    for e in scene.elements:
        if e.number not in look.settings.hidden:
            shapes += PARTS.get(e.shape, plain)(scene, pose, look, e)
    if any(e.shape == "belt" for e in scene.elements):
        shapes += machine.wound_arcs(scene, pose, look)
    return shapes


def beam_line(scene: Scene, pose: Pose, e: Element, n: int) -> tuple[Array, Array, Array]:
    """Points and axes y', z' (n, 3) of the elastic line of a beam; of another element, of the straight line pq."""
    ends = pose.place[[e.p - 1, e.q - 1]]
    frame_p = pose.frame(scene, e, "p")
    frame_q = pose.frame(scene, e, "q") if e.q_turn else frame_p
    if e.shape == "beam":
        l0 = float(scene.length[e.number - 1])
        across = chord_axes(ends, frame_p[1], frame_q[1])
        tangents = np.stack((frame_p[0], frame_q[0]))
        points = elastic_line(ends, tangents, l0, across, shear_parameters(scene, e), n)
    else:
        points = ends[0] + np.linspace(0.0, 1.0, n)[:, None] * (ends[1] - ends[0])
    y = frame_p[1] if frame_p[1].any() else Z
    slopes = None
    if e.warping:
        p, q = scene.length[e.number - 1] * pose.rate[[n - 1 for n in e.warping]]
        slopes = float(p), float(q)
    y, z = section_axes(points, y, frame_q[1] if frame_q[1].any() else y, slopes)
    return points, y, z


def shear_parameters(scene: Scene, e: Element) -> Array:
    """Phi of bending along y' and z' (input-language.md 5.3): 12 EI/(GAk l0^2), ESTIFF position 4 or 7 and 6."""
    row, l0 = scene.stiffness[e.number - 1], float(scene.length[e.number - 1])
    if not l0:
        return np.zeros(2)
    shear = np.array([row[2], 0.0]) if scene.planar else np.array([row[5], row[4]])
    return 12.0 * shear / l0**2


def beam(scene: Scene, pose: Pose, look: Look, e: Element) -> list[Shape]:
    rigid = e.shape == "body" or scene.is_rigid(e.number)
    colour = look.colour(e.number, paint.RIGID if rigid else paint.FLEXIBLE)
    n = look.points if e.shape == "beam" else 2 if scene.planar else 25  # short pieces sort better by depth
    if e.shape == "body" and scene.e_classes(e.number) == {"calculable"}:  # only there to be seen: holds nothing
        twin = any(o.number != e.number and {o.p, o.q} == {e.p, e.q} for o in scene.elements)
        return [] if twin else body(scene, pose, look, e, n, colour, 1.2, DRAWN_ONLY)
    return body(scene, pose, look, e, n, colour, 2.8 if rigid else 2.2, THICK_BEAM if rigid else THIN_BEAM)


def body(
    scene: Scene, pose: Pose, look: Look, e: Element, n: int, colour: Colour | Array, width: float, radius: float
) -> list[Shape]:
    """A slender part along its elastic line: with its cross-section, or as a line or thin rod.

    `colour` may be (n - 1, 3), one for every piece of the line.
    """
    settings = look.settings
    section = settings.section(e.number)
    if section is not None and section.shape == "LINE":
        section = None
        plain = True
    else:
        plain = scene.planar
    alpha = settings.opacity_of(e.number)
    points, y, z = beam_line(scene, pose, e, n)
    if scene.planar:
        return _planar_body(points, y, breadth(section), colour, width, alpha)
    contour = outline(section) if section is not None else None
    if contour is not None and section is not None:
        return list(solid(contour, points, y, z, colour, alpha, settings.light, hole(section)))
    if plain:
        return _pieces(points, colour, width, alpha)
    return list(solid(disc_outline(radius * look.size, 12), points, y, z, colour, alpha, settings.light))


def _planar_body(
    points: Array, y: Array, width: float, colour: Colour | Array, line: float, alpha: float
) -> list[Shape]:
    if not width:
        return _pieces(points, colour, line, alpha)
    left, right = points + 0.5 * width * y, points - 0.5 * width * y
    if isinstance(colour, np.ndarray):
        quads = np.stack((left[:-1], left[1:], right[1:], right[:-1]), axis=1)
        return [Faces(quads, colour, None, alpha, 1, False)]
    around = np.concatenate((left, right[::-1]))
    edge = np.concatenate((around, around[:1]))
    return [Faces(around[None], colour, None, 0.75 * alpha, 1, False), Line(edge, colour, 0.8, 2)]


def _pieces(points: Array, colour: Colour | Array, width: float, alpha: float) -> list[Shape]:
    if not isinstance(colour, np.ndarray):
        return [Line(points, colour, width, 2, alpha=alpha)]
    return [Line(points[i : i + 2], (c[0], c[1], c[2]), width, 2, alpha=alpha) for i, c in enumerate(colour)]


def truss(scene: Scene, pose: Pose, look: Look, e: Element) -> list[Shape]:
    """A bar; with stiffness but free to change its length a spring, with damping only a dashpot, with nothing a
    dotted measuring line."""
    ends = pose.place[[e.p - 1, e.q - 1]]
    i = e.number - 1
    kind = scene.e_class(e.number, 1)
    section = look.settings.section(e.number, truss=True)
    contour = outline(section) if section is not None else None
    if section is not None and contour is not None:
        colour = look.colour(e.number, paint.TRUSS)
        line, y, z = beam_line(scene, pose, e, 2)
        alpha = look.settings.opacity_of(e.number)
        if scene.planar:
            return _planar_body(line, y, breadth(section), colour, 2.0, alpha)
        return list(solid(contour, line, y, z, colour, alpha, look.settings.light, hole(section)))
    if kind in ("fixed", "input"):
        colour = look.colour(e.number, paint.TRUSS if kind == "fixed" else paint.DRIVE)
        return [Line(ends, colour, 2.2, 2)]
    if scene.stiffness[i, 0]:
        return machine.spring(scene, ends, look, look.colour(e.number, paint.SPRING), float(scene.length[i]))
    if scene.damping[i, 0] and scene.planar:
        return machine.dashpot(ends, look, look.colour(e.number, paint.SPRING))
    return [Line(ends, look.colour(e.number, paint.TRUSS), 0.9, 2, dashes=(1.5, 2.5))]


def hinge(scene: Scene, pose: Pose, look: Look, e: Element) -> list[Shape]:
    return machine.hinge(scene, pose, look, e)


def plain(scene: Scene, pose: Pose, look: Look, e: Element) -> list[Shape]:
    """What has no drawing of its own: a line between its position nodes, or a mark where it is if it has not both."""
    colour = look.colour(e.number, paint.TRUSS)
    ends = tuple(n for n in (e.p, e.q) if n)
    if len(ends) == 2:
        return [Line(pose.place[[e.p - 1, e.q - 1]], colour, 1.6, 2)]
    return [Mark(middle(pose, ends or look.hinges.get(e.number, ())), 5.0, colour, colour)]


# Shape of an element type -> how it is drawn; a shape that is not here is drawn as `plain`.
PARTS: dict[str, Callable[[Scene, Pose, Look, Element], list[Shape]]] = {
    "beam": beam,
    "body": beam,
    "truss": truss,
    "hinge": hinge,
    "belt": machine.belt,
    "planar wheel": machine.planar_wheel,
    "wheel": machine.wheel,
    "screw": machine.screw,
}
