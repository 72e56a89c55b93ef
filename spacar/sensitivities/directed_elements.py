"""All elements at complex coordinates: values in the real part, i STEP times a derivative in the imaginary part.

What `spacar.stationary` and `spacar.linearization` have for real numbers is here for numbers with a direction, without
any linear system: residuals, and the blocks of the stiffness and mass of every element (sensitivity.md section 2).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from spacar.arrays import Array, Index
from spacar.deck.directed import STEP
from spacar.dynamics.forces import moment_gradient
from spacar.elements.family import Configuration
from spacar.mechanism.layout import Batch
from spacar.mechanism.mechanism import DriveState, Loads, Mechanism
from spacar.stationary.loading import LoadLevel, SteadyDrive, loads_at, with_flow


class Evaluated(NamedTuple):
    """A batch at a configuration: e (n_deformations, n) and V (n_deformations, n_coordinates, n)."""

    batch: Batch
    at: Configuration
    e: Array
    V: Array


@dataclass(frozen=True)
class ElementMatrices:
    """Matrices of elements: `values` (rows, columns, n) at the places rows, columns (rows, n), (columns, n)."""

    rows: Index
    columns: Index
    values: Array

    @property
    def rate(self) -> ElementMatrices:
        """The derivative."""
        return ElementMatrices(self.rows, self.columns, self.values.imag / STEP)

    def form(self, left: Array, right: Array) -> Array:
        """left^T (sum of the matrices) right, (k, m), of left (., k) and right (., m)."""
        product = np.einsum("abn,bnm->anm", self.values, right[self.columns])
        return np.asarray(np.einsum("ank,anm->km", left[self.rows], product))


class DirectedElements:
    """The elements, loads and prescribed values of a directed mechanism at a load level.

    `at` evaluates at coordinates x (nx,), complex, with angles near the deformations `near` (ne,).
    """

    def __init__(self, mechanism: Mechanism, level: LoadLevel) -> None:
        loads = loads_at(mechanism, level)
        self.mechanism = with_flow(mechanism, loads)
        self.loads: Loads = loads
        self.drive: DriveState = SteadyDrive.at_level(mechanism, level).state
        n = mechanism.numbering
        self.nx, self.ne = n.nx, n.ne
        self.field = np.zeros(n.nx, complex)
        if loads.gravity.any():
            self.field[n.positions] = loads.gravity
        self.evaluated: list[Evaluated] = []

    def at(self, x: Array, near: Array) -> None:
        """Evaluate all elements."""
        self.x = x
        self.evaluated = []
        for b in self.mechanism.batches:
            e = np.zeros((len(b.e), b.family.n), complex)
            V = np.zeros((len(b.e), len(b.x), b.family.n), complex)
            self.evaluated.append(Evaluated(b, b.family.strain(x[b.x], near[b.e], e, V), e, V))

    def deformations(self) -> Array:
        """e (ne,)."""
        out = np.zeros(self.ne, complex)
        for b, _, e, _ in self.evaluated:
            out[b.e] = e
        return out

    def stress_forces(self, sigma: Array) -> Array:
        """V^T sigma (nx,)."""
        out = np.zeros(self.nx, complex)
        for b, _, _, V in self.evaluated:
            np.add.at(out, b.x, np.einsum("ebn,en->bn", V, sigma[b.e]))
        return out

    def inertia(self, gravity: bool) -> Array:
        """h at rest, minus gravity if that is wanted, (nx,)."""
        out = np.zeros(self.nx, complex)
        for b, c, _, _ in self.evaluated:
            if b.family.has_mass:
                a = -self.field[b.x] if gravity else np.zeros(b.x.shape, complex)
                np.add.at(out, b.x, b.family.inertia_force(c, np.zeros(b.x.shape, complex), a))
        return out

    def applied(self) -> Array:
        """XF and moments (nx,)."""
        out = self.loads.force + np.zeros(self.nx, complex)
        rows = self.loads.moment_rows
        if rows.size:
            np.add.at(out, rows, (moment_gradient(self.loads.moment) * self.x[rows]).sum(axis=1))
        return out

    def law(self, deformations: Array, preload: bool = True) -> Array:
        """S e, and the preload, of all rows (ne,)."""
        out = self.loads.preload + 0.0 if preload else np.zeros(self.ne, complex)
        for b, _, _, _ in self.evaluated:
            if len(b.e):
                out[b.e] += np.einsum("abn,bn->an", b.family.stiffness()[0], deformations[b.e])
        return out

    # -- matrices ------------------------------------------------------------------------------------------------
    def gradient(self) -> list[ElementMatrices]:
        """V."""
        return [ElementMatrices(b.e, b.x, V) for b, _, _, V in self.evaluated if len(b.e)]

    def stiffness(self, first: int) -> list[ElementMatrices]:
        """S of the rows from `first`."""
        return self._law(0, first)

    def damping(self, first: int) -> list[ElementMatrices]:
        """S_d of the rows from `first`."""
        return self._law(1, first)

    def _law(self, which: int, first: int) -> list[ElementMatrices]:
        found = []
        for b, *_ in self.evaluated:
            if len(b.e):
                keep = b.e >= first
                found.append(ElementMatrices(b.e, b.e, b.family.stiffness()[which] * keep[:, None] * keep[None] + 0j))
        return found

    def geometric(self, sigma: Array) -> list[ElementMatrices]:
        """Hs(sigma)."""
        found = []
        for b, c, _, _ in self.evaluated:
            if len(b.e) and not b.family.constant_gradient:
                block = np.zeros((len(b.x), len(b.x), b.family.n), complex)
                b.family.geometric_stiffness(c, sigma[b.e] + 0j, block)
                found.append(ElementMatrices(b.x, b.x, block))
        return found

    def loading(self, flow: bool) -> list[ElementMatrices]:
        """-df/dx of gravity and global moments, with `flow` also that of the fluid in tubes."""
        found = []
        for b, c, _, _ in self.evaluated:
            if b.family.has_mass and not b.family.constant_mass:
                zero = np.zeros(b.x.shape, complex)
                block = b.family.inertia_gradient(c, zero, -self.field[b.x])[0]
                if not flow:
                    block = block - b.family.inertia_gradient(c, zero, zero)[0]
                found.append(ElementMatrices(b.x, b.x, block))
        rows = self.loads.moment_rows
        if rows.size:
            found.append(ElementMatrices(rows, rows, -moment_gradient(self.loads.moment)))
        return found

    def flow(self) -> list[ElementMatrices]:
        """dh/dv at rest."""
        found = []
        for b, c, _, _ in self.evaluated:
            if b.family.has_mass and not b.family.constant_mass:
                zero = np.zeros(b.x.shape, complex)
                found.append(ElementMatrices(b.x, b.x, b.family.inertia_gradient(c, zero, zero)[1]))
        return found

    def mass(self) -> list[ElementMatrices]:
        """M of the coordinates."""
        found = []
        for b, c, _, _ in self.evaluated:
            if b.family.has_mass:
                block = np.zeros((len(b.x), len(b.x), b.family.n), complex)
                b.family.mass(c, block)
                found.append(ElementMatrices(b.x, b.x, block))
        return found

    def deformation_mass(self) -> list[ElementMatrices]:
        """MEE."""
        rows, columns, values = self.mechanism.deformation_inertia
        return [ElementMatrices(rows[None], columns[None], values[None, None] + 0j)] if len(rows) else []

    def internal(self, sigma: Array) -> list[tuple[Index, Array, Array, Array]]:
        """Unknowns inside elements (`spacar.linear.internal_unknowns`): places (n_coordinates, m), coupling
        (n_coordinates, m), stiffness (m,), which are eliminated (m,)."""
        found = []
        for b, c, _, _ in self.evaluated:
            if len(b.e) and not b.family.constant_gradient:
                inner = b.family.internal(c, sigma[b.e] + 0j)
                if inner is not None:
                    has = np.flatnonzero(np.isfinite(inner.stiffness) & inner.coupling.real.any(0))
                    stiffness, eliminated = inner.stiffness[has], np.real(inner.eliminated)[has] != 0
                    found.append((b.x[:, has], inner.coupling[:, has], stiffness, eliminated))
        return found
