"""Geometric transfer functions (theory-system.md 1.3).

Velocity transfer W (nx, ndof): xd = W qd, from one factorization and ndof right-hand sides (5). Configuration
transfer G (nx, nkdof): dx = G ds; equal to W for holonomic systems, else from the position matrix with unit rows for
the kinematic coordinates. Second order tensors (6) are formed only for OUTLEVEL, in `second_order_transfer`.
"""

from __future__ import annotations

import numpy as np

from spacar.arrays import Array
from spacar.kinematics.kinematics import Kinematics
from spacar.linear_systems.matrix import Matrix


def velocity_transfer(k: Kinematics) -> Array:
    """W, (nx, ndof), columns in the order of q."""
    n = k.numbering
    given, rate = np.zeros((n.nx, n.ndof)), np.zeros((n.ne, n.ndof))
    nx = len(n.q_x)
    given[n.q_x, np.arange(nx)] = 1.0
    rate[n.q_e, nx + np.arange(len(n.q_e))] = 1.0
    return k.dependent(given, rate)


def deformation_transfer(k: Kinematics, W: Array, V: Matrix) -> Array:
    """We, (ne, ndof): V W, of which the rows E are given: unit rows for the degrees of freedom, else zero."""
    n = k.numbering
    We = np.zeros((n.ne, n.ndof))
    We[n.q_e, len(n.q_x) + np.arange(len(n.q_e))] = 1.0
    given = np.zeros(n.ne, bool)
    given[k.E] = True
    others = np.flatnonzero(~given)
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
    G[k.c] = k.position_system.solve(rate[k.h] - k.sweep_rates(G)[k.h])
    slips = np.flatnonzero(n.slips[e_units])
    G[:, e_columns[slips]] = 0.0  # a slip is no configuration
    return G
