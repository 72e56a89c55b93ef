"""The Newton iteration of a Radau step in C, on the arrays and with the factors of `spacar.integrators.radau.Radau`.

The method stays that of Python: guess, Jacobian, LU factors, error estimate and messages are its own.
"""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING

from spacar.compiled.interface import structure
from spacar.integrators.radau import KAPPA, MAX_NEWTON, Radau
from spacar.kinematics.kinematics import LARGEST_JUMP

if TYPE_CHECKING:
    from spacar.compiled.compiled_model import CompiledModel, State

NO_RATE = 2  # as in radau.c


class Iterating:
    """The iterations of one method object."""

    def __init__(self, model: CompiledModel, state: State, method: Radau) -> None:
        self.model, self.state, self.method = model, state, method
        m = method.method
        kept = m.c, m.a, m.inverse, m.to, m.back
        self.kept = tuple(v.copy(order="C") for v in kept)
        self.c = c = structure("Newton")(*(v.ctypes.data for v in self.kept))
        c.y, c.Z, c.F = method.y.ctypes.data, method.Z.ctypes.data, method.F.ctypes.data
        c.change, c.right, c.weight = (v.ctypes.data for v in (method.change, method.right, method.weight))
        c.jump, c.kappa = LARGEST_JUMP, KAPPA
        c.s, c.n, c.nq, c.most = len(m.c), method.n, method.nq, MAX_NEWTON
        self.address = ctypes.addressof(c)
        self.factors: object = None

    def __call__(self, h: float, within: float) -> tuple[bool, float, float] | None:
        """Whether the stages of the step h converged, size and contraction of the last change; None: Python has to ask
        for derivatives itself, from the guess on. Raises what a user function raised."""
        c, method = self.c, self.method
        if self.factors is not method.factors:
            self.factors = method.factors
            (lu, pivots), *pairs = method.factors
            c.lu, c.pivots = lu.ctypes.data, pivots.ctypes.data
            c.pair_lu[: len(pairs)] = [of[0].ctypes.data for of in pairs]
            c.pair_pivots[: len(pairs)] = [of[1].ctypes.data for of in pairs]
        evaluation = method.evaluation
        c.t, c.h, c.converged, c.contraction = method.t, h, within, method.contraction
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
