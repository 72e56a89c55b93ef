"""Accelerations and multipliers from the saddle-point form of the equations of motion (theory-system.md (9)).

Free coordinates F = calculable, dynamic, kinematic; constraint rows R = fixed and input deformations:

    [ M_FF   V_RF^T ] [ xdd_F   ]   [ (f - h - V_A^T sigma_A - M[:,P] xdd_P)_F ]
    [ V_RF   0      ] [ sigma_R ] = [ edd_R - H(xd,xd)_R - V[R,P] xdd_P        ]

Rows and columns are scaled symmetrically, so that masses, inertias and constraints have the same size: that costs two
multiplications and gains one to two digits. Entries of MEE enter as V^T M_e V. Linear cost for chains in band storage;
more accurate than the reduced form, whose mass matrix squares the condition.
"""

from __future__ import annotations

import numpy as np

from spacar.arrays import Array, Index
from spacar.dynamics.loaded_mechanism import DeformationInertia
from spacar.kinematics.element_sweep import ElementSweep
from spacar.linear_systems import assemble
from spacar.mechanism.mechanism import Mechanism
from spacar.mechanism.numbering import Numbering, places_in


def free_coordinates(numbering: Numbering) -> Index:
    """Calculable, dynamic and kinematic coordinates, (nf,)."""
    classes = (numbering.x_class[name] for name in ("calculable", "dynamic", "kinematic"))
    return np.concatenate([np.arange(c.start, c.stop) for c in classes])


class SaddlePoint:
    """The assembled system; `factor` at the present configuration, `solve` for as many right-hand sides as wanted."""

    def __init__(self, mechanism: Mechanism, sweep: ElementSweep, kind: str | None = None) -> None:
        n = mechanism.numbering
        self.F = free_coordinates(n)
        self.n_rows = n.e_class["input"].stop
        self.sweep = sweep
        nf = len(self.F)
        place = places_in(n.nx, self.F)
        nv = len(sweep.v_entries)
        vr, vc = sweep.v_rows, place[sweep.v_columns]
        v = np.flatnonzero((vr < self.n_rows) & (vc >= 0))
        mr, mc = place[sweep.m_rows], place[sweep.m_columns]
        m = np.flatnonzero((mr >= 0) & (mc >= 0))
        self.take = np.concatenate((m + nv, v, v))
        self.coupling = DeformationInertia(mechanism, sweep)
        a, b = place[self.coupling.rows], place[self.coupling.columns]
        self.coupled = np.flatnonzero((a >= 0) & (b >= 0))
        i = np.concatenate((mr[m], nf + vr[v], vc[v], a[self.coupled]))
        j = np.concatenate((mc[m], vc[v], nf + vr[v], b[self.coupled]))
        self.system = assemble(nf + self.n_rows, i, j, kind, nf)
        self.scale = self._scale(mechanism, v)
        self.weights = self.scale[i] * self.scale[j]
        self.rhs = np.zeros(nf + self.n_rows)

    def _scale(self, mechanism: Mechanism, v: Index) -> Array:
        """Factors of rows and columns, (n,): unit diagonal of M, constraint rows (entries `v`) of norm 1 at the first
        configuration.

        The four Euler parameters of a node share one factor, because their mass moves from one to the other as the node
        turns. A coordinate without mass gets the factor of an average mass, so that positions and rotations compare.
        """
        sweep = self.sweep
        diagonal = sweep.mass_diagonal()
        lambdas = mechanism.numbering.lnp[mechanism.numbering.normalization[:, 0] - 1] - 1
        diagonal[lambdas] = diagonal[lambdas].mean(axis=1, keepdims=True)
        size = mechanism.scale
        heavy = diagonal > 0.0
        average = np.exp(np.mean(np.log(diagonal[heavy] * size[heavy] ** 2))) if heavy.any() else 1.0
        x = np.where(heavy, 1.0 / np.sqrt(np.where(heavy, diagonal, 1.0)), size / np.sqrt(average))
        norm = np.sqrt(np.bincount(sweep.v_rows[v], (sweep.v_entries[v] * x[sweep.v_columns[v]]) ** 2, self.n_rows))
        return np.concatenate((x[self.F], 1.0 / np.where(norm > 0.0, norm, 1.0)))

    def factor(self) -> None:
        """Assemble and factor at the sweep's configuration. Raises SingularMatrixError."""
        entries = self.sweep.entries[self.take]
        if self.coupling.present:
            entries = np.concatenate((entries, self.coupling.entries()[self.coupled]))
        entries *= self.weights
        self.system.factor(entries)

    def solve(self, force: Array, strain: Array) -> tuple[Array, Array]:
        """xdd_F and sigma_R of the right-hand sides force (nx,) and strain (at least the rows R)."""
        nf = len(self.F)
        self.rhs[:nf] = force[self.F]
        self.rhs[nf:] = strain[: self.n_rows]
        self.rhs *= self.scale
        solution = self.system.solve(self.rhs)
        solution *= self.scale
        return solution[:nf], solution[nf:]
