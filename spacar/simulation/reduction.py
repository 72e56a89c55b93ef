"""Modal reduction of a time-varying linear system (mrltv, theory-system.md 7.6).

At every stored time the modes of (K + K^T)/2 and M, normalized to Phi^T M Phi = I, are split into three groups by their
frequency at the first time: low ones are kept as degrees of freedom eta, quasi-static ones answer without inertia, high
ones are dropped. Modes are followed by the largest |Phi_(k-1)^T M Phi_k|. The basis of the kept modes is turned inside
its own space so that it changes as little as possible from time to time (orthogonal Procrustes problem), and is
interpolated by cubic splines, which give its derivatives:

    dq = Phi_l eta + dq_h,        eta'' + Phi_l^T (C1 eta' + K1 eta + K dq_h + C dq_h') = Phi_l^T r
    dq_h = X (r - C1 eta' - K1 eta),    X = Phi_h (Phi_h^T K Phi_h)^-1 Phi_h^T                                  (25)
    C1 = C Phi_l + 2 M Phi_l',    K1 = K Phi_l + C Phi_l' + M Phi_l''

with r the generalized forces of the inputs. The terms of eta in dq_h vanish for a constant symmetric K without damping;
they carry the coupling by feedback, Coriolis terms and the motion of the modes. In C dq_h', the rate at which the
static answer changes drives the low modes through the damping (a derivative gain acts on the whole joint rate); of
dq_h' the part (X r)' is kept. Its r' is no input, so the state is w = eta' + P r with P = Phi_l^T C X instead of eta'.
"""

from dataclasses import dataclass, replace

import numpy as np

from spacar.arrays import Array, Index
from spacar.errors import AnalysisError, UsageError
from spacar.simulation.propagation import disturbance
from spacar.simulation.time_varying import TimeVarying

POOR_OVERLAP = 0.7  # of a mode with its successor: below it the stored times are too far apart to follow it


@dataclass(frozen=True)
class Reduction:
    """The reduced system and what it is made of.

    basis (k, n, kept) M-orthonormal;  rates (k, n) signed circular frequencies [rad/s] of all modes in the
    order of the first time (negative: unstable, -sqrt(-eigenvalue));  kept, static, dropped: numbers of the
    modes (from 0);  report for users
    """

    system: TimeVarying
    basis: Array
    rates: Array
    kept: tuple[int, ...]
    static: tuple[int, ...]
    dropped: tuple[int, ...]
    report: tuple[str, ...]


def reduce_modes(data: TimeVarying, n_low: int, n_static: int | None = None) -> Reduction:
    """Keep the `n_low` modes of lowest frequency; the next `n_static` (default: all) answer quasi-statically.

    Raises UsageError when the numbers do not fit or M0, C0B, K0B are not stored; AnalysisError when M0 is
    not positive definite or the stiffness of a quasi-static mode is not positive.
    """
    M, C, K, _, Cy = data.need("m0", "c0b", "k0b", "B", "C")
    steps, n = M.shape[:2]
    n_static = n - n_low if n_static is None else n_static
    if not (1 <= n_low <= n and 0 <= n_static <= n - n_low):
        raise UsageError(f"{n_low} low and {n_static} quasi-static modes cannot be chosen from {n}", "simulation.modes")
    values, modes, overlap = tracked_modes(data.t, M, K)
    low, static, high = np.split(np.arange(n), [n_low, n_low + n_static])
    basis = _aligned(modes[:, :, low], M)
    first, second = _derivatives(data.t, basis)
    T = np.swapaxes(basis, 1, 2)
    C1, K1 = C @ basis + 2.0 * M @ first, K @ basis + C @ first + M @ second
    X = _static_flexibility(data.t, modes[:, :, static], K)
    E = data.distribution
    project = T - T @ K @ X
    Cr, Kr = project @ C1, project @ K1
    P = T @ C @ X
    drift = _derivatives(data.t, P)[0] - T @ C @ _derivatives(data.t, X)[0]
    eye, zero = np.broadcast_to(np.eye(n_low), (steps, n_low, n_low)), np.zeros((steps, n_low, n_low))
    Cq, Cv = Cy[:, :, :n], Cy[:, :, n:]
    Ce = Cv @ basis - Cq @ X @ C1
    D = (Cq @ X - Ce @ P) @ E if data.D is None else data.D + (Cq @ X - Ce @ P) @ E
    x0 = np.zeros(2 * n) if data.x0 is None else np.ravel(data.x0)
    eta = T[0] @ M[0] @ x0[:n]
    load = E[0] @ disturbance(data)[0]
    system = replace(
        data, name=f"{data.name} reduced to {n_low} modes",
        A=np.block([[zero, eye], [-Kr, -Cr]]),
        B=np.concatenate((-P @ E, (project + Cr @ P + drift) @ E), axis=1),
        C=np.concatenate((Cq @ (basis - X @ K1) + Cv @ first, Ce), axis=2),
        D=D if np.any(D) else None,
        m0=np.array(eye), c0b=Cr, k0b=Kr, n_rigid=0,
        second=None if data.second is None else T[:, None] @ data.second @ basis[:, None],
        x0=np.concatenate((eta, T[0] @ M[0] @ (x0[n:] - first[0] @ eta) + P[0] @ load)),
    )  # fmt: skip
    rates = np.sign(values) * np.sqrt(np.abs(values))
    report = _report(data.t, rates, overlap, low, static, high)
    kept, answering, dropped = (tuple(part.tolist()) for part in (low, static, high))
    return Reduction(system, basis, rates, kept, answering, dropped, report)


def tracked_modes(t: Array, M: Array, K: Array) -> tuple[Array, Array, Array]:
    """Eigenvalues (k, n), modes (k, n, n) and the overlap of each mode with its predecessor (k, n).

    The order is that of ascending eigenvalues at the first time; later each mode is the one that overlaps most. Raises
    AnalysisError for matrices that are not finite, or a mass matrix that is not positive definite.
    """
    from scipy.linalg import eigh
    from scipy.optimize import linear_sum_assignment

    steps, n = M.shape[:2]
    known = np.isfinite(M).all((1, 2)) & np.isfinite(K).all((1, 2))
    if not known.all():
        text = f"the mass or stiffness matrix at t = {t[int(np.argmin(known))]:.9g} holds numbers that are not finite"
        raise AnalysisError(text, "dynamics.not-finite")
    values, modes, overlap = np.zeros((steps, n)), np.zeros((steps, n, n)), np.ones((steps, n))
    for k in range(steps):
        try:
            found, shapes = eigh(0.5 * (K[k] + K[k].T), M[k])
        except np.linalg.LinAlgError:
            text = f"the mass matrix at t = {t[k]:.9g} is not positive definite; a degree of freedom carries no mass"
            raise AnalysisError(text, "dynamics.singular-mass") from None
        if k:
            common = modes[k - 1].T @ M[k] @ shapes
            rows, columns = linear_sum_assignment(-np.abs(common))
            shapes = shapes[:, columns] * np.where(common[rows, columns] < 0.0, -1.0, 1.0)
            found, overlap[k] = found[columns], np.abs(common[rows, columns])
        values[k], modes[k] = found, shapes
    return values, modes, overlap


def _aligned(modes: Array, M: Array) -> Array:
    """The same spaces with bases that follow each other as closely as possible."""
    out = modes.copy()
    for k in range(1, len(out)):
        u, _, v = np.linalg.svd(out[k].T @ M[k] @ out[k - 1])
        out[k] = out[k] @ (u @ v)
    return out


def _derivatives(t: Array, basis: Array) -> tuple[Array, Array]:
    """First and second time derivative at the stored times, from cubic splines; zero for less than four times."""
    if len(t) < 4:
        return np.zeros_like(basis), np.zeros_like(basis)
    from scipy.interpolate import CubicSpline

    spline = CubicSpline(t, basis, axis=0)
    return np.asarray(spline(t, 1)), np.asarray(spline(t, 2))


def _static_flexibility(t: Array, modes: Array, K: Array) -> Array:
    """Phi_h (Phi_h^T K Phi_h)^-1 Phi_h^T, (k, n, n)."""
    if not modes.shape[2]:
        return np.zeros_like(K)
    T = np.swapaxes(modes, 1, 2)
    own = T @ (0.5 * (K + np.swapaxes(K, 1, 2))) @ modes
    stiff = np.diagonal(own, axis1=1, axis2=2)
    if np.any(stiff <= 0.0):
        k, i = (int(v[0]) for v in np.nonzero(stiff <= 0.0))
        text = (
            f"quasi-static mode {i + 1} has the stiffness {stiff[k, i]:.4g} at t = {t[k]:.9g}: a mode without"
            " stiffness cannot answer statically; keep more modes, or fold a proportional gain into the stiffness"
            " first (spacntrl)"
        )
        raise AnalysisError(text, "simulation.modes")
    return modes @ np.linalg.solve(T @ K @ modes, T)


def _report(
    t: Array, rates: Array, overlap: Array, low: Index, static: Index, high: Index
) -> tuple[str, ...]:
    """Which modes were kept, made quasi-static and dropped, with their frequencies."""
    lines = []
    for what, group in (("kept", low), ("quasi-static", static), ("dropped", high)):
        ranges = [f"{i + 1} ({rates[:, i].min():.5g} to {rates[:, i].max():.5g} rad/s)" for i in group]
        lines.append(f"{what}: {'modes ' + ', '.join(ranges) if ranges else 'none'}")
    others = np.concatenate((static, high))
    if len(others) and rates[:, low].max() > rates[:, others].min():
        lines.append("warning: a kept mode is at some time above one that is not kept; keep more modes")
    worst = np.unravel_index(int(np.argmin(overlap)), overlap.shape)
    if overlap[worst] < POOR_OVERLAP:
        lines.append(
            f"warning: mode {int(worst[1]) + 1} overlaps by only {overlap[worst]:.2f} with its predecessor at t ="
            f" {t[worst[0]]:.9g}; modes cross, or the stored times are too far apart"
        )
    return tuple(lines)
