"""Where the mechanism of a simulation is for a state and inputs: by NumPy, or by the compiled engine.

A simulation asks for positions and rates first, from which controllers make the inputs, and then for the accelerations.
Inputs are stresses and forces that are added to those of the model, (ne,) and (nx,).
"""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property

import numpy as np

from spacar.arrays import Array
from spacar.dynamics.array_evaluator import Dynamics
from spacar.frame import Frame
from spacar.mechanism.mechanism import Mechanism, UserForces

Pair = tuple[Array, Array]  # of deformations (ne,), of coordinates (nx,)


class ArrayPlant:
    """By NumPy. Order of the calls: `start`, then `place` for each state and `accelerate` for each of its inputs."""

    def __init__(self, mechanism: Mechanism) -> None:
        n = mechanism.numbering
        self.sigma, self.force = np.zeros(n.ne), np.zeros(n.nx)
        self._zero = np.zeros(n.ne), np.zeros(n.nx)
        self.mechanism = mechanism

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

    def push(self, sigma: Array, force: Array) -> None:
        """Set the inputs."""
        self.sigma, self.force = sigma, force

    def place(self, t: float, y: Array) -> None:
        self._t, self._drive = t, self.dynamics.place(t, y)

    def accelerate(self) -> None:
        self._found = self.dynamics.accelerate(self._t, self._drive)

    def positions(self) -> Pair:
        return self.dynamics.sweep.e, self.dynamics.kinematics.x

    def rates(self) -> Pair:
        return self.dynamics.sweep.rate(self.dynamics.xd), self.dynamics.xd

    def accelerations(self) -> Pair:
        xdd, _, convective = self._found
        return self.dynamics.sweep.rate(xdd) + convective, xdd

    def frame(self, t: float, y: Array) -> Frame:
        """The whole state, as mode 1 gives it."""
        return self.dynamics.frame(t, y)


class CompiledPlant(ArrayPlant):
    """In C, for mechanisms in which `why_general` finds no obstacle. A state that C cannot do is left to NumPy, which
    explains failures.

    One evaluation gives everything. `place` makes it with the inputs of the last `push`; if the next inputs are the
    same, as between the samples of a controller, `accelerate` does not make it again. Positions and rates stay those of
    `place` to the last bit: they do not depend on inputs, and the search for algebraic loops compares them.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        from spacar.compiled import CompiledDynamics

        super().__init__(mechanism)
        self.evaluator = CompiledDynamics(mechanism)
        self._explained = self._known = False

    def start(self) -> Array:
        self._explained = self._known = False
        return self.evaluator.start()

    @property
    def doubt(self) -> str | None:
        return self.evaluator.doubt

    def push(self, sigma: Array, force: Array) -> None:
        if self._known and np.array_equal(sigma, self.sigma) and np.array_equal(force, self.force):
            return
        self._known = False
        super().push(sigma, force)
        self.evaluator.push(sigma, force)

    def place(self, t: float, y: Array) -> None:
        self._at = t, y.copy()
        self._evaluate()
        s = self.evaluator.state
        positions = super().positions() if self._explained else (s.e[:, 0], s.x[:, 0])
        rates = super().rates() if self._explained else (s.ed[:, 0], s.xd[:, 0])
        self._placed = [(of_e.copy(), of_x.copy()) for of_e, of_x in (positions, rates)]

    def accelerate(self) -> None:
        if not self._known:
            self._evaluate()

    def _evaluate(self) -> None:
        self._explained = not self.evaluator.reach(*self._at)
        if self._explained:
            self.dynamics.stand(self.evaluator.placement())
            super().place(*self._at)
            super().accelerate()
            self.evaluator.stand(self.dynamics.placement())
        self._known = True

    def positions(self) -> Pair:
        return self._placed[0]

    def rates(self) -> Pair:
        return self._placed[1]

    def accelerations(self) -> Pair:
        s = self.evaluator.state
        return super().accelerations() if self._explained else (s.edd[:, 0], s.xdd[:, 0])

    def frame(self, t: float, y: Array) -> Frame:
        self.place(t, y)
        return super().frame(t, y) if self._explained else self.evaluator.frame(t, y)
