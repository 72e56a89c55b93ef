"""Variables of expressions at one stored step, with their derivatives along all directions."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from spacar.arrays import Array
from spacar.errors import UsageError
from spacar.expressions.expression_units import Unit, unit
from spacar.expressions.result_places import ELEMENT, NODE, place
from spacar.frame import Frame
from spacar.mechanism import Mechanism
from spacar.mechanism.numbering import Numbering
from spacar.modes import registered
from spacar.sensitivities.linear_quantities import LinearQuantities
from spacar.sensitivities.state_derivatives import StateDerivative

COORDINATES, DEFORMATIONS = ("x", "fx", "fxgrav", "fxtot"), ("e", "sig")
LINEAR = ("frequency", "eigval", "lmult", "xcompl")
_N, _MOMENT, _STRESS = unit(N=1), unit(N=1, m=1), unit(N=1, m=-2)
# Stresses along beams and trusses, [element] or [element, place]. The package of pictures computes them; it lies above
# this room and is therefore named in `spacar`, not imported.
STRESSES: Mapping[str, Unit] = {
    "N": _N, "Qy": _N, "Qz": _N, "T": _MOMENT, "My": _MOMENT, "Mz": _MOMENT, "B": unit(N=1, m=2),
    "mises": _STRESS, "normal": _STRESS, "shear": _STRESS,
}  # fmt: skip
STRESS_INDICES = dict.fromkeys(STRESSES, (1, 2))
KNOWN = (*COORDINATES, *DEFORMATIONS, *LINEAR, *STRESSES)

Variable = tuple[str, tuple[int, ...]]


def stress_derivatives(mechanism: Mechanism, directions: Sequence[Mechanism], mode: int) -> Any:
    """The evaluator of stresses and their derivatives. Raises UsageError where its package is not installed."""
    try:
        found = registered("StressDerivatives")
    except ImportError as error:
        text = f"stresses need the package spacar_drawing, which comes with the whole program ({error})"
        raise UsageError(text, "sensitivity.quantity") from None
    return found(mechanism, directions, mode)


def check_variable(variable: Variable, numbering: Numbering) -> None:
    """Raises UsageError for a variable that is not stationary, and for nodes, elements and modes that do not exist."""
    name, numbers = variable
    if name not in KNOWN:
        text = f"'{name}' is no quantity of stationary states that has derivatives; these are {', '.join(KNOWN)}"
        raise UsageError(text, "sensitivity.quantity")
    if name in DEFORMATIONS:
        place(numbering.le, numbers[0], numbers[1], ELEMENT)
    elif name in (*COORDINATES, "xcompl"):
        place(numbering.lnp, numbers[0], numbers[1], NODE)


class StepQuantities:
    """The state of a stored step: `frame`, its derivatives, and where wanted the linearized equations and stresses."""

    def __init__(
        self, frame: Frame, numbering: Numbering, states: list[StateDerivative], linear: LinearQuantities | None,
        stresses: Any,
    ) -> None:  # fmt: skip
        self.frame, self.numbering, self.states = frame, numbering, states
        self.linear, self.stresses = linear, stresses

    def __call__(self, variable: Variable) -> tuple[float | complex, Array]:
        """Value and derivatives (directions,)."""
        name, numbers = variable
        if name in COORDINATES:
            return self._stored(name, place(self.numbering.lnp, numbers[0], numbers[1], NODE))
        if name in DEFORMATIONS:
            return self._stored(name, place(self.numbering.le, numbers[0], numbers[1], ELEMENT))
        if name in STRESSES:
            dsigma, de = [s.dsigma for s in self.states], [s.de for s in self.states]
            value, rates = self.stresses(name, numbers, self.frame.sig, self.frame.e, dsigma, de)
            return float(value), rates
        assert self.linear is not None
        if name == "xcompl":
            return self.linear.compliance(place(self.numbering.lnp, numbers[0], numbers[1], NODE))
        count = {"eigval": len, "frequency": lambda v: int(np.sum(v.imag >= 0.0)), "lmult": len}[name](
            self.linear.multipliers if name == "lmult" else self.linear.eigenvalues
        )
        if numbers[0] > count:
            text = f"{name}[{numbers[0]}]: the model has {count} of them"
            raise UsageError(text, "expression.number")
        of = {"eigval": self.linear.eigenvalue, "frequency": self.linear.frequency, "lmult": self.linear.multiplier}
        return of[name](numbers[0] - 1)

    def _stored(self, name: str, at: int) -> tuple[float, Array]:
        attribute = {"x": "dx", "e": "de", "sig": "dsigma"}.get(name, name)
        rates = np.array([getattr(s, attribute)[at] for s in self.states])
        return float(getattr(self.frame, name)[at]), rates
