"""The loop of one-step codes with variable steps.

Step control: theory-system.md section 9. The first step follows Hairer, Norsett, Wanner, "Solving Ordinary Differential
Equations I", section II.4.
"""

from collections.abc import Iterator
from math import inf

import numpy as np

from spacar.arrays import EPS
from spacar.errors import AnalysisError

from .failures import LAST_STRETCH, MAX_REDUCTIONS, REDUCTION, not_evaluated, step_too_small
from .problem import Step
from .runge_kutta import ExplicitRungeKutta, OneStepMethod


def one_step(
    integrator: OneStepMethod, t: float, y: np.ndarray, t_end: float, h: float, estimate: bool, longest: float = inf
) -> Iterator[Step]:
    """As `Adams.steps`, of a one-step code; `estimate` the first step, of h at most; no step is above `longest` [s]."""
    exponent, smallest, largest = integrator.controller
    evaluation = integrator.evaluation
    h_min = 4.0 * EPS * max(abs(t), abs(t_end), t_end - t)
    f = integrator.start(t, y)
    if estimate:
        h = min(h, _first_step(integrator, t, y, f.copy()))
    h = max(min(h, longest), h_min)
    if evaluation.stepper is not None and isinstance(integrator, ExplicitRungeKutta):
        yield from evaluation.stepper.steps(integrator, t, t_end, h, longest)
        return
    final = False
    while not final:
        integrator.begin(t)
        growth, reductions = largest, 0
        while True:
            final = t + min(LAST_STRETCH * h, max(h, longest)) >= t_end
            if final:
                h = t_end - t
            try:
                error = integrator.attempt(h)
                if error <= 1.0:
                    integrator.finish()
                    break
            except AnalysisError as cause:
                reductions += 1
                evaluation.step_rejected()
                if reductions > MAX_REDUCTIONS or h * REDUCTION < h_min:
                    raise not_evaluated(cause, t, h, reductions) from cause
                h *= REDUCTION
                growth = 1.0
                continue
            evaluation.step_rejected()
            growth = 1.0
            reduced = h * max(smallest, 0.9 * error ** (-1.0 / exponent))
            if reduced < h_min:
                raise step_too_small(evaluation, t, h, error, integrator.scaled)
            h = reduced
        t = t_end if final else t + h
        evaluation.step_accepted(t, integrator.y_new)
        yield Step(t, integrator.y_new, integrator.interpolate)
        h = max(min(h * min(growth, integrator.factor(error)), longest), h_min)


def _first_step(integrator: OneStepMethod, t: float, y: np.ndarray, f: np.ndarray) -> float:
    """Step with a local error of about a hundredth of the tolerance, from |y|, |F| and one Euler step."""
    weight = integrator.tolerance.absolute + integrator.tolerance.relative * np.abs(y)

    def norm(v: np.ndarray) -> float:
        return float(np.sqrt(np.mean((v / weight) ** 2)))

    size, slope = norm(y), norm(f)
    h0 = 1e-6 if min(size, slope) < 1e-5 else 0.01 * size / slope
    h0 = min(h0, integrator.evaluation.last - t)
    try:
        bend = norm(integrator.evaluation.rhs(t + h0, y + h0 * f) - f) / h0
    except AnalysisError:
        return h0  # the step loop deals with a state that cannot be evaluated
    largest = max(slope, bend)
    h1 = max(1e-6, 1e-3 * h0) if largest <= 1e-15 else (0.01 / largest) ** (1.0 / integrator.controller[0])
    return min(100.0 * h0, h1)
