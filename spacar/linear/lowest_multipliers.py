"""Lowest load multipliers of large systems at rest, without dense matrices (theory-system.md 6.2, 6.5).

    all loads      op = -K_S^-1 G,  theta = 1/lambda, K_S = V^T S V, G = Hs(sigma) + load; where K_S is singular,
                   op = -(K_S + s G)^-1 G, theta = 1/(lambda - s)
    in motion, user functions   the same by the descriptor system of section 5.7 without rates, of the stiffness alone
    an extra load  op = -K^-1 G1, K = K_S + G of the present state, G1 of the stresses s1 of the extra load alone

Unknowns a inside elements (`spacar.linear.internal_unknowns`) stand beside the coordinates: z = (x, b), with b = a
sqrt(k/size), so that their stiffness has the size of the others. In the shifted problem they are left out, with a
warning. Doubtful pairs are treated as in `spacar.linear.lowest`.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import EPS, Array, Complex, Index
from spacar.errors import AnalysisError, Report
from spacar.linear import backward_error
from spacar.linear.buckling import SINGULAR_K0, BucklingModes, order_of
from spacar.linear.internal_unknowns import element_unknowns
from spacar.linear.lowest import (
    LOADING,
    WANTED,
    degrees_of_freedom_of,
    is_symmetric_loading,
    lost_pairs,
    rayleigh,
    start_block,
)
from spacar.linear.subspace import NOTHING, SUFFICIENT, Operator, RefinedOperator, dominant, real_vectors
from spacar.linear_systems import SingularMatrixError
from spacar.linear_systems.linear_system import compressed, zero_matrix
from spacar.linearization.coefficients import Coefficients
from spacar.linearization.sparse_linearization import SparseLinearization
from spacar.stationary.stationary_equations import require_digits
from spacar.stationary.tangent import STATIC, SparseTangent

MOST = 8  # times the wanted multipliers, among which real ones are looked for
SHIFTS = (1e-2, 0.3, 1.0)  # of the present load: no multiplier of interest
NO_TWIST_GRADIENT = (
    "warning: the stiffness K0 is singular: these load multipliers leave out the twist gradient of beams in the angle"
    " measure, so they converge with order 2 in the length of the elements; MODES 0 asks for the dense matrices, that"
    " contain it"
)


def lowest_buckling(
    tangent: SparseTangent, report: Report, wanted: int = WANTED, c: Coefficients | None = None
) -> BucklingModes:
    """The `wanted` load multipliers of smallest modulus.

    c   of a state that moves or has user functions, which are no parts of `tangent`

    Raises AnalysisError when K0 and G0 are singular together.
    """
    if c is None:
        sigma, factor = tangent.sigma, partial(_stiffness_at_rest, tangent)
        loading, symmetric = tangent.assembled(LOADING), is_symmetric_loading(tangent)
    else:
        sigma, factor = c.sigma, partial(_stiffness_in_motion, tangent, c)
        loading, symmetric = _between_free(tangent, c.geometric + c.load_x), False
    if not abs(loading).sum():
        return BucklingModes(np.zeros(0), np.zeros((tangent.dynamics.numbering.nddof, 0)))
    unknowns = _Unknowns(tangent, sigma)
    shift = 0.0
    try:
        displacement = factor(shift)
    except SingularMatrixError:
        if unknowns.m:
            report.add(NO_TWIST_GRADIENT)
            unknowns = _Unknowns(tangent, None)
        shift, displacement = _shifted(factor)
        report.add(SINGULAR_K0)

    def solve(force: Array, refined: bool = False) -> Array:
        return np.vstack((displacement(force[: unknowns.nx], refined), force[unknowns.nx :] / unknowns.size))

    return _modes(tangent, unknowns, solve, unknowns.bordered(loading), symmetric, shift, wanted, report)


def _stiffness_at_rest(tangent: SparseTangent, shift: float) -> RefinedOperator:
    """Displacements (nx, k) by forces (nx, k): (K_S + shift G)^-1. Raises SingularMatrixError."""
    return partial(tangent.displacement, tangent.factor(dict.fromkeys(LOADING, shift) if shift else {}))


def _stiffness_in_motion(tangent: SparseTangent, c: Coefficients, shift: float) -> RefinedOperator:
    """The same with the stiffness that user functions state. Raises SingularMatrixError."""
    from spacar.linear_systems.sparse_factors import SparseFactors

    d = tangent.dynamics
    nx, ne = d.numbering.nx, d.numbering.ne
    still, none = zero_matrix((ne, nx)), zero_matrix((nx, nx))
    alone = replace(
        c, rate_x=still, second_v=still, second_x=still, stress_v=still, inertia_x=none, inertia_v=none, user_v=none,
        geometric=shift * c.geometric, load_x=shift * c.load_x,
    )  # fmt: skip
    system = SparseLinearization(d, (), ()).once(alone)
    A, at = system.shifted(0.0), system.n_states
    n = A.shape[0]
    try:
        factors = SparseFactors(A)
    except RuntimeError:
        raise SingularMatrixError("the stiffness is singular") from None

    def displacement(force: Array, refined: bool = True) -> Array:
        right = np.zeros((n, force.shape[1]))
        right[at + tangent.F] = -force[tangent.F]
        return np.asarray(factors.solve(right)[at + nx : at + 2 * nx])

    moved = at + nx + tangent.F  # the unknowns that tell whether digits are left, first
    order = np.concatenate((moved, np.setdiff1d(np.arange(n), moved)))
    probe = np.zeros(n)
    probe[at + tangent.F] = tangent.flexibility.size

    def solve(b: Array) -> Array:
        return np.asarray(factors.solve(b[:, None])[order, 0])

    def rounding(z: Array) -> Array:
        return np.asarray(EPS * (abs(A[:, order]) @ np.abs(z)))

    require_digits(solve, rounding, solve(probe), len(moved))
    return displacement


def _between_free(tangent: SparseTangent, A: Any) -> Any:
    """A (nx, nx) in compressed rows with its rows and columns F only."""
    from scipy.sparse import csr_array

    from spacar.linear_systems.sparse_factors import diagonal

    free = diagonal((tangent.place >= 0).astype(float))
    return csr_array(free @ A @ free)


def lowest_extra_load(
    tangent: SparseTangent, s1: Array, moments: tuple[Index, Index, Array], report: Report, wanted: int = WANTED
) -> BucklingModes:
    """The `wanted` multipliers of smallest modulus of an extra load beside all present ones.

    s1 (ne,) the stresses that it adds; moments: rows, columns, values of the gradient df/dx of its moments
    Unknowns inside elements that have a rigid deformation are left out. Raises SingularMatrixError at a critical state.
    """
    sigma = tangent.sigma
    system = tangent.factor(STATIC)
    present, added = _Unknowns(tangent, sigma, s1, True), _Unknowns(tangent, s1, sigma, True)
    tangent.sigma = s1
    G = tangent.assembled(("geometric",))
    tangent.sigma = sigma
    rows, columns, values = moments
    values = values * ((tangent.place[rows] >= 0) & (tangent.place[columns] >= 0))
    loading = added.bordered(G - compressed(rows, columns, values, G.shape))
    c, turned = present.coupling, present.coupling.T.tocsr()

    def solve(force: Array, refined: bool = False) -> Array:
        """[K + c0 c0^T/k, c0; c0^T, k]: without b, K is left, which has them eliminated."""
        fx, fb = force[: present.nx], force[present.nx :]
        x = tangent.displacement(system, fx - c @ fb / present.size, refined)
        return np.vstack((x, (fb - turned @ x) / present.size))

    symmetric = is_symmetric_loading(tangent) and not len(moments[2])
    return _modes(tangent, added, solve, loading, symmetric, 0.0, wanted, report)


class _Unknowns:
    """Unknowns b (m,) beside the coordinates.

    `coupling` (nx, m) is c sqrt(size/k), `size` the stiffness of every b, `part` (m,) is 1 where the element has
    eliminated its unknown. `eliminated`: take only these.
    """

    def __init__(
        self, tangent: SparseTangent, sigma: Array | None, other: Array | None = None, eliminated: bool = False
    ) -> None:
        from scipy.sparse import csr_array, hstack

        self.nx, self.size = tangent.dynamics.numbering.nx, tangent.flexibility.size
        found = [] if sigma is None else element_unknowns(tangent.dynamics, sigma, other)
        blocks, parts = [csr_array((self.nx, 0))], [np.zeros(0)]
        for u in found:
            keep = np.flatnonzero(u.eliminated) if eliminated else np.arange(len(u.stiffness))
            if len(keep):
                c = u.coupling[:, keep] * np.sqrt(self.size / u.stiffness[keep])
                blocks.append(_columns(tangent, u.rows[:, keep], c))
                parts.append(u.eliminated[keep].astype(float))
        self.coupling, self.part = hstack(blocks, format="csr"), np.concatenate(parts)
        self.m = len(self.part)

    def bordered(self, G: Any) -> Any:
        """[G + c part c^T/size, c; c^T, 0] in compressed rows, G (nx, nx)."""
        from scipy.sparse import bmat, csr_array

        from spacar.linear_systems.sparse_factors import diagonal

        c = self.coupling
        part = diagonal(self.part / self.size)
        return csr_array(bmat([[G + c @ part @ c.T, c], [c.T, None]])) if self.m else G


def _columns(tangent: SparseTangent, rows: Index, values: Array) -> Any:
    """(nx, m) with a column for every element, rows F only."""
    columns = np.broadcast_to(np.arange(rows.shape[1]), rows.shape)
    keep = tangent.place[rows] >= 0
    return compressed(rows[keep], columns[keep], values[keep], (len(tangent.place), rows.shape[1]))


def _modes(
    tangent: SparseTangent, unknowns: _Unknowns, solve: RefinedOperator, loading: Any, symmetric: bool, shift: float,
    wanted: int, report: Report,
) -> BucklingModes:  # fmt: skip
    wanted = min(wanted, tangent.dynamics.numbering.nddof)

    def operator(z: Array) -> Array:
        return -solve(loading @ z, refined=not symmetric)

    values, vectors, real = _largest_real(tangent, unknowns, operator, wanted, symmetric)
    if symmetric:
        z = real_vectors(values, vectors)
        force = loading @ z
        theta = rayleigh(z, force, -solve(force, refined=True))
    else:
        if not real.all():
            report.add(f"{int((~real).sum())} load multipliers are complex (follower loads): they are left out")
        theta, z = values[real].real[:wanted], vectors[:, real].real[:, :wanted]
    with np.errstate(divide="ignore"):
        multipliers = shift + 1.0 / theta
    lost = lost_pairs(operator, theta, z, multipliers, "load multipliers", report)
    theta[lost], z[:, lost] = np.nan, np.nan
    infinite = np.abs(theta) <= NOTHING * np.max(np.abs(theta[~lost]), initial=0.0)
    theta, x = theta[~infinite], z[: unknowns.nx, ~infinite]
    multipliers = shift + 1.0 / theta
    # A multiplier below the residual that counts as converged, times the shift, is zero.
    multipliers[np.abs(multipliers) <= SUFFICIENT * shift] = 0.0
    unknown = np.isnan(multipliers)
    known = np.flatnonzero(~unknown)
    order = np.concatenate((known[order_of(multipliers[known])], np.flatnonzero(unknown)))
    x = x[:, order]
    modes = degrees_of_freedom_of(tangent, x)
    size = np.linalg.norm(modes, axis=0)
    size = np.where(size > 0.0, size, 1.0)
    return BucklingModes(multipliers[order], modes / size, x / size)


def _largest_real(
    tangent: SparseTangent, unknowns: _Unknowns, operator: Operator, wanted: int, symmetric: bool
) -> tuple[Complex, Complex, NDArray[np.bool_]]:
    """The largest eigenvalues with their vectors, and which are real: `wanted` of these, if there are as many among
    the MOST times as many largest."""
    n = tangent.dynamics.numbering.nddof + unknowns.m
    count = wanted
    while True:
        start = start_block(tangent, count)
        start = np.vstack((start, np.zeros((unknowns.m, start.shape[1]))))
        values, vectors = dominant(operator, start, count, n)
        # a double value is known to half of the digits
        unreal = np.abs(values.imag) > np.sqrt(backward_error.rounding(len(vectors))) * np.abs(values)
        real = symmetric | ~unreal
        if real.sum() >= wanted or count >= min(MOST * wanted, n):
            return values, vectors, real
        count = min(2 * count, n)


def _shifted(factor: Callable[[float], RefinedOperator]) -> tuple[float, RefinedOperator]:
    """s > 0 and the factors of K0 + s G0 for K0 singular: (K0 + s G0) v = -(lambda - s) G0 v. Raises AnalysisError."""
    for shift in SHIFTS:
        try:
            return shift, factor(shift)
        except SingularMatrixError:
            continue
    raise AnalysisError(
        "K0 and G0 have a common null vector: a motion without stiffness and without geometric stiffness; support or"
        " prescribe it before buckling is asked for",
        "buckling.singular",
    )
