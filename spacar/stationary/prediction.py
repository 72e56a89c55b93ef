"""Where the next state of a path is, by the polynomial through states before it."""

from __future__ import annotations

from math import prod
from typing import NamedTuple

import numpy as np

from spacar.arrays import Array

FARTHEST = 16.0  # weight of a state in the prediction: 6 for equal parts, more when the parts have grown


class Known(NamedTuple):
    """A state of the path: its place on the way (0 to 1 initial, 1 to 2 additional loading), x, sigma."""

    path: float
    x: Array
    sigma: Array


def predicted(known: list[Known], path: float, fixed: slice) -> Known:
    """Lagrange's polynomial through the known states; fewer of them if they are close together."""
    weights = _lagrange(known, path)
    while len(known) > 1 and max(map(abs, weights)) > FARTHEST:
        known = known[1:]
        weights = _lagrange(known, path)
    x, sigma = np.dot(weights, [k.x for k in known]), np.dot(weights, [k.sigma for k in known])
    x[fixed] = known[-1].x[fixed]  # no iteration corrects them: rounding would grow from level to level
    return Known(path, x, sigma)


def _lagrange(known: list[Known], path: float) -> list[float]:
    """Weights of the polynomial through the known states, at a place."""
    at = [k.path for k in known]
    return [prod((path - b) / (a - b) for j, b in enumerate(at) if j != i) for i, a in enumerate(at)]
