"""How things look: colours, and the choices that hold for a whole series of pictures."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from spacar.arrays import Array
from spacar_drawing.drawn_shapes import Colour
from spacar_drawing.placement import pin_joints, places_of_hinges
from spacar_drawing.scene import Pose, Scene, positions
from spacar_drawing.settings import PictureSettings

FLEXIBLE, RIGID, TRUSS, SPRING = "#2f74b5", "#3c4a57", "#5d6d7a", "#3d8b5f"
HINGE, BELT, PULLEY, WHEEL, SCREW = "#c2703d", "#6b4a2b", "#c9d2da", "#4a5560", "#8a97a3"
GROUND, DRIVE, TRACE, GHOST, NODE, INK = "#6f7880", "#c0272d", "#d0812a", "#aab4bd", "#1d262e", "#1d262e"
DEFAULT_POINTS = 25  # on one elastic line
MOST_POINTS = 4000  # on all elastic lines together, unless STEPLINE says otherwise
SYMBOL = 0.022  # size of symbols, of the extent of the mechanism


@dataclass(frozen=True)
class Look:
    """Choices for a series of pictures of one scene.

    size      length of symbols [m];  points  on an elastic line
    hinges    hinge element -> position nodes where it is drawn;  pins  position nodes that are joints
    ranges    (highest node, 2, 3) smallest and largest places of the nodes over the series, for guides
    tints     element -> colour instead of its own;  faint elements are drawn thin and pale
    """

    settings: PictureSettings
    size: float
    points: int
    hinges: dict[int, tuple[int, ...]]
    pins: tuple[int, ...]
    ranges: Array
    tints: dict[int, Colour] = field(default_factory=dict)
    supports: bool = True

    def colour(self, element: int, default: Colour) -> Colour:
        return self.tints.get(element) or self.settings.colour(element) or default


def look_of(scene: Scene, xs: Array, settings: PictureSettings) -> Look:
    """The look for drawing the configurations xs (steps, nx)."""
    places = np.stack([positions(scene, x) for x in xs])
    rows = scene.position_nodes - 1
    ranges = np.stack((places.min(0), places.max(0)), axis=1)
    first = places[0][rows]
    extent = float(np.linalg.norm(np.ptp(first, axis=0))) if len(first) else 0.0
    extent = extent or float(np.max(scene.length, initial=0.0)) or 1.0
    beams = sum(e.shape == "beam" for e in scene.elements)
    if settings.step_line is not None:
        points = int(np.clip(round(1.0 / settings.step_line) + 1, 3, 1001))
    else:
        points = int(np.clip(MOST_POINTS // max(beams, 1), 4, DEFAULT_POINTS))
    return Look(
        settings,
        SYMBOL * extent,
        points,
        places_of_hinges(scene, places[0]),
        pin_joints(scene) if scene.planar else (),
        ranges,
    )


def middle(pose: Pose, nodes: tuple[int, ...]) -> Array:
    """Mean place of nodes; the origin for none."""
    return pose.place[[n - 1 for n in nodes]].mean(0) if nodes else np.zeros(3)
