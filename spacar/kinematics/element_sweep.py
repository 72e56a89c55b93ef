"""One pass over all element families: gather, evaluate, scatter, with preallocated arrays.

The entries of V (ne x nx) and of the variable and constant parts of M (nx x nx) live in one flat array `entries`;
every family writes through a view into it. All matrices of the system (D_cc, the saddle-point matrix, ...) are
assembled from this array with index maps that are made once. Nothing here allocates per element.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from spacar.arrays import Array
from spacar.elements.family import Configuration
from spacar.mechanism.layout import Batch, Place
from spacar.mechanism.mechanism import Mechanism


class SweepArrays(NamedTuple):
    """What an evaluation in C may share with a sweep: the entries of V, then of M; e and the branch (ne,)."""

    entries: Array
    e: Array
    branch: Array

    @classmethod
    def of(cls, mechanism: Mechanism) -> SweepArrays:
        ne = mechanism.numbering.ne
        return cls(np.zeros(sum(mechanism.layout.sizes)), np.zeros(ne), np.zeros(ne))


class ElementSweep:
    """Evaluation of all batches at the current configuration; `arrays`: those that it shares."""

    def __init__(self, mechanism: Mechanism, arrays: SweepArrays | None = None) -> None:
        numbering = mechanism.numbering
        self.nx, self.ne = numbering.nx, numbering.ne
        self.layout = layout = mechanism.layout
        self.strained, self.moving, self.curved = layout.strained, layout.moving, layout.curved
        self.entries, self.e, self.branch = arrays or SweepArrays.of(mechanism)
        self.configuration: dict[int, Configuration] = {}
        self.count = 0  # evaluations of D, for the log and the benchmarks
        self.v_rows, self.v_columns = layout.v_rows, layout.v_columns
        self.m_rows, self.m_columns = layout.m_rows, layout.m_columns
        self.x_index, self.e_index, self.f_index = layout.x_index, layout.e_index, layout.f_index
        nv = len(self.v_rows)
        self.v_entries, self.m_entries = self.entries[:nv], self.entries[nv:]
        self.V, self.M = _views(self.v_entries, layout.V), _views(self.m_entries, layout.M)
        self._x, self._v, self._a = np.zeros((3, len(self.x_index)))
        self._e, self._branch, self._h = np.zeros((3, len(self.e_index)))
        self._f = np.zeros(len(self.f_index))

        self.x_of, self.v_of, self.a_of = (_views(u, layout.x) for u in (self._x, self._v, self._a))
        self.e_of, self.branch_of, self.h_of = (_views(u, layout.e) for u in (self._e, self._branch, self._h))
        self.f_of = _views(self._f, layout.f)

    @classmethod
    def at(cls, mechanism: Mechanism, x: Array | None = None) -> ElementSweep:
        """A sweep at the configuration x (nx,), that of reference by default."""
        made = cls(mechanism)
        made.strain(mechanism.x0 if x is None else x)
        return made

    # -- kinematics ---------------------------------------------------------------------------------------------
    def strain(self, x: Array) -> None:
        """D(x) into `e`, V into `entries`; keeps the configurations for the calls below."""
        np.take(x, self.x_index, out=self._x, mode="clip")
        np.take(self.branch, self.e_index, out=self._branch, mode="clip")
        for b in self.strained:
            key = b.index
            self.configuration[key] = b.family.strain(self.x_of[key], self.branch_of[key], self.e_of[key], self.V[key])
        self.e[self.e_index] = self._e
        self.count += 1

    def follow(self, x: Array, e: Array) -> None:
        """States are those on the branch of x (nx,), e (ne,) from now on."""
        self.branch[:] = self.layout.branch(x, e)

    def rate(self, v: Array) -> Array:
        """V v, (ne,)."""
        return np.bincount(self.v_rows, self.v_entries * v[self.v_columns], self.ne)

    def rate_transposed(self, sigma: Array) -> Array:
        """V^T sigma, (nx,)."""
        return np.bincount(self.v_columns, self.v_entries * sigma[self.v_rows], self.nx)

    def convective(self, v: Array) -> Array:
        """H(v, v), (ne,): the part of the second time derivative of e that does not contain accelerations."""
        out = np.zeros(self.ne)
        np.take(v, self.x_index, out=self._v, mode="clip")
        self._h[:] = 0.0
        for b in self.curved:
            b.family.convective_strain(self.configuration[b.index], self.v_of[b.index], self.h_of[b.index])
        out[self.e_index] = self._h
        return out

    def gradient(self) -> Array:
        """V as a dense (ne, nx) array."""
        V = np.zeros((self.ne, self.nx))
        V[self.v_rows, self.v_columns] = self.v_entries
        return V

    # -- inertia ------------------------------------------------------------------------------------------------
    def constant_mass(self) -> None:
        """Evaluate the mass matrices that never change; once per run."""
        for b in self.layout.massive:
            if b.family.constant_mass:
                b.family.mass(None, self.M[b.index])

    def constant_masses(self) -> list[tuple[Batch, Array]]:
        """Those, (n_coordinates, n_coordinates, n) each."""
        return [(b, self.M[b.index]) for b in self.layout.massive if b.family.constant_mass]

    def mass(self) -> None:
        """M of the configuration-dependent families into `entries`."""
        for b in self.moving:
            b.family.mass(self.configured(b), self.M[b.index])

    def configured(self, b: Batch) -> Configuration:
        """The configuration of a batch. Those without deformations are not in `strain`: theirs is made here."""
        if b.family.n_deformations == 0:
            x = self.x_of[b.index]
            empty = np.zeros((0, *x.shape[1:]))
            self.configuration[b.index] = b.family.strain(x, empty, empty, empty[:, None])
        return self.configuration[b.index]

    def mass_diagonal(self) -> Array:
        """Diagonal of M, (nx,)."""
        on = np.flatnonzero(self.m_rows == self.m_columns)
        return np.bincount(self.m_rows[on], self.m_entries[on], self.nx)

    def mass_times(self, a: Array) -> Array:
        """M a, (nx,)."""
        return np.bincount(self.m_rows, self.m_entries * a[self.m_columns], self.nx)

    def inertia_force(self, v: Array, a: Array | None) -> Array:
        """M a + h of the configuration-dependent families, (nx,)."""
        if not self.moving:
            return np.zeros(self.nx)
        np.take(v, self.x_index, out=self._v, mode="clip")
        if a is not None:
            np.take(a, self.x_index, out=self._a, mode="clip")
        for b in self.moving:
            key, acceleration = b.index, None if a is None else self.a_of[b.index]
            self.f_of[key][...] = b.family.inertia_force(self.configured(b), self.v_of[key], acceleration)
        return np.bincount(self.f_index, self._f, self.nx)


def gradient_blocks(sweep: ElementSweep, fill: Callable[[Batch, Array], None]) -> list[tuple[Batch, Array]]:
    """What `fill` writes into (n_deformations, n_coordinates, n) of every batch whose V depends on x."""
    blocks = [(b, np.zeros((len(b.e), len(b.x), b.family.n))) for b in sweep.curved]
    for b, block in blocks:
        fill(b, block)
    return blocks


def geometric_blocks(sweep: ElementSweep, sigma: Array) -> list[tuple[Batch, Array]]:
    """Hs(sigma) per batch, (n_coordinates, n_coordinates, n) each."""
    blocks = []
    for b in sweep.curved:
        block = np.zeros((len(b.x), len(b.x), b.family.n))
        b.family.geometric_stiffness(sweep.configuration[b.index], sigma[b.e], block)
        blocks.append((b, block))
    return blocks


def _views(buffer: Array, places: tuple[Place, ...]) -> dict[int, Array]:
    """The parts of a buffer as arrays (*shape, n), by the index of the batch."""
    return {key: buffer[part].reshape(shape) for key, part, shape in places}
