"""What `spacar edit` shows of a model before it runs: the start position with loads and releases, and small motions.

A motion is that of one degree of freedom with rate 1, V v = e' with all other given rates zero (theory-system.md
section 1.2), of an under-constraint, or of a vibration or buckling mode; it is drawn linearly, x0 + a sin(s) v, with a
such that the largest displacement is a share of the mechanism (`suitable_factor`).
"""

from dataclasses import replace
from typing import Any

import numpy as np

from spacar.arrays import Array
from spacar.deck import ELEMENT_TYPES
from spacar.frame import Frame
from spacar.kinematics.kinematics import Kinematics
from spacar.mechanism.mechanism import Loads, Mechanism
from spacar.result import Result
from spacar_drawing.drawn_shapes import Line, Shape, circle, normal_pair
from spacar_drawing.look import HINGE, look_of
from spacar_drawing.mode_picture import PHASES, period
from spacar_drawing.mode_shapes import ModeShape, redundancy, suitable_factor
from spacar_drawing.picture_source import PictureSource, source_of_result
from spacar_drawing.scene import Pose, Scene
from spacar_drawing.symbols import Symbols
from spacar_drawing.viewer_page import view_model

MOST_DENSE = 1_000_000  # numbers of the derivative of the deformations, beyond which no motions are looked for
MOST_RELEASES = 300  # marks


def start_source(mechanism: Mechanism) -> PictureSource:
    """The start position as a result of one step, with the loads of the input."""
    n = mechanism.numbering
    x, e = np.zeros(n.nx), np.zeros(n.ne)
    force = sum((_forces(loads, n.nx) for loads in (mechanism.loads, mechanism.additional) if loads), x)
    frame = Frame(t=0.0, x=mechanism.x0, xd=x, xdd=x, e=e, ed=e, edd=e, sig=e, fx=np.asarray(force), fxgrav=x, fxtot=x)
    return source_of_result(Result(mechanism, 0, [frame], (), {}))


def _forces(loads: Loads, nx: int) -> Array:
    """(nx,) with moments as forces on Euler parameters, f = 2 L^T M at lambda = (1, 0, 0, 0) (files.md section 5)."""
    force = loads.force + np.zeros(nx)
    if loads.moment_rows.size:
        np.add.at(force, loads.moment_rows[1:], 2.0 * loads.moment.T)
    return force


def start_model(mechanism: Mechanism) -> dict[str, Any]:
    source = start_source(mechanism)
    scene, x = source.scene, source.x(1)
    look = look_of(scene, x[None], source.settings)
    symbols = Symbols.of(source, ("loads",), [1])
    more = (lambda _: symbols.shapes(1, x, look), lambda pose: release_marks(scene, pose, look.size))
    return view_model(source, more=more)


def release_marks(scene: Scene, pose: Pose, size: float) -> list[Shape]:
    """Rings on beams with released deformations: at the end that the deformation is named after, else in the middle."""
    shapes: list[Shape] = []
    for e in scene.elements:
        if e.shape != "beam" or scene.free[e.number - 1] or not (e.p and e.q) or len(shapes) >= MOST_RELEASES:
            continue
        names = [
            name for m, (name, _) in enumerate(ELEMENT_TYPES[e.keyword].modes, 1)
            if scene.le[e.number - 1, m - 1] and scene.e_class(e.number, m) == "calculable"
        ]  # fmt: skip
        shares = {0.12 if "at p" in name else 0.88 if "at q" in name else 0.5 for name in names}
        if not shares:
            continue
        p, q = pose.place[e.p - 1], pose.place[e.q - 1]
        axis = q - p if np.any(q != p) else np.array([1.0, 0.0, 0.0])
        u, v = np.eye(3)[:2] if scene.planar else normal_pair(axis)
        shapes += [Line(circle(p + s * (q - p), u, v, 0.8 * size, 16), HINGE, 1.6, 6) for s in sorted(shares)]
    return shapes


def motion_model(source: PictureSource, x: Array, motion: Array, label: str) -> dict[str, Any]:
    """Pictures of one period of a small motion (nx,), real or complex, about x (nx,)."""
    mode = ModeShape(1, "buckling", 1.0 + 0j, np.zeros(0, complex), motion.astype(complex))
    scene, rows = source.scene, source.scene.position_nodes - 1
    extent = np.max(np.ptp(Pose.of(scene, x).place[rows], axis=0), initial=0.0) or 1.0
    xs = period(mode, x, suitable_factor(scene, motion, extent), PHASES)

    def read(name: str, k: int | None) -> Array | None:
        if name == "x":
            return xs if k is None else xs[k - 1]
        return np.arange(float(PHASES)) if name == "t" else None

    return view_model(replace(source, steps=PHASES, read=read)) | {"times": [label] * PHASES}


def motion_of_freedom(mechanism: Mechanism, name: str) -> Array:
    """(nx,) velocities for rate 1 of one degree of freedom, named as in `numbering.q_names`. The mechanism must be
    neither over- nor under-constrained."""
    n = mechanism.numbering
    kinematics = Kinematics(mechanism)
    kinematics.x = mechanism.x0.copy()
    kinematics.refresh()
    x, e = np.zeros(n.nx), np.zeros(n.ne)
    if name in (names := [n.x_name(i) for i in range(n.nx)]):
        x[names.index(name)] = 1.0
    else:
        e[[n.e_name(i) for i in range(n.ne)].index(name)] = 1.0
    return kinematics.dependent(x, e)


def free_motions(mechanism: Mechanism, gradient: Array) -> Array:
    """(k, nx) motions of the under-constraints."""
    return redundancy(start_source(mechanism).scene, gradient, mechanism.length).under
