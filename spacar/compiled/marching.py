"""Steps of an integrator in C, from output to output: Adams (code 0) and explicit Runge-Kutta (135, 155, 853).

The methods stay those of `spacar.integrators`: C works on the arrays of their objects and with their coefficients, so
that interpolation, failures and messages are theirs too. Python is called back where C cannot give a derivative, and
at the accepted steps that have to be looked at (`Lookout`).
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, Protocol

import numpy as np

from spacar.arrays import Array
from spacar.compiled.compiled_model import CompiledModel, State
from spacar.compiled.library import DOUBLES, INTEGER, NUMBER, POINTER
from spacar.dynamics.loaded_mechanism import ALWAYS, NOISE, SHARE, STILL, Accepted, LoadedMechanism, Moving
from spacar.errors import AnalysisError
from spacar.integrators.adams import GAMMA_STAR, MAX_ORDER, Adams
from spacar.integrators.failures import MAX_REDUCTIONS, REDUCTION, not_evaluated, step_too_small
from spacar.integrators.problem import Step
from spacar.integrators.runge_kutta import TINY, ExplicitRungeKutta
from spacar.kinematics.kinematics import LARGEST_JUMP
from spacar.kinematics.regularity import HALF_TURN, HalfTurns
from spacar.mechanism.numbering import Numbering

ARRIVED, AT_OUTPUT, PAUSED, TOO_SMALL, NOT_EVALUATED, INTERRUPTED = range(6)  # as in march.c
MOST, COMPONENTS = 1000, 20_000  # steps in one call, and steps times components of x and e, so that Ctrl-C is heard

ASK = ctypes.CFUNCTYPE(INTEGER, NUMBER, POINTER, POINTER)
TELL = ctypes.CFUNCTYPE(INTEGER, NUMBER, POINTER)


class CMarch(ctypes.Structure):
    """`March` of march.c."""

    _fields_ = [
        ("model", POINTER), ("at", POINTER), ("ask", POINTER), ("tell", POINTER), ("records", DOUBLES),
        ("scale", DOUBLES), ("atol", DOUBLES),
        *((name, INTEGER) for name in ("n", "capacity", "width", "look", "back", "most", "max_reductions")),
        *((name, NUMBER) for name in (
            "reduction", "rtol", "longest", "converged", "jump", "earliest", "latest", "half", "inside", "wide",
            "far", "share", "noise", "still", "t", "t_end", "until", "h", "error", "peak", "begin",
        )),
        ("sizes", NUMBER * 2),
        *((name, INTEGER) for name in ("recorded", "entered", "n_steps", "n_rhs", "n_rejected", "reductions")),
        ("lambda0", POINTER), ("half_turn", NUMBER), ("signs", NUMBER * 8), ("n_lambda0", INTEGER),
    ]  # fmt: skip


class CAdams(ctypes.Structure):
    """`Adams` of adams.c."""

    _fields_ = [
        *((name, DOUBLES) for name in ("phi", "expected", "y", "y_new", "predicted", "d", "weight", "gamma_star")),
        ("psi", NUMBER * (MAX_ORDER + 1)), ("h_old", NUMBER), ("h_min", NUMBER),
        *((name, INTEGER) for name in ("k", "order", "k_old", "equal", "starting", "rejections")),
    ]  # fmt: skip


class CRungeKutta(ctypes.Structure):
    """`RungeKutta` of runge_kutta.c."""

    _fields_ = [
        *((name, DOUBLES) for name in ("c", "a", "b", "errors", "K", "y", "y_new", "scaled")),
        *((name, NUMBER) for name in ("exponent", "smallest", "largest", "safety", "tiny", "h")),
        *((name, INTEGER) for name in ("stages", "rows", "estimated", "two")),
    ]  # fmt: skip


class Lookout(Protocol):
    """Who looks at accepted steps (`spacar.forward.driver`).

    look      which of them: NEVER, AT_DETERMINANTS, AT_VELOCITIES, ALWAYS
    back      whether the state goes back to the last accepted step after a rejected one
    half      logarithm: a minimum of the determinant below its last maximum that is looked at
    inside    logarithm: the same of a state inside a step below both of its ends
    wide      logarithm: the same of a state below the larger end of a step in which a coordinate goes beyond `far`
    far       rad, or lengths of the model
    capacity  how many steps are remembered
    """

    look: int
    back: bool
    half: float
    inside: float
    wide: float
    far: float
    capacity: int

    def closer(
        self, t: float, y: Array, peak: float, before: list[Accepted] | None
    ) -> tuple[float, bool, Accepted | None]:
        """Look at the step to t, where the evaluator stands; peak of the determinants and the steps `before` it (None:
        all have been shown here). Returns peak, whether to look at the next one too, and the step (None: not known).
        Raises AnalysisError.
        """

    def started(self, t: float, y: Array) -> Accepted | None:
        """The start of the motion, unless it has begun before: then the last step of it; None: not known."""

    def passed(self, n: int, last: Callable[[int], list[Accepted]]) -> None:
        """n steps have been made; `last(k)` gives the last k of them, fewer if fewer are known."""


class InC(Protocol):
    """What is asked of the evaluator in C."""

    solver: CompiledModel
    state: State
    numbering: Numbering
    n_positions: int

    @property
    def model(self) -> LoadedMechanism: ...


class Marching:
    """The steps of one motion."""

    def __init__(self, evaluator: InC, lookout: Lookout, within: Callable[[], float]) -> None:
        model = evaluator.solver
        lanes = model.cases
        nx, ne = evaluator.numbering.nx * lanes, evaluator.numbering.ne * lanes
        n = (evaluator.n_positions + evaluator.numbering.nddof) * lanes
        self.evaluator, self.lookout, self.within = evaluator, lookout, within
        self.engine = model.engine
        self.shape = n, nx
        self.records = np.zeros((lookout.capacity, 4 + n + 3 * nx + ne))
        self.scale = np.ascontiguousarray(evaluator.model.mechanism.scale)
        self.atol = np.empty(n)  # absolute error of every component
        self.gamma_star = np.array(GAMMA_STAR)
        alone = lanes == 1
        self.calls = (ASK(self._ask), TELL(self._tell)) if alone else ()
        self.error: BaseException | None = None
        self.kept: tuple[Any, ...] = ()  # what C points at
        ask, tell = (ctypes.cast(call, POINTER).value for call in self.calls) if alone else (None, None)
        most = max(1, min(MOST, COMPONENTS // (nx + ne)))
        self.c = CMarch(
            model.handle, evaluator.state.address, ask, tell, self.records.ctypes.data, self.scale.ctypes.data,
            self.atol.ctypes.data, n, lookout.capacity, self.records.shape[1], lookout.look, lookout.back, most,
            MAX_REDUCTIONS, REDUCTION,
        )  # fmt: skip
        self.c.jump, self.c.share, self.c.noise, self.c.still = LARGEST_JUMP, SHARE, NOISE, STILL
        self.c.half, self.c.inside, self.c.wide, self.c.far = lookout.half, lookout.inside, lookout.wide, lookout.far
        if not alone:
            self.near = np.ascontiguousarray(HalfTurns(evaluator.numbering).lambda0, np.int32)
            self.c.lambda0, self.c.n_lambda0, self.c.half_turn = self.near.ctypes.data, len(self.near), HALF_TURN
        self.address = ctypes.c_void_p(ctypes.addressof(self.c))

    def steps(
        self, method: Adams | ExplicitRungeKutta, t: float, t_end: float, h: float, longest: float = float("inf")
    ) -> Iterator[Step]:
        """Steps of a method that has been started at t, at least those with an output, up to t_end."""
        c, evaluation = self.c, method.evaluation
        self.method = method
        self.atol[:], c.rtol = method.tolerance
        c.t, c.t_end, c.h, c.longest = t, t_end, h, longest
        c.earliest, c.latest = evaluation.first, evaluation.last
        c.sizes[:] = 0.0, 0.0
        c.n_steps = c.n_rhs = c.n_rejected = 0
        run, kept = self._adams(method) if isinstance(method, Adams) else self._runge_kutta(method)
        before = self.lookout.started(t, self.y)
        if before is not None and not (c.recorded and self._seen(c.recorded - 1).at.t >= before.at.t):
            self._record(0, before)  # the start, or the last of steps that were made elsewhere
            c.recorded, c.peak = 1, before.size
        counted = evaluation.statistics
        status = self.status = PAUSED
        while status != ARRIVED:
            c.until = evaluation.next_output(c.t)
            c.converged = self.within()
            status = self.status = run()
            kept()
            steps, c.n_steps = c.n_steps, 0
            counted.n_steps += steps
            counted.n_rhs += c.n_rhs
            counted.n_rejected += c.n_rejected
            c.n_rhs = c.n_rejected = 0
            if status in (TOO_SMALL, NOT_EVALUATED, INTERRUPTED):
                self._failed(status)
            self.lookout.passed(steps, self._last)
            yield Step(c.t, self.y, self.value, (c.sizes[1], c.sizes[0]))

    # -- methods --------------------------------------------------------------------------------------------------
    def _adams(self, a: Adams) -> tuple[Callable[[], int], Callable[[], None]]:
        """The call of C, and what is told to the object after it."""
        arrays = a.phi, a.expected, a.y, a.y_new, a.predicted, a.d, a.weight, self.gamma_star
        s = CAdams(*(v.ctypes.data for v in arrays))
        self.kept = s, arrays
        self.y = a.y
        at = ctypes.c_void_p(ctypes.addressof(s))
        status = self.engine.adams_begin(self.address, at)
        if status:
            self._failed(NOT_EVALUATED if status == 1 else INTERRUPTED, started=False)

        def kept() -> None:
            if self.status == TOO_SMALL:
                np.multiply(a.d, a.weight, out=a.scaled)

        found = np.empty_like(a.y)
        found_at = found.ctypes.data

        def value(t: float) -> Array:
            """y(t) in the last step."""
            self.engine.adams_value(self.address, at, t, found_at)
            return found.copy()

        self.value = value
        return partial(self.engine.adams, self.address, at), kept

    def _runge_kutta(self, m: ExplicitRungeKutta) -> tuple[Callable[[], int], Callable[[], None]]:
        tableau = m.tableau
        c, a, errors, safety = m.coefficients()
        exponent, smallest, largest = m.controller
        s = CRungeKutta(
            c.ctypes.data, a.ctypes.data, tableau.b.ctypes.data, errors.ctypes.data, m.stages.ctypes.data,
            m.y.ctypes.data, m.y_new.ctypes.data, m.scaled.ctypes.data, exponent, smallest, largest, safety, TINY, 0.0,
            len(tableau.c), len(c), errors.shape[1], len(errors) - 1,
        )  # fmt: skip
        self.y, self.kept = m.y_new, (s, c, a, errors)
        at = ctypes.c_void_p(ctypes.addressof(s))

        def kept() -> None:
            m.taken(self.c.begin, s.h)

        self.value = m.interpolate
        return partial(self.engine.runge_kutta, self.address, at), kept

    def _failed(self, status: int, started: bool = True) -> None:
        """Raise what ended a call."""
        c, evaluation = self.c, self.method.evaluation
        error, self.error = self.error, None
        if status == TOO_SMALL:
            worst = int(np.argmax(np.abs(self.method.scaled)))
            raise step_too_small(evaluation, c.t, c.h, c.error, worst)
        if error is None:  # of several cases
            self.evaluator.solver.slots.interrupted()
            error = AnalysisError(f"a case of the batch could not be followed at t = {c.t:.9g}", "study.batch")
        if status == NOT_EVALUATED and started:
            assert isinstance(error, AnalysisError)
            raise not_evaluated(error, c.t, c.h, c.reductions) from error
        raise error

    # -- called by C ----------------------------------------------------------------------------------------------
    def _vector(self, address: int) -> Array:
        return np.ctypeslib.as_array((ctypes.c_double * self.shape[0]).from_address(address))

    def _ask(self, t: float, y: int, out: int) -> int:
        """Answer C with a derivative that it cannot compute."""
        try:
            self.evaluator.solver.slots.interrupted()
            self._vector(out)[:] = self.method.evaluation.rhs(t, self._vector(y))
        except AnalysisError as error:
            self.error = error
            return 1
        except BaseException as error:  # nothing may pass through C
            self.error = error
            return 2
        return 0

    def _tell(self, t: float, y: int) -> int:
        """Look at a step for C."""
        c = self.c
        try:
            before = None
            if self.lookout.look != ALWAYS:
                first = max(0, c.recorded - self.lookout.capacity)
                before = [self._seen(k) for k in range(first, c.recorded - 1)]
            c.peak, c.entered, seen = self.lookout.closer(t, self._vector(y).copy(), c.peak, before)
            if seen is None and not self.evaluator.state.c.known:
                c.recorded -= 1
            elif seen is not None:
                self._record(c.recorded - 1, seen)
        except BaseException as error:
            self.error = error
            return 2
        return 0

    def _record(self, k: int, seen: Accepted) -> None:
        at = seen.at
        row = self.records[k % len(self.records)]
        row[:] = np.concatenate(((at.t, seen.sign, seen.size, 1.0), seen.y, at.x, at.xd, at.xdd, at.e))

    def _seen(self, k: int) -> Accepted:
        """A recorded step."""
        n, nx = self.shape
        row = self.records[k % len(self.records)].copy()
        x, xd, xdd = row[4 + n : 4 + n + 3 * nx].reshape(3, nx)
        return Accepted(row[4 : 4 + n], Moving(float(row[0]), x, xd, xdd, row[4 + n + 3 * nx :]), row[1], row[2])

    def _last(self, k: int) -> list[Accepted]:
        """The last k steps; only those behind the last one that is not known."""
        recorded, found = self.c.recorded, []
        for i in range(recorded - 1, max(-1, recorded - 1 - min(k, len(self.records))), -1):
            if not self.records[i % len(self.records), 3]:
                break
            found.append(self._seen(i))
        return found[::-1]
