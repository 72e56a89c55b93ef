"""Linearized equations M0 δs̈ + C0 δṡ + K0 δq = 0 about a state of rest, with the names of the numeric core.

With position constraints δq = T δq_i, J T = 0, in independent speeds chosen by pivoting. The forces λ stay constant in
the derivatives of f − I a + Jᵀ λ, so that K0 has the part of the curved constraints; Tᵀ takes the change of λ out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from spacar.errors import UsageError
from spacar.symbolic.closure import Manifold
from spacar.symbolic.derivation import DerivedEquations
from spacar.symbolic.program import make_program


@dataclass(frozen=True, eq=False)
class Linearized:
    """M0, C0 (damping and gyroscopic terms), K0 of shape (n, n) in the order of `speeds`."""

    names: tuple[str, ...]
    M0: np.ndarray
    C0: np.ndarray
    K0: np.ndarray

    def eigenvalues(self) -> np.ndarray:
        """Eigenvalues of the state matrix [1/s], sorted by modulus."""
        n = len(self.names)
        A = np.block([[np.zeros((n, n)), np.eye(n)], [np.linalg.solve(self.M0, -np.hstack((self.K0, self.C0)))]])
        values: np.ndarray = np.linalg.eigvals(A)
        return values[np.argsort(abs(values))]


def linearize(eq: DerivedEquations, values: dict[str, float], point: dict[str, float]) -> Linearized:
    """Derivatives of f(q, s) − I(q) a at `point` (states by name, others zero) with a the accelerations there.

    Inputs with a law are differentiated with it. Raises UsageError when the coordinates do not correspond to the
    speeds one to one (q̇ = s), because K0 would not be square.
    """
    if len(eq.coordinates) != len(eq.speeds) or any(
        eq.kinematics[q] != s for q, s in zip(eq.coordinates, eq.speeds, strict=True)
    ):
        raise UsageError("M0, C0, K0 need every speed to be the derivative of its coordinate")
    program = make_program(eq, {})
    f = program.function(values, jacobian=True)
    names = [str(s.func) for s in (*eq.coordinates, *eq.speeds)]
    y = [float(point.get(name, 0.0)) for name in names]
    n = len(eq.speeds)
    upper, _ = f.accel(y, f.inputs(0.0, y))
    M0 = np.zeros((n, n))
    M0[np.triu_indices(n)] = upper
    M0 += np.triu(M0, 1).T
    slopes = -M0 @ np.asarray(f.jac(0.0, y))[n:]
    speeds = tuple(str(s.func) for s in eq.speeds)
    if eq.constraints is None:
        return Linearized(speeds, M0, slopes[:, n:], slopes[:, :n])
    if len(eq.constraints.position) != eq.constraints.count:
        raise UsageError(
            "M0, C0, K0 need constraints of positions: a velocity constraint leaves more coordinates than speeds"
        )
    manifold = Manifold(program, f)
    place = np.array(y)
    if np.max(np.abs(manifold.project(0.0, place) - place)) > 1e-6 * max(np.max(np.abs(place)), 1e-3):
        raise UsageError("the point of linearization does not satisfy the constraints")
    free, T = _independent(f.manifold(0.0, y)[1], M0)
    M, C, K = (T.T @ A @ T for A in (M0, slopes[:, n:], slopes[:, :n]))
    return Linearized(tuple(speeds[k] for k in free), M, C, K)


def _independent(J: np.ndarray, M: np.ndarray) -> tuple[list[int], np.ndarray]:
    """Independent speeds and T with J T = 0, T the unit matrix in them; pivots in mass units."""
    from scipy.linalg import qr

    D = 1 / np.sqrt(np.where(M.diagonal() > 0, M.diagonal(), 1.0))
    m, n = J.shape
    _, _, order = qr(J * D, pivoting=True)
    tied, free = sorted(order[:m].tolist()), sorted(order[m:].tolist())
    T = np.zeros((n, n - m))
    T[free, np.arange(n - m)] = 1.0
    T[tied] = -np.linalg.solve(J[:, tied], J[:, free])
    return free, T
