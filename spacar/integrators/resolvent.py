"""(s I - J)^-1 b of the implicit codes, J = dF/dy, s real or complex.

J is an array, or an object whose `resolvent(s)` has factors of a sparse form of it and gives what is not finite where
s turns out to be an eigenvalue (`spacar.linearization.descriptor`).
With y = (q, u), q' = v, v the last part of u, and b alike, the rows q of an array are eliminated:

    (s I - J_uu - [0, J_uq / s]) w_u = b_u + J_uq b_q / s,      w_q = (b_q + w_v) / s

which is half the size for a mechanism without kinematic coordinates.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from spacar.errors import AnalysisError

Resolvent = Callable[[np.ndarray], np.ndarray]


class DenseResolvent:
    """With the LU factors `lu`, `pivots` of the matrix above; nq (number of q), 0 where nothing is eliminated.

    Raises RuntimeError where s is an eigenvalue of J (n, n).
    """

    def __init__(self, jacobian: np.ndarray, s: complex, nq: int) -> None:
        from scipy.linalg.lapack import dgetrf, dgetrs, zgetrf, zgetrs

        factored, self._solved = (dgetrf, dgetrs) if isinstance(s, float) else (zgetrf, zgetrs)
        self.s, self.nq, self.by_q = s, nq, jacobian[nq:, :nq]
        matrix = -jacobian[nq:, nq:].astype(np.result_type(s), order="F")
        if nq:
            matrix[:, -nq:] -= self.by_q / s
        matrix.flat[:: len(matrix) + 1] += s
        self.lu, self.pivots, info = factored(matrix, overwrite_a=1)
        if info > 0:
            raise RuntimeError("singular")

    def __call__(self, b: np.ndarray) -> np.ndarray:
        nq, s = self.nq, self.s
        out = np.empty(len(b), np.result_type(b, s))
        right = b[nq:] + self.by_q @ (b[:nq] / s) if nq else b
        out[nq:] = self._solved(self.lu, self.pivots, right)[0]
        if nq:
            out[:nq] = (b[:nq] + out[-nq:]) / s
        return out


def resolvent(jacobian: Any, s: complex, nq: int, t: float, h: float) -> Resolvent:
    """b (n,) -> (s I - J)^-1 b in the step h from t. Raises, as what it returns does, AnalysisError
    `integrator.singular` where s is an eigenvalue of J; codes with variable steps try another size then."""

    def singular() -> AnalysisError:
        return AnalysisError(
            f"the iteration matrix of the implicit integrator is singular at t = {t:.9g} s with step size {h:.3g} s"
            " (an unstable mode grows exactly with this step): change the step size (INTEGRAT position 2)",
            "integrator.singular", t=t, step=h,
        )  # fmt: skip

    try:
        if isinstance(jacobian, np.ndarray):
            return DenseResolvent(jacobian, s, nq)
        solve = jacobian.resolvent(s)
    except RuntimeError:
        raise singular() from None

    def finite(b: np.ndarray) -> np.ndarray:
        w: np.ndarray = solve(b)
        if not np.isfinite(w).all():
            raise singular()
        return w

    return finite


def eliminated(n: int, n_positions: int) -> int:
    """The number of q whose rates are the last components of y (n,), 0 where these are less."""
    rates = n - n_positions
    return rates if 2 * rates <= n else 0
