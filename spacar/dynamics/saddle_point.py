"""Accelerations and multipliers from the saddle-point form of the equations of motion (theory-system.md (9)).

Free coordinates F = calculable, dynamic, kinematic; constraint rows R = fixed and input deformations:

    [ M_FF   V_RF^T ] [ xdd_F   ]   [ (f - h - V_A^T sigma_A - M[:,P] xdd_P)_F ]
    [ V_RF   0      ] [ sigma_R ] = [ edd_R - H(xd,xd)_R - V[R,P] xdd_P        ]

The constraint rows are multiplied by a typical mass, so that both blocks have the same size. Entries of MEE enter as
V^T M_e V. Linear cost for chains in band storage; more accurate than the reduced form, whose mass matrix squares the
condition.
"""

from __future__ import annotations

import numpy as np

from spacar.kinematics.sweep import Sweep
from spacar.linear_systems import assemble
from spacar.mechanism.mechanism import Array, Mechanism


class SaddlePoint:
    """The assembled system; `factor` at the present configuration, `solve` for as many right-hand sides as wanted."""

    def __init__(self, mechanism: Mechanism, sweep: Sweep, kind: str | None = None) -> None:
        n = mechanism.numbering
        xs, es = n.x_class, n.e_class
        self.F = np.r_[
            xs["calculable"].start : xs["calculable"].stop,
            xs["dynamic"].start : xs["dynamic"].stop,
            xs["kinematic"].start : xs["kinematic"].stop,
        ]
        self.n_rows = es["input"].stop
        self.sweep = sweep
        nf = len(self.F)
        place = np.full(n.nx, -1)
        place[self.F] = np.arange(nf)
        nv = len(sweep.v_entries)
        vr, vc = sweep.v_rows, place[sweep.v_columns]
        v = np.flatnonzero((vr < self.n_rows) & (vc >= 0))
        mr, mc = place[sweep.m_rows], place[sweep.m_columns]
        m = np.flatnonzero((mr >= 0) & (mc >= 0))
        self.take = np.concatenate((m + nv, v, v))
        rows = [mr[m], nf + vr[v], vc[v]]
        columns = [mc[m], vc[v], nf + vr[v]]
        self.coupling = DeformationInertia(mechanism, sweep)
        if self.coupling.present:
            a, b = place[self.coupling.rows], place[self.coupling.columns]
            self.coupled = np.flatnonzero((a >= 0) & (b >= 0))
            rows.append(a[self.coupled])
            columns.append(b[self.coupled])
        self.system = assemble(nf + self.n_rows, np.concatenate(rows), np.concatenate(columns), kind)
        mass = np.abs(sweep.m_entries[sweep.m_rows == sweep.m_columns])
        mass = mass[mass > 0.0]
        self.mass_scale = float(np.exp(np.mean(np.log(mass)))) if len(mass) else 1.0
        self.weights = np.ones(len(self.take))
        self.weights[len(m) :] = self.mass_scale
        self.rhs = np.zeros(nf + self.n_rows)

    def factor(self) -> None:
        """Assemble and factor at the sweep's configuration. Raises SingularMatrixError."""
        entries = self.sweep.entries[self.take] * self.weights
        if self.coupling.present:
            entries = np.concatenate((entries, self.coupling.entries()[self.coupled]))
        self.system.factor(entries)

    def solve(self, force: Array, strain: Array) -> tuple[Array, Array]:
        """xdd_F and sigma_R of the right-hand sides force (nx,) and strain (at least the rows R)."""
        nf = len(self.F)
        self.rhs[:nf] = force[self.F]
        self.rhs[nf:] = strain[: self.n_rows] * self.mass_scale
        solution = self.system.solve(self.rhs)
        return solution[:nf], solution[nf:] * self.mass_scale


class DeformationInertia:
    """The inertia V^T M_e V of MEE as entries of an nx x nx matrix."""

    def __init__(self, mechanism: Mechanism, sweep: Sweep) -> None:
        i, j, value = self.table = mechanism.deformation_inertia
        self.present = bool(len(i))
        self.sweep = sweep
        if not self.present:
            return
        pairs = []
        for r, c, w in zip(i, j, value, strict=True):
            a, b = np.flatnonzero(sweep.v_rows == r), np.flatnonzero(sweep.v_rows == c)
            pairs.append((np.repeat(a, len(b)), np.tile(b, len(a)), np.full(len(a) * len(b), w)))
        self.a, self.b, self.value = (np.concatenate(p) for p in zip(*pairs, strict=True))
        self.rows, self.columns = sweep.v_columns[self.a], sweep.v_columns[self.b]

    def entries(self) -> Array:
        """Values of V^T M_e V in the order of `rows`, `columns`."""
        v = self.sweep.v_entries
        return np.asarray(self.value * v[self.a] * v[self.b])

    def stress(self, edd: Array) -> Array:
        """M_e edd, (ne,)."""
        i, j, value = self.table
        return np.bincount(i, value * edd[j], len(edd)) if self.present else np.zeros(len(edd))
