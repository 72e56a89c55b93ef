"""Accepted steps of a simulation, from one restart to the next, by one code or by the one that goes on faster.

States are handed on as (q, others, v) with v the rates of the positions q of mechanisms, so that Radau IIA measures a
rate by the displacement that it makes (integrators/radau.py).

The automatic method (integrators/automatic.py) takes 155, and 595 where a vibration or a decay of the loop that is
faster than its motion limits the steps. Work is counted in evaluations of the diagram, Jacobians with all that they
take; the largest omega is that of the eigenvalues of the Jacobian. Sampling times and events, where the integration
starts again, do not end a trial.

Where one compiled mechanism is the only block with rates of its own, and all that they depend on besides is affine
(affine_blocks.py) or given in time, the stages of a step are one call in C (spacar/compiled/loop_stages.py).
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import numpy as np

from spacar.arrays import Array
from spacar.errors import AnalysisError
from spacar.integrators import AUTOMATIC, METHODS, Problem, Step, Tolerance, steps
from spacar.integrators.method_choice import FIRST_LOOK, MethodChoice
from spacar.simulation.affine_blocks import AffineRun, Plan
from spacar.simulation.blocks import NONE
from spacar.simulation.diagram import Schedule
from spacar.simulation.diagram_evaluator import DiagramEvaluator
from spacar.simulation.plant import CompiledPlant, Spasim

EXPLICIT, IMPLICIT = 155, 595
# Evaluations of a step, counted with refused steps: 6.2 to 6.9 by 155, 8.6 (linear) to 17.6 by 595 (van der Pol)
EVALUATIONS, ITERATED = 6.0, 18.0
STABLE = 0.9  # h omega above which it does, of explicit codes
FAST = 0.33  # h omega above which a vibration may limit the steps: 155 is stable up to about 1 near the imaginary axis


class CompiledLoop:
    """`stages` of a problem (integrators/problem.py), of states in the order of stepping.py; `rates`: of one alone."""

    def __init__(self, s: Schedule, plan: Plan, plant: Spasim, motion: CompiledPlant) -> None:
        from spacar.compiled.loop_stages import LoopStages

        self.plant, order = plant, plan.for_rates
        self.sources = [b for b in order.first if b is not plant]
        ends = np.cumsum([0, *(b.n_out for b in self.sources)])
        self.places = [slice(a, b) for a, b in pairwise(ends)]
        n_x = s.n_states
        own, outputs = s.states[plant.name], n_x + s.outputs[plant.name].start
        read, rows = plant.placed
        signals = [n_x + k for b in self.sources for k in range(s.outputs[b.name].start, s.outputs[b.name].stop)]
        others = [k for k in range(n_x) if not own.start <= k < own.stop]
        # what z of the plan is of (1, signals, states of blocks, what is read)
        known = np.array([-1, *signals, *others, *(outputs + read)], np.int64)
        z = np.zeros((n_x + s.wiring.shape[1] + 1, len(known)))
        z[known, np.arange(len(known))] = 1.0
        for run in order.later:
            assert isinstance(run, AffineRun)  # `loop_of` has asked
            z[n_x + run.rows] = run.matrix @ z
        product = plan.matrix @ z
        u, rates = product[: plant.n_in], product[plant.n_in :]
        stresses, forces = motion.stresses, motion.forces
        load = np.concatenate((forces.rows, motion.n.nx + stresses.rows))
        matrix = np.vstack((forces.by @ u, stresses.by @ u, rates))
        self.in_c = LoopStages(motion.evaluator, rows, load, matrix, len(signals))
        self.at, self.found, self.alone = np.zeros(n_x), np.zeros((1, n_x)), (np.zeros(1), np.zeros((1, 1)))

    def rates(self, t: float, y: Array) -> Array | None:
        """F (n,), in an array that is used again; None where C cannot, or finds what is not finite."""
        self.at[:] = y
        done = self(0, *self.alone, t, 0.0, (t, t), self.at, self.found)
        return self.found[0] if done and np.isfinite(self.found[0].dot(self.found[0])) else None

    def __call__(
        self, done: int, c: Array, a: Array, t: float, h: float, window: tuple[float, float], y: Array, K: Array
    ) -> int:
        given = np.empty((len(c), self.in_c.n_given))
        for i in range(done, len(c)):
            time = min(max(t + float(c[i]) * h, window[0]), window[1])
            for b, place in zip(self.sources, self.places, strict=True):
                given[i, place] = b.state_outputs(time, NONE)
        self.plant.forget()
        return self.in_c(done, c, a, t, h, window, given, y, K)


def loop_of(s: Schedule, plan: Plan) -> CompiledLoop | None:
    """For the present modes of the blocks; None where a part has to be asked in Python."""
    order = plan.for_rates
    if len(plan.alone) != 1 or not all(isinstance(part, AffineRun) for part in order.later):
        return None
    plant = plan.alone[0][0]
    if not isinstance(plant, Spasim) or any(b.n_states for b in order.first if b is not plant):
        return None
    motion = plant.motion
    return CompiledLoop(s, plan, plant, motion) if isinstance(motion, CompiledPlant) and not motion.whole else None


class _Mistake(Exception):
    """An error of a block, its argument, on its way through the integrator."""


class _Problem(Problem):
    """The diagram as the integrators see it (integrators/problem.py). It counts evaluations."""

    def __init__(self, evaluator: DiagramEvaluator, absolute: float) -> None:
        s = evaluator.s
        self.evaluator, self.absolute = evaluator, absolute
        n = s.n_states
        pairs = [(s.states[b.name], b.numbering.nddof) for b in s.blocks if isinstance(b, Spasim)]
        first = [i for part, k in pairs for i in range(part.start, part.start + k)]
        last = [i for part, k in pairs for i in range(part.stop - k, part.stop)]
        self.order = np.array([*first, *sorted({*range(n)} - {*first, *last}), *last], np.int64)
        self.back = np.argsort(self.order)
        self.n_positions = n - len(last) if last else 0
        self.of_jacobian = 1 + sum(b.n_states + b.n_in for b in s.blocks if b.affine() is None)
        self.n_rhs = 0
        self.loop: CompiledLoop | None = None

    def rhs(self, t: float, y: Array) -> Array:
        """F. The integrator would answer an AnalysisError with a smaller step, which does not cure a mistake in a
        block: that goes straight through as a _Mistake.
        """
        self.n_rhs += 1
        found = None if self.loop is None else self.loop.rates(t, y)
        if found is not None:
            return found
        try:
            return self.evaluator.rates(t, y[self.back])[self.order]
        except AnalysisError as error:
            if error.code.startswith(("simulation.", "user-function")):
                raise _Mistake(error) from error
            raise

    @property
    def blocks(self) -> _Problem | None:  # type: ignore[override]
        """Where all of it is in C; asked at every start, as modes may have changed."""
        self.loop = loop_of(self.evaluator.s, self.evaluator.plan)
        return None if self.loop is None else self

    def stages(self, done: int, *step: Any) -> int:
        assert self.loop is not None
        reached = self.loop(done, *step[:-1])  # positions keep the tolerance of the loop
        self.n_rhs += reached - done
        return reached

    def newton(self, method: Any) -> None:
        """In Python."""

    def jacobian(self, t: float, y: Array) -> tuple[Array, Array]:
        """(dF/dy, dF/dt), (n, n) and (n,): dF/dt as zero; a simplified Newton iteration needs no more."""
        self.n_rhs += self.of_jacobian
        found = self.evaluator.jacobian(t, y[self.back], self.absolute)
        return found[np.ix_(self.order, self.order)], np.zeros(len(y))


class Stepping:
    """Steps of a simulation `over` these times [s] by the code `method`, none longer than `longest` [s].

    n_steps   so far;  notes   what the log says about a change of the method
    """

    def __init__(
        self, evaluator: DiagramEvaluator, method: int, tolerance: Tolerance, longest: float, over: tuple[float, float]
    ) -> None:
        self.problem = _Problem(evaluator, float(np.min(tolerance.absolute)))
        self.tolerance, self.longest, (self.begun, self.end) = tolerance, longest, over
        self.automatic = method == AUTOMATIC
        self.code = EXPLICIT if self.automatic else method
        self.solver: Iterator[Step] | None = None
        self.size: float | None = None  # of the last step, with which an integration that starts anew begins
        self.n_steps = 0
        self.last: Step | None = None
        self.notes: list[str] = []
        look = self.problem.of_jacobian / EVALUATIONS
        self.choice = MethodChoice(ITERATED / EVALUATIONS + look, look, FAST, self._largest)
        self.choice.begin(self.begun, 0)
        self.explicit = 0  # steps of 155

    def restart(self) -> None:
        """What comes is not smooth any more."""
        self.solver = None

    def step(self, t: float, x: Array, end: float, window: tuple[float, float]) -> Step:
        """One accepted step from t, not beyond `end`; the diagram is evaluated in the window. Raises AnalysisError."""
        if not len(x):
            return Step(min(end, t + self.longest), x, lambda time: x)
        order, back = self.problem.order, self.problem.back
        try:
            if self.solver is None:
                self.solver = steps(
                    self.problem, t, x[order], end, window, self.code, self.tolerance, self.size, self.longest
                )
            taken = next(self.solver)
        except _Mistake as mistake:
            raise mistake.args[0] from None
        except AnalysisError as error:
            if error.code != "integrator.step-too-small":
                raise
            if self.automatic and self.code == EXPLICIT:
                self.choice.size = error.data["step"]
                self._try(t)
                return self.step(t, x, end, window)
            text = (
                f"the step size became too small at t = {error.data.get('t', t):.9g}; the loop may be unstable or"
                " stiff: check the gains, or use the method 553"
            )
            raise AnalysisError(text, "simulation.step-too-small") from None
        self.n_steps += 1
        size = float(taken.t) - t
        # The last step of a piece is short only because the piece ends.
        self.size = max(size, self.size or 0.0) if taken.t >= end else size
        self.last = found = Step(float(taken.t), taken.y[back], lambda time: np.asarray(taken.interpolate(time))[back])
        if self.automatic:
            self._choose(found)
        return found

    def hint(self) -> str:
        """What limits the steps, where that is a vibration or decay that is faster than they need be."""
        if METHODS[self.code].needs_jacobian or self.last is None or self.n_steps < FIRST_LOOK:
            return ""
        mean, omega, advice = (self.end - self.begun) / self.n_steps, self.choice.omega, "or a larger rtol"
        if not self.automatic:
            omega, advice = self._largest(self.last.t, self.last.y), f"or method {IMPLICIT} or auto"
        if mean * omega <= (FAST if self.automatic else STABLE):
            return ""
        return (
            f"{self.n_steps} steps of {mean:.3g} s, as the loop has a vibration or decay of {omega:.3g} rad/s: a"
            f" slower filter or lower gain, stiff parts made rigid, {advice} make the steps longer"
        )

    # -- the automatic method ------------------------------------------------------------------------------------
    def _choose(self, at: Step) -> None:
        """Whether another code goes on behind the step."""
        choice = self.choice
        if self.code == EXPLICIT:
            self.explicit += 1
            if self.explicit >= choice.look and choice.limited(at.t, at.y, self.explicit, self.end):
                self._try(at.t)
            return
        stood = choice.stays
        if not choice.goes_on(at.t, self.problem.n_rhs / EVALUATIONS):
            if stood:
                self.notes.append(f"from t = {at.t:.9g}: method {EXPLICIT} ({METHODS[EXPLICIT].name}) again")
            choice.begin(at.t, self.explicit)
            self.code, self.solver, self.size = EXPLICIT, None, choice.size
        elif choice.stays and not stood:
            self.notes.append(
                f"from t = {at.t:.9g}: method {IMPLICIT} ({METHODS[IMPLICIT].name}), as a vibration or decay of the"
                f" loop ({choice.omega:.3g} rad/s) limits the steps of {EXPLICIT}"
            )

    def _largest(self, t: float, x: Array) -> float:
        found = self.problem.jacobian(t, x[self.problem.order])[0]
        return float(np.max(np.abs(np.linalg.eigvals(found)), initial=0.0))

    def _try(self, t: float) -> None:
        self.choice.attempt(t, self.problem.n_rhs / EVALUATIONS)
        self.code, self.solver, self.size = IMPLICIT, None, None
