"""The ways in which an integration can fail, as errors that say when, how far, which component and what to try."""

from __future__ import annotations

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


def step_too_small(evaluation: Evaluation, t: float, h: float, error: float, component: int) -> AnalysisError:
    """The step fell below the resolution of the time; `error` is the estimate as a multiple of the tolerance."""
    return AnalysisError(
        f"the integration stopped at t = {t:.9g} s: with step size {h:.3g} s the error estimate is "
        f"still {error:.3g} times the tolerance, largest in {evaluation.name(component)}. {STIFF_ADVICE}",
        "integrator.step-too-small", t=t, step=h, error=error,
        component=component,
    )  # fmt: skip


def too_many_steps(t: float, h: float, limit: int) -> AnalysisError:
    """More than `limit` steps between two outputs."""
    return AnalysisError(
        f"more than {limit} integration steps between two output times at t = {t:.9g} s "
        f"(step size {h:.3g} s). {STIFF_ADVICE}",
        "integrator.too-many-steps", t=t, step=h,
    )  # fmt: skip


def not_evaluated(cause: AnalysisError, t: float, h: float, reductions: int = 0) -> AnalysisError:
    """F failed in the step from `t`; keeps code and data of the cause and adds time, step and advice."""
    if reductions:
        what = f"after {reductions} reductions of the step size to {h:.3g} s"
        advice = "look for a singular position or a vanishing mass at this time"
    else:
        what = f"with step size {h:.3g} s"
        advice = (
            "try a smaller step size (INTEGRAT position 2) or a code with variable steps (INTEGRAT 0 or 155)"
        )
    if reductions and cause.code == "integrator.newton":
        advice = "enlarge ERROR, look for a singular position at this time, or use a code without iteration"
    if cause.code.startswith("user-function"):
        advice = "correct the function"
    return AnalysisError(
        f"{cause}; the integration stopped at t = {t:.9g} s {what}: {advice}", cause.code,
        **{**cause.data, "t": t, "step": h},
    )


def newton_failed(
    evaluation: Evaluation, t: float, h: float, change: float, component: int, limit: float
) -> AnalysisError:
    """The stage equations of an implicit code were not solved."""
    return AnalysisError(
        "the implicit integrator's Newton iteration did not converge in the step of "
        f"{h:.3g} s from t = {t:.9g} s: last change {change:.3g} in {evaluation.name(component)}, "
        f"required {limit:.3g}. Try a smaller step size (INTEGRAT position 2) or, when the change is at "
        "rounding level, a larger absolute error (ERROR position 1)",
        "integrator.newton", t=t, step=h, error=change,
        component=component,
    )  # fmt: skip


def singular_iteration(t: float, h: float) -> AnalysisError:
    """s of `resolvent` is an eigenvalue of the Jacobian; codes with variable steps try another size."""
    return AnalysisError(
        f"the iteration matrix of the implicit integrator is singular at t = {t:.9g} s with step size {h:.3g} s (an"
        " unstable mode grows exactly with this step): change the step size (INTEGRAT position 2)",
        "integrator.singular", t=t, step=h,
    )  # fmt: skip


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


def second_order_needed(code: int, n_positions: int, n_velocities: int) -> AnalysisError:
    """Codes 220 and 225 on a system with kinematic coordinates."""
    return AnalysisError(
        f"INTEGRAT {code} needs as many velocities as positions, the model has {n_velocities} and "
        f"{n_positions} (kinematic coordinates of non-holonomic constraints): use INTEGRAT 0, 155 or 140",
        "integrator.second-order",
        n_positions=n_positions, n_velocities=n_velocities,
    )  # fmt: skip
