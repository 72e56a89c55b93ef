"""Several cases of one mechanism in C, as the driver integrates them: as many as a vector of the processor has lanes
(2, 4 or 8). One model serves block after block of them, where Python has nothing to answer.

The state has all components, each with its lanes, (components, lanes). The cases share the steps, each of which has the
largest error of a case; codes 0, 135, 155 and 853 make them in C from output to output, without Python.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from spacar.arrays import Array
from spacar.compiled.compiled_model import DOUBTFUL_MASS, FAR_AWAY, CompiledModel, State
from spacar.compiled.compiled_stepper import CompiledStepper, StepMonitor
from spacar.compiled.library import lanes_of_processor
from spacar.compiled.numbers import Numbers
from spacar.compiled.output_block import BatchOutputBlock, not_followed
from spacar.dynamics.limits import Wheels
from spacar.dynamics.loaded_mechanism import Entries, LoadedMechanism, Moving, unexplained
from spacar.dynamics.mass_check import is_checked, is_doubtful
from spacar.kinematics.kinematics import CONVERGED, FARTHEST_GUESS
from spacar.kinematics.regularity import HALF_TURN, HalfTurns
from spacar.mechanism.mechanism import Drive, UserSignal


@dataclass(frozen=True)
class PlacedStart:
    """Start state y of a case, where it was placed: x (nx,), e (ne,); its `largest_mass`, kg m^2."""

    y: Array
    x: Array
    e: Array
    largest: float


class InLanes(StepMonitor):
    """One block of cases; a `RightHandSide`, and the `StepMonitor` of its own steps: C looks at them.

    numbers, start (cases, components)   of every lane
    drives, users                        of every case: prescribed motions, user functions of stresses
    """

    blocks = None  # but for the steps, which `stepper` makes

    def __init__(
        self, model: LoadedMechanism, scale: Array, numbers: Numbers, start: Array, drives: Sequence[Drive] = (),
        users: Sequence[UserSignal] = (),
    ) -> None:  # fmt: skip
        mechanism = model.mechanism
        self.model, self.numbering = model, mechanism.numbering
        lanes, size = start.shape
        self.n_positions, self.by_case = self.numbering.nkddof, (1, size, lanes)
        scales = scale, mechanism.deformation_scale
        self.solver = CompiledModel(self.numbering, numbers, scales, drives, users)
        self.breaks = tuple(t for law in (*drives, *users) for t in getattr(law, "breaks", ()))
        self.state, self.shown = State(self.solver), State(self.solver)
        self.y0 = np.ascontiguousarray(start.T).ravel()
        self.lambda0 = HalfTurns(self.numbering).lambda0
        self._scale = scale[:, None]
        self._seen: tuple[Moving, Array] | None = None  # last accepted state, signs of the determinants
        self._accepted: tuple[Array, Array] | None = None  # its x and e
        self._out = np.zeros_like(self.y0)
        self.output_block = BatchOutputBlock(self.solver, self.state, self.shown, size * lanes)

    def renew(self, values: Array, start: Array) -> None:
        """Other cases: see `CompiledModel.renew`. Not with functions of their own."""
        self.solver.renew(values, self.state, self.shown)
        self.y0.reshape(start.shape[::-1])[:] = start.T
        self._seen = self._accepted = None
        self.n = 0

    @property
    def failed(self) -> int | None:
        """The case whose user function did not answer when it was asked last."""
        return self.solver.slots.failed

    def lost(self, case: int) -> dict[int, str]:
        """Sentences about stresses of the user function that could not act at an output, by row of e."""
        found = self.solver.slots.first_lost
        return found[case] if case < len(found) else {}

    def rhs(self, t: float, y: Array, within: float = CONVERGED) -> Array:
        """Time derivative of the state. Raises AnalysisError when a case cannot be evaluated."""
        where, out = y.ctypes.data, self._out.ctypes.data
        if self.solver.rhs(self.state, t, where, out, within) < 0:
            # a stage of a step that is too long may have led far away: once more from the last accepted state
            self.state.begin(*(self._accepted or (self.solver.x0, np.zeros_like(self.state.e))))
            if self.solver.rhs(self.state, t, where, out, within) < 0:
                raise not_followed(t)
        return self._out.copy()

    def start(self, find_placed: Callable[[], PlacedStart]) -> bool:
        """Place the start state. Are the mass matrices regular? Where C leaves a doubt they are to be looked at alone.

        A start that is far from the reference configuration is reached over that of one of the cases, which is asked
        for then; its `largest_mass` is for the size of all and refuses and accepts nothing.
        Raises AnalysisError where the start of a case cannot be reached from there, and where e of one case tells no
        other one its branch (belts).
        """
        out, y0, checked = self._out.ctypes.data, self.y0.ctypes.data, is_checked(self.numbering)
        status = self.solver.start(self.state, y0, out, checked)
        if status >= 0 and status != FAR_AWAY:
            return checked and status != DOUBTFUL_MASS
        if any(batch.family.has_own_branch for batch in self.model.mechanism.batches):
            raise not_followed(0.0)
        state, mechanism, placed = self.state, self.model.mechanism, find_placed()
        there = self.solver.x0 + (placed.x - mechanism.x0)[:, None]
        state.begin(there, placed.e[:, None])
        y = np.repeat(placed.y, self.by_case[2])
        if self.solver.rhs(state, 0.0, y.ctypes.data, out, CONVERGED) < 0:
            raise not_followed(0.0)
        if (np.abs(state.x - there) / self._scale).max() > FARTHEST_GUESS:
            raise not_followed(0.0)
        self.rhs(0.0, self.y0)
        self.shown.resume(state.moving())
        M, rcond = self.solver.reduced_mass() if checked else None, self.solver.rcond()
        condition = 1.0 / rcond if rcond > 0.0 else float("inf")
        return M is not None and not any(
            is_doubtful(mechanism, M[:, :, lane], condition, placed.largest) for lane in range(self.by_case[2])
        )

    def component_name(self, i: int) -> str:
        """Name of a component of the state, for messages."""
        component, lane = divmod(i, self.by_case[2])
        return f"component {component} of case {lane + 1} of the block"

    # -- steps in C -----------------------------------------------------------------------------------------------
    def stepper(self) -> CompiledStepper:
        """Steps through all outputs, each of which is evaluated; of one block after the other."""
        return CompiledStepper(self, self, self.output_block)

    # -- steps in Python: other codes -----------------------------------------------------------------------------
    def accepted(self, t: float, y: Array) -> None:
        """Raises AnalysisError where a case comes to a dead point or half a turn, or its velocities jump (see
        `spacar.forward.continuity`): it has to be followed alone."""
        state = self.state
        if (np.abs(state.x[self.lambda0]) < HALF_TURN).any():
            raise not_followed(t)
        sign = self.solver.determinant()[0].copy()
        now = state.moving()
        seen, self._seen = self._seen, (now, sign)
        if seen is not None and ((seen[1] != sign).any() or unexplained(seen[0], now, self._scale).any()):
            raise not_followed(t)
        self._accepted = now.x, now.e

    def rejected(self) -> None:
        """Back to the last accepted step."""
        if self._seen is not None:
            self.state.resume(self._seen[0])

    # -- outputs --------------------------------------------------------------------------------------------------
    def wheels_lifted(self, times: Array, rows: Array, stiffness: Entries) -> list[dict[int, str]]:
        """Warnings of every lane, by wheel, after all outputs; rows as for `output_block`, `stiffness` of the lanes."""
        lanes = self.by_case[2]
        said: list[dict[int, str]] = [{} for _ in range(lanes)]
        wheels = Wheels(self.model, lanes, stiffness)
        if len(wheels.rows):
            nx, ne = self.numbering.nx, self.numbering.ne
            forces, stresses = rows[:, 5 * nx : 6 * nx], rows[:, 6 * nx + 3 * ne : 6 * nx + 4 * ne]
            for t, force, stress in zip(times.tolist(), forces, stresses, strict=True):
                for lane, wheel, text in wheels.lifted(t, force, stress):
                    said[lane].setdefault(wheel, f"warning: {text}")
        return said


def blocks(cases: int) -> Iterator[Sequence[int]]:
    """Cases of every block; the last one is filled up with its last case."""
    lanes = lanes_of_processor()
    for first in range(0, cases, lanes):
        yield [min(k, cases - 1) for k in range(first, first + lanes)]
