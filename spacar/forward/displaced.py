"""What a deformation does to the positions: the unit in which the absolute part of ERROR measures it.

A deformation e of an element with length l turns what is behind it by about e/l, so in a mesh of n elements 1e-6 m of e
move the tip n 1e-6 m: an absolute error that is the same for every deformation means less and less on finer meshes. So
the absolute error of a dynamic deformation (and of its rate) is that of ERROR divided by

    g = max_i |dx_i/de|,   i the coordinates of position nodes;   1 <= g <= L/l

taken from the velocity transfer function of the start state (theory-system.md section 1.3); L is the size of the model.
Below 1 nothing is gained, as the deformation itself is a result. Rotations and coordinates keep their own unit.

Up to BLOCK deformations g is computed as it stands, from a column of the transfer function each. Of more, whose
columns are the n^2 entries of an inverse, few rows tell almost all: what moves most is the tip of an arm, for all
elements of the arm. A row, what all deformations do to one coordinate, is one solution with the transposed matrix; the
largest entry in the known rows is a lower bound of g. The Euclidean norms t of all columns, g <= t <= sqrt(positions)
g, are estimated from PROBES sums of rows with random signs s, E (s.z)^2 = |z|^2. The SAMPLE columns with the largest
t/g, and as many spread over all, are computed; where one has an entry of more than 1/SHARE times what is known, the row
of this entry is taken too, until a sample has none. Where arms are many and short each has its own tip, but t is close
to g: a random sample of the columns with t <= SHORT g tells whether they take t, as all do that are left after ROUNDS.
So g is found at the price of some dozen solutions, up to a factor of two or three, within which a unit may be chosen.
"""

import numpy as np

from spacar.arrays import Array, Index
from spacar.dynamics.evaluator import Evaluator
from spacar.kinematics import Kinematics
from spacar.mechanism.mechanism import Mechanism

BLOCK = 256  # deformations up to which every column of the transfer function is computed
PROBES, SAMPLE, ROUNDS, SHARE, SHORT = 12, 8, 12, 0.7, 3.0  # see above


def displaced(evaluator: Evaluator) -> Array | None:
    """g of every component of the state (n,); None where all are 1. The evaluator stands at the start state."""
    mechanism = evaluator.model.mechanism
    if not np.count_nonzero(mechanism.is_length[mechanism.numbering.e_class["dynamic"]]):
        return None
    most = _most(mechanism)
    columns = np.flatnonzero(most > 1.0)
    if not len(columns):
        return None
    n, k = mechanism.numbering, evaluator.numpy_evaluator().kinematics
    first = n.e_class["dynamic"].start
    g = np.ones(len(most))
    few = len(columns) <= BLOCK
    known = _moved(k, first + columns).max(axis=0) if few else _by_rows(k, first + columns)
    g[columns] = np.clip(known, 1.0, most[columns])
    x = np.ones(int(n.nxp[3]))
    return np.concatenate((x, g, np.ones(n.nk), x, g))


def _moved(k: Kinematics, deformations: Index) -> Array:
    """|dx_i/de| of the position coordinates, (positions, deformations)."""
    n = k.numbering
    rate = np.zeros((n.ne, len(deformations)))
    rate[deformations, np.arange(len(deformations))] = 1.0
    return np.abs(k.dependent(np.zeros((n.nx, len(deformations))), rate)[n.positions.ravel()])


def _by_rows(k: Kinematics, deformations: Index) -> Array:
    """g of these deformations, from few rows and columns."""
    place_e, place_x = np.full(k.numbering.ne, -1), np.full(k.numbering.nx, -1)
    place_e[k.E], place_x[k.U] = np.arange(len(k.E)), np.arange(len(k.U))
    columns, positions = place_e[deformations], place_x[k.numbering.positions.ravel()]
    free = np.flatnonzero(positions >= 0)

    def rows(weights: Array) -> Array:
        """What all deformations do to sums of the free positions, weights (free, m), as (m, deformations)."""
        right = np.zeros((len(k.U), weights.shape[1]))
        right[positions[free]] = weights
        return np.asarray(k.velocity_system.solve_transposed(right)[columns].T)

    rng = np.random.default_rng(1)
    signs = rng.integers(0, 2, (len(free), PROBES)) * 2.0 - 1.0
    norms = np.sqrt(np.mean(rows(signs) ** 2, axis=0))
    g = np.ones(len(deformations))
    asked = np.zeros(len(deformations), bool)
    for _ in range(ROUNDS):
        worst = np.argsort(np.where(asked, 0.0, norms / g))[-SAMPLE:]
        spread = (np.arange(SAMPLE) + rng.random()) * (len(g) / SAMPLE)
        sample = np.union1d(worst, spread.astype(np.int64))
        asked[sample] = True
        moved = _moved(k, deformations[sample])[free]
        tips, most = moved.argmax(axis=0), moved.max(axis=0)
        unexplained = SHARE * most > g[sample]
        g[sample] = np.maximum(g[sample], most)
        if not unexplained.any():
            break
        chosen = np.unique(tips[unexplained])
        unit = np.zeros((len(free), len(chosen)))
        unit[chosen, np.arange(len(chosen))] = 1.0
        g = np.maximum(g, np.abs(rows(unit)).max(axis=0))
    else:
        return np.where(asked, g, np.maximum(g, norms))
    short = np.flatnonzero(~asked & (norms <= SHORT * g))
    if len(short):
        sample = rng.choice(short, min(SAMPLE, len(short)), replace=False)
        if (SHARE * _moved(k, deformations[sample]).max(axis=0) > g[sample]).any():
            g[short] = np.maximum(g, norms)[short]
    return g


def _most(mechanism: Mechanism) -> Array:
    """L/l of every dynamic deformation that is a length, 1 of the others."""
    most = np.ones(mechanism.numbering.ne)
    for batch in mechanism.batches:
        length = batch.family.length
        most[batch.e] = np.where(length > 0.0, mechanism.length / np.where(length > 0.0, length, 1.0), 1.0)
    most[~mechanism.is_length] = 1.0
    return np.maximum(most[mechanism.numbering.e_class["dynamic"]], 1.0)
