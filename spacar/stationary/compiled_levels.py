"""The evaluator of load levels in C, and which of the two a mechanism has."""

from __future__ import annotations

from spacar.arrays import Array
from spacar.mechanism.mechanism import Mechanism
from spacar.stationary.equilibrium import Equilibrium, NotCompiled, takes
from spacar.stationary.level_dynamics import LevelDynamics
from spacar.stationary.level_evaluator import LevelEvaluator
from spacar.stationary.loading import LoadLevel
from spacar.stationary.newton import Converged, Demand
from spacar.stationary.stability import CRITICAL, STABLE, Stability
from spacar.stationary.stationary_equations import Iterate


def level_evaluator(mechanism: Mechanism) -> LevelEvaluator:
    """In C where the mechanism has compiled elements and C has all that acts on it."""
    if takes(mechanism):
        try:
            return CompiledLevelEvaluator(mechanism)
        except NotCompiled:
            pass
    return LevelEvaluator(mechanism)


class CompiledLevelEvaluator(LevelEvaluator):
    """Iterations and proofs of stability are those of `equilibrium`; what it leaves is done over in NumPy.

    What NumPy needs of loads and elements is made, or put in place, when something asks for `dynamics`, `equations` or
    `tangent`; the elements share deformations and V with C. Raises NotCompiled where something moves.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        super().__init__(mechanism)
        if not self.plain:
            raise NotCompiled
        self.equilibrium = Equilibrium(mechanism)
        self._dynamics.arrays = self.equilibrium.arrays
        self._at: Array | None = None  # where the sweep has to be
        self._factored_in_c = False

    def load(self, level: LoadLevel) -> None:
        self._level, self._given = level, None
        self.equilibrium.load(self._acting(level), self.fading_force, self._held(level))

    def _settle(self) -> None:
        super()._settle()
        if self._at is not None:
            x, self._at = self._at, None
            self._dynamics.evaluate(x)

    @property
    def e(self) -> Array:
        return self.equilibrium.arrays.e

    @property
    def branch(self) -> Array:
        return self.equilibrium.arrays.branch

    def stand_at(self, x: Array) -> LevelDynamics:
        self._at = None
        return super().stand_at(x)

    def newton(self, x: Array, sigma: Array, demand: Demand) -> Converged:
        self._at = x
        found = self.equilibrium.newton(x, sigma, demand)
        self._factored_in_c = found is not None
        if found is None:
            return super().newton(x, sigma, demand)
        self._at = found.point.x
        return found

    def point(self, x: Array, sigma: Array) -> Iterate:
        self._at = x
        return self.equilibrium.point(x, sigma)

    def set_state(self, p: Iterate) -> None:
        self._at = p.x
        self._factored_in_c = self.equilibrium.sign(p) is not None
        if not self._factored_in_c:
            super().set_state(p)

    def stability(self, p: Iterate, noise: float, regular: bool, before: Stability | None) -> Stability | None:
        c = self.equilibrium
        hopeful = noise <= CRITICAL and (before is None or before.negative == 0) and self.mechanism.numbering.nddof
        if hopeful and c.is_definite(p) and (regular or c.sign(p) is not None):
            return STABLE
        return super().stability(p, noise, regular, before)

    def sign(self, p: Iterate, factored: bool) -> float:
        if factored and self._factored_in_c:
            return self.equilibrium.last_sign()
        sign = None if factored else self.equilibrium.sign(p)
        return super().sign(p, factored) if sign is None else sign
