"""Levels that are passed through only, many in one call of C (compiled/walk.c), as long as nothing needs a decision."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from spacar.arrays import Array
from spacar.stationary.equilibrium import DOUBLES, NUMBER, WHOLE, Equilibrium
from spacar.stationary.newton import Demand
from spacar.stationary.stability import CRITICAL

REMEMBERED = 4  # states that the prediction uses: a cubic polynomial
FARTHEST = 16.0  # weight of a state in the prediction: 6 for equal parts, more when the parts have grown
FASTER = 2.0  # change of x over that of the loading, against the part before, from which a part is walked back
WIDE = 0.01  # model lengths or rad: shorter parts are not walked back


@dataclass(frozen=True)
class Known:
    """A state of the path: its place on the way (0 to 1 initial, 1 to 2 additional loading), x, sigma."""

    path: float
    x: Array
    sigma: Array


@dataclass(frozen=True)
class PassedLevels:
    """How many levels were passed, with how many iterations; the path there, what rounding is in its last state."""

    levels: int
    iterations: int
    path: list[Known]
    noise: float


class CPassed(ctypes.Structure):
    """`Passed` of walk.c."""

    _fields_ = [
        *((name, DOUBLES) for name in ("levels", "states", "places", "near")),
        *((name, WHOLE) for name in ("count", "known", "passed", "iterations")),
        *((name, NUMBER) for name in ("wide", "faster", "farthest", "critical", "noise")),
    ]  # fmt: skip


def pass_levels(equations: Equilibrium, levels: Array, path: Sequence[Known], limit: int) -> PassedLevels | None:
    """From the last state of the path over levels (n, 4): fractions of both parts of the loading, the part of the
    forces that are held, the place on the way. At most `limit` iterations each. None: not even the first one.

    The sweep's `near` is that of the last level that was passed; its deformations may be those of a trial.
    """
    nx, known = equations.nx, len(path)
    states, places = np.zeros((REMEMBERED, nx + equations.ne)), np.zeros(REMEMBERED)
    for k, state in enumerate(path, REMEMBERED - known):
        states[k, :nx], states[k, nx:], places[k] = state.x, state.sigma, state.path
    near = np.empty(equations.ne)
    c = CPassed(
        *(A.ctypes.data for A in (levels, states, places, near)), len(levels), known, 0, 0,
        WIDE, FASTER, FARTHEST, CRITICAL, 0.0,
    )  # fmt: skip
    equations.walk(c, Demand(limit))
    if not c.passed:
        return None
    first = REMEMBERED - c.known
    kept = [Known(float(places[k]), states[k, :nx], states[k, nx:]) for k in range(first, REMEMBERED)]
    return PassedLevels(c.passed, c.iterations, kept, c.noise)
