"""Elements as shapes: one function per kind of element, and the tables that say which."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from spacar_drawing import look as paint
from spacar_drawing import machine_parts as machine
from spacar_drawing.bodies import bars, bodies
from spacar_drawing.drawn_shapes import Line, Mark, Shape
from spacar_drawing.look import Look, middle
from spacar_drawing.scene import Element, Pose, Scene
from spacar_drawing.sections import outline


def element_shapes(scene: Scene, pose: Pose, look: Look) -> list[Shape]:
    """All elements at one configuration, except those that the settings hide."""
    shapes: list[Shape] = []
    seen = [e for e in scene.elements if e.number not in look.settings.hidden]
    for shape, draw in TOGETHER.items():
        alike = [e for e in seen if e.shape == shape]
        if alike:
            shapes += draw(scene, pose, look, alike)
    for e in seen:
        if e.shape not in TOGETHER:
            shapes += PARTS.get(e.shape, plain)(scene, pose, look, e)
    for e in seen:
        if machine.slides(scene, e):
            shapes += machine.slider(scene, pose, look, e)
    if any(e.shape == "belt" for e in scene.elements):
        shapes += machine.wound_arcs(scene, pose, look)
    return shapes


def trusses(scene: Scene, pose: Pose, look: Look, elements: Sequence[Element]) -> list[Shape]:
    """Bars; with stiffness but free to change its length a spring, with damping only a dashpot, with nothing a dotted
    measuring line."""
    straight, others = straight_and_free(scene, look, elements)
    shapes = bars(scene, pose, look, straight)
    for e in others:
        shapes += free_truss(scene, pose, look, e)
    return shapes


def straight_and_free(scene: Scene, look: Look, elements: Sequence[Element]) -> tuple[list[Element], list[Element]]:
    """Trusses that are drawn as bars, because they have a cross-section or keep their length; and the others."""
    straight: list[Element] = []
    others: list[Element] = []
    for e in elements:
        section = look.settings.section(e.number, truss=True)
        shown = section is not None and outline(section) is not None
        bar = shown or scene.e_class(e.number, 1) in ("fixed", "input")
        (straight if bar else others).append(e)
    return straight, others


def free_truss(scene: Scene, pose: Pose, look: Look, e: Element) -> list[Shape]:
    ends = pose.place[[e.p - 1, e.q - 1]]
    i = e.number - 1
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
        return [Line(pose.place[np.array(ends) - 1], colour, 1.6, 2)]
    return [Mark(middle(pose, ends or look.hinges.get(e.number, ())), 5.0, colour, colour)]


# Shape of an element type -> how all elements of it are drawn at once.
TOGETHER: dict[str, Callable[[Scene, Pose, Look, Sequence[Element]], list[Shape]]] = {
    "beam": bodies,
    "body": bodies,
    "truss": trusses,
}
# Shape of an element type -> how one is drawn; a shape that is in neither table is drawn as `plain`.
PARTS: dict[str, Callable[[Scene, Pose, Look, Element], list[Shape]]] = {
    "hinge": hinge,
    "belt": machine.belt,
    "planar wheel": machine.planar_wheel,
    "wheel": machine.wheel,
    "screw": machine.screw,
}
