"""All elements at complex coordinates: values in the real part, i STEP times a derivative in the imaginary part.

What `spacar.stationary` and `spacar.linearization` compute for real numbers is computed here for numbers with a
direction, without any linear system: residuals, and the blocks of the stiffness and mass of every element
(sensitivity.md section 2).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from spacar.arrays import Array, Index
from spacar.dynamics.loaded_mechanism import moment_gradient
from spacar.elements.family import Configuration
from spacar.mechanism.layout import Batch
from spacar.mechanism.mechanism import Mechanism
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

    def times(self, right: Array) -> Array:
        """The matrix of every element times its rows of right (., m): (rows, n, m)."""
        return np.einsum("abn,bnm->anm", self.values, right[self.columns])


Matrices = list[ElementMatrices]


class DirectedElements:
    """The elements, loads and prescribed values of a directed mechanism at a load level.

    `at` evaluates at coordinates x (nx,), complex, on the branch of a state with the deformations `near` (ne,).
    """

    def __init__(self, mechanism: Mechanism, level: LoadLevel) -> None:
        self.loads = loads_at(mechanism, level)
        self.mechanism = with_flow(mechanism, self.loads)
        self.drive = SteadyDrive.at_level(mechanism, level).state
        n = mechanism.numbering
        self.nx, self.ne = n.nx, n.ne
        self.field = np.zeros(n.nx, complex)
        self.field[n.positions] = self.loads.gravity
        self.evaluated: list[Evaluated] = []

    def at(self, x: Array, near: Array) -> None:
        self.x = x
        self.evaluated = []
        branch = self.mechanism.layout.branch(x.real, near)
        for b in self.mechanism.batches:
            e = np.zeros((len(b.e), b.family.n), complex)
            V = np.zeros((len(b.e), len(b.x), b.family.n), complex)
            self.evaluated.append(Evaluated(b, b.family.strain(x[b.x], branch[b.e], e, V), e, V))

    def _of_rows(self, each: Callable[[Evaluated], Array]) -> Array:
        """(ne,) of the numbers (n_deformations, n) of every batch that has deformations."""
        out = np.zeros(self.ne, complex)
        for one in self.evaluated:
            if len(one.batch.e):
                out[one.batch.e] = each(one)
        return out

    def deformations(self) -> Array:
        """e (ne,)."""
        return self._of_rows(lambda one: one.e)

    def stress_forces(self, sigma: Array) -> Array:
        """V^T sigma (nx,)."""
        out = np.zeros(self.nx, complex)
        for b, _, _, V in self.evaluated:
            np.add.at(out, b.x, np.einsum("ebn,en->bn", V, sigma[b.e]))
        return out

    def inertia(self, v: Array, a: Array, gravity: bool) -> Array:
        """M a + h with velocities v and accelerations a (nx,), minus gravity if that is wanted, (nx,)."""
        out = np.zeros(self.nx, complex)
        acceleration = a - self.field if gravity else a
        for b, c, _, _ in self.evaluated:
            if b.family.has_mass:
                np.add.at(out, b.x, b.family.inertia_force(c, v[b.x] + 0j, acceleration[b.x] + 0j))
        return out

    def strain_rate(self, v: Array) -> Array:
        """V v (ne,)."""
        return self._of_rows(lambda one: np.einsum("ebn,bn->en", one.V, v[one.batch.x]))

    def convective(self, v: Array) -> Array:
        """H(v, v) (ne,)."""

        def each(one: Evaluated) -> Array:
            block = np.zeros(one.e.shape, complex)
            if not one.batch.family.constant_gradient:
                one.batch.family.convective_strain(one.at, v[one.batch.x] + 0j, block)
            return block

        return self._of_rows(each)

    def viscous(self, rates: Array) -> Array:
        """S_d de/dt of all rows (ne,)."""
        return self._by_law(1, rates)

    def coupling(self, accelerations: Array) -> Array:
        """Stresses (ne,) of MEE by second rates (ne,) of the deformations."""
        out = np.zeros(self.ne, complex)
        rows, columns, values = self.mechanism.deformation_inertia
        np.add.at(out, rows, values * accelerations[columns])
        return out

    def applied(self) -> Array:
        """XF and moments (nx,)."""
        out = self.loads.force + np.zeros(self.nx, complex)
        rows = self.loads.moment_rows
        if rows.size:
            np.add.at(out, rows, (moment_gradient(self.loads.moment) * self.x[rows]).sum(axis=1))
        return out

    def law(self, deformations: Array) -> Array:
        """S e and the preload of all rows (ne,)."""
        return self.loads.preload + self._by_law(0, deformations)

    def _by_law(self, which: int, values: Array) -> Array:
        return self._of_rows(
            lambda one: np.einsum("abn,bn->an", one.batch.family.stiffness()[which], values[one.batch.e])
        )

    # -- matrices ------------------------------------------------------------------------------------------------
    def gradient(self) -> Matrices:
        return [ElementMatrices(b.e, b.x, V) for b, _, _, V in self.evaluated if len(b.e)]

    def stiffness(self) -> Matrices:
        """S of the rows that are neither fixed nor prescribed."""
        return self._law(0)

    def damping(self) -> Matrices:
        """S_d of the same rows."""
        return self._law(1)

    def _law(self, which: int) -> Matrices:
        begin, batches = self.mechanism.numbering.e_class["input"].stop, [b for b, *_ in self.evaluated if len(b.e)]
        kept = [(b, (b.e >= begin)[:, None] & (b.e >= begin)[None]) for b in batches]
        return [ElementMatrices(b.e, b.e, b.family.stiffness()[which] * keep + 0j) for b, keep in kept]

    def loading(self, flow: bool, v: Array, a: Array) -> Matrices:
        """-df/dx of gravity and global moments; with `flow` also d(M a + h)/dx, which at rest comes from the fluid in
        tubes only."""
        heavy, _ = self.inertia_gradient(v, a, gravity=True)
        if not flow:
            light, _ = self.inertia_gradient(v, a, gravity=False)
            heavy = [replace(h, values=h.values - g.values) for h, g in zip(heavy, light, strict=True)]
        rows = self.loads.moment_rows
        moments = [ElementMatrices(rows, rows, -moment_gradient(self.loads.moment))] if rows.size else []
        return heavy + moments

    def inertia_gradient(
        self, v: Array, a: Array, gravity: bool
    ) -> tuple[Matrices, Matrices]:
        """d(M a + h)/dx, minus that of gravity if wanted, and dh/dv."""
        by_x, by_v = [], []
        acceleration = a - self.field if gravity else a
        for b, c, _, _ in self.evaluated:
            if b.family.has_mass and not b.family.constant_mass:
                x, rate = b.family.inertia_gradient(c, v[b.x] + 0j, acceleration[b.x] + 0j)
                by_x.append(ElementMatrices(b.x, b.x, x))
                by_v.append(ElementMatrices(b.x, b.x, rate))
        return by_x, by_v

    def second(self, method: str, values: Array) -> Matrices:
        """What a method of families writes about second derivatives: `geometric_stiffness` Hs(sigma), `gradient_rate`
        H1(v), `rate_gradient` T(v)."""
        found = []
        rows, of = ("x", "e") if method == "geometric_stiffness" else ("e", "x")
        for b, c, _, _ in self.evaluated:
            if len(b.e) and not b.family.constant_gradient:
                own = getattr(b, rows)
                block = np.zeros((len(own), len(b.x), b.family.n), complex)
                getattr(b.family, method)(c, values[getattr(b, of)] + 0j, block)
                found.append(ElementMatrices(own, b.x, block))
        return found

    def mass(self) -> Matrices:
        """M of the coordinates."""
        found = []
        for b, c, _, _ in self.evaluated:
            if b.family.has_mass:
                block = np.zeros((len(b.x), len(b.x), b.family.n), complex)
                b.family.mass(c, block)
                found.append(ElementMatrices(b.x, b.x, block))
        return found

    def deformation_mass(self) -> Matrices:
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
