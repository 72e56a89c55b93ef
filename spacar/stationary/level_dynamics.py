"""The evaluator of NumPy at load levels. Its elements and matrices are made when something asks for them.

Where states are found in C (`spacar.stationary.equilibrium`) an ordinary run asks for none of them: what is to be
evaluated waits until then.
"""

from __future__ import annotations

from spacar.arrays import Array
from spacar.dynamics.array_evaluator import Dynamics
from spacar.kinematics.element_sweep import SweepArrays
from spacar.kinematics.kinematics import Kinematics
from spacar.mechanism.mechanism import Drive, Loads, Mechanism


class LevelDynamics(Dynamics):
    """The evaluator of one mechanism, which goes from state to state of load levels.

    arrays  what its elements share with equations in C
    y       state vector: the kinematic values, and the rates that are kept
    """

    def __init__(self, mechanism: Mechanism, loads: Loads, drive: Drive) -> None:
        super().__init__(mechanism, loads=loads, drive=drive)
        self.arrays: SweepArrays | None = None
        self._at: tuple[Array, bool] | None = None  # x, and is it a solution?
        self._is_made = False
        self.y = self.start_values()

    def evaluate(self, x: Array) -> None:
        """The elements at x (nx,)."""
        self._go(x, False)

    def stand_at(self, x: Array) -> None:
        """At the solution x (nx,) of the level, where the prescribed deformations are as they are given."""
        self._go(x, True)

    def prescribed(self) -> tuple[Array, Array]:
        """x (nx,), e (ne,) with the values that are prescribed, and the kinematic ones of the start."""
        x, e = self.given(self.drive.at(0.0), self.y)
        e[self.es["dynamic"]] = 0.0
        return x, e

    def _go(self, x: Array, solution: bool) -> None:
        self._at = x, solution
        if self._is_made:
            self._bring(self.kinematics)

    def _made(self, arrays: SweepArrays | None = None) -> Kinematics:
        found = super()._made(arrays or self.arrays)
        self._is_made = True
        if self._at is not None:
            self._bring(found)
        return found

    def _bring(self, k: Kinematics) -> None:
        assert self._at is not None
        x, solution = self._at
        sweep, n = k.sweep, self.numbering
        sweep.strain(x)
        if not solution:
            return
        sweep.mass()
        given = ~n.slips
        given[self.es["input"].stop :] = False
        sweep.e[given] = self.prescribed()[1][given]  # exact, while S times the rounding of e is not small
        k.stand_at(x, sweep.e)
        if not n.nddof:
            k.factor_waiting()  # for the prediction of the next position
