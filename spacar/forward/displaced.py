"""What a deformation does to the positions: the unit in which the absolute part of ERROR measures it.

A deformation e of an element with length l turns what is behind it by about e/l, so in a mesh of n elements 1e-6 m of e
move the tip n 1e-6 m: an absolute error that is the same for every deformation means less and less on finer meshes. So
the absolute error of a dynamic deformation (and of its rate) is that of ERROR divided by

    g = max_i |dx_i/de|,   i the coordinates of position nodes;   1 <= g <= L/l

taken from the velocity transfer function of the start state (theory-system.md section 1.3); L is the size of the model.
Below 1 nothing is gained, as the deformation itself is a result. Rotations and coordinates keep their own unit.
"""

from __future__ import annotations

import numpy as np

from spacar.arrays import Array
from spacar.deck import ELEMENT_TYPES
from spacar.dynamics.evaluator import Evaluator
from spacar.mechanism.mechanism import Mechanism

BLOCK = 256  # columns of the transfer function at a time


def displaced(evaluator: Evaluator) -> Array | None:
    """g of every component of the state (n,); None where all are 1. The evaluator stands at the start state."""
    mechanism = evaluator.model.mechanism
    most = _most(mechanism)
    columns = np.flatnonzero(most > 1.0)
    if not len(columns):
        return None
    n, k = mechanism.numbering, evaluator.settled().kinematics
    first = n.e_class["dynamic"].start
    g = np.ones(len(most))
    for part in np.array_split(columns, -(-len(columns) // BLOCK)):
        rate = np.zeros((n.ne, len(part)))
        rate[first + part, np.arange(len(part))] = 1.0
        moved = np.abs(k.dependent(np.zeros((n.nx, len(part))), rate)[n.positions.ravel()])
        g[part] = np.clip(moved.max(axis=0), 1.0, most[part])
    x = np.ones(int(n.nxp[3]))
    return np.concatenate((x, g, np.ones(n.nk), x, g))


def _most(mechanism: Mechanism) -> Array:
    """L/l of every dynamic deformation that is a length, 1 of the others."""
    most = np.ones(mechanism.numbering.ne)
    for batch in mechanism.batches:
        kind = ELEMENT_TYPES.get(batch.family.keyword)  # None of node inertia and normalizations
        if kind is not None:
            rows = batch.e[[k for k, (_, unit) in enumerate(kind.modes) if unit == "m"]]
            length = batch.family.length
            most[rows] = np.where(length > 0.0, mechanism.length / np.where(length > 0.0, length, 1.0), 1.0)
    return np.maximum(most[mechanism.numbering.e_class["dynamic"]], 1.0)
