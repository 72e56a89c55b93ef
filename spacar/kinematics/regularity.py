"""Is the configuration determined by its degrees of freedom? Asked at stored steps only.

At a dead point the position may still solve D(x) = e to rounding, but velocities and reactions are not determined:
their values would be of any size. Below a reciprocal condition of sqrt(eps), times sqrt(|x|/L) far from the origin, the
position is looked at: is its root a single one (`is_single_root`)? Euler parameters as dynamic coordinates end at a
rotation of 180 degrees.

What happens between stored steps is looked at in `spacar.forward.continuity`.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from math import sqrt
from typing import TYPE_CHECKING

import numpy as np

from spacar.arrays import Array, Index
from spacar.errors import AnalysisError
from spacar.kinematics.constraint_matrices import ZERO, entries_of, scaled_difference_matrix
from spacar.linear_systems.linear_system import DenseSystem
from spacar.linear_systems.reciprocal_condition import reciprocal_condition
from spacar.mechanism.mechanism import Mechanism
from spacar.mechanism.numbering import Numbering

if TYPE_CHECKING:
    from spacar.kinematics.kinematics import Kinematics

MOST_NAMED = 3000  # unknowns whose singular vectors (time and memory of a full matrix) are worth names in a message
HALF_TURN = 0.02  # smallest |lambda0| of a node whose lambda1..3 are dynamic: 177.7 degrees


class PositionMatrix:
    """The matrix V[E, U] of an evaluator at its present configuration, as the checks look at it.

    `kinematics` gives that of NumPy, for what is asked of it only; `dense`: how it stores the matrix. `rows` and
    `columns` are factors that measure deformations and coordinates in their sizes; `zero`: a reciprocal condition below
    which the position is looked at.
    """

    def __init__(self, mechanism: Mechanism, kinematics: Callable[[], Kinematics], dense: bool) -> None:
        self._kinematics, n = kinematics, mechanism.numbering
        self.is_empty = not n.e_class["dynamic"].stop
        # Only with dense storage, where the determinant costs next to nothing.
        self.has_determinant = dense and not self.is_empty
        self.rows = 1.0 / mechanism.deformation_scale[n.velocity_equations]
        self.columns: Array = mechanism.scale[n.velocity_unknowns]
        self.zero = ZERO * sqrt(mechanism.distance)

    @property
    def kinematics(self) -> Kinematics:
        return self._kinematics()

    def determinant(self) -> tuple[float, float]:
        """Its sign, the logarithm of its size."""
        sign, size = np.linalg.slogdet(self.kinematics.velocity_system.A)  # type: ignore[attr-defined]
        return float(sign), float(size)

    def rcond(self) -> float:
        """Reciprocal condition of the scaled matrix that was factored last."""
        k = self.kinematics
        system = k.velocity_system
        if isinstance(system, DenseSystem):
            norm = float((self.rows @ np.abs(system.A) * self.columns).max())
        else:
            norm = k.norm(k.of_velocity)
        return reciprocal_condition(system, norm, self.rows, self.columns)

    def surely_regular(self) -> bool:
        """Is the reciprocal condition surely above `zero`?"""
        return self.rcond() > self.zero

    def regular_everywhere(self) -> bool:
        """Is it known that this holds at all configurations? Then there are no dead points."""
        return False

    def determined(self) -> bool:
        """Is the position a single root? Worth its cost only where `rcond` is below `zero`."""
        k = self.kinematics
        return k.is_single_root(k.of_velocity, k.rounding(k.x, k.sweep.e[k.h]))

    def undetermined(self) -> str:
        """Names of the coordinates that move most in the motion that is not determined."""
        k = self.kinematics
        if len(k.U) > MOST_NAMED:
            return "some of its coordinates (too many to be told apart)"
        D = scaled_difference_matrix(k.mechanism, entries_of(k.sweep), k.E, k.U)
        motion = np.abs(np.linalg.svd(D)[2][-1]).round(9)
        order = np.argsort(-motion, kind="stable")[:3]
        return ", ".join(k.numbering.x_name(int(k.U[i])) for i in order if motion[i] > 0.1)

    def check(self, t: float) -> None:
        """Raises AnalysisError 'position.singular' that names the motion which is not determined."""
        if self.is_empty or self.surely_regular() or self.determined():
            return
        rcond = self.rcond()
        raise AnalysisError(
            f"singular position at t = {t:.9g}: the degrees of freedom do not determine the motion of"
            f" {self.undetermined()} (reciprocal condition {rcond:.2g}); a dead point: choose other degrees of"
            " freedom, or output times that do not fall on it",
            "position.singular",
            t=t,
            rcond=rcond,
        )


class HalfTurns:
    """Watches the nodes whose lambda1, lambda2 or lambda3 is a dynamic coordinate, at every accepted step, except the
    nodes `without`, which may pass half a turn."""

    def __init__(self, n: Numbering, without: Collection[int] = ()) -> None:
        where = n.x_class["dynamic"]
        owners = [] if n.planar else [n.x_owner(i)[0] for i in range(where.start, where.stop)]
        dynamic = [node for node in owners if n.kind[node] == "orientation"]
        self.some = {node for node in dynamic if dynamic.count(node) < 3}  # of three only one or two
        self.nodes = sorted(set(dynamic).difference(without))
        self.lambda0: Index = np.array([n.x_index(node, 1) for node in self.nodes], np.int64)  # where it is in x

    def check(self, t: float, x: Array, within: float = HALF_TURN) -> None:
        """Raises AnalysisError 'position.singular' when |lambda0| of a node is below `within` at x (nx,), t [s]."""
        near = np.flatnonzero(np.abs(x[self.lambda0]) < within)
        if len(near):
            node = self.nodes[near[0]]
            cure = f"make all three dynamic (DYNX {node}) if it turns freely, else " if node in self.some else ""
            raise AnalysisError(
                f"singular position at t = {t:.9g}: the rotation of node {node} reaches 180 degrees, where lambda1,"
                f" lambda2, lambda3 (DYNX) are no coordinates; {cure}describe it by HINGE elements (DYNE)",
                "position.singular",
                t=t,
            )
