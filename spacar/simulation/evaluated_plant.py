"""Where the mechanism of a simulation is for a state and inputs: by NumPy, or by the compiled engine.

A simulation asks for positions and rates first, from which controllers make the inputs, and then for the accelerations.
Inputs are stresses and forces that are added to those of the model. Values are read by rows of one vector, in which
`first` finds those of elements (ne,) and of coordinates (nx,).
"""

from dataclasses import replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from spacar.arrays import Array, Index
from spacar.dynamics.array_evaluator import Dynamics
from spacar.frame import Frame
from spacar.mechanism.mechanism import Mechanism, UserForces

POSITION, RATE, ACCELERATION = range(3)


class Driven(NamedTuple):
    """Rows (n,) of deformations or coordinates that inputs drive, and what each input gives them, (n, inputs)."""

    rows: Index
    by: Array


class ArrayPlant:
    """By NumPy. Order of the calls: `start`, then `place` for each state and `accelerate` for each of its inputs."""

    def __init__(self, mechanism: Mechanism, stresses: Driven, forces: Driven) -> None:
        self.n = n = mechanism.numbering
        self.sigma, self.force = np.zeros(n.ne), np.zeros(n.nx)
        self._zero = np.zeros(n.ne), np.zeros(n.nx)
        self.mechanism, self.stresses, self.forces = mechanism, stresses, forces
        self._values = np.zeros(3 * (n.nx + n.ne))

    @cached_property
    def dynamics(self) -> Dynamics:
        return Dynamics(replace(self.mechanism, user_signal=self._user))

    def _user(self, t: float, e: Array, ed: Array, x: Array, xd: Array) -> UserForces:
        """The inputs, added to what a user function of the file gives."""
        ze, zx = self._zero
        if self.mechanism.user_signal is None:
            return UserForces(self.sigma.copy(), self.force.copy(), ze, ze, zx, zx)
        found = self.mechanism.user_signal(t, e, ed, x, xd)
        return replace(found, sigma=found.sigma + self.sigma, force=found.force + self.force)

    def start(self) -> Array:
        """Start state, at the start position."""
        return self.dynamics.start()

    @property
    def doubt(self) -> str | None:
        """As of an `Evaluator`, after `start`."""
        return self.dynamics.doubt

    def push(self, u: Array) -> None:
        """Set the inputs."""
        self.sigma[self.stresses.rows] = self.stresses.by @ u
        self.force[self.forces.rows] = self.forces.by @ u

    def place(self, t: float, y: Array) -> None:
        self._t, self._drive = t, self.dynamics.place(t, y)
        d, nx, ne = self.dynamics, self.n.nx, self.n.ne
        self._values[: 2 * nx] = np.concatenate((d.kinematics.x, d.xd))
        self._values[3 * nx : 3 * nx + 2 * ne] = np.concatenate((d.sweep.e, d.sweep.rate(d.xd)))

    def accelerate(self) -> None:
        xdd, _, convective = self.dynamics.accelerate(self._t, self._drive)
        nx, ne = self.n.nx, self.n.ne
        self._values[2 * nx : 3 * nx] = xdd
        self._values[3 * nx + 2 * ne :] = self.dynamics.sweep.rate(xdd) + convective

    def forget(self) -> None:
        """Neither what has been evaluated nor the inputs are there any more."""

    def first(self, quantity: int, of_elements: bool) -> int:
        """Row of the first position, rate or acceleration."""
        return 3 * self.n.nx + quantity * self.n.ne if of_elements else quantity * self.n.nx

    def read(self, rows: Index) -> Array:
        """Values (rows,): positions and rates after `place`, accelerations after `accelerate`."""
        return self._values[rows]

    def frame(self, t: float, y: Array) -> Frame:
        """The whole state, as mode 1 gives it."""
        return self.dynamics.frame(t, y)


class CompiledPlant(ArrayPlant):
    """In C, for mechanisms in which `why_general` finds no obstacle. A state that C cannot do is left to NumPy, which
    explains failures.

    One evaluation gives everything. `place` makes it with the inputs of the last `push`; if the next inputs are the
    same, as between the samples of a controller, `accelerate` does not make it again. `whole`: rates and accelerations
    of other deformations than the degrees of freedom are read, which takes twice as long.
    """

    def __init__(self, mechanism: Mechanism, stresses: Driven, forces: Driven, whole: bool) -> None:
        from spacar.compiled import CompiledDynamics

        super().__init__(mechanism, stresses, forces)
        self.evaluator, self.whole = CompiledDynamics(mechanism), whole
        self._values = self.evaluator.state.together
        self._known = False
        self._pushed: bytes | None = None  # the inputs that C has

    def start(self) -> Array:
        self._known = False
        return self.evaluator.start()

    @property
    def doubt(self) -> str | None:
        return self.evaluator.doubt

    def push(self, u: Array) -> None:
        if self._known and u.tobytes() == self._pushed:
            return
        self._known, self._pushed = False, u.tobytes()
        super().push(u)
        self.evaluator.push(self.sigma, self.force)

    def place(self, t: float, y: Array) -> None:
        self._at = t, y.copy()
        self._evaluate()

    def accelerate(self) -> None:
        if not self._known:
            self._evaluate()

    def _evaluate(self) -> None:
        if not self.evaluator.reach(*self._at, self.whole):
            self._explain()
        self._known = True

    def _explain(self) -> None:
        """By NumPy, with its values where those of C are read."""
        in_c, nx = self._values, self.n.nx
        self._values = np.zeros(3 * (nx + self.n.ne))
        self.dynamics.stand(self.evaluator.placement())
        try:
            super().place(*self._at)
            super().accelerate()
            self.evaluator.stand(self.dynamics.placement())
            in_c[: 3 * nx] = self._values[: 3 * nx]
            in_c[6 * nx : 6 * nx + 3 * self.n.ne] = self._values[3 * nx :]
        finally:
            self._values = in_c

    def forget(self) -> None:
        self._known, self._pushed = False, None

    def first(self, quantity: int, of_elements: bool) -> int:
        return 6 * self.n.nx + quantity * self.n.ne if of_elements else quantity * self.n.nx

    def frame(self, t: float, y: Array) -> Frame:
        self._known = False
        if self.evaluator.reach(t, y, True):
            return self.evaluator.frame(t, y)
        self.dynamics.stand(self.evaluator.placement())
        found = super().frame(t, y)
        self.evaluator.stand(self.dynamics.placement())
        return found
