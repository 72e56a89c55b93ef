"""Contractions of the second and third derivatives and of the inertia terms, assembled over all families.

Every function returns a dense array; the sparse forms for long chains are in `spacar.stationary.tangent`.
Notation of theory-system.md section 0.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from spacar.arrays import Array
from spacar.elements.family import Family
from spacar.kinematics.element_sweep import ElementSweep
from spacar.mechanism.layout import Batch


def _by_rows(sweep: ElementSweep, fill: Callable[[Batch, Array], None]) -> Array:
    """Sum of element blocks (n_deformations, n_coordinates, n) as (ne, nx)."""
    out = np.zeros((sweep.ne, sweep.nx))
    for batch in sweep.curved:
        block = np.zeros((len(batch.e), len(batch.x), batch.family.n))
        fill(batch, block)
        out[batch.e[:, None, :], batch.x[None, :, :]] = block
    return out


def gradient_rate(sweep: ElementSweep, v: Array) -> Array:
    """H1(v), (ne, nx)."""
    return _by_rows(sweep, lambda b, out: b.family.gradient_rate(sweep.configuration[b.index], v[b.x], out))


def gradient_transport(sweep: ElementSweep, v: Array) -> Array:
    """H2(v), (ne, nx)."""
    return _by_rows(sweep, lambda b, out: b.family.gradient_transport(sweep.configuration[b.index], v[b.x], out))


def rate_gradient(sweep: ElementSweep, v: Array) -> Array:
    """T(v), (ne, nx)."""
    return _by_rows(sweep, lambda b, out: b.family.rate_gradient(sweep.configuration[b.index], v[b.x], out))


def geometric_blocks(sweep: ElementSweep, sigma: Array) -> list[tuple[Batch, Array]]:
    """Hs(sigma) per batch, (n_coordinates, n_coordinates, n) each."""
    blocks = []
    for b in sweep.curved:
        block = np.zeros((len(b.x), len(b.x), b.family.n))
        b.family.geometric_stiffness(sweep.configuration[b.index], sigma[b.e], block)
        blocks.append((b, block))
    return blocks


def scatter(nx: int, blocks: list[tuple[Batch, Array]]) -> Array:
    """Sum of square element blocks as (nx, nx)."""
    out = np.zeros((nx, nx))
    for b, block in blocks:
        np.add.at(out, (b.x[:, None, :], b.x[None, :, :]), block)
    return out


def geometric_stiffness(sweep: ElementSweep, sigma: Array) -> Array:
    """Hs(sigma), (nx, nx)."""
    return scatter(sweep.nx, geometric_blocks(sweep, sigma))


def mass_matrix(sweep: ElementSweep) -> Array:
    """M, (nx, nx), from the entries of the last mass evaluation."""
    M = np.zeros((sweep.nx, sweep.nx))
    np.add.at(M, (sweep.m_rows, sweep.m_columns), sweep.m_entries)
    return M


def inertia_blocks(
    sweep: ElementSweep, v: Array, a: Array
) -> tuple[list[tuple[Batch, Array]], list[tuple[Batch, Array]]]:
    """d(M a + h)/dx and dh/dv per batch of the configuration-dependent families."""
    by_x, by_v = [], []
    for b in sweep.moving:
        dx, dv = b.family.inertia_gradient(configuration_of(sweep, b), v[b.x], a[b.x])
        by_x.append((b, dx))
        by_v.append((b, dv))
    return by_x, by_v


def configuration_of(sweep: ElementSweep, b: Batch) -> object:
    """Configuration of a batch at the sweep's x, also for families without deformations."""
    family: Family = b.family
    return sweep.configured(family, b.index)
