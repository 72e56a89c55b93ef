"""Derivatives of eigenvalues, load multipliers and compliances along the derivative of the state.

With all coordinates and stresses as unknowns the eigenproblems of the linearized equations at rest are

    A(lambda) u + V_c^T tau_c = 0,    V_c u = 0,       c: fixed and prescribed deformations
    A = lambda^2 (M + V^T M_e V) + lambda (V_a^T S_d V_a + F) + V_a^T S V_a + Hs(sigma) + L       vibration
    A = V_a^T S V_a + lambda (Hs(sigma) + L)                                                      buckling

a: the other deformations; L, F: gradients of loads and of the fluid in tubes. Nothing in them depends on the choice of
degrees of freedom, and no transfer function has to be differentiated. For a simple eigenvalue with the right and left
vectors u = W phi, w = W psi of the pencil, tau, rho their stresses (sensitivity.md section 3),

    dlambda = - [w^T dA u + rho^T dV u + (dV w)^T tau] / (w^T A' u),     A' = dA/dlambda

where dA holds the changes of S, Hs, L, M with the parameter and with the state it moves. For an eigenvalue that occurs
m times u and w have m columns and the m derivatives are the eigenvalues of the small pencil of these brackets
(Seyranian, Lund, Olhoff, Structural Optimization 8 (1994) 207-227). Compliances c = w^T f of unit forces f:
dc = -[w^T dA u ...].
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import Array, Index
from spacar.deck.directed import STEP, nothing_lost
from spacar.dynamics.array_evaluator import Dynamics
from spacar.linear_systems.linear_system import Matrix, matrix
from spacar.linearization.matrices import Linearization
from spacar.sensitivities.directed_elements import ElementMatrices
from spacar.sensitivities.state_derivatives import StateDerivative

REPEATED = 1e-6  # relative distance below which eigenvalues count as one: closer ones have no vectors of their own


@dataclass(frozen=True)
class PencilMode:
    """Right and left vectors u, w (nx, m) of an eigenvalue, their constitutive and constraint stresses tau, rho
    (ne, m)."""

    u: Array
    w: Array
    tau: Array
    rho: Array


class LinearizedState:
    """The linearized equations at a stored state at rest, and vectors in all coordinates."""

    def __init__(self, dynamics: Dynamics, L: Linearization) -> None:
        self.dynamics, self.L = dynamics, L
        n = dynamics.numbering
        self.dynamic = n.dynamic
        self.first = n.e_class["input"].stop
        self.block = np.ix_(self.dynamic, self.dynamic)
        self.W = L.W[:, self.dynamic]
        self.Me = matrix(*dynamics.mechanism.deformation_inertia, (n.ne, n.ne))

    @cached_property
    def tangent(self) -> Matrix:
        """Hs + L (nx, nx)."""
        return self.L.inertia_x + self.L.load_x

    @property
    def stiffness(self) -> Array:
        """K of the dynamic degrees of freedom."""
        return np.asarray(self.L.stiffness[self.block])

    def mode(self, phi: Array, psi: Array, force: Matrix, law: Matrix, load: Array | None = None) -> PencilMode:
        """The mode of reduced vectors phi, psi (nq, m).

        force (nx, nx) is A without its terms of deformations, law (ne, ne) those; load (nx, m): the unit forces.
        """
        u, w = self.W @ phi, self.W @ psi
        return PencilMode(u, w, self._stresses(force @ u, law @ (self.L.V @ u), load),
                    self._stresses(force.T @ w, law.T @ (self.L.V @ w), load))  # fmt: skip

    def _stresses(self, force: Array, tau: Array, load: Array | None) -> Array:
        """tau (ne, m) with the multipliers of the constraints in its first rows."""
        if load is not None:
            force = force - load
        out = tau.copy()
        for k in range(tau.shape[1]):
            parts = [self._reactions(f, s) for f, s in _parts(force[:, k], tau[:, k])]
            whole = parts[0] if len(parts) == 1 else parts[0] + 1j * parts[1]
            out[: self.first, k] += whole[: self.first]
        return out

    def _reactions(self, force: Array, tau: Array) -> Array:
        """Multipliers beside the stresses tau; those of the dynamic rows, whose stresses are known, vanish."""
        sigma = np.zeros_like(tau)
        self.dynamics.kinematics.reactions(force + self.L.V.T @ tau, sigma)
        return sigma


def _parts(force: Array, tau: Array) -> list[tuple[Array, Array]]:
    if np.iscomplexobj(force) or np.iscomplexobj(tau):
        return [(np.real(force), np.real(tau)), (np.imag(force), np.imag(tau))]
    return [(force, tau)]


@dataclass(frozen=True)
class Change:
    """The change of all element matrices along one direction, at a state; `form(mode, ...)` gives brackets (m, m)."""

    state: StateDerivative
    first: int

    @cached_property
    def gradient(self) -> list[ElementMatrices]:
        return _rates(self.state.elements.gradient())

    @cached_property
    def stiffness(self) -> list[ElementMatrices]:
        return _rates(self.state.elements.stiffness(self.first))

    @cached_property
    def damping(self) -> list[ElementMatrices]:
        return _rates(self.state.elements.damping(self.first))

    @cached_property
    def geometric(self) -> list[ElementMatrices]:
        return _rates(self.state.elements.geometric(self.state.sigma))

    @cached_property
    def loading(self) -> list[ElementMatrices]:
        return _rates(self.state.elements.loading(flow=True))

    @cached_property
    def weight(self) -> list[ElementMatrices]:
        """Loading without the fluid in tubes: what load multipliers multiply."""
        return _rates(self.state.elements.loading(flow=False))

    @cached_property
    def flow(self) -> list[ElementMatrices]:
        return _rates(self.state.elements.flow())

    @cached_property
    def mass(self) -> list[ElementMatrices]:
        return _rates(self.state.elements.mass())

    @cached_property
    def deformation_mass(self) -> list[ElementMatrices]:
        return _rates(self.state.elements.deformation_mass())

    @cached_property
    def internal(self) -> tuple[Array, Array, Array, NDArray[np.bool_]]:
        """Couplings c (nx, m), their derivatives, stiffnesses k with their derivatives (2, m), which are eliminated."""
        with nothing_lost():
            parts = self.state.elements.internal(self.state.sigma)
        nx = self.state.elements.nx
        c = [np.zeros((nx, 0), complex)]
        k: list[Array] = [np.zeros(0, complex)]
        eliminated: list[Array] = [np.zeros(0, bool)]
        for places, coupling, stiffness, out in parts:
            block = np.zeros((nx, coupling.shape[1]), complex)
            np.add.at(block, (places, np.arange(coupling.shape[1])), coupling)
            c, k, eliminated = [*c, block], [*k, stiffness + 0j], [*eliminated, out]
        coupling, stiffness = np.concatenate(c, axis=1), np.concatenate(k)
        both = np.stack((stiffness.real, stiffness.imag / STEP))
        return coupling.real, coupling.imag / STEP, both, np.concatenate(eliminated)

    def strained(self, mode: PencilMode) -> Array:
        """rho^T dV u + (dV w)^T tau."""
        return forms(self.gradient, mode.rho, mode.u) + forms(self.gradient, mode.tau, mode.w).T

    def vibration(self, mode: PencilMode, V: Array, value: complex | float, squared: bool) -> Array:
        """The bracket for lambda, or for lambda^2 = -`value` without damping (`squared`)."""
        e_w, e_u = V @ mode.w, V @ mode.u
        out = self.strained(mode) + forms(self.stiffness, e_w, e_u)
        out = out + forms(self.geometric, mode.w, mode.u) + forms(self.loading, mode.w, mode.u)
        square = -value if squared else value * value
        out = out + square * (forms(self.mass, mode.w, mode.u) + forms(self.deformation_mass, e_w, e_u))
        if not squared:
            out = out + value * (forms(self.damping, e_w, e_u) + forms(self.flow, mode.w, mode.u))
        return np.asarray(out)

    def compliance(self, mode: PencilMode, V: Array) -> Array:
        """Minus the derivatives of compliances on the diagonal."""
        out = self.strained(mode) + forms(self.stiffness, V @ mode.w, V @ mode.u)
        return np.asarray(out + forms(self.geometric, mode.w, mode.u) + forms(self.loading, mode.w, mode.u))

    def buckling(self, mode: PencilMode, V: Array, value: float, inner: Array, inner_left: Array) -> Array:
        """The bracket of a load multiplier; inner, inner_left (unknowns inside elements, m)."""
        out = self.strained(mode) + forms(self.stiffness, V @ mode.w, V @ mode.u)
        out = out + value * (forms(self.geometric, mode.w, mode.u) + forms(self.weight, mode.w, mode.u))
        c, dc, (k, dk), eliminated = self.internal
        if len(k):
            cu, cw, du, dw = c.T @ mode.u, c.T @ mode.w, dc.T @ mode.u, dc.T @ mode.w
            part = (eliminated / k)[:, None]
            again = cw.T @ (part * du) + dw.T @ (part * cu) - cw.T @ (part * (dk / k)[:, None] * cu)
            out = out + value * (again + dw.T @ inner + inner_left.T @ du) + inner_left.T @ (dk[:, None] * inner)
        return np.asarray(out)


def _rates(blocks: list[ElementMatrices]) -> list[ElementMatrices]:
    return [b for block in blocks if (b := block.rate).values.any()]


def forms(blocks: list[ElementMatrices], left: Array, right: Array) -> Array:
    """Sum of left^T block right, (k, m)."""
    out: Array = np.zeros((left.shape[1], right.shape[1]))
    for block in blocks:
        out = out + block.form(left, right)
    return out


def null_vectors(Q: Array, size: Array, count: int) -> tuple[Array, Array]:
    """Right and left vectors (n, count) of the smallest singular values of Q, rows and columns divided by the root of
    `size` (n,)."""
    d = 1.0 / np.sqrt(np.where(size > 0.0, size, size.max(initial=0.0) or 1.0))
    left, _, right = np.linalg.svd(Q * np.outer(d, d))
    return d[:, None] * right[-count:].conj().T, d[:, None] * left[:, -count:].conj()


def together(values: Array, index: int) -> Index:
    """Places of the values that are the one at `index` to REPEATED."""
    return np.flatnonzero(np.abs(values - values[index]) <= REPEATED * np.abs(values[index]))
