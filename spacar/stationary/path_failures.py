"""Why an equilibrium path ends, in words, with what helps."""

from __future__ import annotations

from spacar.errors import AnalysisError
from spacar.stationary.arc_length import LimitPoint
from spacar.stationary.level_evaluator import LevelEvaluator
from spacar.stationary.loading import LoadLevel
from spacar.stationary.stability import critical_motion


def at_limit(e: LevelEvaluator, reached: LoadLevel, target: LoadLevel, limit: LimitPoint) -> AnalysisError:
    """The loads grow and the path turns back before the target."""
    e.load(reached)
    e.dynamics.sweep.strain(limit.point.x)
    motion = critical_motion(e.equations, e.tangent, limit.point, negative=False)
    text = (
        f"the equilibrium path has a limit point at {reached.initial:.8g} x initial + {reached.additional:.8g} x"
        f" additional loading, before {target} is reached: no static solution is near beyond it, the mechanism"
        " jumps" + (f" (the motion is largest at {motion})" if motion else "") + "; prescribe the displacement"
        " instead of the load, or give ITERSTEP position 7 the value 1 to follow the path beyond limit points;"
        " where beams bend by tens of degrees in one element, the model with more elements may have none"
    )
    return AnalysisError(text, "statics.limit-point", level=reached)


def unsupported(e: LevelEvaluator, coordinate: int, target: LoadLevel) -> AnalysisError:
    """The load works on a motion without stiffness, mainly of this coordinate of x."""
    text = (
        f"no stationary solution at {target}: the stiffness matrix is singular and the load works on a motion"
        f" without stiffness, mainly {e.mechanism.numbering.x_name(coordinate)}; support it (FIX), prescribe it"
        " (INPUTX, INPUTE) or give it a stiffness (ESTIFF)"
    )
    return AnalysisError(text, "statics.no-solution")


def given_up(
    reached: LoadLevel, target: LoadLevel, smallest: float, reason: Exception, known: str
) -> AnalysisError:
    """Parts as small as `smallest` do not converge; `known` of the last solution, at the level that was reached."""
    text = (
        f"the stationary solution did not converge at {target}: {reason}; the step was cut to {smallest:.3g} of its"
        f" size, the last solution is at {reached.initial:.6g} x initial + {reached.additional:.6g} x additional"
        f" loading {known}; try more iterations, more load steps or a smaller load (ITERSTEP)"
    )
    return AnalysisError(text, "statics.no-convergence", level=target)
