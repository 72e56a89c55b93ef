"""Variables of expressions at one stored step, with their derivatives along all directions: those of the state, and
eigenvalues, load multipliers and compliances of its linearized equations.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from spacar.arrays import Array
from spacar.dynamics.array_evaluator import Dynamics
from spacar.errors import AnalysisError, Report, UsageError
from spacar.expressions.evaluation import frequency_order
from spacar.expressions.expression_units import Unit, unit
from spacar.expressions.result_places import ELEMENT, NODE, place
from spacar.frame import Frame
from spacar.linear.buckling import buckling_modes, directional_compliances
from spacar.linear.eigen import Modes, is_symmetric, is_zero, matters, vibration_modes
from spacar.linear.internal_unknowns import buckling_matrices
from spacar.linearization.matrices import Linearization
from spacar.mechanism import Mechanism
from spacar.mechanism.numbering import Numbering
from spacar.modes import registered
from spacar.sensitivities.pencil_derivatives import PencilDerivatives, null_vectors, together
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


@dataclass
class LinearQuantities:
    """Of the linearized equations L; `states`: one for every direction. Each quantity gives its value and its
    derivatives (directions,)."""

    dynamics: Dynamics
    L: Linearization
    states: list[StateDerivative]
    report: Report
    moving: bool

    def __post_init__(self) -> None:
        self.dynamic = self.dynamics.numbering.dynamic
        self.along = [PencilDerivatives(self.dynamics, self.L, s, self.moving) for s in self.states]
        for doubt in self.L.c.user.doubts if self.L.c.user else ():
            self.report.add(doubt)

    # -- vibration -----------------------------------------------------------------------------------------------
    @cached_property
    def _matrices(self) -> tuple[Array, Array, Array]:
        L, block = self.L, np.ix_(self.dynamic, self.dynamic)
        return L.m0[block], L.damping[block], L.stiffness[block]

    @cached_property
    def modes(self) -> Modes:
        """Their values are (n,) [rad/s], in the order of the results."""
        q = self.dynamic
        if not len(q):
            raise AnalysisError("no dynamic degrees of freedom: there are no eigenvalues", "sensitivity.eigenvalues")
        return vibration_modes(self.L, q, q, self.report, self.dynamics.numbering.twist_rates)

    def eigenvalue(self, index: int) -> tuple[complex, Array]:
        """Value and derivatives of the eigenvalue at a place (from 0) of the results."""
        values = self.modes.values
        group = together(values, index)
        rates = self._eigenvalue_rates(index)
        size = (np.conj(values[index]) * rates).real  # decreasing modulus
        order = np.argsort(-size, axis=1, kind="stable")
        rank = int(np.flatnonzero(group == index)[0])
        return complex(values[index]), np.take_along_axis(rates, order, 1)[:, rank]

    def frequency(self, index: int) -> tuple[float, Array]:
        """Value and derivatives of the natural frequency [Hz] at a place (from 0), counted from low to high."""
        values = self.modes.values
        order = frequency_order(values)
        here = int(order[index])
        group = set(together(values, here).tolist())
        rank = [int(j) for j in order if j in group].index(here)
        rates = (np.conj(values[here]) * self._eigenvalue_rates(here)).real / np.abs(values[here])
        return float(np.abs(values[here])) / (2.0 * np.pi), np.sort(rates, axis=1)[:, rank] / (2.0 * np.pi)

    def _eigenvalue_rates(self, index: int) -> Array:
        """Derivatives of the eigenvalues that are equal to this one, (directions, m), in no particular order."""
        values = self.modes.values
        group = together(values, index)
        value, (M, C, K) = values[index], self._matrices
        if is_zero(values, K)[index]:
            self.report.add(f"eigenvalue {index + 1} is zero, its derivatives are not defined (nan)")
            return np.full((len(self.states), 1), complex(np.nan, np.nan))
        if len(group) > 1:
            self.report.add(f"eigenvalue {group[0] + 1} occurs {len(group)} times: its derivatives are one-sided")
        if is_symmetric(K) and is_symmetric(M) and not matters(C, M, K) and not self.moving:
            square = float((-value * value).real)
            phi = self.modes.vectors[: len(K), group].real
            of_squares = [dK - square * dM for dM, _, dK in (d.vibration(phi, phi) for d in self.along)]
            return -self._eigenvalues_of(of_squares, phi.T @ M @ phi, symmetric=True) / (2.0 * value)
        size = np.abs(np.diag(K)) + np.abs(value) ** 2 * np.abs(np.diag(M))
        phi, psi = null_vectors(value**2 * M + value * C + K, size, len(group))
        brackets = [value**2 * dM + value * dC + dK for dM, dC, dK in (d.vibration(phi, psi) for d in self.along)]
        return self._eigenvalues_of(brackets, -psi.T @ (2.0 * value * M + C) @ phi)

    def _eigenvalues_of(self, brackets: list[Array], weight: Array, symmetric: bool = False) -> Array:
        """Eigenvalues `rate` of the small pencils bracket - rate weight, (directions, m)."""
        from scipy.linalg import eigh, eigvals

        if symmetric:
            found = [eigh(0.5 * (B + B.T), weight, eigvals_only=True) for B in brackets]
        else:
            found = [eigvals(B, weight) for B in brackets]
        return np.array(found).reshape(len(self.states), len(weight))

    # -- buckling ------------------------------------------------------------------------------------------------
    @cached_property
    def _pencil(self) -> tuple[Array, Array]:
        return buckling_matrices(self.dynamics, self.L, self.dynamic)

    @cached_property
    def multipliers(self) -> Array:
        """(n,) in the order of the results."""
        if not len(self.dynamic):
            text = "no dynamic degrees of freedom: there are no load multipliers"
            raise AnalysisError(text, "sensitivity.multipliers")
        return buckling_modes(*self._pencil, self.report).first(len(self.dynamic)).multipliers

    def multiplier(self, index: int) -> tuple[float, Array]:
        """Value and derivatives of the load multiplier at a place (from 0) of the results."""
        values = self.multipliers
        value = float(values[index])
        if not np.isfinite(value):
            self.report.add(f"load multiplier {index + 1} is infinite, it has no derivatives (nan)")
            return value, np.full(len(self.states), np.nan)
        group = together(values, index)
        if len(group) > 1:
            self.report.add(f"load multiplier {group[0] + 1} occurs {len(group)} times: its derivatives are one-sided")
        K0, G0 = self._pencil
        phi, psi = null_vectors(K0 + value * G0, np.abs(np.diag(K0)), len(group))
        brackets = [dK0 + value * dG0 for dK0, dG0 in (d.buckling(phi, psi) for d in self.along)]
        rates = np.sort(np.real(self._eigenvalues_of(brackets, -psi.T @ G0 @ phi)), axis=1)
        rank = int(np.flatnonzero(group == index)[0])
        return value, rates[:, rank if value > 0.0 else -1 - rank]

    # -- compliances ---------------------------------------------------------------------------------------------
    @cached_property
    def compliances(self) -> Array:
        """(nx,) as in the results."""
        return directional_compliances(self.L, self.dynamic, self.report)

    def compliance(self, place: int) -> tuple[float, Array]:
        """Value and derivatives of the compliance of a coordinate (from 0)."""
        value = float(self.compliances[place])
        row = self.L.W[place, self.dynamic]
        if not row.any() or not np.isfinite(value):
            return value, np.full(len(self.states), 0.0 if np.isfinite(value) else np.nan)
        K = self._matrices[2]
        phi, psi = np.linalg.solve(K, row)[:, None], np.linalg.solve(K.T, row)[:, None]
        rates = [d.moved(phi + psi)[place, 0] - d.vibration(phi, psi)[2][0, 0] for d in self.along]
        return value, np.array(rates)


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
    name = variable[0]
    if name not in KNOWN:
        text = f"'{name}' is no quantity of stationary states that has derivatives; these are {', '.join(KNOWN)}"
        raise UsageError(text, "sensitivity.quantity")
    if name in (*COORDINATES, *DEFORMATIONS, "xcompl"):
        _place(variable, numbering)


def _place(variable: Variable, numbering: Numbering) -> int:
    """Of a coordinate or deformation in x or e (from 0). Raises UsageError where there is none."""
    name, numbers = variable
    table, words = (numbering.le, ELEMENT) if name in DEFORMATIONS else (numbering.lnp, NODE)
    return place(table, numbers[0], numbers[1], words)


def step_quantity(
    variable: Variable, frame: Frame, numbering: Numbering, states: list[StateDerivative],
    linear: LinearQuantities | None, stresses: Any,
) -> tuple[float | complex, Array]:  # fmt: skip
    """Value and derivatives (directions,) at a stored step: the frame, its derivatives, and where the variable needs
    them the linearized equations or stresses."""
    name, numbers = variable
    if name in (*COORDINATES, *DEFORMATIONS):
        at, attribute = _place(variable, numbering), {"x": "dx", "e": "de", "sig": "dsigma"}.get(name, name)
        return float(getattr(frame, name)[at]), np.array([getattr(s, attribute)[at] for s in states])
    if name in STRESSES:
        dsigma, de = [s.dsigma for s in states], [s.de for s in states]
        value, rates = stresses(name, numbers, frame.sig, frame.e, dsigma, de)
        return float(value), rates
    assert linear is not None
    if name == "xcompl":
        return linear.compliance(_place(variable, numbering))
    known = linear.multipliers if name == "lmult" else linear.modes.values
    count = int(np.sum(known.imag >= 0.0)) if name == "frequency" else len(known)
    if numbers[0] > count:
        raise UsageError(f"{name}[{numbers[0]}]: the model has {count} of them", "expression.number")
    of = {"eigval": linear.eigenvalue, "frequency": linear.frequency, "lmult": linear.multiplier}
    return of[name](numbers[0] - 1)
