"""Many load levels in one call of C (compiled/walk.c), as long as nothing needs a decision."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from spacar.arrays import Array
from spacar.stationary.equilibrium import DOUBLES, NUMBER, WHOLE, Equilibrium
from spacar.stationary.newton import Demand
from spacar.stationary.stability import CRITICAL
from spacar.stationary.stationary_equations import Iterate

REMEMBERED = 4  # states that the prediction uses: a cubic polynomial
FARTHEST = 16.0  # weight of a state in the prediction: 6 for equal parts, more when the parts have grown
FASTER = 2.0  # change of x over that of the loading, against the part before, from which a part is walked back
ELSEWHERE = 0.1  # of the motion of a part: states that differ by more are not the same
RETURNED = 0.02  # of the motion of a part: last correction on the way back; it leaves an error of three times that
WIDE = 0.01  # model lengths or rad: shorter parts are not walked back


class Known(NamedTuple):
    """A state of the path: its place on the way (0 to 1 initial, 1 to 2 additional loading), x, sigma."""

    path: float
    x: Array
    sigma: Array


class PassedLevels(NamedTuple):
    """How many levels were passed, with how many iterations; the path there, its last state, what rounding is in it."""

    levels: int
    iterations: int
    path: list[Known]
    point: Iterate
    noise: float


class CPassed(ctypes.Structure):
    """`BlockOfOutputs` of walk.c."""

    _fields_ = [
        *((name, DOUBLES) for name in ("levels", "states", "places", "branch", "trial")),
        *((name, WHOLE) for name in ("count", "known", "passed", "iterations")),
        *((name, NUMBER) for name in (
            "wide", "faster", "farthest", "critical", "returned", "elsewhere", "noise",
        )),
        ("demands", NUMBER * 8),
    ]  # fmt: skip


def pass_levels(
    equations: Equilibrium, levels: Array, path: Sequence[Known], limit: int, tolerance: float
) -> PassedLevels | None:
    """From the last state of the path, at whose level the equations stand, over levels (n, 5): fractions of both parts
    of the loading, the part of the forces that are held, the place on the way, 1 for levels that are stored. At most
    `limit` iterations each; `tolerance` of those that are stored. None: not even the first one.

    The equations and the sweep's `branch` are those of the last level that was passed.
    """
    from spacar.compiled.library import address_of

    nx, ne, known = equations.nx, equations.ne, len(path)
    states, places, branch, trial = np.zeros((REMEMBERED, nx + ne)), np.zeros(REMEMBERED), np.zeros(ne), np.zeros(ne)
    for k, state in enumerate(path, REMEMBERED - known):
        states[k, :nx], states[k, nx:], places[k] = state.x, state.sigma, state.path
    c = CPassed(
        *map(address_of, (levels, states, places, branch, trial)), len(levels), known, 0, 0,
        WIDE, FASTER, FARTHEST, CRITICAL, RETURNED, ELSEWHERE, 0.0,
        (*Demand.of(limit, tolerance, False).sizes, *Demand.of(limit, tolerance, True).sizes),
    )  # fmt: skip
    point = equations.walk(c, limit)
    if not c.passed:
        return None
    kept = [Known(places.item(k), states[k, :nx], states[k, nx:]) for k in range(REMEMBERED - c.known, REMEMBERED)]
    return PassedLevels(c.passed, c.iterations, kept, point, c.noise)
