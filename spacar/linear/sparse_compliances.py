"""Directional compliances of large models: the diagonal of the inverse of the tangent, without dense matrices."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, cast

import numpy as np

from spacar.arrays import Array
from spacar.dynamics.array_evaluator import Dynamics
from spacar.linear_systems import LinearSystem, SingularMatrixError
from spacar.stationary.solution import StationarySolver
from spacar.stationary.stationary_equations import require_digits
from spacar.stationary.tangent import STATIC, SparseTangent

if TYPE_CHECKING:
    from spacar.linear_systems.banded import BandedSystem
    from spacar.linear_systems.condensed import CondensedSystem

COLUMNS = 256  # right-hand sides at once


def compliances_at_rest(tangent: SparseTangent) -> Array:
    """(nx,) directional compliances: the diagonal of the inverse of the tangent, infinite where K is singular."""
    n = tangent.dynamics.numbering
    out = np.zeros(n.nx)
    try:
        system = tangent.factor(STATIC)
    except SingularMatrixError:
        out[tangent.F] = np.inf
        return out
    out[tangent.F] = _leading_inverse_diagonal(system, tangent.nf, tangent.dynamics)
    return out


def compliances_in_motion(solver: StationarySolver) -> Array:
    """(nx,) the same of a state that moves or has user functions, by the exact tangent of the equilibrium."""
    d = solver.dynamics
    n = d.numbering
    out = np.zeros(n.nx)
    try:
        q, tangent = solver.factorized()
        require_digits(tangent.solve, tangent.rounding, tangent.solve(q.probe), q.nf)
    except SingularMatrixError:
        out[np.r_[n.x_class["calculable"], n.x_class["dynamic"]]] = np.inf
        return out
    out[q.F] = _leading_inverse_diagonal(tangent.system, q.nf, d)
    return out


def _leading_inverse_diagonal(system: LinearSystem, n: int, dynamics: Dynamics) -> Array:
    """(n,) of the inverse: the first n unknowns and equations. By selected inversion of band storage with one order of
    rows and columns, and of a condensed matrix, of which these are the coordinates; else one solution for every column.
    """
    if system.kind == "banded" and (band := cast("BandedSystem", system)).is_ordered_alike:
        from spacar.linear_systems.selected_inverse import inverse_diagonal

        return inverse_diagonal(band, _in_c(dynamics))[:n]
    found = cast("CondensedSystem", system).inverse_diagonal() if system.kind == "condensed" else None
    if found is not None:
        return found
    out = np.empty(n)
    for first in range(0, n, COLUMNS):
        rows = np.arange(first, min(first + COLUMNS, n))
        unit = np.zeros((system.n, len(rows)))
        unit[rows, rows - first] = 1.0
        out[rows] = system.solve(unit)[rows, rows - first]
    return out


def _in_c(dynamics: Dynamics) -> Callable[[BandedSystem], Array] | None:
    """The inverse of band storage in C, where elements are."""
    if not any(b.family.compiled for b in dynamics.mechanism.batches):
        return None
    from spacar.compiled.compiled_elements import band_inverse

    return band_inverse
