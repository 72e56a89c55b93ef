"""Derivatives of the linearized equations between vectors, along the derivative of the state.

With right and left vectors phi, psi of a simple eigenvalue or load multiplier of the reduced equations,

    dlambda = - psi^T (lambda^2 dM + lambda dC + dK) phi / psi^T (2 lambda M + C) phi      vibration
    dlambda = - psi^T (dK0 + lambda dG0) phi / psi^T G0 phi                                buckling

where the derivatives hold the changes of the elements with the parameter and with the state it moves. For an eigenvalue
that occurs m times phi and psi have m columns and the m derivatives are the eigenvalues of the small pencil of these
brackets (Seyranian, Lund, Olhoff, Structural Optimization 8 (1994) 207-227).

The matrices hold W = d(x)/dq and, in steady motion, Z = d(xd)/ds, Y = d(xdd)/ds and Yv = d(xdd)/d(qd)
(`spacar.linearization.matrices`). All of them solve V X = B on the rows that determine velocities, so with a complex
step in V and B

    V dX = dB - dV X,        B:  0 for W,  -H1(v) W for Z,  -(H1(a) + T(v)) W - 2 H1(v) Z for Y,  -2 H1(v) W for Yv

with real factors (sensitivity.md section 3). Only their products with the vectors are computed.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, wraps

import numpy as np

from spacar.arrays import Array, Index
from spacar.deck.directed import STEP, nothing_lost
from spacar.dynamics.array_evaluator import Dynamics
from spacar.linearization.matrices import Linearization
from spacar.sensitivities.directed_elements import Matrices
from spacar.sensitivities.state_derivatives import StateDerivative
from spacar.sensitivities.user_terms import UserTerms

REPEATED = 1e-6  # relative distance below which eigenvalues count as one: closer ones have no vectors of their own

Brackets = Callable[["PencilDerivatives", Array, Array], list[Array]]


def _between(brackets: Brackets) -> Brackets:
    """Derivatives of brackets between complex vectors, from those with complex steps between their real and imaginary
    parts."""

    @wraps(brackets)
    def derivatives(self: "PencilDerivatives", phi: Array, psi: Array) -> list[Array]:
        with nothing_lost():
            if not (np.iscomplexobj(phi) or np.iscomplexobj(psi)):
                return [b.imag / STEP for b in brackets(self, phi, psi)]
            found = brackets(self, np.hstack((phi.real, phi.imag)), np.hstack((psi.real, psi.imag)))
            one = np.eye(phi.shape[1])
            both = np.vstack((one, 1j * one))
            return [both.T @ (b.imag / STEP) @ both for b in found]

    return derivatives


@dataclass(frozen=True)
class PencilDerivatives:
    """Of the linearized equations L of a state along one direction; `moving`: in steady motion."""

    dynamics: Dynamics
    L: Linearization
    state: StateDerivative
    moving: bool

    @cached_property
    def user(self) -> UserTerms | None:
        """Those of a function of the user, if there is one."""
        known = self.L.c.user
        return None if known is None else UserTerms(self.dynamics, known, self.state)

    def moved(self, phi: Array) -> Array:
        """dW phi (nx, m)."""
        with nothing_lost():
            return self._solved(self.L.W, phi).imag / STEP

    @_between
    def vibration(self, phi: Array, psi: Array) -> list[Array]:
        """psi^T dM phi, psi^T dC phi, psi^T dK phi, (m, m) each, with phi, psi (n, m)."""
        L, (mass, damping, flow, Me, tangent) = self.L, self._of_vibration
        u, w = self._solved(L.W, phi), self._solved(L.W, psi)
        ue, we = self._strained(u), self._strained(w)
        M = forms(mass, w, u) + forms(Me, we, ue)
        C = forms(flow, w, u) + forms(damping, we, ue)
        K = forms(tangent, w, u) + forms(self.state.elements.stiffness(), we, ue)
        z, ze = 0.0 * u, 0.0 * ue
        if self.moving:
            H1, of_accelerations = self._of_motion
            ne = len(ue)
            turned = product(H1, u, ne)
            z = self._solved(L.Z, phi, -turned)
            convected, swept = product(of_accelerations, u, ne) + 2.0 * product(H1, z, ne), 2.0 * turned
            y, yv = self._solved(L.Y, phi, -convected), self._solved(L.Yv, phi, -swept)
            ze, ye, yve = self._strained(z) + turned, self._strained(y) + convected, self._strained(yv) + swept
            C = C + forms(mass, w, yv) + forms(Me, we, yve)
            K = K + forms(mass, w, y) + forms(flow, w, z) + forms(damping, we, ze) + forms(Me, we, ye)
        if self.user is not None:
            C = C + self.user.form((we, w), (0.0 * ue, 0.0 * u, ue, u))
            K = K + self.user.form((we, w), (ue, u, ze, z))
        return [M, C, K]

    @_between
    def buckling(self, phi: Array, psi: Array) -> list[Array]:
        """psi^T dK0 phi, psi^T dG0 phi, (m, m) each; behind the n rows those of the unknowns inside elements
        (`spacar.linear.internal_unknowns`)."""
        state, n = self.state, len(self.dynamics.numbering.dynamic)
        (phi, inner), (psi, inner_left) = np.split(phi, [n]), np.split(psi, [n])
        u, w = self._solved(self.L.W, phi), self._solved(self.L.W, psi)
        weight = state.elements.loading(False, state.v, state.a)
        ue, we = self._strained(u), self._strained(w)
        K0 = forms(self.state.elements.stiffness(), we, ue)
        G0 = forms([*self._geometric, *weight], w, u)
        if self.user is not None:
            turned = product(self._of_motion[0], u, len(ue)) if self.moving else 0.0 * ue
            springs = self.user.springs(w, u)
            K0 = K0 + self.user.form((we, 0.0 * w), (ue, u, 0.0 * ue, 0.0 * u)) + springs
            G0 = G0 + self.user.form((0.0 * we, w), (ue, u, turned, 0.0 * u)) - springs
        at = 0
        for rows, coupling, k, eliminated in state.elements.internal(state.sigma):
            right, left = (np.einsum("bnm,bn->nm", v[rows], coupling) for v in (u, w))
            a, b = (v[at : at + len(k)] for v in (inner, inner_left))
            K0 = K0 + b.T @ (k[:, None] * a)
            G0 = G0 + left.T @ ((eliminated / k)[:, None] * right + a) + b.T @ right
            at += len(k)
        return [K0, G0]

    def _solved(self, X: Array, phi: Array, B: Array | float = 0.0) -> Array:
        """X phi with its derivative, V X phi = B."""
        found = X[:, self.dynamics.numbering.dynamic] @ phi
        missing = np.imag(B - self._strained(found))
        return found + 1j * self.dynamics.kinematics.dependent(np.zeros(found.shape), missing)

    def _strained(self, u: Array) -> Array:
        """V u (ne, m)."""
        return product(self.state.elements.gradient(), u, self.state.elements.ne)

    # -- element matrices ----------------------------------------------------------------------------------------
    @cached_property
    def _geometric(self) -> Matrices:
        return self.state.elements.second("geometric_stiffness", self.state.sigma)

    @cached_property
    def _of_vibration(self) -> tuple[Matrices, ...]:
        """Mass, S_d, dh/dv, M_e, and Hs with all loading."""
        s, e = self.state, self.state.elements
        flow = e.inertia_gradient(s.v, s.a, gravity=False)[1]
        return e.mass(), e.damping(), flow, e.deformation_mass(), [*self._geometric, *e.loading(True, s.v, s.a)]

    @cached_property
    def _of_motion(self) -> tuple[Matrices, Matrices]:
        """H1(v), and H1(a) + T(v)."""
        s, e = self.state, self.state.elements
        of_v = e.second("gradient_rate", s.v)
        return of_v, [*e.second("gradient_rate", s.a), *e.second("rate_gradient", s.v)]


def product(blocks: Matrices, right: Array, rows: int) -> Array:
    """Sum of block right, (rows, m)."""
    out = np.zeros((rows, right.shape[1]), complex)
    for block in blocks:
        np.add.at(out, block.rows, block.times(right))
    return out


def forms(blocks: Matrices, left: Array, right: Array) -> Array:
    """Sum of left^T block right, (k, m)."""
    out = np.zeros((left.shape[1], right.shape[1]), complex)
    for block in blocks:
        out += np.einsum("ank,anm->km", left[block.rows], block.times(right))
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
