"""Contractions of the second and third derivatives and of the inertia terms, assembled over all families.

Every function returns a `spacar.linear_systems.matrix`: dense for a small model, sparse for a large one.
Notation of theory-system.md section 0.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from spacar.arrays import Array, Index
from spacar.elements.family import Family
from spacar.kinematics.element_sweep import ElementSweep
from spacar.linear_systems.matrix import Matrix, matrix, zero_matrix
from spacar.mechanism.layout import Batch

NOWHERE: Index = np.zeros(0, np.int64)


def _by_rows(sweep: ElementSweep, fill: Callable[[Batch, Array], None]) -> Matrix:
    """Sum of element blocks (n_deformations, n_coordinates, n) as (ne, nx)."""
    rows, columns, values = [NOWHERE], [NOWHERE], [np.zeros(0)]
    for batch in sweep.curved:
        block = np.zeros((len(batch.e), len(batch.x), batch.family.n))
        fill(batch, block)
        rows.append(np.broadcast_to(batch.e[:, None, :], block.shape).ravel())
        columns.append(np.broadcast_to(batch.x[None, :, :], block.shape).ravel())
        values.append(block.ravel())
    return matrix(np.concatenate(rows), np.concatenate(columns), np.concatenate(values), (sweep.ne, sweep.nx))


def block_pattern(sweep: ElementSweep) -> Matrix:
    """Positive numbers where H1, H2 and T may have entries, (ne, nx)."""
    return _by_rows(sweep, lambda b, out: out.fill(1.0))


def gradient_rate(sweep: ElementSweep, v: Array) -> Matrix:
    """H1(v), (ne, nx)."""
    return _by_rows(sweep, lambda b, out: b.family.gradient_rate(sweep.configuration[b.index], v[b.x], out))


def gradient_transport(sweep: ElementSweep, v: Array) -> Matrix:
    """H2(v), (ne, nx)."""
    return _by_rows(sweep, lambda b, out: b.family.gradient_transport(sweep.configuration[b.index], v[b.x], out))


def rate_gradient(sweep: ElementSweep, v: Array) -> Matrix:
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


def scatter(nx: int, blocks: list[tuple[Batch, Array]]) -> Matrix:
    """Sum of square element blocks as (nx, nx)."""
    if not blocks:
        return zero_matrix((nx, nx))
    rows = [np.broadcast_to(b.x[:, None, :], block.shape).ravel() for b, block in blocks]
    columns = [np.broadcast_to(b.x[None, :, :], block.shape).ravel() for b, block in blocks]
    values = np.concatenate([block.ravel() for _, block in blocks])
    return matrix(np.concatenate(rows), np.concatenate(columns), values, (nx, nx))


def geometric_stiffness(sweep: ElementSweep, sigma: Array) -> Matrix:
    """Hs(sigma), (nx, nx)."""
    if not sigma.any():
        return zero_matrix((sweep.nx, sweep.nx))
    return scatter(sweep.nx, geometric_blocks(sweep, sigma))


def geometric_rounding(sweep: ElementSweep, sigma: Array, scale: Array, W: Array) -> Array:
    """What rounding can make of W^T Hs(sigma) W for the motions W (nx, n), (n, n).

    An element knows its Hs to 8 eps of its largest entry, with coordinates in their sizes `scale` (nx,); motions along
    which the others cancel (a bar along its axis) leave nothing but that.
    """
    n = W.shape[1]
    out, moved = np.zeros((n, n)), np.abs(W) / scale[:, None]
    for b, block in geometric_blocks(sweep, sigma):
        size = scale[b.x]
        largest = np.abs(block * size[:, None] * size).max(axis=(0, 1))
        most = moved[b.x].max(axis=0)
        out += (most * largest[:, None]).T @ most
    return np.asarray(8.0 * np.finfo(float).eps * out)


def mass_matrix(sweep: ElementSweep) -> Matrix:
    """M, (nx, nx), from the entries of the last mass evaluation."""
    return matrix(sweep.m_rows, sweep.m_columns, sweep.m_entries, (sweep.nx, sweep.nx))


def gradient_matrix(sweep: ElementSweep) -> Matrix:
    """V, (ne, nx), at the present configuration."""
    return matrix(sweep.v_rows, sweep.v_columns, sweep.v_entries, (sweep.ne, sweep.nx))


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
