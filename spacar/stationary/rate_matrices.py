"""The second derivatives of the deformations contracted with velocities and accelerations, as dense matrices.

    ed  = V v             changes with x by  H1(v)
    edd = V a + H(v, v)   changes with x by  H1(a) + T(v),   with v by  H1(v) + H2(v)     (theory-system.md section 0)

The same sums as `spacar.linearization.contractions`, for models that keep all coordinates in dense matrices: where the
entries go is found once, and H2 is not evaluated where a family has it equal to H1.
"""

from __future__ import annotations

import numpy as np

from spacar.arrays import Array, Index
from spacar.elements.family import Family
from spacar.kinematics.element_sweep import ElementSweep
from spacar.mechanism.mechanism import Batch


class RateMatrices:
    """Of one model, at the configuration where its sweep is."""

    def __init__(self, sweep: ElementSweep) -> None:
        self.sweep = sweep
        self._shapes = [(len(b.e), len(b.x), b.family.n) for b in sweep.curved]
        flat = [(b.e[:, None, :] * sweep.nx + b.x[None, :, :]).ravel() for b in sweep.curved]
        self._flat = np.concatenate([np.zeros(0, np.int64), *flat])
        self._symmetric = all(type(b.family).gradient_transport is Family.gradient_transport for b in sweep.curved)

    def __call__(self, v: Array, a: Array) -> tuple[Array, Array, Array]:
        """H1(v), H1(v) + H2(v), H1(a) + T(v), each (ne, nx)."""
        by_v, by_a, by_turn, transported = [], [], [], []
        for b, shape in zip(self.sweep.curved, self._shapes, strict=True):
            family, c = b.family, self.sweep.configuration[b.index]
            v_b, a_b = v[b.x], a[b.x]
            rate, swept, turned = np.zeros((3, *shape))
            family.gradient_rate(c, v_b, rate)
            family.gradient_rate(c, a_b, swept)
            family.rate_gradient(c, v_b, turned)
            by_v.append(rate.ravel())
            by_a.append(swept.ravel())
            by_turn.append(turned.ravel())
            if not self._symmetric:
                moved = np.zeros(shape)
                family.gradient_transport(c, v_b, moved)
                transported.append(moved.ravel())
        rates = self._sum(by_v)
        second = rates if self._symmetric else self._sum(transported)
        return rates, rates + second, self._sum(by_a) + self._sum(by_turn)

    def _sum(self, values: list[Array]) -> Array:
        ne, nx = self.sweep.ne, self.sweep.nx
        return np.bincount(self._flat, np.concatenate([np.zeros(0), *values]), ne * nx).reshape(ne, nx)


class SquareSum:
    """Sums of square element blocks (b.x, b.x, n) as dense (nx, nx); the places of a batch are found once."""

    def __init__(self, nx: int) -> None:
        self.nx = nx
        self._flat: dict[int, Index] = {}

    def __call__(self, blocks: list[tuple[Batch, Array]]) -> Array:
        for b, _ in blocks:
            if b.index not in self._flat:
                self._flat[b.index] = (b.x[:, None, :] * self.nx + b.x[None, :, :]).ravel()
        flat = np.concatenate([np.zeros(0, np.int64), *(self._flat[b.index] for b, _ in blocks)])
        values = np.concatenate([np.zeros(0), *(block.ravel() for _, block in blocks)])
        return np.bincount(flat, values, self.nx * self.nx).reshape(self.nx, self.nx)
