"""A mechanism that advances from one communication point to the next with inputs that stay in between (co-simulation).

The master sets the inputs, asks for a step from t to t + h, and reads the outputs: FMI 2.0, section 4.2.1. Inside a
step the states follow a one-step code with error control; the inputs are held, so a step is exact to the tolerances for
the held inputs, and the coupling itself of first order in h.
"""

from dataclasses import dataclass

import numpy as np

from spacar.arrays import Array
from spacar.errors import UsageError
from spacar.integrators import Problem, Tolerance, named, steps
from spacar.simulation.plant import Spasim


@dataclass
class _Held(Problem):
    """The equations of motion under held inputs, as the integrators see them."""

    plant: Spasim
    u: Array
    n_positions: int = 0

    def rhs(self, t: float, x: Array) -> Array:
        return self.plant.derivative(t, x, self.u)


class CoSimulation:
    """State, inputs and outputs of a mechanism between communication points.

    t [s]; x (states,); u (inputs,) to be set by the master. Raises UsageError for tolerances that are not positive.
    """

    def __init__(self, plant: Spasim, t: float = 0.0, rtol: float = 1e-6, atol: float = 1e-8) -> None:
        if not (atol > 0.0 and rtol >= 0.0):
            raise UsageError("atol must be positive, rtol must not be negative", "simulation.tolerance")
        self.plant, self.t = plant, float(t)
        self.tolerance, self.code = Tolerance(atol, rtol), named(155).code
        self.x, self.u = plant.start(), np.zeros(plant.n_in)
        self._size: float | None = None

    def outputs(self) -> Array:
        """(outputs,) at the present time, state and inputs."""
        return self.plant.outputs(self.t, self.x, self.u)

    def advance(self, h: float) -> None:
        """One communication step of length h > 0 [s], stopping at jumps of the drives of the mechanism in it.

        Raises UsageError for another h, AnalysisError when the motion cannot be followed; the state then stays.
        """
        if not 0.0 < h < np.inf:
            raise UsageError(f"a communication step must be positive, not {h}", "simulation.times")
        end, t, x = self.t + h, self.t, self.x
        stops = sorted({b for b in self.plant.breaks if t < b < end} | {end})
        problem = _Held(self.plant, np.array(self.u, float))
        for stop in stops:
            for taken in steps(problem, t, x, stop, (t, stop), self.code, self.tolerance, self._size, np.inf):
                self._size = max(float(taken.t) - t, self._size or 0.0) if taken.t >= stop else float(taken.t) - t
                t, x = float(taken.t), np.array(taken.y)
                if t >= stop:
                    break
        self.plant.frame(end, x, problem.u)  # raises beyond the limits of its elements
        self.t, self.x = end, x
