"""C (j omega - A)^-1 B + D of a large model at many frequencies, by few factorizations (theory-system.md 5.7).

About s0 = j omega0 the state z of an input follows from z0, that of s0, and T, the states that (A - s0 E)^-1 gives for
states:

    (I - (s - s0) T) z = z0,      y = y0 + (s - s0) C (A - s0 E)^-1 (z, 0)

In the space that Arnoldi's method builds from T and z0 (E. J. Grimme, Krylov projection methods for model reduction,
thesis, University of Illinois, 1997), z = V c with (I - (s - s0) H) c = |z0| e1 and a residual of |s - s0| h |c_m|, h
the next entry of H. A frequency is answered when the residual is below CONVERGED |z0|, near the rounding of a solution
of its own; the others have the same again, about the middle of those below and of those above omega0. Poles are known
to rounding of T: within some 1e-9 of one that is not damped the response is large, but has no digits.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import EPS, Array, Complex, Index
from spacar.linearization.descriptor import DescriptorSystem

STEPS = 10  # of Arnoldi's method between two looks at the residuals
MOST = 60  # steps about one frequency
CONVERGED = 1e-13  # residual over |z0|


def response(system: DescriptorSystem, omega: Array) -> Complex:
    """(omega, outputs, inputs); infinite where j omega is an eigenvalue. omega [rad/s]."""
    out = np.full((len(omega), system.C.shape[0], system.B.shape[1]), np.inf, complex)
    waiting = [np.argsort(omega)]
    while waiting:
        part = waiting.pop()
        if len(part):
            answered = _about(system, omega, part, out)
            below = np.arange(len(part)) < len(part) // 2
            waiting += [part[below & ~answered], part[~below & ~answered]]
    return out


def _about(system: DescriptorSystem, omega: Array, part: Index, out: Complex) -> NDArray[np.bool_]:
    """Writes the outputs at the frequency in the middle of `part` and at others of them; which are answered."""
    from spacar.linear_systems.sparse_factors import SparseFactors

    middle = part[len(part) // 2]
    answered = part == middle
    out[middle] = np.inf
    right = system.B.toarray().astype(complex)
    s0 = 1j * omega[middle]
    try:
        factors = SparseFactors(system.shifted(s0))
    except RuntimeError:
        return answered
    y0 = factors.solve(-right)
    if not np.isfinite(y0).all():
        return answered
    out[middle] = system.C @ y0
    distance = 1j * omega[part] - s0
    open_ = np.flatnonzero(~answered)
    for k in range(right.shape[1]):
        if not len(open_):
            break
        y, known = _outputs(system, factors.solve, y0[:, k], abs(s0), distance[open_])
        out[part[open_[known]], :, k] = y[known]
        open_ = open_[known]
    answered[open_] = True
    return answered


def _outputs(
    system: DescriptorSystem, solve: Callable[[Complex], Complex], y0: Complex, size: float, distance: Complex
) -> tuple[Complex, NDArray[np.bool_]]:
    """Of one input, (frequencies, outputs) at these distances from s0, where the solution is y0, and which are known.
    Positions are multiplied by `size`, so that both halves of the state compare."""
    n, C = system.n_states, system.C
    scale = np.where(np.arange(n) < (n + 1) // 2, size or 1.0, 1.0)
    z, base = scale * y0[:n], C @ y0
    y, known = np.tile(base, (len(distance), 1)), np.zeros(len(distance), bool)
    start = float(np.linalg.norm(z))
    if not start:  # the input does not act on states
        return y, np.ones(len(y), bool)
    V, H = np.zeros((n, MOST), complex), np.zeros((MOST + 1, MOST), complex)
    moved = np.zeros((len(base), MOST), complex)
    right, beyond = np.zeros((len(y0), 1), complex), start
    for m in range(1, min(MOST, n, STEPS * (1 + len(y))) + 1):  # few frequencies are soon answered one by one
        V[:, m - 1] = z / beyond
        right[:n, 0] = V[:, m - 1] / scale
        w = solve(right)[:, 0]
        moved[:, m - 1], z = C @ w, scale * w[:n]
        for _ in range(2):  # once more for rounding
            part = V[:, :m].conj().T @ z
            H[:m, m - 1] += part
            z = z - V[:, :m] @ part
        H[m, m - 1] = beyond = float(np.linalg.norm(z))
        whole = m == n or beyond <= EPS * np.linalg.norm(H[:m, m - 1])
        if m % STEPS and not whole:
            continue
        first = np.zeros((len(y), m, 1), complex)
        first[:, 0] = start
        try:
            c = np.linalg.solve(np.eye(m) - distance[:, None, None] * H[:m, :m], first)[:, :, 0]
        except np.linalg.LinAlgError:  # one of them is an eigenvalue
            break
        y = base + distance[:, None] * (c @ moved[:, :m].T)
        known = np.abs(distance) * beyond * np.abs(c[:, -1]) <= CONVERGED * start
        if whole or known.all():
            return y, known | whole
    return y, known
