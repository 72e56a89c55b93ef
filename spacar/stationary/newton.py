"""Newton's iteration for one load level.

Unknown are the dynamic degrees of freedom q_d. Converged when max |R| <= tolerance (ITERSTEP position 3) and small
against the loads, or max |R| <= 100 eps max(|f|, |sigma|) (`Equilibrium.reached`), or when max |R| <= tolerance does
not fall any more. A level that is no result is only a start value for the next one: it is left when the residual has
fallen to a thousandth. The tangent is the exact K0 + N0 + G0 (types 1, 3: without N0); the sparse form
(theory-system.md (18)) for large systems at rest. At most ITERSTEP position 1 iterations.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from spacar.dynamics.dynamics import Dynamics
from spacar.errors import AnalysisError
from spacar.kinematics.kinematics import CONVERGED
from spacar.linear_systems import SingularMatrixError
from spacar.mechanism.mechanism import Array
from spacar.stationary.dense import solve_tangent, tangent
from spacar.stationary.equilibrium import Equilibrium, equilibrium
from spacar.stationary.loading import WITHOUT_N0, LoadLevel
from spacar.stationary.tangent import SparseTangent

PASSING = 1e-3  # of the forces and of the largest residual: enough to leave a level that is not stored
ON_THE_WAY = 1e-6  # `Kinematics.converged` at such a level
LARGE = 600  # dynamic degrees of freedom; above, no dense tangent is formed


@dataclass(frozen=True)
class Converged:
    """What Newton's iteration found: the state y, its equilibrium, and max |R| of every evaluation."""

    y: Array
    state: Equilibrium
    history: tuple[float, ...]

    @property
    def iterations(self) -> int:
        return len(self.history) - 1


def newton(dynamics: Dynamics, y: Array, level: LoadLevel, sparse: Callable[[], SparseTangent] | None) -> Converged:
    """Solve R = 0 from y; `sparse` gives the sparse tangent where it applies.

    Raises AnalysisError 'statics.no-convergence', 'statics.no-solution', or what the position problem raises.
    """
    settings, n = dynamics.mechanism.settings, dynamics.numbering
    history: list[float] = []
    seen = 0.0
    y = y.copy()
    dynamics.kinematics.begin()
    dynamics.kinematics.converged = CONVERGED if level.store else ON_THE_WAY
    while True:
        state = equilibrium(dynamics, dynamics.place(0.0, y))
        history.append(state.norm)
        seen = max(seen, state.work)
        at_rest = len(history) > 1 and state.norm <= settings.tolerance and state.norm >= 0.5 * history[-2]
        passed = not level.store and state.work <= PASSING * min(seen, state.work_size)
        if state.reached(settings.tolerance, seen) or at_rest or passed:
            return Converged(y, state, tuple(history))
        if not np.isfinite(state.norm) or len(history) > settings.max_iterations:
            raise no_convergence(dynamics, state, level, history)
        y[: n.nddof] -= _correction(dynamics, state, sparse)


def _correction(d: Dynamics, state: Equilibrium, sparse: Callable[[], SparseTangent] | None) -> Array:
    """K^-1 R."""
    if sparse is not None:
        try:
            return -sparse().correction(state.sigma, state.full)
        except SingularMatrixError as error:
            if d.numbering.nddof > LARGE:
                raise AnalysisError(
                    f"the tangent stiffness is singular ({error}): a motion without stiffness, or exactly a"
                    f" critical load;"
                    " support or prescribe the motion, or change the load",
                    "statics.no-solution",
                ) from None
    K = tangent(d, state, d.mechanism.settings.stationary_type in WITHOUT_N0)
    names = [d.numbering.q_names[i] for i in d.numbering.dynamic]
    return solve_tangent(K, state.residual, names, state.size)


def no_convergence(d: Dynamics, state: Equilibrium, level: LoadLevel, history: list[float]) -> AnalysisError:
    """The failure with its numbers: load step, residuals, definiteness of the stiffness, advice."""
    settings, n = d.mechanism.settings, d.numbering
    k = int(np.argmax(np.abs(state.residual))) if np.isfinite(state.norm) else 0
    text = (
        f"the stationary solution did not converge at {level}: largest residual"
        f" {' '.join(f'{r:.3g}' for r in history)} after {len(history) - 1} iterations (tolerance"
        f" {settings.tolerance:.3g}),"
        f" the last one at {n.q_names[n.dynamic[k]]}{_definiteness(d, state)}; try more load steps, more"
        f" iterations or a"
        " smaller load (ITERSTEP), or type 1 or 3 when N0 disturbs"
    )
    return AnalysisError(text, "statics.no-convergence", history=tuple(history), level=level)


def _definiteness(d: Dynamics, state: Equilibrium) -> str:
    """Has the tangent stiffness of the last iterate negative eigenvalues?"""
    if d.numbering.nddof > LARGE or not np.isfinite(state.norm):
        return ""
    K = tangent(d, state, without_n0=False)
    if not np.isfinite(K).all():
        return ""
    negative = int(np.sum(np.linalg.eigvalsh((K + K.T) / 2) < 0.0))
    if not negative:
        return "; the tangent stiffness there is positive definite"
    return (
        f"; the tangent stiffness there has {negative} negative eigenvalue{'s' * (negative > 1)}:"
        " a critical load has been passed, or the last iterate is far from the solution"
    )
