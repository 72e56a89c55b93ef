"""What is evaluated, and where an evaluator stands: both values that never change."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import Array
from spacar.dynamics.forces import StressLaw
from spacar.mechanism.mechanism import Drive, Loads, Mechanism

# Which accepted steps are looked at closer, where many are made at a time (LOOK_NEVER ... of stepper.c)
NEVER, AT_DETERMINANTS, AT_VELOCITIES, ALWAYS = range(4)
SHARE = 0.1  # of a velocity: change that needs no explanation, more than the trapezoidal rule errs (forward.continuity)
NOISE = 1e-6  # of the largest scaled velocity: what is slower says nothing
STILL = 64.0 * float(np.finfo(float).eps)  # way in a step, in model lengths or rad, that is lost in the position


@dataclass(frozen=True)
class LoadedMechanism:
    """A mechanism under loads and prescribed motion. `own_law`: another stress law of its active deformations than that
    of mechanism and loads."""

    mechanism: Mechanism
    loads: Loads
    drive: Drive
    own_law: StressLaw | None = None

    @classmethod
    def of(cls, mechanism: Mechanism, loads: Loads | None = None, drive: Drive | None = None) -> LoadedMechanism:
        """`loads` and `drive` replace those of the mechanism."""
        return cls(mechanism, loads or mechanism.loads, drive or mechanism.drive)

    @cached_property
    def law(self) -> StressLaw:
        return self.own_law or StressLaw.of(self.mechanism, self.loads)


@dataclass(frozen=True, slots=True)
class Placement:
    """The configuration and the velocity of the last evaluated state: from here another evaluator can go on.

    x, xd (nx,); e (ne,) deformations, which also say on what branch the angles are; e_given (ne,) those that were
    prescribed. The arrays may be those of the evaluator: they hold until its next evaluation.
    """

    x: Array
    xd: Array
    e: Array
    e_given: Array


@dataclass(frozen=True, slots=True)
class Moving:
    """The last evaluated state with its accelerations: t; x, xd, xdd (nx,) or (nx, cases); e (ne,). It stays valid."""

    t: float
    x: Array
    xd: Array
    xdd: Array
    e: Array


@dataclass(frozen=True, slots=True)
class Accepted:
    """An accepted step: state y, what moves there, sign and logarithm of the determinant of V[E, U]."""

    y: Array
    at: Moving
    sign: float
    size: float


def unexplained(a: Moving, b: Moving, scale: Array) -> NDArray[np.bool_]:
    """Coordinates whose velocities change from a to b by more than their accelerations explain, as xd.

    `scale` (nx,), or (nx, 1) for cases side by side. See `spacar.forward.continuity`.
    """
    h = b.t - a.t
    v, acceleration = np.maximum(np.abs(a.xd), np.abs(b.xd)), np.maximum(np.abs(a.xdd), np.abs(b.xdd))
    change = np.abs(b.xd - a.xd - (0.5 * h) * (a.xdd + b.xdd))
    fastest = (v / scale).max(axis=0, initial=0.0)
    moves = fastest * abs(h) > STILL
    return np.asarray(moves & (change > abs(h) * acceleration + SHARE * v + fastest * scale * NOISE))
