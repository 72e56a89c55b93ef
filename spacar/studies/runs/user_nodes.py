"""Results of a divided model on the nodes and elements of the model that the user gave.

Coordinates, velocities, accelerations and reactions are those of the nodes that both have. Deformations are those of
the user's elements at these coordinates, e = D(x), ed = V xd, edd = V xdd + H(xd, xd); generalized stresses are the end
moments and the means of normal force and torsion of the parts (`joined_preload`). Modes of vibration and buckling are
displacements of the same nodes, then the degrees of freedom of the user: q = (dx, V dx).

Matrices of the linearized equations and transfer functions have no counterpart and are those of the user's mesh; the
state space is that of the divided model.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from spacar.arrays import Array, Index
from spacar.deck.rewrite.divide import joined_preload
from spacar.dynamics.array_evaluator import Dynamics
from spacar.frame import Frame
from spacar.kinematics.element_sweep import ElementSweep
from spacar.linear.eigen import arranged
from spacar.mechanism import Mechanism
from spacar.mechanism.numbering import Numbering


@dataclass
class UserNodes:
    """From frames of `fine`, in which `parts[beam]` elements stand for a beam, to frames of `given`, whose run gave the
    frames `own`."""

    given: Mechanism
    fine: Mechanism
    parts: Mapping[int, Sequence[int]]
    own: Sequence[Frame]

    def __post_init__(self) -> None:
        n, m = self.given.numbering, self.fine.numbering
        self.sweep = ElementSweep(self.given)
        self.at = np.array([m.x_index(*n.x_owner(i)) for i in range(n.nx)], np.int64)
        self.rows, self.columns, self.factors = _stresses(n, m, self.parts)

    def frame(self, frame: Frame, i: int) -> Frame:
        """The frame of the divided model at step i on the nodes of the user."""
        at, own = self.at, self.own[i]
        sig = np.bincount(self.rows, self.factors * frame.sig[self.columns], self.given.numbering.ne)
        # The weight of the parts at inner nodes is contained in that of the user's elements, `own.fxgrav`.
        reaction = (frame.fxtot - frame.fx - frame.fxgrav)[at]
        fx = frame.fx[at]
        found = replace(
            own, x=frame.x[at], xd=frame.xd[at], xdd=frame.xdd[at], sig=sig, fx=fx, fxtot=reaction + fx + own.fxgrav,
            matrices=dict(own.matrices), state_space=frame.state_space, statistics=dict(frame.statistics),
        )  # fmt: skip
        if frame.xcompl is not None:
            found.xcompl = frame.xcompl[at]
        deform(self.given, self.sweep, found, own)
        self._modes(frame, found)
        return found

    def _modes(self, frame: Frame, found: Frame) -> None:
        """Eigenvalues, multipliers and their shapes: as many of the lowest as the mesh of the user has. They keep their
        places: those that a large divided model was not asked for are nan."""
        fine, given = frame.matrices, found.matrices
        if "eigval" not in given and "lmult" not in given:
            return
        dynamics = Dynamics(self.fine)
        dynamics.kinematics.start_at(frame.x, frame.e)
        dynamics.kinematics.refresh()
        if "eigval" in given:
            k = min(len(given["eigval"]), len(fine["eigval"]))
            unknown = len(given["eigval"]) - k
            values = fine["eigval"][-k:]
            given["eigval"] = np.pad(values, ((unknown, 0), (0, 0)), constant_values=np.nan)
            shapes = (fine["eigvre"] + 1j * fine["eigvim"])[:, -k:]
            n, m = self.given.numbering, self.fine.numbering
            if n.nk == 0 and len(shapes) == 2 * m.nddof:
                both = [self._shape(dynamics, part) for part in np.split(shapes, 2)]
                with np.errstate(all="ignore"):
                    modes = arranged(values[:, 0] + 1j * values[:, 1], np.vstack(both), n.nddof)
                vectors = np.pad(modes.vectors, ((0, 0), (unknown, 0)), constant_values=np.nan)
                given["eigvre"], given["eigvim"] = vectors.real, vectors.imag
        if "lmult" in given and "lmult" in fine:
            wanted, k = len(given["lmult"]), min(len(given["lmult"]), len(fine["lmult"]))
            if not k:  # a large divided model without stress has none: all are infinite, as those of a small one
                given["lmult"], given["bmode"] = np.full(wanted, np.inf), np.eye(wanted)
                return
            given["lmult"] = fine["lmult"][:k]
            shape = self._shape(dynamics, fine["bmode"][:, :k]).real
            size = np.linalg.norm(shape, axis=0)
            given["bmode"] = shape / np.where(size > 0.0, size, 1.0)

    def _shape(self, dynamics: Dynamics, q: Array) -> Array:
        """Degrees of freedom of the user (dynamic, k) of small motions q (dynamic of the divided model, k)."""
        if np.iscomplexobj(q):
            return self._shape(dynamics, q.real) + 1j * self._shape(dynamics, q.imag)
        m, n = dynamics.numbering, self.given.numbering
        dx, de = np.zeros((m.nx, q.shape[1])), np.zeros((m.ne, q.shape[1]))
        count = int(m.nxp[3])
        dx[m.x_class["dynamic"]], de[m.e_class["dynamic"]] = q[:count], q[count:]
        motion = dynamics.kinematics.dependent(dx, de)[self.at]
        rates = np.column_stack([self.sweep.rate(column) for column in motion.T])
        return np.vstack((motion[n.x_class["dynamic"]], rates[n.e_class["dynamic"]]))


def deform(given: Mechanism, sweep: ElementSweep, frame: Frame, near: Frame) -> None:
    """Set e, ed, edd of a frame from its coordinates; angles are taken on the turns of `near`."""
    sweep.follow(near.x, near.e)
    sweep.strain(frame.x)
    frame.e = np.where(given.numbering.slips, frame.e, sweep.e)
    frame.ed, frame.edd = sweep.rate(frame.xd), sweep.rate(frame.xdd) + sweep.convective(frame.xd)


def _stresses(n: Numbering, m: Numbering, parts: Mapping[int, Sequence[int]]) -> tuple[Index, Index, Array]:
    """The map from generalized stresses of the divided model (m) to those of the user (n): rows, columns, factors."""
    normal = {int(node): int(row) for node, row in m.normalization}
    found: list[tuple[int, int, float]] = []
    for i in range(n.ne):
        element, mode = n.e_owner(i)
        if element < 0:
            found.append((i, normal[-element], 1.0))
        elif element not in parts:
            found.append((i, m.e_index(element, mode), 1.0))
    for element, its in parts.items():
        for mode, part, factor in joined_preload(n.keyword[element], len(its)):
            found.append((n.e_index(element, mode), m.e_index(its[part], mode), factor))
    rows, columns, factors = zip(*found, strict=True) if found else ((), (), ())
    return np.array(rows, np.int64), np.array(columns, np.int64), np.array(factors, float)
