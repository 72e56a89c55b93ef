"""Derivatives of the reduced matrices of the linearized equations, in steady motion and at rest.

In steady motion the matrices hold Z = d(xd)/ds, Y = d(xdd)/ds and Yv = d(xdd)/d(qd) (`spacar.linearization.matrices`).
Like W they solve V X = B on the rows that determine velocities, so with a complex step in V and B

    V dX = dB - dV X,        B:  0 for W,  -H1(v) W for Z,  -(H1(a) + T(v)) W - 2 H1(v) Z for Y,  -2 H1(v) W for Yv

with real factors (sensitivity.md section 3). The matrices follow from the complex X, and with right and left vectors

    dlambda = - psi^T (lambda^2 dM + lambda dC + dK) phi / psi^T (2 lambda M + C) phi.

At rest this is a second way to what `pencil_derivatives` gives.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from spacar.arrays import Array, Index
from spacar.deck.directed import STEP, nothing_lost
from spacar.linear.internal_unknowns import bordered_pencil
from spacar.sensitivities.directed_elements import ElementMatrices
from spacar.sensitivities.pencil_derivatives import LinearizedState
from spacar.sensitivities.state_derivatives import StateDerivative


@dataclass(frozen=True)
class ReducedDerivatives:
    """Derivatives of m0, damping, stiffness over the dynamic degrees of freedom (n, n), of K0, G0 of the load
    multipliers with the unknowns inside elements (`spacar.linear.internal_unknowns`), and of W (nx, n)."""

    M: Array
    C: Array
    K: Array
    K0: Array
    G0: Array
    W: Array


def reduced_derivatives(at: LinearizedState, state: StateDerivative) -> ReducedDerivatives:
    """Along the direction of `state`."""
    L, e, k = at.L, state.elements, at.dynamics.kinematics
    nx, ne, q = e.nx, e.ne, at.dynamic
    with nothing_lost():
        V = _dense(e.gradient(), ne, nx)
        H1 = _dense(e.gradient_rate(state.v), ne, nx)
        along = _dense(e.gradient_rate(state.a), ne, nx) + _dense(e.rate_gradient(state.v), ne, nx)
        M, Me = _dense(e.mass(), nx, nx), _dense(e.deformation_mass(), ne, ne)
        S, Sd = _dense(e.stiffness(at.first), ne, ne), _dense(e.damping(at.first), ne, ne)
        inertia, velocity = e.inertia_gradient(state.v, state.a, gravity=False)
        weight = _dense(e.loading(flow=False, v=state.v, a=state.a), nx, nx)
        I, h = _dense(inertia, nx, nx), _dense(velocity, nx, nx)
        Hs = _dense(e.geometric(state.sigma), nx, nx)

        def solved(X: Array, B: Array) -> Array:
            return X + 1j * k.dependent(np.zeros(X.shape), (B - V @ X).imag)

        W = solved(L.W[:, q], np.zeros((ne, len(q)), complex))
        Z = solved(L.Z[:, q], -H1 @ W)
        convected, swept = along @ W + 2.0 * H1 @ Z, 2.0 * H1 @ W
        Y, Yv = solved(L.Y[:, q], -convected), solved(L.Yv[:, q], -swept)
        We, Ze, Ye, Yev = V @ W, V @ Z + H1 @ W, V @ Y + convected, V @ Yv + swept
        m0 = W.T @ M @ W + We.T @ Me @ We
        damping = W.T @ (M @ Yv + h @ W) + We.T @ (Me @ Yev + Sd @ We)
        k0, g0 = We.T @ S @ We, W.T @ (Hs + weight) @ W
        n0 = W.T @ (M @ Y + I @ W + h @ Z) + We.T @ (Sd @ Ze + Me @ Ye)
        pencil = _with_internal(k0, g0, W, e.internal(state.sigma))
        return ReducedDerivatives(*(A.imag / STEP for A in (m0, damping, k0 + n0 + g0, *pencil, W)))


def _with_internal(
    k0: Array, g0: Array, W: Array, unknowns: list[tuple[Index, Array, Array, Array]]
) -> tuple[Array, Array]:
    """K0 and G0 bordered by the unknowns inside elements."""
    found = [(np.zeros((W.shape[1], 0)), np.zeros(0), np.zeros(0, bool))]
    for rows, coupling, stiffness, eliminated in unknowns:
        found.append((np.einsum("bnq,bn->qn", W[rows], coupling), stiffness, eliminated))
    couplings, stiffnesses, which = zip(*found, strict=True)
    c, k = np.concatenate(couplings, axis=1), np.concatenate(stiffnesses)
    return bordered_pencil(k0, g0, c, k, np.concatenate(which))


def _dense(parts: list[ElementMatrices], rows: int, columns: int) -> Array:
    out = np.zeros((rows, columns), complex)
    for part in parts:
        np.add.at(out, (part.rows[:, None, :], part.columns[None, :, :]), part.values)
    return out
