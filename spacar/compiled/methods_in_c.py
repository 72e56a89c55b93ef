"""The integrators whose steps are made in C (`compiled_stepper`): their arrays and coefficients as C has them.

Adams (code 0) and explicit Runge-Kutta (135, 155, 853). C works on the arrays of the objects of `spacar.integrators`.

Of Radau IIA C has the Newton iteration, with the factors of `spacar.integrators.radau.Radau`: guess, Jacobian, LU
factors, error estimate and messages are its own.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from spacar.arrays import Array
from spacar.compiled.interface import constants, structure
from spacar.compiled.library import Engine, address_of
from spacar.compiled.output_block import VALUE, BatchOutputBlock, OutputBlock
from spacar.integrators.adams import GAMMA_STAR, Adams
from spacar.integrators.radau import KAPPA, MAX_NEWTON, Radau
from spacar.integrators.runge_kutta import TINY, ExplicitRungeKutta
from spacar.kinematics.kinematics import LARGEST_JUMP

if TYPE_CHECKING:
    from spacar.compiled.compiled_model import CompiledModel, State
    from spacar.integrators.resolvent import DenseResolvent

ARRIVED, PAUSED, TOO_SMALL, NOT_EVALUATED, INTERRUPTED, NO_RATE = constants(
    "ARRIVED", "PAUSED", "TOO_SMALL", "NOT_EVALUATED", "INTERRUPTED", "NO_RATE"
)
GAMMA = np.array(GAMMA_STAR)
GAMMA_AT = address_of(GAMMA)


class AdamsInC:
    """Steps of code 0 with the arrays of its object, for a `TakeSteps` at an address. C makes the start too."""

    def __init__(self, engine: Engine, take_steps: int, method: Adams) -> None:
        self.engine, self.to, self.method, self.y = engine, take_steps, method, method.y
        self.c = structure("Adams")(address_of(method.memory), GAMMA_AT)
        self.at = ctypes.addressof(self.c)

    def begin(self) -> int:
        """0; 1 when F at the start could not be evaluated, 2 when all has to end."""
        return int(self.engine.adams_begin(self.to, self.at))

    def take_steps(self, output_block: OutputBlock | BatchOutputBlock | None) -> int:
        """Steps up to the next output, or through those of the block."""
        if output_block is None:
            return int(self.engine.adams(self.to, self.at))
        return int(self.engine.pass_adams(self.to, self.at, output_block.address))

    def taken(self, status: int) -> None:
        """After a call: what the object has to know of it."""
        if status == TOO_SMALL:
            np.multiply(self.method.d, self.method.weight, out=self.method.scaled)

    def value(self, t: float) -> Array:
        """y(t) in the last step."""
        found = np.empty_like(self.y)
        self.engine.adams_value(self.to, self.at, t, found.ctypes.data)
        return found


class RungeKuttaInC:
    """The same of codes 135, 155 and 853; states inside a step come from the object. `answered` lets a question of C be
    answered."""

    def __init__(
        self, engine: Engine, take_steps: ctypes.Structure, method: ExplicitRungeKutta, answered: Callable[..., int]
    ) -> None:
        m = method
        self.engine, self.of, self.method, self.y = engine, take_steps, method, m.y_new
        self.to, self.answered = ctypes.addressof(take_steps), answered
        c, a, errors, safety = m.coefficients()
        tableau = m.tableau
        self.kept = c, a, errors  # what C points at
        self.c = structure("RungeKutta")(
            c.ctypes.data, a.ctypes.data, tableau.b.ctypes.data, errors.ctypes.data, m.stages.ctypes.data,
            m.y.ctypes.data, m.y_new.ctypes.data, m.scaled.ctypes.data, *m.controller, safety, TINY, 0.0,
            len(tableau.c), len(c), errors.shape[1], len(errors) - 1,
        )  # fmt: skip
        self.at = ctypes.addressof(self.c)
        self.value = m.interpolate
        self.known: tuple[float, float] | None = None  # the step that the object knows of

    def begin(self) -> int:
        """Nothing is left to do: the object has been started."""
        return 0

    def take_steps(self, output_block: OutputBlock | BatchOutputBlock | None) -> int:
        """Steps up to the next output, or through those of the block."""
        if output_block is None:
            return int(self.engine.runge_kutta(self.to, self.at))
        call = VALUE(partial(self.answered, self._interpolated))
        output_block.c.value = address_of_call(call)
        status = int(self.engine.pass_runge_kutta(self.to, self.at, output_block.address))
        output_block.c.value = None
        return status

    def taken(self, status: int) -> None:
        """After a step: what the object has to know of it."""
        step = self.of.begin, self.of.t
        if step != self.known:
            self.known = step
            self.method.taken(self.of.begin, self.c.h)

    def _interpolated(self, t: float, y: int) -> None:
        """Answer C with the state inside the last step."""
        self.taken(ARRIVED)
        vector(y, len(self.y))[:] = self.method.interpolate(t)


def address_of_call(call: Any) -> int | None:
    """Of a function of Python that C calls (`ctypes.cast` would leave a circle of references behind)."""
    return ctypes.c_void_p.from_buffer(call).value


def vector(address: int, n: int) -> Array:
    """The n numbers that stand there."""
    return np.ctypeslib.as_array((ctypes.c_double * n).from_address(address))


class Iterating:
    """The iterations of one method object."""

    def __init__(self, model: CompiledModel, state: State, method: Radau) -> None:
        self.model, self.state, self.method = model, state, method
        m = method.method
        self.kept = tuple(v.copy(order="C") for v in (m.c, m.a, m.inverse, m.to, m.back))
        shared = {name: getattr(method, name).ctypes.data for name in ("y", "weight", "Z", "F", "change", "right")}
        self.c = structure("Newton")(
            *(v.ctypes.data for v in self.kept), **shared, jump=LARGEST_JUMP, kappa=KAPPA, s=len(m.c), n=method.n,
            nq=method.nq, most=MAX_NEWTON,
        )  # fmt: skip
        self.address = ctypes.addressof(self.c)
        self.factors: object = None

    def __call__(self) -> tuple[bool, float, float] | None:
        """Whether the stages of the step converged, size and contraction of the last change; None: Python has to ask
        for derivatives itself, from the guess on. Raises what a user function raised."""
        c, method = self.c, self.method
        if self.factors is not method.factors:
            self.factors = method.factors
            real, *pairs = cast("list[DenseResolvent]", method.factors)
            c.lu, c.pivots = real.lu.ctypes.data, real.pivots.ctypes.data
            c.pair_lu[: len(pairs)] = [of.lu.ctypes.data for of in pairs]
            c.pair_pivots[: len(pairs)] = [of.pivots.ctypes.data for of in pairs]
        evaluation = method.evaluation
        c.t, c.h, c.converged = method.t, method.h, evaluation.problem.within
        c.contraction = method.contraction
        c.earliest, c.latest = evaluation.first, evaluation.last
        c.iterations = c.n_rhs = 0
        status = self.model.engine.newton(self.model.handle, self.state.address, self.address)
        evaluation.statistics.n_rhs += c.n_rhs
        if status == NO_RATE:
            self.model.slots.interrupted()
            return None
        evaluation.statistics.newton_iterations += c.iterations
        method.contraction = c.contraction
        return status == 0, c.size, c.theta
