"""The ways in which an integration can fail, as errors that say when, how far, which component and what to try."""

import numpy as np

from spacar.errors import AnalysisError

from .problem import Evaluation

# So many times in a row a variable-step method reduces its step when F cannot be evaluated.
MAX_REDUCTIONS = 10
REDUCTION = 0.25
LAST_STRETCH = 1.01  # the last step may be so much longer, so that none of rounding follows

STIFF_ADVICE = (
    "A stiff model (high-frequency vibration) wants an implicit code, INTEGRAT 553 or 595 (variable steps), 330 or "
    "430, or its stiff deformations made rigid; otherwise look for a singular position at this time or enlarge ERROR"
)


def step_too_small(evaluation: Evaluation, t: float, h: float, error: float, scaled: np.ndarray) -> AnalysisError:
    """The step fell below the resolution of the time; `error` is the estimate as a multiple of the tolerance, `scaled`
    its components."""
    component = int(np.argmax(np.abs(scaled)))
    return AnalysisError(
        f"the integration stopped at t = {t:.9g} s: with step size {h:.3g} s the error estimate is "
        f"still {error:.3g} times the tolerance, largest in {evaluation.name(component)}. {STIFF_ADVICE}",
        "integrator.step-too-small", t=t, step=h, error=error,
        component=component,
    )  # fmt: skip


def not_evaluated(cause: AnalysisError, t: float, h: float, reductions: int = 0) -> AnalysisError:
    """F failed in the step from `t`; keeps code and data of the cause and adds time, step and advice."""
    if reductions:
        what = f"after {reductions} reductions of the step size to {h:.3g} s"
        advice = "look for a singular position or a vanishing mass at this time"
    else:
        what = f"with step size {h:.3g} s"
        advice = "try a smaller step size (INTEGRAT position 2) or a code with variable steps (INTEGRAT 0 or 155)"
    if reductions and cause.code == "integrator.newton":
        advice = "enlarge ERROR, look for a singular position at this time, or use a code without iteration"
    if cause.code.startswith("user-function"):
        advice = "correct the function"
    return AnalysisError(
        f"{cause}; the integration stopped at t = {t:.9g} s {what}: {advice}",
        cause.code,
        **{**cause.data, "t": t, "step": h},
    )


def slow_newton(
    evaluation: Evaluation, t: float, h: float, change: float, contraction: float, component: int, limit: float
) -> AnalysisError:
    """The stages of a variable-step implicit code were not found; `change` is a multiple of the tolerance."""
    return AnalysisError(
        f"the implicit integrator's Newton iteration does not converge in the step of {h:.3g} s from t = {t:.9g} s: "
        f"last change {change:.3g} times the tolerance in {evaluation.name(component)}, {contraction:.2g} times the "
        f"change before; its estimated error must fall below {limit:g} times the tolerance",
        "integrator.newton", t=t, step=h, error=change,
        component=component,
    )  # fmt: skip
