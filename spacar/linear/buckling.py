"""Linear buckling and directional compliances (mode 8; theory-system.md 6.5, 6.6).

    det(K0 + lambda G0) = 0:   -G0 v = mu K0 v,  lambda = 1/mu      (K0 positive definite, G0 symmetric)
    otherwise the general problem  -G0 v = mu K0 v;  mu = 0 are infinite multipliers

Multipliers are ordered by modulus, of a pair +- the positive one first; modes have norm 1; negative multipliers
belong to the reversed load. Every pair is checked (`spacar.linear.backward_error`); a doubtful one is kept, with a
warning. The compliance of coordinate i is W_i K^-1 W_i^T with K = K0 + N0 + G0 of the dynamic degrees of freedom.
"""

from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import TYPE_CHECKING, NamedTuple, cast

import numpy as np

from spacar.arrays import EPS, Array, Index
from spacar.dynamics.array_evaluator import Dynamics
from spacar.errors import AnalysisError, Report
from spacar.linear import backward_error
from spacar.linear.eigen import SYMMETRIC, by_factor, is_symmetric
from spacar.linear_systems import LinearSystem, SingularMatrixError
from spacar.linearization.matrices import Linearization, selected
from spacar.stationary.solution import StationarySolver
from spacar.stationary.stationary_equations import require_digits

if TYPE_CHECKING:
    from spacar.linear_systems.banded import BandedSystem

NOTHING = 1e-13  # mu below this fraction of the largest is an infinite multiplier
PAIR = 1e-6  # relative difference of moduli below which multipliers count as +- the same: loads are known to 1e-8
NO_STRESS = "no stress, no load multiplier: the geometric stiffness vanishes"
SINGULAR_K0 = "the stiffness matrix K0 is singular: a load multiplier is zero"
SINGULAR = 1e-14  # singular values of the scaled K below this fraction of the largest are zero
CERTAIN = 1e-2 / SINGULAR  # condition number, of which rounding may take digits, from which singular values decide
COLUMNS = 256  # right-hand sides at once, of large models
NEGLIGIBLE = 1e-12  # part of the largest size of an unknown that does not scale it


class BucklingModes(NamedTuple):
    """multipliers (n,), infinite where the load has no effect; modes (n, n) of norm 1 over the dynamic rows.

    motions (nx, n): displacements of the coordinates, where they are computed without transfer functions.
    """

    multipliers: Array
    modes: Array
    motions: Array | None = None

    @property
    def lowest_positive(self) -> float:
        """The margin against the loads as they act; infinite when no multiplier is positive."""
        return float(self.multipliers[self.multipliers > 0.0].min(initial=np.inf))

    def filled(self, n: int) -> "BucklingModes":
        """n of them at every load step: where fewer loads have an effect infinite multipliers, their modes nan."""
        more = max(n - len(self.multipliers), 0)
        wider = partial(np.pad, pad_width=((0, 0), (0, more)), constant_values=np.nan)
        motions = None if self.motions is None else wider(self.motions)
        return BucklingModes(np.pad(self.multipliers, (0, more), constant_values=np.inf), wider(self.modes), motions)

    def first(self, n: int) -> "BucklingModes":
        """The n lowest multipliers with the first n rows of their modes, of norm 1 again.

        The rows that are left out belong to unknowns inside elements.
        """
        if n == len(self.modes):
            return self
        modes = self.modes[:n, :n]
        norm = np.linalg.norm(modes, axis=0)
        return BucklingModes(self.multipliers[:n], modes / np.where(norm > 0.0, norm, 1.0))


def buckling_modes(K0: Array, G0: Array, report: Report) -> BucklingModes:
    """Load multipliers of K0 + lambda G0, both (n, n)."""
    n = len(K0)
    if not G0.any():
        report.add(NO_STRESS)
        return BucklingModes(np.full(n, np.inf), np.eye(n))
    scale = _scale(K0)
    load, least = -G0, n * EPS  # a pivot that is rounding
    product = scale[:, None] * scale
    K, load = K0 * product, load * product
    lower = np.zeros((0, 0))
    # In the scale of K; rows on which the load does not act hold rounding, so that they are no scale of their own.
    if is_symmetric(K) and np.abs(load - load.T).max() <= SYMMETRIC * np.abs(load).max():
        with suppress(np.linalg.LinAlgError):
            lower = np.linalg.cholesky(K)
    if len(lower) and lower.diagonal().min() ** 2 > least:
        mu, modes = by_factor(load, lower)
    else:
        mu, modes = _general(K, -load, report)
    size = np.abs(mu)
    finite = size > NOTHING * size[size < np.inf].max(initial=0.0)
    multipliers = np.where(finite, 1.0 / np.where(finite, mu, 1.0), np.inf)
    pairs = multipliers[finite], modes[:, finite]
    backward_error.warn(report, backward_error.of_scaled_pencil(K, load, *pairs), pairs[0], "load multipliers")
    order = order_of(multipliers)
    modes = (modes * scale[:, None])[:, order]
    return BucklingModes(multipliers[order], modes / np.linalg.norm(modes, axis=0))


def order_of(multipliers: Array) -> Index:
    """Increasing modulus; where moduli agree to PAIR, positive before negative, so that rounding decides nothing."""
    size = np.abs(multipliers)
    by_size = size.argsort(kind="stable")
    size = size[by_size]
    group = np.concatenate(([0], np.cumsum(size[:-1] < (1.0 - PAIR) * size[1:])))[: len(size)]
    return np.asarray(by_size[np.lexsort((multipliers[by_size] < 0.0, group))])


def _general(K: Array, G: Array, report: Report) -> tuple[Array, Array]:
    """K0 indefinite or a matrix not symmetric: real solutions of the general problem, mu infinite where K0 v = 0."""
    from scipy.linalg import eig

    of_G, of_K = (float(np.linalg.norm(A)) or 1.0 for A in (G, K))
    common = _common_null_space(K / of_K, G / of_G)
    if common is not None:
        return _without(*common, K, G, report)
    (alpha, beta), vectors = eig(-G / of_G, K / of_K, homogeneous_eigvals=True)
    size = np.maximum(np.abs(alpha), np.abs(beta))
    rounding = backward_error.rounding(len(K))
    undetermined = size <= rounding  # alpha and beta of matrices of norm 1 are both zero: any value is an eigenvalue
    if undetermined.any():
        raise AnalysisError(
            "K0 + lambda G0 is singular for every lambda: a motion without stiffness that the load does not restore;"
            " support or prescribe it before buckling is asked for",
            "buckling.singular",
        )
    with np.errstate(divide="ignore"):
        mu = np.where(np.abs(beta) > rounding * size, alpha / np.where(beta == 0, 1.0, beta) * (of_G / of_K), np.inf)
    mu = np.where(np.abs(alpha) > rounding * size, mu, 0.0)
    complex_values = np.abs(mu.imag) > np.sqrt(rounding) * np.abs(mu)  # a double value is known to half of the digits
    if complex_values.any():
        report.add(
            f"{int(complex_values.sum())} load multipliers are complex (follower loads): they are shown as infinite"
        )
    mu = np.where(complex_values, 0.0, mu.real)
    if not np.isfinite(mu).all():
        report.add(SINGULAR_K0)
    return mu, vectors.real


def _common_null_space(K: Array, G: Array) -> tuple[Array, Array] | None:
    """Orthogonal bases (n, rank) beside the null spaces of [K; G] and of its transposed counterpart; None where they
    are empty or of different dimensions. K and G have the norm 1."""
    bases, ranks = [], []
    for both in (np.vstack((K, G)), np.vstack((K.T, G.T))):
        _, s, vt = np.linalg.svd(both, full_matrices=True)
        ranks.append(int(np.sum(s > backward_error.rounding(len(K)) * s[0])))
        bases.append(vt.T)
    if ranks[0] == len(K) or ranks[0] != ranks[1]:
        return None
    return bases[0][:, : ranks[0]], bases[1][:, : ranks[0]]


def _without(right: Array, left: Array, K: Array, G: Array, report: Report) -> tuple[Array, Array]:
    """The general problem beside the common null space of K and G, on which the load has no effect: mu = 0 there."""
    n, rank = right.shape
    report.add(
        f"warning: K0 and G0 have {n - rank} common null vector{'s' * (n - rank > 1)}: a motion without stiffness and"
        " without geometric stiffness; it has no load multiplier (infinite), the others are those of the other motions;"
        " support or prescribe it"
    )
    mu, vectors = _general(left.T @ K @ right, left.T @ G @ right, report)
    rest = np.linalg.svd(right.T, full_matrices=True)[2][rank:].T
    return np.concatenate((mu, np.zeros(n - rank))), np.hstack((right @ vectors, rest))


def _scale(K: Array) -> Array:
    d = np.sqrt(np.abs(K.diagonal()))
    largest = float(d.max(initial=0.0))
    return 1.0 / np.where(d > NEGLIGIBLE * largest, d, largest or 1.0)


def directional_compliances(L: Linearization, dynamic: Index, report: Report) -> Array:
    """(nx,) diagonal of W K^-1 W^T; infinite where a singular K moves the coordinate."""
    K, W = selected(L.stiffness, dynamic, dynamic), L.W[:, dynamic]
    if not len(dynamic):
        return np.zeros(len(W))
    scale = _scale(K)
    K, Ws = K * (scale[:, None] * scale), W * scale
    try:
        own = np.linalg.solve(K, np.eye(len(K)))  # the compliances of the degrees of freedom
    except np.linalg.LinAlgError:
        own = np.full_like(K, np.inf)
    # at least s_1/s_n
    if np.linalg.norm(K) * np.linalg.norm(own) < CERTAIN:
        return np.asarray(((Ws @ own) * Ws).sum(axis=1))
    u, s, vt = np.linalg.svd(K)
    regular = s > SINGULAR * s[0]
    if not regular.all():
        report.add("the tangent stiffness is singular (critical load or rigid motion): some compliances are infinite")
    compliance = np.einsum("ia,a,ia->i", Ws @ vt[regular].T, 1.0 / s[regular], Ws @ u[:, regular])
    moved = np.abs(Ws @ vt[~regular].T).max(axis=1, initial=0.0) > 1e-8 * np.abs(Ws).max()
    return np.where(moved, np.inf, compliance)


# -- of large models: the diagonal of the inverse of the tangent, without dense matrices ------------------------------
def sparse_compliances(dynamics: Dynamics, factored: Callable[[], LinearSystem]) -> Array:
    """(nx,) directional compliances: the diagonal of the inverse of the tangent, infinite where K is singular."""
    n = dynamics.numbering
    out, free = np.zeros(n.nx), np.r_[n.x_class["calculable"], n.x_class["dynamic"]]
    try:
        out[free] = _leading_inverse_diagonal(factored(), len(free), dynamics)
    except SingularMatrixError:
        out[free] = np.inf
    return out


def factored_in_motion(solver: StationarySolver) -> LinearSystem:
    """The exact tangent of an equilibrium that moves or has user functions. Raises SingularMatrixError."""
    q, tangent = solver.factorized()
    require_digits(tangent.solve, tangent.rounding, tangent.solve(q.probe), q.nf)
    return tangent.system


def _leading_inverse_diagonal(system: LinearSystem, n: int, dynamics: Dynamics) -> Array:
    """(n,) of the inverse: the first n unknowns and equations. By selected inversion of band storage with one order of
    rows and columns, and of a condensed matrix, of which these are the coordinates; else one solution for every column.
    """
    band = cast("BandedSystem", system)
    if system.kind == "banded" and np.array_equal(band.row_rank, band.column_rank):
        from spacar.linear_systems.selected_inverse import inverse_diagonal

        by = None
        if any(b.family.compiled for b in dynamics.mechanism.batches):  # in C, where elements are
            from spacar.compiled.compiled_elements import band_inverse as by  # type: ignore[assignment]
        return inverse_diagonal(band, by)[:n]
    found = system.inverse_diagonal()
    if found is not None:
        return found
    out = np.empty(n)
    for first in range(0, n, COLUMNS):
        rows = np.arange(first, min(first + COLUMNS, n))
        unit = np.zeros((system.n, len(rows)))
        unit[rows, rows - first] = 1.0
        out[rows] = system.solve(unit)[rows, rows - first]
    return out
