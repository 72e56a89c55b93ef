"""Is the configuration determined by its degrees of freedom? Asked at stored steps only.

At a dead point the position may still solve D(x) = e to rounding, but velocities and reactions are not determined:
numbers would come out, of any size. There the position itself is known to the square root of the rounding only, so the
limit on the reciprocal condition of the scaled matrix V[E, U] is the one of the diagnosis, sqrt(eps), times sqrt(|x|/L)
far from the origin, where rounding is larger by |x|/L. The condition is that of the 1-norm: of n unknowns that move
together the inverse is larger by sqrt(n) than in the 2-norm, which is what the position error shifts, so the limit of
large systems falls with sqrt(n). Euler parameters as dynamic coordinates end at a rotation of 180
degrees.

A dynamic degree of freedom that passes a singular position between two stored steps shows in the sign of the
determinant. The integration may have gone through it, but its accuracy is lost there, so this is reported too (for
systems in dense storage, where the determinant costs nothing).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from spacar.arrays import Array
from spacar.errors import AnalysisError, Report
from spacar.kinematics.diagnosis import ZERO, scaled_difference_matrix
from spacar.linear_systems import DENSE_LIMIT
from spacar.linear_systems.dense import DenseSystem
from spacar.linear_systems.reciprocal_condition import reciprocal_condition
from spacar.mechanism.numbering import Numbering

if TYPE_CHECKING:
    from spacar.kinematics.kinematics import Kinematics

HALF_TURN = 0.02  # smallest |lambda0| of a node whose lambda1..3 are dynamic: 177.7 degrees
COLLAPSE = float(np.log(1e-3))


class PositionMatrix:
    """The matrix V[E, U] of an evaluator at its present configuration, as the checks look at it."""

    def __init__(self, kinematics: Kinematics) -> None:
        self.kinematics = k = kinematics
        self.rows = 1.0 / k.mechanism.deformation_scale[k.E]
        self.columns = k.scale[k.U]
        far = np.abs(k.mechanism.x0 / k.scale).max(initial=1.0)
        large = max(1.0, len(k.U) / DENSE_LIMIT)
        self.zero = ZERO * float(np.sqrt(far / large))  # a reciprocal condition that is zero to rounding
        # of systems in dense storage, where the determinant costs nothing
        self.has_determinant = bool(len(k.U)) and isinstance(k.velocity_system, DenseSystem)

    def determinant(self) -> tuple[float, float]:
        """Its sign, the logarithm of its size."""
        sign, size = np.linalg.slogdet(self.kinematics.velocity_system.A)  # type: ignore[attr-defined]
        return float(sign), float(size)

    def rcond(self) -> float:
        """Reciprocal condition of the scaled matrix that was factored last."""
        system = self.kinematics.velocity_system
        norm = self._dense_norm(system.A) if isinstance(system, DenseSystem) else self._norm()
        return reciprocal_condition(system, norm, self.rows, self.columns)

    def _dense_norm(self, A: Array) -> float:
        return float((self.rows @ np.abs(A) * self.columns).max())

    def _norm(self) -> float:
        """1-norm of the scaled matrix from its entries; bounded from above where two add up."""
        k, sweep = self.kinematics, self.kinematics.sweep
        take = k.velocity_take
        columns = sweep.v_columns[take]
        weight = k.scale[columns] / k.mechanism.deformation_scale[sweep.v_rows[take]]
        return float(np.bincount(columns, np.abs(sweep.entries[take]) * weight).max())

    def undetermined(self) -> str:
        """Names of the coordinates that move most in the motion that is not determined."""
        k = self.kinematics
        if len(k.U) > MOST_NAMED:
            return "some of its coordinates (too many to be told apart)"
        D = scaled_difference_matrix(k.mechanism, k.sweep.gradient())[np.ix_(k.E, k.U)]
        motion = np.abs(np.linalg.svd(D)[2][-1]).round(9)
        order = np.argsort(-motion, kind="stable")[:3]
        return ", ".join(k.numbering.x_name(int(k.U[i])) for i in order if motion[i] > 0.1)


MOST_NAMED = 3000
"""Unknown positions whose singular vectors (time and memory of a full matrix) are worth the names in a message."""


class Regularity:
    """Checks one evaluator at its present configuration."""

    def __init__(self, matrix: PositionMatrix, report: Report) -> None:
        self.matrix = matrix
        self.report = report
        self.last: tuple[float, float] | None = None  # time, sign of the determinant

    def check(self, t: float) -> None:
        """Raises AnalysisError 'position.singular' that names the motion which is not determined."""
        if not len(self.matrix.columns):
            return
        rcond = self.matrix.rcond()
        if rcond > self.matrix.zero:
            self._passage(t)
            return
        raise AnalysisError(
            f"singular position at t = {t:.9g}: the degrees of freedom do not determine the motion of"
            f" {self.matrix.undetermined()} (reciprocal condition {rcond:.2g}); a dead point: choose other degrees of"
            " freedom, or output times that do not fall on it",
            "position.singular",
            rcond=rcond,
        )

    def _passage(self, t: float) -> None:
        if not self.matrix.kinematics.numbering.nddof or not self.matrix.has_determinant:
            return
        sign = self.matrix.determinant()[0]
        if self.last is not None and sign != self.last[1]:
            self.report.add(
                f"warning: between t = {self.last[0]:.9g} and {t:.9g} the degrees of freedom passed a singular position"
                " (dead point); the accuracy of the integration is lost there: choose other degrees of freedom"
            )
        self.last = t, sign


class DeadPoints:
    """Finds at the accepted steps an integration that turns back at a dead point instead of passing it.

    A degree of freedom has an extreme value at its dead point while the dependent velocities go on. Passing it changes
    the sign of the determinant of V[E, U]; when the condition collapses by a factor of 1000 and recovers with the old
    sign, the motion has been reflected. For a matrix that `has_determinant`.
    """

    def __init__(self, matrix: PositionMatrix) -> None:
        self.matrix = matrix
        self.largest = (-np.inf, 0.0)  # logarithm of |det|, reciprocal condition there
        self.sign = 1.0
        self.entered: tuple[float, float] | None = None  # time, sign before

    def check(self, t: float) -> None:
        """Raises AnalysisError 'position.singular'."""
        sign, size = self.matrix.determinant()
        if size > self.largest[0] + 0.1:
            self.largest = size, self.matrix.rcond()
        collapsed = size < self.largest[0] + COLLAPSE and self.matrix.rcond() < np.exp(COLLAPSE) * self.largest[1]
        if collapsed:
            self.entered = self.entered or (t, self.sign)
        else:
            if self.entered and self.entered[1] == sign:
                raise AnalysisError(
                    f"singular position at t = {self.entered[0]:.9g}: at this dead point of the degrees of freedom the"
                    " integration turned back instead of passing it; choose other degrees of freedom",
                    "position.singular",
                )
            self.entered = None
            self.sign = sign


class HalfTurns:
    """Watches the nodes whose lambda1, lambda2 or lambda3 is a dynamic coordinate, at every accepted step."""

    def __init__(self, n: Numbering) -> None:
        nodes: set[int] = set()
        if not n.planar:
            owners = (n.x_owner(i) for i in range(n.x_class["dynamic"].start, n.x_class["dynamic"].stop))
            nodes = {node for node, _ in owners if n.kind[node] == "orientation"}
        self.nodes = sorted(nodes)
        self.lambda0 = np.array([n.x_index(node, 1) for node in self.nodes], np.int64)

    def check(self, t: float, x: Array) -> None:
        """Raises AnalysisError 'position.singular' at the configuration x (nx,)."""
        near = np.flatnonzero(np.abs(x[self.lambda0]) < HALF_TURN)
        if len(near):
            raise AnalysisError(
                f"singular position at t = {t:.9g}: the rotation of node {self.nodes[near[0]]} has reached 180 degrees,"
                " where lambda1, lambda2, lambda3 (DYNX) are no coordinates; describe it by HINGE elements (DYNE)",
                "position.singular",
            )
