"""Eigenvalues, load multipliers and compliances of one stored state, with their derivatives along all directions.

Derivatives of the reduced matrices of the linearized equations, in steady motion and at rest.

In steady motion the matrices hold Z = d(xd)/ds, Y = d(xdd)/ds and Yv = d(xdd)/d(qd) (`spacar.linearization.matrices`).
Like W they solve V X = B on the rows that determine velocities, so with a complex step in V and B

    V dX = dB - dV X,        B:  0 for W,  -H1(v) W for Z,  -(H1(a) + T(v)) W - 2 H1(v) Z for Y,  -2 H1(v) W for Yv

with real factors (sensitivity.md section 3). The matrices follow from the complex X, and with right and left vectors

    dlambda = - psi^T (lambda^2 dM + lambda dC + dK) phi / psi^T (2 lambda M + C) phi.

At rest this is a second way to what `pencil_derivatives` gives.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from spacar.arrays import Array, Index
from spacar.deck.directed import STEP, nothing_lost
from spacar.errors import AnalysisError, Report
from spacar.expressions.frequencies import frequency_order
from spacar.linear.buckling import BucklingModes, buckling_modes, directional_compliances
from spacar.linear.eigen import is_symmetric, matters, vibration_modes
from spacar.linear.eigenmodes import Modes, is_zero
from spacar.linear.internal_unknowns import bordered_pencil, buckling_matrices, internal_unknowns
from spacar.linearization.coefficients import geometric_stiffness
from spacar.sensitivities.directed_elements import ElementMatrices
from spacar.sensitivities.pencil_derivatives import Change, LinearizedState, PencilMode, null_vectors, together
from spacar.sensitivities.state_derivatives import StateDerivative


@dataclass
class LinearQuantities:
    """`states`: one for every direction. Each quantity gives its value and its derivatives (directions,)."""

    at: LinearizedState
    states: list[StateDerivative]
    report: Report
    moving: bool = False
    _found: dict[tuple[str, int], list[Array]] = field(default_factory=dict)

    @cached_property
    def _changes(self) -> list[Change]:
        return [Change(s, self.at.first) for s in self.states]

    @cached_property
    def _reduced(self) -> list[ReducedDerivatives]:
        return [reduced_derivatives(self.at, s) for s in self.states]

    # -- vibration -----------------------------------------------------------------------------------------------
    @cached_property
    def _matrices(self) -> tuple[Array, Array, Array]:
        L, block = self.at.L, self.at.block
        return L.m0[block], L.damping[block], L.stiffness[block]

    @cached_property
    def _undamped(self) -> bool:
        M, C, K = self._matrices
        return is_symmetric(K) and is_symmetric(M) and not matters(C, M, K)

    @cached_property
    def _modes(self) -> Modes:
        q = self.at.dynamic
        if not len(q):
            raise AnalysisError("no dynamic degrees of freedom: there are no eigenvalues", "sensitivity.eigenvalues")
        return vibration_modes(self.at.L, q, q, self.report, self.at.dynamics.numbering.twist_rates)

    @property
    def eigenvalues(self) -> Array:
        """(n,) [rad/s], in the order of the results."""
        return np.asarray(self._modes.values)

    def eigenvalue(self, index: int) -> tuple[complex, Array]:
        """Value and derivatives of the eigenvalue at a place (from 0) of the results."""
        values = self.eigenvalues
        group = together(values, index)
        rates = self._eigenvalue_rates(index)
        size = (np.conj(values[index]) * rates).real  # decreasing modulus
        order = np.argsort(-size, axis=1, kind="stable")
        rank = int(np.flatnonzero(group == index)[0])
        return complex(values[index]), np.take_along_axis(rates, order, 1)[:, rank]

    def frequency(self, index: int) -> tuple[float, Array]:
        """Value and derivatives of the natural frequency [Hz] at a place (from 0), counted from low to high."""
        values = self.eigenvalues
        order = frequency_order(values)
        here = int(order[index])
        group = set(together(values, here).tolist())
        rank = [int(j) for j in order if j in group].index(here)
        rates = (np.conj(values[here]) * self._eigenvalue_rates(here)).real / np.abs(values[here])
        return float(np.abs(values[here])) / (2.0 * np.pi), np.sort(rates, axis=1)[:, rank] / (2.0 * np.pi)

    def _eigenvalue_rates(self, index: int) -> Array:
        """Derivatives of the eigenvalues that are equal to this one, (directions, m), in no particular order."""
        values = self.eigenvalues
        key = ("eigenvalue", int(together(values, index)[0]))
        if key in self._found:
            return self._found[key][0]
        M, C, K = self._matrices
        value, group = values[index], together(values, index)
        if is_zero(values)[index]:
            self._say(f"eigenvalue {index + 1} is zero, its derivatives are not defined (nan)")
            self._found[key] = [np.full((len(self.states), 1), complex(np.nan, np.nan))]
            return self._found[key][0]
        L, at = self.at.L, self.at
        Me = at.Me
        if self._undamped and not self.moving:
            square = float((-value * value).real)
            phi = self._modes.vectors[: len(K), group].real
            mode = at.mode(phi, phi, at.tangent - square * L.M, L.S - square * Me)
            weight = phi.T @ M @ phi
            squares = self._rates(lambda c: c.vibration(mode, L.V, square, squared=True), weight, symmetric=True)
            rates = -squares / (2.0 * value)
        else:
            size = np.abs(np.diag(K)) + np.abs(value) ** 2 * np.abs(np.diag(M))
            phi, psi = null_vectors(value**2 * M + value * C + K, size, len(group))
            weight = -psi.T @ (2.0 * value * M + C) @ phi
            if self.moving:
                found = [psi.T @ (value**2 * r.M + value * r.C + r.K) @ phi for r in self._reduced]
                rates = self._eigenvalues_of(found, weight)
            else:
                matrix = value**2 * L.M + value * (L.inertia_v + L.load_v) + at.tangent
                mode = at.mode(phi, psi, matrix, L.S + value * L.Sd + value**2 * Me)
                rates = self._rates(lambda c: c.vibration(mode, L.V, value, squared=False), weight)
        if len(group) > 1:
            self._say(f"eigenvalue {index + 1} occurs {len(group)} times: its derivatives are one-sided")
        self._found[key] = [rates]
        return rates

    def _rates(self, bracket, weight: Array, symmetric: bool = False) -> Array:  # type: ignore[no-untyped-def]
        with nothing_lost():
            return self._eigenvalues_of([bracket(change) for change in self._changes], weight, symmetric)

    def _eigenvalues_of(self, brackets: list[Array], weight: Array, symmetric: bool = False) -> Array:
        """Eigenvalues `rate` of the small pencils bracket - rate weight, (directions, m)."""
        found = []
        for B in brackets:
            if B.shape == (1, 1):
                found.append(B[0] / weight[0])
            elif symmetric:
                lower = np.linalg.cholesky(weight)
                half = np.linalg.solve(lower, np.linalg.solve(lower, B).T)
                found.append(np.linalg.eigvalsh(0.5 * (half + half.T)))
            else:
                found.append(np.linalg.eigvals(np.linalg.solve(weight, B)))
        return np.array(found).reshape(len(self.states), weight.shape[0])

    # -- buckling ------------------------------------------------------------------------------------------------
    @cached_property
    def _pencil(self) -> tuple[Array, Array]:
        return buckling_matrices(self.at.dynamics, self.at.L, self.at.dynamic)

    @cached_property
    def _buckling(self) -> BucklingModes:
        if not len(self.at.dynamic):
            text = "no dynamic degrees of freedom: there are no load multipliers"
            raise AnalysisError(text, "sensitivity.multipliers")
        return buckling_modes(*self._pencil, self.report).first(len(self.at.dynamic))

    @property
    def multipliers(self) -> Array:
        """(n,) in the order of the results."""
        return self._buckling.multipliers

    def multiplier(self, index: int) -> tuple[float, Array]:
        """Value and derivatives of the load multiplier at a place (from 0) of the results."""
        values = self.multipliers
        value = float(values[index])
        if not np.isfinite(value):
            self._say(f"load multiplier {index + 1} is infinite, it has no derivatives (nan)")
            return value, np.full(len(self.states), np.nan)
        group = together(values, index)
        key = ("multiplier", int(group[0]))
        if key not in self._found:
            self._found[key] = [self._multiplier_rates(value, len(group))]
            if len(group) > 1:
                self._say(f"load multiplier {index + 1} occurs {len(group)} times: its derivatives are one-sided")
        rates = np.sort(self._found[key][0], axis=1)
        rank = int(np.flatnonzero(group == index)[0])
        return value, rates[:, rank if value > 0.0 else -1 - rank]

    def _multiplier_rates(self, value: float, count: int) -> Array:
        at, L = self.at, self.at.L
        K0, G0 = self._pencil
        phi, psi = null_vectors(K0 + value * G0, np.abs(np.diag(K0)), count)
        n = len(at.dynamic)
        weight = -psi.T @ G0 @ phi
        if self.moving:
            brackets = [psi.T @ (r.K0 + value * r.G0) @ phi for r in self._reduced]
            return np.real(self._eigenvalues_of(brackets, weight))
        c, k, eliminated = internal_unknowns(at.dynamics, L.sigma)
        weights = geometric_stiffness(at.dynamics.sweep, L.sigma) + L.load_x
        matrix = value * (weights + (c * (eliminated / k)) @ c.T if len(k) else weights)
        mode = at.mode(phi[:n], psi[:n], matrix, L.S, np.zeros((at.dynamics.numbering.nx, count)))
        if len(k):
            right = at.mode(phi[:n], psi[:n], matrix, L.S, -value * (c @ phi[n:]))
            left = at.mode(phi[:n], psi[:n], matrix, L.S, -value * (c @ psi[n:]))
            mode = PencilMode(mode.u, mode.w, right.tau, left.rho)
        rates = self._rates(lambda d: d.buckling(mode, L.V, value, phi[n:], psi[n:]), weight)
        return np.real(rates)

    # -- compliances ---------------------------------------------------------------------------------------------
    @cached_property
    def compliances(self) -> Array:
        """(nx,) as in the results."""
        return directional_compliances(self.at.L, self.at.dynamic, self.report)

    def compliance(self, place: int) -> tuple[float, Array]:
        """Value and derivatives of the compliance of a coordinate (from 0)."""
        value = float(self.compliances[place])
        row = self.at.W[place]
        if not row.any() or not np.isfinite(value):
            return value, np.full(len(self.states), 0.0 if np.isfinite(value) else np.nan)
        K = self.at.stiffness
        phi, psi = np.linalg.solve(K, row)[:, None], np.linalg.solve(K.T, row)[:, None]
        if self.moving:
            found = [r.W[place] @ (phi + psi)[:, 0] - psi[:, 0] @ r.K @ phi[:, 0] for r in self._reduced]
            return value, np.array(found)
        unit = np.zeros((len(self.at.W), 1))
        unit[place] = 1.0
        mode = self.at.mode(phi, psi, self.at.tangent, self.at.L.S, unit)
        with nothing_lost():
            rates = [-c.compliance(mode, self.at.L.V)[0, 0] for c in self._changes]
        return value, np.array(rates)

    def _say(self, text: str) -> None:
        if text not in self.report.lines:
            self.report.add(text)


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
