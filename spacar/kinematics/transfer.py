"""Geometric transfer functions (theory-system.md 1.3).

Velocity transfer W (nx, ndof): xd = W qd, from one factorization and ndof right-hand sides (5). Configuration
transfer G (nx, nkdof): dx = G ds; equal to W for holonomic systems, else from the position matrix with unit rows for
the kinematic coordinates. Full tensors of second order, for OUTLEVEL only (6), and of third order, for the log only:

    D2F_x[:,a,b] = solveU(-H(G_a, G_b)),     D2F_e[:,a,b] = H(G_a, G_b) + V D2F_x[:,a,b]
    D3F_x[:,a,b,c] = solveU(-B_abc),    D3F_e[:,a,b,c] = B_abc + V D3F_x[:,a,b,c]
    B_abc = D3D(G_a, G_b, G_c) + H(F_ab, G_c) + H(F_bc, G_a) + H(F_ca, G_b),    F_ab = D2F_x[:,a,b]

The element families give T(v)[e,j] = D3D(v, v, unit_j); polarization gives D3D(u, v, .) = (T(u+v) - T(u-v))/4.
`TransferOutput` puts into frames what OUTLEVEL asks of them (input-language.md note k8).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from spacar.arrays import Array
from spacar.frame import Frame
from spacar.kinematics.element_sweep import geometric_blocks, gradient_blocks
from spacar.kinematics.kinematics import Kinematics
from spacar.linear_systems.linear_system import Matrix

if TYPE_CHECKING:
    from spacar.stream import Run


def velocity_transfer(k: Kinematics) -> Array:
    """W, (nx, ndof), columns in the order of q."""
    n = k.numbering
    given, rate = np.zeros((n.nx, n.ndof)), np.zeros((n.ne, n.ndof))
    nx = len(n.q_x)
    given[n.q_x, np.arange(nx)] = 1.0
    rate[n.q_e, np.arange(nx, n.ndof)] = 1.0
    return k.dependent(given, rate)


def deformation_transfer(k: Kinematics, W: Array, V: Matrix) -> Array:
    """We, (ne, ndof): V W, of which the rows E are given: unit rows for the degrees of freedom, else zero."""
    n = k.numbering
    We = np.zeros((n.ne, n.ndof))
    We[n.q_e, np.arange(len(n.q_x), n.ndof)] = 1.0
    others = np.delete(np.arange(n.ne), k.E)
    if len(others):
        We[others] = V[others] @ W
    return We


def moved_along(k: Kinematics, force: Array) -> Array:
    """W^T force (ndof,) of forces (nx,) without forming W: the stresses that hold the coordinates against them do the
    work of the degrees of freedom (theory-system.md (10))."""
    n = k.numbering
    sigma = np.zeros(n.ne)
    k.reactions(-force, sigma)
    return np.concatenate(((force - k.sweep.rate_transposed(sigma))[n.q_x], sigma[n.q_e]))


def configuration_transfer(k: Kinematics, W: Array | None = None) -> Array:
    """G, (nx, nkdof), columns q then kinematic coordinates, kinematic deformations."""
    n = k.numbering
    if k.velocity_map_is_position_map:
        return velocity_transfer(k) if W is None else W
    xs, es = n.x_class, n.e_class
    x_units = np.r_[n.q_x, xs["kinematic"].start : xs["kinematic"].stop]
    e_units = np.r_[n.q_e, es["kinematic"].start : es["kinematic"].stop]
    nx, nk = len(n.q_x), int(n.nxp[4])
    x_columns = np.r_[0:nx, n.ndof : n.ndof + nk]
    e_columns = np.r_[nx : n.ndof, n.ndof + nk : n.nkdof]
    G, rate = np.zeros((n.nx, n.nkdof)), np.zeros((n.ne, n.nkdof))
    G[x_units, x_columns] = 1.0
    rate[e_units, e_columns] = 1.0
    G[k.c] = k.position_system.solve((rate - k.sweep_rates(G))[k.h])
    G[:, rate[n.slips].any(axis=0)] = 0.0  # a slip is no configuration
    return G


def second_order_transfer(k: Kinematics, G: Array) -> tuple[Array, Array]:
    """d2x (nx, nkdof, nkdof) and d2e (ne, nkdof, nkdof) at the present configuration; nan where G is (a dead point)."""
    return _completed(k, G, np.einsum("eij,ia,jb->eab", gradient_tensor(k), G, G, optimize=True))


def _completed(k: Kinematics, G: Array, curved: Array) -> tuple[Array, Array]:
    """Derivatives (nx, n, ...) and (ne, n, ...) from what e has of lower ones, `curved`; nan where G is (a dead
    point)."""
    n, m, size = len(curved), k.numbering.nx, curved.shape[1:]
    flat = curved.reshape(n, G.shape[1] ** len(size))
    dx = np.zeros((m, flat.shape[1]))
    if np.isnan(G).any():
        flat, dx = np.full_like(flat, np.nan), np.full_like(dx, np.nan)
    else:
        dx[k.c] = k.position_system.solve(-flat[k.h])
        flat = flat + k.sweep_rates(dx)
    return dx.reshape(m, *size), flat.reshape(n, *size)


def gradient_tensor(k: Kinematics) -> Array:
    """H as a full (ne, nx, nx) array; only for output, from unit stresses."""
    sweep = k.sweep
    H = np.zeros((sweep.ne, sweep.nx, sweep.nx))
    for row in range(max((len(b.e) for b in sweep.curved), default=0)):
        sigma = np.zeros(sweep.ne)
        for b in sweep.curved:
            sigma[b.e[row : row + 1]] = 1.0
        for b, block in geometric_blocks(sweep, sigma):
            if row < len(b.e):
                np.add.at(H, (b.e[row], b.x[:, None], b.x[None]), block)
    return H


def third_order_transfer(k: Kinematics, G: Array, d2x: Array) -> tuple[Array, Array]:
    """d3x (nx, n, n, n) and d3e (ne, n, n, n) from G (nx, n) and d2x (nx, n, n) at the present configuration, as
    above."""
    n, H = G.shape[1], gradient_tensor(k)
    HG = np.einsum("eij,jc->eic", H, G)  # H is symmetric in i, j for holonomic rows
    mixed = np.einsum("eic,iab->eabc", HG, d2x, optimize=True)
    bracket = mixed + mixed.transpose(0, 3, 1, 2) + mixed.transpose(0, 2, 3, 1)
    for a in range(n):
        for b in range(a, n):
            third = (_rate_gradient(k, G[:, a] + G[:, b]) - _rate_gradient(k, G[:, a] - G[:, b])) / 4.0 @ G
            bracket[:, a, b] += third
            if b != a:
                bracket[:, b, a] += third
    return _completed(k, G, bracket)


def _rate_gradient(k: Kinematics, v: Array) -> Array:
    out, at = np.zeros((k.numbering.ne, k.numbering.nx)), k.sweep.configuration
    for b, block in gradient_blocks(k.sweep, lambda b, out: b.family.rate_gradient(at[b.index], v[b.x], out)):
        out[b.e[:, None, :], b.x[None, :, :]] = block
    return out


FIRST, SECOND = 1, 2  # flags of the sbd level, and of the log level, which has more:
THIRD, GLOBAL_DEFORMATION = 4, 8
LARGEST_THIRD = 10_000_000  # numbers of a third order tensor; larger ones are refused


class Transfer(NamedTuple):
    """Transfer functions of the degrees of freedom, (nx, n) and (ne, n): W and We of rates, G and Ge of the
    configuration."""

    W: Array
    We: Array
    G: Array
    Ge: Array

    @classmethod
    def of(cls, k: Kinematics) -> Transfer:
        """Those of the present configuration."""
        W = velocity_transfer(k)
        G = configuration_transfer(k, W)
        We = k.sweep_rates(W)
        return cls(W, We, G, We if G is W else k.sweep_rates(G))


class TransferOutput:
    """Adds dx, de (flag 1) and d2x, d2e (flag 2) to frames; stationary modes have flag 1 by default.

    What only the log asks for goes to `frame.log`: dx de d2x d2e d3x d3e bigd. Tensors have a row for every coordinate
    or deformation and a column for every combination of degrees of freedom, the first index running fastest.
    """

    def __init__(self, run: Run) -> None:
        settings = run.mechanism.settings
        level = settings.sbd_level
        if level is None:
            level = FIRST if run.mode.stationary else 0
        self.level = FIRST | SECOND if level < 0 else level
        self.log = 15 if settings.log_level < 0 else settings.log_level
        n = run.mechanism.numbering
        if self.log & THIRD and max(n.nx, n.ne) * n.nkdof**3 > LARGEST_THIRD:
            self.log &= ~THIRD
            run.report.add(
                f"the third order transfer functions of {n.nkdof} degrees of freedom would have {n.nx * n.nkdof**3:,}"
                " numbers: they are left out"
            )

    @property
    def wanted(self) -> bool:
        return bool(self.level or self.log & (FIRST | SECOND | THIRD | GLOBAL_DEFORMATION))

    def add(self, frame: Frame, k: Kinematics, known: Transfer | None = None) -> Frame:
        """The same frame with the transfer functions of the present configuration; `known` of a linearization there."""
        if self.log & GLOBAL_DEFORMATION:
            frame.log["bigd"] = k.sweep.gradient()
        if not self.level and not self.log & (FIRST | SECOND | THIRD):
            return frame
        W, We, G, Ge = known or Transfer.of(k)
        if (self.level | self.log) & FIRST:
            frame.log["dx"], frame.log["de"] = G, Ge
        if self.level & FIRST:
            frame.dx, frame.de, frame.dxc, frame.dec = G, Ge, W, Ge if G is W else We
        if self.level & SECOND or self.log & (SECOND | THIRD):
            d2x, d2e = second_order_transfer(k, G)
            flat = [A.reshape(len(A), -1, order="F") for A in (d2x, d2e)]
            if self.level & SECOND:
                frame.d2x, frame.d2e = flat
            if self.log & SECOND:
                frame.log["d2x"], frame.log["d2e"] = flat
            if self.log & THIRD:
                d3 = third_order_transfer(k, G, d2x)
                frame.log["d3x"], frame.log["d3e"] = (A.reshape(len(A), -1, order="F") for A in d3)
        return frame
