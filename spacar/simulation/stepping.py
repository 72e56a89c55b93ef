"""Accepted steps of a simulation, from one restart to the next, by one code or by the one that goes on faster.

States are handed on as (q, others, v) with v the rates of the positions q of mechanisms, so that Radau IIA measures a
rate by the displacement that it makes (integrators/radau.py).

The automatic method takes 155, and 595 where a vibration or a decay of the loop that is faster than its motion limits
the steps. After 200, 400, 800 ... steps of 155 of mean size h it asks for the largest eigenvalue of the Jacobian; where
h |lambda| is above FAST (155 is stable up to about 1 near the imaginary axis, 3.3 on the real one) 595 is tried. It
stays when more time passes for an evaluation of the diagram than with 155, over the LAST of at least TRIAL steps; they
grow slowly while old vibrations are damped, so that a trial goes on up to LONGEST_TRIAL while each LAST of them are
GROWING times the ones before. It is left when over WATCHED steps less than LEFT of that time passes. Sampling times and
events, where the integration starts again, do not end a trial. A trial begins only where the steps ahead are worth it:
what trials in vain have cost may be the part LOST of them.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np

from spacar.arrays import Array
from spacar.errors import AnalysisError
from spacar.integrators import AUTOMATIC, METHODS, Step, Tolerance, steps
from spacar.simulation.compiled_loop import loop_of
from spacar.simulation.diagram_evaluator import DiagramEvaluator
from spacar.simulation.plant import Spasim

EXPLICIT, IMPLICIT = 155, 595
FIRST_LOOK, FAST = 200, 0.5
TRIAL, LAST, LONGEST_TRIAL, GROWING = 20, 10, 100, 1.2
GAIN, LOST = 4.0, 0.2  # evaluations of a step of 595 over those of 155, about; see above
WATCHED, LEFT = 100, 0.5


class _Mistake(Exception):
    """An error of a block, on its way through the integrator."""

    def __init__(self, error: AnalysisError) -> None:
        super().__init__(str(error))
        self.error = error


class _Problem:
    """The diagram as the integrators see it (integrators/problem.py). It counts evaluations."""

    def __init__(self, evaluator: DiagramEvaluator, absolute: float) -> None:
        s = evaluator.s
        self.evaluator, self.absolute = evaluator, absolute
        n = sum(b.n_states for b in s.blocks)
        pairs = [(s.states[b.name], b.numbering.nddof) for b in s.blocks if isinstance(b, Spasim)]
        first = [i for part, k in pairs for i in range(part.start, part.start + k)]
        last = [i for part, k in pairs for i in range(part.stop - k, part.stop)]
        self.order = np.array([*first, *sorted({*range(n)} - {*first, *last}), *last], np.int64)
        self.back = np.argsort(self.order)
        self.n_positions = n - len(last) if last else 0
        self.of_jacobian = 1 + sum(b.n_states + b.n_in for b in s.blocks if b.affine() is None)
        self.n_rhs = 0

    def rhs(self, t: float, y: Array) -> Array:
        """F. The integrator would answer an AnalysisError with a smaller step, which does not cure a mistake in a
        block: that goes straight through as a _Mistake.
        """
        self.n_rhs += 1
        try:
            return self.evaluator.rates(t, y[self.back])[self.order]
        except AnalysisError as error:
            if error.code.startswith(("simulation.", "user-function")):
                raise _Mistake(error) from error
            raise

    @property
    def stages(self) -> Callable[..., int] | None:
        """Where all of it is in C; asked at every start, as modes may have changed."""
        loop = loop_of(self.evaluator.s, self.evaluator.plan)
        if loop is None:
            return None

        def counted(done: int, *step: Any) -> int:
            reached = loop(done, *step)
            self.n_rhs += reached - done
            return reached

        return counted

    def jacobian(self, t: float, y: Array) -> tuple[Array, Array]:
        """(dF/dy, dF/dt), (n, n) and (n,): dF/dt as zero; a simplified Newton iteration needs no more."""
        self.n_rhs += self.of_jacobian
        found = self.evaluator.jacobian(t, y[self.back], self.absolute)
        return found[np.ix_(self.order, self.order)], np.zeros(len(y))


class Taken(NamedTuple):
    """An accepted step: its end, interpolation inside it, state at the end (n_states,)."""

    t: float
    interpolate: Callable[[float], Array]
    x: Array


class Stepping:
    """Steps up to the end of the simulation [s] by the code `method`, none longer than `longest` [s].

    n_steps, n_rhs   work so far;  notes   what the log says about a change of the method
    """

    def __init__(
        self, evaluator: DiagramEvaluator, method: int, tolerance: Tolerance, longest: float, end: float
    ) -> None:
        self.problem = _Problem(evaluator, float(np.min(tolerance.absolute)))
        self.tolerance, self.longest, self.end = tolerance, longest, end
        self.automatic = method == AUTOMATIC
        self.code = EXPLICIT if self.automatic else method
        self.solver: Iterator[Step] | None = None
        self.size: float | None = None  # of the last step, with which an integration that starts anew begins
        self.n_steps = 0
        self.notes: list[str] = []
        self.look, self.pace, self.lost = FIRST_LOOK, 0.0, 0.0
        self.explicit, self.explicit_size = 0, 0.0
        self.stays, self.fastest = False, 0.0
        self.way: deque[tuple[float, int]] = deque(maxlen=WATCHED + 1)  # time passed and evaluations
        self.passed = 0.0

    @property
    def n_rhs(self) -> int:
        return self.problem.n_rhs

    def restart(self) -> None:
        """What comes is not smooth any more."""
        self.solver = None

    def step(self, t: float, x: Array, end: float, window: tuple[float, float]) -> Taken:
        """One accepted step from t, not beyond `end`; the diagram is evaluated in the window. Raises AnalysisError."""
        if not len(x):
            return Taken(min(end, t + self.longest), lambda time: x, x)
        order, back = self.problem.order, self.problem.back
        try:
            if self.solver is None:
                self.solver = steps(
                    self.problem, t, x[order], end, window, self.code, self.tolerance, self.size, self.longest
                )
            taken = next(self.solver)
        except _Mistake as mistake:
            raise mistake.error from None
        except AnalysisError as error:
            if error.code != "integrator.step-too-small":
                raise
            if self.automatic and self.code == EXPLICIT:
                self._change(IMPLICIT)
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
        found = Taken(float(taken.t), lambda time: np.asarray(taken.interpolate(time))[back], taken.y[back])
        if self.automatic:
            self.passed += size
            self.way.append((self.passed, self.n_rhs))
            self._choose(found)
        return found

    def hint(self, begun: float) -> str:
        """What limits the steps, where that is a vibration or decay that is faster than they need be; since `begun`."""
        mean = (self.end - begun) / max(self.n_steps, 1)
        if self.code == IMPLICIT or mean * self.fastest <= FAST:
            return ""
        return (
            f"{self.n_steps} steps of {mean:.3g} s, as the loop has a vibration or decay of {self.fastest:.3g} rad/s: a"
            " slower filter or lower gain, stiff parts made rigid, or a larger rtol make the steps longer"
        )

    # -- the automatic method ------------------------------------------------------------------------------------
    def _paced(self, n: int) -> float:
        """Time for an evaluation over the last n steps [s]."""
        (a, before), (b, now) = self.way[-1 - n], self.way[-1]
        return (b - a) / (now - before)

    def _choose(self, at: Taken) -> None:
        """Whether another code goes on behind the step."""
        made = len(self.way) - 1
        if self.code == EXPLICIT:
            self.explicit += 1
            if self.explicit >= self.look and made:
                self.look = 2 * self.explicit
                self.pace = self._paced(made)
                if self._limited(at, (self.way[-1][0] - self.way[0][0]) / made):
                    self._change(IMPLICIT)
        elif not self.stays and made >= TRIAL and made % LAST == 0:
            grows = self._paced(LAST) >= GROWING * (self.way[-1 - LAST][0] - self.way[-1 - 2 * LAST][0]) / max(
                self.way[-1 - LAST][1] - self.way[-1 - 2 * LAST][1], 1
            )
            self.stays = self._paced(LAST) > self.pace
            if not self.stays and (made >= LONGEST_TRIAL or not grows):
                self._leave(at.t)
            elif self.stays:
                self.notes.append(
                    f"from t = {at.t:.9g}: method {IMPLICIT} ({METHODS[IMPLICIT].name}), as a vibration or decay of the"
                    f" loop ({self.fastest:.3g} rad/s) limits the steps of {EXPLICIT}"
                )
        elif self.stays and made >= WATCHED and self._paced(WATCHED) < LEFT * self.pace:
            self.notes.append(f"from t = {at.t:.9g}: method {EXPLICIT} ({METHODS[EXPLICIT].name}) again")
            self._leave(at.t)

    def _limited(self, at: Taken, size: float) -> bool:
        """May something fast limit the steps of mean `size` [s], and are there enough of them ahead?"""
        if LOST * (self.end - at.t) / size < self.lost + TRIAL * GAIN:
            return False
        found = self.problem.jacobian(at.t, at.x[self.problem.order])[0]
        self.fastest = float(np.max(np.abs(np.linalg.eigvals(found)), initial=0.0))
        self.explicit_size = size
        return size * self.fastest > FAST

    def _leave(self, t: float) -> None:
        self.lost += 0.0 if self.stays else GAIN * (len(self.way) - 1)
        self._change(EXPLICIT)
        self.size = self.explicit_size

    def _change(self, code: int) -> None:
        self.code, self.solver, self.size, self.stays = code, None, None, False
        self.way.clear()
        self.way.append((self.passed, self.n_rhs))
