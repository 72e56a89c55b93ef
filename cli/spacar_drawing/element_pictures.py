"""Elements as shapes: one function per kind of element, and the tables that say which.

Machine elements as shapes: springs, dashpots, hinges, belts and pulleys, wheels, screws.
"""

from collections.abc import Callable

import numpy as np

from spacar.arrays import Array
from spacar_drawing import look as paint
from spacar_drawing.bodies import beam_lines, bodies
from spacar_drawing.drawn_shapes import (
    Colour,
    Line,
    Mark,
    Shape,
    bordered,
    circle,
    cylinder,
    disc_outline,
    normal_pair,
    solid,
    torus,
    unit,
)
from spacar_drawing.look import Look, middle
from spacar_drawing.scene import Element, Pose, Scene
from spacar_drawing.sections import outline

X, Y, Z = np.eye(3)
DrawOne = Callable[[Scene, Pose, Look, Element], list[Shape]]


def spring(scene: Scene, ends: Array, look: Look, colour: Colour, l0: float) -> list[Shape]:
    """Zigzag (planar) or coil (spatial) between two points; the number of coils follows from the undeformed length."""
    s = look.size
    l, u = float(np.linalg.norm(ends[1] - ends[0])), unit(ends[1] - ends[0])
    coils = int(np.clip(0.45 * l0 / s, 4, 12))
    lead = min(0.18 * l, 2.0 * s)
    if scene.planar:
        v = np.cross(Z, u)
        along = lead + (l - 2 * lead) * np.concatenate(([0.0], (np.arange(2 * coils) + 0.5) / (2 * coils), [1.0]))
        side = np.concatenate(([0.0], np.where(np.arange(2 * coils) % 2, -0.7, 0.7) * s, [0.0]))
        points = ends[0] + along[:, None] * u + side[:, None] * v
    else:
        v, w = normal_pair(u)
        angle = np.linspace(0.0, 2 * np.pi * coils, 14 * coils + 1)
        ramp = 0.6 * s * np.minimum(1.0, np.minimum(angle, angle[::-1]) / 1.5)
        along = lead + (l - 2 * lead) * angle / angle[-1]
        side = ramp * np.array((np.cos(angle), np.sin(angle)))
        points = ends[0] + np.column_stack((along, *side)) @ np.stack((u, v, w))
    return [Line(np.concatenate((ends[:1], points, ends[1:])), colour, 1.3, 2)]


def dashpot(ends: Array, look: Look, colour: Colour) -> list[Shape]:
    """Cylinder at p, piston at q."""
    s, d = look.size, ends[1] - ends[0]
    half, v = min(1.2 * s, 0.2 * np.linalg.norm(d)) * unit(d), 0.75 * s * np.cross(Z, unit(d))
    mid = ends.mean(0)
    a, b, piston = mid - half, mid + half, mid + 0.2 * half
    strokes = (ends[0], a), (b + v, a + v, a - v, b - v), (piston, ends[1])
    across = Line(np.stack((piston + 0.8 * v, piston - 0.8 * v)), colour, 1.8, 2)
    return [*(Line(np.stack(stroke), colour, 1.3, 2) for stroke in strokes), across]


def hinge(scene: Scene, pose: Pose, look: Look, e: Element) -> list[Shape]:
    """Planar: a pin circle with a ring. Spatial: a cylinder along the axis. One that only measures is drawn open."""
    at = middle(pose, look.hinges.get(e.number, ()))
    driven = scene.e_class(e.number, 1) == "input"
    colour = look.colour(e.number, paint.DRIVE if driven else paint.HINGE)
    s = look.size
    if scene.planar:
        return bordered(circle(at, X, Y, 0.62 * s, 28)[:-1], "#ffffff", colour, 1.6, (5, 5))
    axis = pose.frame(scene, e)[0]
    crowd = sum(place == look.hinges[e.number] for place in look.hinges.values())
    # several at one place: slender, to be told apart
    usual = (0.62 * s, 2.6 * s) if crowd == 1 else (0.42 * s, 4.0 * s)
    radius, length = look.settings.hinges.get(e.number, look.settings.hinges.get(0, usual))
    half = 0.5 * length * axis
    if scene.e_class(e.number, 2) != "fixed":  # no bearing: it only measures the rotation
        return [Line(np.stack((at - 3 * half, at + 3 * half)), colour, 0.9, 5, (6, 2, 1, 2))]
    alpha = look.settings.opacity_of(e.number)
    return cylinder(at - half, at + half, radius, colour, alpha=alpha, light=look.settings.light)


def slides(scene: Scene, e: Element) -> bool:
    """A beam whose elongation is free or driven while its other deformations are held: the two parts of a slider. A
    kinematic check does not know the stiffness of a dynamic elongation: a spring there."""
    i = e.number - 1
    springs = ("fixed",) if scene.analysis.forces else ("fixed", "dynamic")
    loose = scene.e_class(e.number, 1) not in springs and not (scene.stiffness[i, 0] or scene.damping[i, 0])
    held = any(scene.e_class(e.number, mode) == "fixed" or scene.stiffness[i, mode - 1] for mode in (2, 3))
    return e.shape == "beam" and bool(e.p and e.q) and loose and held


def slider(scene: Scene, pose: Pose, look: Look, e: Element) -> list[Shape]:
    """The sleeve in which the one end of a beam slides on the other, half-way along it."""
    s = look.size
    points = beam_lines(scene, pose, [e], 5)[0][0]
    along = points[3] - points[1]
    length = np.linalg.norm(along)
    if not length:
        return []
    colour = look.colour(e.number, paint.DRIVE if scene.e_class(e.number, 1) == "input" else paint.HINGE)
    half = min(1.6 * s, length) * along / length
    ends = np.stack((points[2] - half, points[2] + half))
    if not scene.planar:
        a, b = ends
        return cylinder(a, b, 0.9 * s, colour, 4, look.settings.opacity_of(e.number), look.settings.light)
    side = 0.65 * s * np.cross(Z, along) / length
    return bordered(np.concatenate((ends + side, (ends - side)[::-1])), "#ffffff", colour, 1.6, (4, 4))


def span(scene: Scene, pose: Pose, e: Element) -> tuple[Array, Array]:
    """Tangent points of the straight span of a belt at p and q (2, 3), and the radii.

    theory-planar.md section 7: sin delta = -(r_p - r_q)/d, n_b = cos delta nu - sin delta u its left normal.
    """
    radii = scene.data[e.number - 1, :2] if scene.data.shape[1] > 1 else np.zeros(2)
    ends = pose.place[[e.p - 1, e.q - 1]]
    d = max(np.linalg.norm(ends[1] - ends[0]), 1e-300)
    sine = np.clip((radii[1] - radii[0]) / d, -1.0, 1.0)
    u = (ends[1] - ends[0]) / d
    n_b = np.sqrt(1.0 - sine**2) * np.cross(Z, u) - sine * u
    return ends + radii[:, None] * n_b, radii


def belt(scene: Scene, pose: Pose, look: Look, e: Element) -> list[Shape]:
    """The straight span and the two pulleys with a spoke that shows their rotation."""
    tangent, radii = span(scene, pose, e)
    colour = look.colour(e.number, paint.BELT)
    shapes: list[Shape] = [Line(tangent, colour, 1.5, 3)]
    for place, turn, r in ((e.p, e.p_turn, radii[0]), (e.q, e.q_turn, radii[1])):
        centre = pose.place[place - 1]
        rim = circle(centre, X, Y, abs(r), 48)[:-1]
        spoke = centre + np.outer([0.35, 0.92], abs(r) * pose.turn[turn - 1][:, 0])
        shapes += [*bordered(rim, paint.PULLEY, "#7d8a96", 0.9, (0, 1), 0.55), Line(spoke, "#7d8a96", 1.1, 1)]
    return shapes


def wound_arcs(scene: Scene, pose: Pose, look: Look) -> list[Shape]:
    """Belt on a pulley between two spans that share its centre and rotation node.

    The belt leaves along u_b; a pulley on its left (negative radius) is wound counter-clockwise, else clockwise.
    """
    belts = [e for e in scene.elements if e.shape == "belt" and e.number not in look.settings.hidden]
    shapes: list[Shape] = []
    for first in belts:
        for second in belts:
            if (first.q, first.q_turn) != (second.p, second.p_turn) or first is second:
                continue
            (_, enter), r_1 = span(scene, pose, first)
            (leave, _), r_2 = span(scene, pose, second)
            if r_1[1] * r_2[0] <= 0:
                continue
            centre = pose.place[first.q - 1]
            a, b = (np.arctan2(*(p - centre)[1::-1]) for p in (enter, leave))
            turn = (b - a) % (2 * np.pi) if r_1[1] < 0 else -((a - b) % (2 * np.pi))
            arc = circle(centre, X, Y, abs(r_1[1]), 40, (a, a + turn))
            shapes.append(Line(arc, look.colour(first.number, paint.BELT), 1.5, 3))
    return shapes


def planar_wheel(scene: Scene, pose: Pose, look: Look, e: Element) -> list[Shape]:
    """A wheel seen from above: the tyre, and tread lines that run with its spin angle."""
    r = scene.data[e.number - 1, 0] or 3 * look.size
    heading, axle = pose.frame(scene, e)[:2]
    centre, half = pose.place[e.p - 1], 0.16 * r
    corners = [centre + a * r * heading + b * half * axle for a, b in ((1, 1), (1, -1), (-1, -1), (-1, 1))]
    colour = look.colour(e.number, paint.WHEEL)
    shapes = bordered(np.array(corners), colour, colour, 1.2, (3, 4), 0.45)
    spin = pose.turn[e.q_turn - 1] if e.q_turn else np.eye(3)
    angle = np.arctan2(spin[1, 0], spin[0, 0]) + np.arange(10) * np.pi / 5
    for a in angle[np.cos(angle) > 0.05]:  # the upper half of the tread moves forwards
        at = centre + r * np.sin(a) * heading
        shapes.append(Line(np.stack((at - half * axle, at + half * axle)), colour, 0.7, 4))
    return shapes


def wheel(scene: Scene, pose: Pose, look: Look, e: Element) -> list[Shape]:
    """Rim and spokes of a disk or torus wheel about the spin axis (local z'), reaching to the contact point."""
    centre = pose.place[e.p - 1]
    frame = pose.frame(scene, e)
    axis, spoke = frame[2], frame[0]
    if not axis.any():
        axis, spoke = Y, X
    radius = scene.length[e.number - 1] or float(np.linalg.norm(pose.place[e.q - 1] - centre)) or 3 * look.size
    tread = scene.data[e.number - 1, 1] if e.keyword == "TWHEEL" and scene.data.shape[1] > 1 else 0.055 * radius
    colour = look.colour(e.number, paint.WHEEL)
    shapes = torus(centre, axis, spoke, radius - tread, tread, colour)
    rim = circle(centre, spoke, np.cross(axis, spoke), radius - 2 * tread, 7)
    shapes.append(Line(np.stack((centre, rim[0])), paint.DRIVE, 1.8))
    shapes += [Line(np.stack((centre, at)), colour, 1.3) for at in rim[1:-1]]
    shapes += cylinder(centre - 0.12 * radius * axis, centre + 0.12 * radius * axis, 0.09 * radius, colour)
    return shapes


def screw(scene: Scene, pose: Pose, look: Look, e: Element) -> list[Shape]:
    """A threaded spindle through p along the axis (local x'), and a nut around q."""
    s = look.size
    frame = pose.frame(scene, e)
    p, q = pose.place[e.p - 1], pose.place[e.q - 1]
    axis = frame[0]
    reach = (q - p) @ axis
    a, b = p + min(reach, 0.0) * axis - s * axis, p + max(reach, 0.0) * axis + 3 * s * axis
    shapes = cylinder(a, b, 0.32 * s, look.colour(e.number, paint.SCREW), light=look.settings.light)
    turns = max(int(np.linalg.norm(b - a) / (0.55 * s)), 4)
    n = 12 * turns + 1
    thread = circle(np.linspace(a, b, n), frame[1], frame[2], 0.40 * s, n, (0.0, 2 * np.pi * turns))
    shapes.append(Line(thread, "#4a545d", 0.8))
    ends = np.stack((q - 0.6 * s * axis, q + 0.6 * s * axis))
    y, z = (np.stack((v, v)) for v in pose.frame(scene, e, "q")[1:])
    return shapes + solid(disc_outline(0.75 * s, 6), ends, y, z, paint.HINGE, light=look.settings.light)


def divided(scene: Scene, look: Look) -> tuple[list[Element], list[tuple[DrawOne, Element]]]:
    """Elements that are drawn along their lines, those that look alike together; and the others, each with the function
    that draws it. Beams that slide are among both. Those that the settings hide are left out."""
    seen = [e for e in scene.elements if e.number not in look.settings.hidden]
    along = [e for shape in ALONG_LINES for e in seen if e.shape == shape]

    def is_bar(e: Element) -> bool:
        """A truss that is drawn as a bar, because it has a cross-section or keeps its length."""
        shown = outline(look.settings.section(e.number, e.shape)) is not None
        return shown or scene.e_class(e.number, 1) in ("fixed", "input")

    free = dict.fromkeys(e for e in along if e.shape == "truss" and not is_bar(e))
    single: list[tuple[DrawOne, Element]] = [(free_truss, e) for e in free]
    single += [(PARTS.get(e.shape, plain), e) for e in seen if e.shape not in ALONG_LINES]
    return [e for e in along if e not in free], single + [(slider, e) for e in seen if slides(scene, e)]


def element_shapes(scene: Scene, pose: Pose, look: Look) -> list[Shape]:
    lines, single = divided(scene, look)
    shapes = bodies(scene, pose, look, lines)
    for draw, e in single:
        shapes += draw(scene, pose, look, e)
    return shapes + wound_arcs(scene, pose, look)


def free_truss(scene: Scene, pose: Pose, look: Look, e: Element) -> list[Shape]:
    """With stiffness a spring, with damping only a dashpot, with nothing a dotted measuring line."""
    ends = pose.place[[e.p - 1, e.q - 1]]
    i = e.number - 1
    if scene.stiffness[i, 0]:
        return spring(scene, ends, look, look.colour(e.number, paint.SPRING), scene.length[i])
    if scene.damping[i, 0] and scene.planar:
        return dashpot(ends, look, look.colour(e.number, paint.SPRING))
    return [Line(ends, look.colour(e.number, paint.TRUSS), 0.9, 2, dashes=(1.5, 2.5))]


def plain(scene: Scene, pose: Pose, look: Look, e: Element) -> list[Shape]:
    """What has no drawing of its own: a line between its position nodes, or a mark where it is if it has not both."""
    colour = look.colour(e.number, paint.TRUSS)
    ends = tuple(n for n in (e.p, e.q) if n)
    if len(ends) == 2:
        return [Line(pose.place[np.array(ends) - 1], colour, 1.6, 2)]
    return [Mark(middle(pose, ends or look.hinges.get(e.number, ())), 5.0, colour, colour)]


ALONG_LINES = ("beam", "body", "truss")  # shapes of element types
# Shape of an element type -> how one is drawn; a shape that is not here either is drawn as `plain`.
PARTS: dict[str, DrawOne] = {
    "hinge": hinge, "belt": belt, "planar wheel": planar_wheel, "wheel": wheel, "screw": screw,
}  # fmt: skip
