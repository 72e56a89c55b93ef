"""Simulation of a stored time-varying linear system from stored time to stored time, without step size control.

Stepwise: A and B are constant around every stored time, so each half interval is solved exactly by the exponential of
[A B u; 0 0]. Linear: A, B and u are interpolated linearly, and an interval of length h is advanced by the fourth order
commutator-free exponential integrator of the augmented matrix of (z, 1, tau), with A1, A2 at its Gauss points:

    z(h) = exp(h (b A1 + a A2)) exp(h (a A1 + b A2)) z(0),    a = 1/4 + sqrt(3)/6, b = 1/4 - sqrt(3)/6

It is exact when A and B are constant and u is linear. Unlike the Magnus expansion with commutators it stays stable for
modes that are fast compared with the interval: for a linear A(t) the exponents are A(h/6) h/2 and A(5h/6) h/2.
Source: S. Blanes, P. C. Moan, Fourth- and sixth-order commutator-free Magnus integrators, Applied Numerical Mathematics
56 (2006).
"""

from dataclasses import dataclass

import numpy as np

from spacar.arrays import Array
from spacar.errors import AnalysisError, UsageError
from spacar.simulation.time_varying import TimeVarying


@dataclass(frozen=True)
class LtvResponse:
    """t (k,) [s]; z (k, n) states; dy (k, p) outputs of the linear system; y (k, p) = y0 + dy + second order terms."""

    t: Array
    z: Array
    dy: Array
    y: Array


def disturbance(data: TimeVarying) -> Array:
    """(k, m) inputs of the perturbation method: no change of the nominal inputs, then sigma0."""
    (B,) = data.need("B")
    u = np.zeros((len(data.t), B.shape[2]))
    if data.sigma0 is not None:
        u[:, data.n_nominal :] = data.sigma0
    return u


def simulate_ltv(
    data: TimeVarying, u: Array | None = None, *, interpolation: str = "linear", substeps: int = 1,
    z0: Array | None = None,
) -> LtvResponse:  # fmt: skip
    """Response to the inputs u (k, m) at the stored times (default: sigma0 alone), from z0 (default X0).

    interpolation   "linear" (default) or "step"
    substeps        parts of every interval with linear interpolation, whose error is of order 4 in the step

    Raises UsageError for wrong shapes, AnalysisError when the response overflows.
    """
    A, B, C = data.need("A", "B", "C")
    steps, n, m = B.shape
    u = disturbance(data) if u is None else np.asarray(u, float)
    if u.shape != (steps, m):
        raise UsageError(
            f"the inputs have the shape {u.shape}, expected {(steps, m)}: one row a stored time", "simulation.size"
        )
    if interpolation not in ("step", "linear"):
        raise UsageError(
            f"interpolation '{interpolation}' does not exist here; choose step or linear", "simulation.table"
        )
    if substeps < 1:
        raise UsageError("the number of substeps must be at least 1", "simulation.substeps")
    start = data.x0 if z0 is None else z0
    z = np.zeros((steps, n))
    z[0] = 0.0 if start is None else np.ravel(start)
    stepwise = interpolation == "step"
    with np.errstate(over="ignore", invalid="ignore"):
        maps = _stepwise(data.t, A, B, u) if stepwise else _linear(data.t, A, B, u, substeps)
        for k, P in enumerate(maps[:, :n]):
            z[k + 1] = P[:, :n] @ z[k] + P[:, n]
    if not np.isfinite(z).all():
        k = int(np.flatnonzero(~np.isfinite(z).all(axis=1))[0])
        text = f"the linear system is unstable: its states overflow at t = {data.t[k]:.9g}; add feedback (spacntrl)"
        raise AnalysisError(text, "simulation.not-finite")
    dy = np.einsum("kpn,kn->kp", C, z)
    if data.D is not None:
        dy += np.einsum("kpm,km->kp", data.D, u)
    y = dy.copy()
    if data.second is not None:
        dq = z[:, : n // 2]
        y[:, data.second_rows] += 0.5 * np.einsum("ki,ksij,kj->ks", dq, data.second, dq)
    return LtvResponse(data.t, z, dy, y if data.y0 is None else y + data.y0)


def _stepwise(t: Array, A: Array, B: Array, u: Array) -> Array:
    """(z, 1) at t_(k+1) by that at t_k, with constant matrices in each half of the interval."""
    from scipy.linalg import expm

    n = A.shape[1]
    b = np.einsum("knm,km->kn", B, u)
    half = 0.5 * np.diff(t)
    augmented = np.zeros((len(t), n + 1, n + 1))
    augmented[:, :n, :n], augmented[:, :n, n] = A, b
    left, right = expm(augmented[:-1] * half[:, None, None]), expm(augmented[1:] * half[:, None, None])
    return right @ left


def _linear(t: Array, A: Array, B: Array, u: Array, substeps: int) -> Array:
    """The same by the exponential integrator, with everything linear between the stored times."""
    from scipy.linalg import expm

    n = A.shape[1]
    shift = np.sqrt(3.0) / 6.0
    early, late = 0.25 - shift, 0.25 + shift
    H = np.diff(t) / substeps
    total = np.broadcast_to(np.eye(n + 2), (len(H), n + 2, n + 2))
    for j in range(substeps):
        matrices = []
        ends = [_between(u, (j + side) / substeps) for side in (0, 1)]
        for gauss in (0.5 - shift, 0.5 + shift):
            w = (j + gauss) / substeps
            Aw, Bw, uw = _between(A, w), _between(B, w), _between(u, w)
            slope = np.einsum("knm,km->kn", Bw, ends[1] - ends[0]) / H[:, None]
            matrix = np.zeros((len(H), n + 2, n + 2))
            matrix[:, :n, :n] = Aw
            matrix[:, :n, n] = np.einsum("knm,km->kn", Bw, uw) - slope * (gauss * H)[:, None]
            matrix[:, :n, n + 1] = slope
            matrix[:, n + 1, n] = 1.0
            matrices.append(matrix)
        first, second = matrices
        h = H[:, None, None]
        step = expm(h * (early * first + late * second)) @ expm(h * (late * first + early * second))
        # tau counts from the start of each substep: the map of (z, 1) alone is chained.
        reduced = np.zeros_like(step)
        reduced[:, :n, : n + 1] = step[:, :n, : n + 1]
        reduced[:, n, n] = 1.0
        total = reduced @ total
    return total


def _between(values: Array, w: float) -> Array:
    """Values at the part w of every interval."""
    return (1.0 - w) * values[:-1] + w * values[1:]
