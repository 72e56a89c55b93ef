"""The evaluator in C: right-hand sides, stages and frames are evaluated by the compiled solver.

It has a NumPy evaluator, `general`, for what C cannot do: a start that is far away, states that fail (and are
explained), and everything that needs element sweeps. It is made when it is asked for: most runs end without. Nothing is
shared between both: a `Placement` goes from the state in C to the general evaluator (`numpy_evaluator`), or back
(`stand`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from copy import copy
from functools import cached_property
from math import log
from typing import TypeVar

import numpy as np

from spacar.arrays import Array, Index
from spacar.compiled.compiled_elements import with_compiled_elements
from spacar.compiled.compiled_model import DOUBTFUL_MASS, EXACT, FAR_AWAY, CompiledModel, State
from spacar.compiled.compiled_stepper import CompiledStepper, StepMonitor
from spacar.compiled.library import address_of
from spacar.compiled.methods_in_c import Iterating
from spacar.compiled.numbers import of_one
from spacar.compiled.output_block import OutputBlock
from spacar.dynamics.array_evaluator import Dynamics, component_name
from spacar.dynamics.loaded_mechanism import LoadedMechanism, Moving, Placement
from spacar.dynamics.mass_check import is_checked
from spacar.frame import Frame
from spacar.integrators.radau import Radau
from spacar.kinematics.constraint_condition import of_entries
from spacar.kinematics.kinematics import CONVERGED, LARGEST_JUMP
from spacar.kinematics.regularity import PositionMatrix
from spacar.linear_systems import DENSE_LIMIT
from spacar.mechanism.mechanism import Drive, Loads, Mechanism

Result = TypeVar("Result")


SMALL = 64  # equations up to which the exact condition in C is cheaper than an estimate in the general path


class CompiledPositionMatrix(PositionMatrix):
    """V[E, U] as it is factored in C; that of the general path after a state that C could not do."""

    def __init__(self, evaluator: CompiledDynamics) -> None:
        mechanism = evaluator.model.mechanism
        n = mechanism.numbering.e_class["dynamic"].stop
        super().__init__(mechanism, lambda: evaluator.general.kinematics, n <= DENSE_LIMIT)
        self.evaluator = evaluator

    def determinant(self) -> tuple[float, float]:
        if not self.evaluator.state.c.known:
            return super().determinant()
        sign, size = self.evaluator.solver.determinant()
        return float(sign[0]), float(size[0])

    def regular_everywhere(self) -> bool:
        return self.evaluator.solver.rcond_everywhere() > self.zero

    def rcond(self) -> float:
        return self._more_than(float("inf")) or super().rcond()

    def surely_regular(self) -> bool:
        return self._more_than(self.zero) > self.zero or super().surely_regular()

    def _more_than(self, enough: float) -> float:
        """The reciprocal condition from C, or a bound that is `enough`; 0 where it is unknown or below `zero`, and the
        general path has to look."""
        if self.evaluator.state.c.known:
            rcond = self.evaluator.solver.rcond(enough, SMALL)
            if rcond > self.zero:
                return rcond
            self.evaluator.numpy_evaluator()
        return 0.0


class General:
    """The NumPy evaluator of a model, with elements in C, made when it is asked for; `sampling`: whether it keeps
    samples then."""

    def __init__(self, model: LoadedMechanism) -> None:
        self.model, self.sampling = model, False

    @cached_property
    def evaluator(self) -> Dynamics:
        mechanism = with_compiled_elements(self.model.mechanism)
        made = Dynamics(mechanism, loads=self.model.loads, drive=self.model.drive)
        if self.sampling:
            made.sample()
        return made

    @property
    def known(self) -> Dynamics | None:
        """The evaluator, if somebody has asked for it."""
        made: Dynamics | None = vars(self).get("evaluator")
        return made


class CompiledDynamics:
    """An `Evaluator` (`spacar.dynamics.evaluator`) where `why_general` finds no reason for that of NumPy."""

    by_case = None
    largest_exact = SMALL  # equations up to which C tells the exact condition of outputs

    def __init__(self, mechanism: Mechanism, *, loads: Loads | None = None, drive: Drive | None = None) -> None:
        self.model = model = LoadedMechanism.of(mechanism, loads, drive)
        self.numbering = n = mechanism.numbering
        self.n_positions = n.nkddof
        self._general = General(model)
        if not n.is_square:
            self.general.numpy_evaluator()  # raises
        scales = mechanism.scale, mechanism.deformation_scale
        users = () if mechanism.user_signal is None else (mechanism.user_signal,)
        self.solver = CompiledModel(n, of_one(model), scales, (model.drive,), users)
        self.state = State(self.solver)
        self._y, self._out = shared = np.zeros((2, self.n_positions + n.nddof))
        first = address_of(shared)
        self._addresses = first, first + shared.nbytes // 2
        self.iterations = 0
        self._iterating: Iterating | None = None
        self._step_of: tuple[Array, Array, Array, tuple[int, ...]] | None = None

    @property
    def general(self) -> Dynamics:
        """The NumPy evaluator; that of companions is the same."""
        return self._general.evaluator

    @property
    def doubt(self) -> str | None:
        return None if self._general.known is None else self._general.known.doubt

    @property
    def blocks(self) -> CompiledDynamics:
        return self

    # -- where it stands ------------------------------------------------------------------------------------------
    def start(self) -> Array:
        """Start state. One that is near the reference configuration is placed in C; else the general path goes there.

        Near is what a guess of Newton's method may be away.
        """
        given, x0 = self.model.mechanism.start, self.model.mechanism.x0
        y = given.state(given.e_kinematic) if given.is_complete else self.general.start_values()
        self.stand(Placement(x0, np.zeros_like(x0), np.zeros(self.numbering.ne)))
        if self.solver.slots.foreign:
            self.general.sweep.strain(x0)
            self.state.e[:, 0] = self.general.sweep.e
        self._y[:] = y
        checked = is_checked(self.numbering)
        status = self.solver.start(self.state, *self._addresses, checked)
        if status < 0 or status == FAR_AWAY:
            y = self.general.start()
            self.stand(self.general.placement())
        elif self.numbering.nddof and (not checked or status == DOUBTFUL_MASS):
            self.numpy_evaluator().check_mass()  # a large model is asked by the factors of its equations
        return y

    def placement(self) -> Placement:
        s = self.state
        return Placement(s.x[:, 0], s.xd[:, 0], s.e[:, 0])

    def moving(self) -> Moving | None:
        s = self.state
        if not s.c.known:  # what C could not do the general evaluator has done
            general = self._general.known
            same = general is not None and np.array_equal(general.kinematics.x, s.x[:, 0])
            return self.general.moving() if same else None
        x, xd, xdd = s.of_x[:3, :, 0].copy()
        return Moving(float(s.c.t), x, xd, xdd, s.e[:, 0].copy())

    def resume(self, at: Moving) -> None:
        self.state.resume(at)

    def stand(self, at: Placement) -> None:
        """Go on from there, without the memory of earlier states."""
        s = self.state
        s.begin(at.x[:, None], at.e[:, None])
        s.xd[:, 0] = at.xd

    def numpy_evaluator(self) -> Dynamics:
        self.general.stand(self.placement())
        self.general.kinematics.refresh()
        return self.general

    def fork(self, independent: bool = False) -> CompiledDynamics:
        """Another state of the same model; `independent`: with a general evaluator of its own."""
        if independent:
            model = self.model
            other = type(self)(model.mechanism, loads=model.loads, drive=model.drive)
            other.stand(self.placement())
        else:
            other = copy(self)
            other.state, other._iterating = State(self.solver), None
            other.state.follow(self.state)
        return other

    def sample(self) -> None:
        self.state.c.watched = 1
        self._general.sampling = True
        if self._general.known is not None:
            self.general.sample()
        self.sampled()

    def sampled(self) -> tuple[float, bool]:
        c, general = self.state.c, self._general.known
        low, changed = (float("inf"), False) if general is None else general.sampled()
        if c.signs:
            low = min(low, -(log(c.mantissa) + log(2.0) * c.exponent))
        changed = changed or c.signs == 3
        c.signs, c.mantissa, c.exponent = 0, 0.0, 0.0
        return low, changed

    def _in_general(self, evaluate: Callable[[], Result]) -> Result:
        """Let the general evaluator look at a state that C could not do; it explains failures."""
        self.general.stand(self.placement())
        result = evaluate()
        self.stand(self.general.placement())
        return result

    # -- inputs of a simulation -----------------------------------------------------------------------------------
    def reach(self, t: float, y: Array, whole: bool) -> bool:
        """Whether C could evaluate the state; then x, e and their derivatives are in `state`, and everything else when
        `whole`: of e only the derivatives of degrees of freedom are there without it."""
        if whole:
            self._y[:] = y
            return self.solver.evaluate(self.state, t, self._addresses[0], CONVERGED) >= 0
        s, part = self.state, self.numbering.e_class["dynamic"]
        if self._derivative(t, y, CONVERGED) < 0:
            return False
        if n := part.stop - part.start:
            s.ed[part, 0], s.edd[part, 0] = self._y[-n:], self._out[-n:]
        return True

    # -- checks ---------------------------------------------------------------------------------------------------
    def condition(self) -> float:
        if self.numbering.e_class["dynamic"].stop > SMALL or not self.state.c.known:
            return self.numpy_evaluator().condition()
        rows, columns, values = self.solver.gradient()
        return of_entries(self.model.mechanism, (rows, columns, values[:, 0]))

    def position_matrix(self) -> PositionMatrix:
        return CompiledPositionMatrix(self)

    def in_range(self) -> bool:
        return self.solver.in_range(self.state)

    def component_name(self, i: int) -> str:
        return component_name(self.numbering, i)

    def stepper(self, monitor: StepMonitor, output_block: OutputBlock | None = None) -> CompiledStepper:
        """Steps from output to output, or through those of an output block, inspected by `monitor`."""
        return CompiledStepper(self, monitor, output_block)

    def output_block(self, times: Sequence[float] | Array, ground: Index, singular: float, far: int = 0) -> OutputBlock:
        """Outputs at `times`, evaluated here many at a time; arguments as `OutputBlock`."""
        return OutputBlock(self, times, ground, singular, far)

    # -- evaluation -----------------------------------------------------------------------------------------------
    def _derivative(self, t: float, y: Array, within: float) -> int:
        """Time derivative of y into `_out`; a negative number when C cannot."""
        self._y[:] = y
        return self.solver.rhs(self.state, t, *self._addresses, within)

    def rhs(self, t: float, y: Array, within: float = CONVERGED) -> Array:
        if self._derivative(t, y, within) < 0:
            return self._in_general(lambda: self.general.rhs(t, y, within))
        return self._out.copy()

    def stages(
        self, done: int, c: Array, a: Array, t: float, h: float, window: tuple[float, float], y: Array, K: Array,
        within: float = CONVERGED,
    ) -> int:  # fmt: skip
        """Stages of an explicit Runge-Kutta step, see `spacar.integrators.problem.BlockEvaluator`."""
        kept = self._step_of  # an integrator keeps its arrays
        if kept is None or kept[0] is not c or kept[1] is not y or kept[2] is not K:
            kept = self._step_of = c, y, K, (c.ctypes.data, a.ctypes.data, y.ctypes.data, K.ctypes.data)
        (at_c, at_a, at_y, at_K), m = kept[3], self.solver
        reached = int(m.engine.stages(
            m.handle, self.state.address, done, len(c), at_c, at_a, t, h, *window, at_y, at_K, len(y), within,
            LARGEST_JUMP,
        ))  # fmt: skip
        if reached < len(c):
            m.slots.interrupted()
        return reached

    def newton(self, method: Radau) -> tuple[bool, float, float] | None:
        """Newton iteration of a step of codes 553 and 595, see `spacar.integrators.problem.BlockEvaluator`."""
        if self._iterating is None or self._iterating.method is not method:
            self._iterating = Iterating(self.solver, self.state, method)
        return self._iterating()

    def frame_in_general(self, t: float, y: Array) -> Frame:
        """That of a state that C could not do."""
        frame = self._in_general(lambda: self.general.frame(t, y))
        self.iterations = self.general.iterations
        return frame

    def frame(self, t: float, y: Array) -> Frame:
        m, s = self.solver, self.state
        self._y[:] = y
        self.iterations = m.evaluate(s, t, self._addresses[0], EXACT)
        if self.iterations < 0:
            return self.frame_in_general(t, y)
        (x, xd, xdd, applied, gravity, total), (e, ed, edd, sigma) = s.of_one()
        return Frame(
            t=t, x=x, xd=xd, xdd=xdd, e=e, ed=ed, edd=edd, sig=sigma, fx=applied, fxgrav=gravity, fxtot=total,
            lost=m.slots.lost[0],
        )  # fmt: skip
