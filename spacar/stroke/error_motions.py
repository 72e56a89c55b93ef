"""How a body moves along the stroke, and how it deviates from the ideal line or axis (docs/flexures.md section 3).

u_k, theta_k   displacement of the node, and rotation vector of R_k R_0^T, from the undeflected state 0
line           error u - (u.t) t, t the direction of the path of the node in state 0; the rotation theta is an error too
axis           direction a of the angular velocity in state 0, through the point c_0 of the body that does not move then
pivot shift    p_k = x_k + R_k R_0^T (c_0 - x_0) - c_0, of the point of the body that is the pivot in state 0
tilt           theta - (theta.a) a
pole           c = x + (w x v)/w^2, with the velocities v of the node and w of the body by the drive: the instantaneous
               centre, in space the point of the instantaneous screw axis nearest to the node
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from spacar.arrays import Array

NEAR = 3.0  # distance of the pole over the size of the mechanism, below which the pole is a pivot
AT_INFINITY = 1e-9  # |w| length / |v| below which the body only translates


@dataclass(frozen=True)
class ErrorMotions:
    """Along the stroke, in global axes. Definitions: see above.

    displacement [m], rotation (vector) [rad], line_error [m], pivot_shift [m], tilt [rad], pole [m]  (k, 3) each; the
             pole is nan where the body only translates
    angle    (k,) rotation about the axis [rad];  tangent, axis  (3,) unit vectors, zero where they do not exist
    pivot    (3,) the ideal pivot in the undeflected state [m]
    turning  is the ideal motion a rotation: is the pivot nearer than NEAR times the size of the mechanism to the node?
    """

    displacement: Array
    rotation: Array
    line_error: Array
    pivot_shift: Array
    tilt: Array
    pole: Array
    angle: Array
    tangent: Array
    axis: Array
    pivot: Array
    turning: bool


def error_motions(
    places: Array, turns: Array, moves: Array, spins: Array, zero: int, length: float, pivot: Array | None,
    turned: bool,
) -> ErrorMotions:  # fmt: skip
    """The errors of a node over k states.

    places, turns   (k, 3) positions [m], (k, 4) Euler parameters
    moves, spins    (k, 3) velocity and angular velocity by the drive
    zero            number of the undeflected state;  length  size of the mechanism [m]
    pivot           (3,) the ideal pivot [m], if it is not the pole of the undeflected state
    turned          the drive turns the body itself
    """
    displacement = places - places[zero]
    rotations = relative_rotations(turns, turns[zero])
    rotation = rotations.as_rotvec()
    pole = np.array([_pole(*state, length) for state in zip(places, moves, spins, strict=True)])
    tangent, axis = _unit(moves[zero]), _unit(spins[zero])
    if not np.isfinite(pole[zero]).all():
        axis = np.zeros(3)
    distance = float(np.linalg.norm(pole[zero] - places[zero]))  # nan where the body only translates
    turning = pivot is not None or distance < NEAR * length or (turned and np.isfinite(distance))
    centre = pole[zero] if pivot is None else pivot
    arm = centre - places[zero]
    shift = displacement + rotations.apply(arm) - arm
    angle = rotation @ axis
    return ErrorMotions(
        displacement, rotation, displacement - np.outer(displacement @ tangent, tangent), shift,
        rotation - np.outer(angle, axis), pole, angle, tangent, axis, centre, bool(turning),
    )  # fmt: skip


def relative_rotations(turns: Array, references: Array) -> Any:
    """The scipy Rotations R(turn) R(reference)^T of Euler parameters (k, 4)."""
    from scipy.spatial.transform import Rotation

    ours, theirs = (Rotation.from_quat(np.roll(np.atleast_2d(lam), -1, axis=1)) for lam in (turns, references))
    return ours * theirs.inv()


def _unit(v: Array) -> Array:
    size = float(np.linalg.norm(v))
    return v / size if np.isfinite(size) and size > 0.0 else np.zeros(3)


def _pole(place: Array, move: Array, spin: Array, length: float) -> Array:
    """The instantaneous centre; nan where the rotation is rounding."""
    square = float(spin @ spin)
    if not np.sqrt(square) * length > AT_INFINITY * float(np.linalg.norm(move)):
        return np.full(3, np.nan)
    return place + np.cross(spin, move) / square
