"""Lowest modes of vibration of large systems at rest, without dense matrices (theory-system.md 6.2).

Vibration: (lambda^2 M + lambda C + K_x) x + V^T sigma = 0, V x = 0 (rows fixed and input). With a real shift s > 0,
that is the negative shift -s^2 for omega^2, Q = K_x + s C + s^2 M is regular although there may be rigid-body modes:

    C = 0, K symmetric:  op = Q^-1 M,  theta = 1/(omega^2 + s^2), Rayleigh quotients in the energy of Q
    otherwise:           op (x, v) = (x', x + s x'),  Q x' = -(M v + (C + s M) x),  theta = 1/(lambda - s)

s^2 is a hundredth of the highest wanted omega^2 within a factor of ten. Pairs with
|op(z) - theta z| > 1e-8 |theta| |z| are kept, with a warning. Where it exceeds 0.1 |theta| |z| no digit of theta is
known (theta is an eigenvalue of an operator that differs by that much): value and shape are nan, with the same warning.

Descriptor systems E dz/dt = A z (theory-system.md 5.7), with one factorization: with the real shift s > 0, on the far
side of zero so that rigid motions do no harm, and positions multiplied by the wanted modulus,

    op z = the state part of (A - s E)^-1 (z, 0),      theta = 1/(lambda - s)
"""

from functools import partial

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import Array, Complex
from spacar.errors import AnalysisError, Report
from spacar.linear import backward_error
from spacar.linear.eigen import Modes, arranged, both_of
from spacar.linear.subspace import (
    SPARE,
    SUFFICIENT,
    Operator,
    RefinedOperator,
    dominant,
    real_vectors,
    with_shift,
)
from spacar.linearization.descriptor import MASSLESS, DescriptorSystem
from spacar.stationary.tangent import STATIC, SparseTangent

WANTED = 20  # modes
SHIFT = 1e-2  # s^2 as a fraction of the highest wanted omega^2
OF_MODULUS = 0.1  # s of a descriptor system as a fraction of the highest wanted modulus
LOADING = tuple(STATIC)
RIGID = 1e-10  # least s^2 M of rods without springs: below 1e-14 a matrix counts as singular; omega^2 loses nothing
SYMMETRIC = 1e-9  # relative asymmetry of the loading that is rounding
LEAST = 1e-9  # part of the largest theta with which smaller ones are compared: op knows them to n eps of the largest
NO_DIGIT = 0.1  # relative residual above which not even the first digit of a value is known


def lowest_vibration(tangent: SparseTangent, report: Report, wanted: int = WANTED, undamped: bool = False) -> Modes:
    """The `wanted` modes of lowest frequency about the equilibrium of `tangent`, whose sigma is set.

    undamped   without dampers and without the forces of the flow in tubes that are proportional to rates
    """
    n = tangent.dynamics.numbering
    wanted = min(wanted, n.nddof)
    symmetric = is_symmetric_loading(tangent)
    square, operator = _shift(tangent, wanted)
    if not undamped and (tangent.damped or not symmetric):
        values, x = _quadratic(tangent, float(np.sqrt(square)), wanted, report)
    else:
        squares, x = _undamped(tangent, square, operator, wanted, symmetric, report)
        values, x = both_of(squares, x)
    q = degrees_of_freedom_of(tangent, x)
    return arranged(values, np.vstack((q, q * np.where(np.isnan(values), 1.0, values))), len(q), x)


def _shift(tangent: SparseTangent, wanted: int) -> tuple[float, RefinedOperator]:
    """s^2 > 0, within a factor of ten of a hundredth of the highest wanted omega^2, by rough values of these; the
    operator of this shift."""
    springs = [b.family.stiffness()[0] for b in tangent.elastic]
    loading = [tangent.parts[k].values() for k in LOADING]  # the only stiffness of a pendulum
    K = max(float(np.max(np.abs(S), initial=0.0)) for S in (springs or loading))
    M = float(np.max(np.abs(tangent.parts["mass"].values()), initial=0.0))
    if M == 0.0:
        raise AnalysisError("singular mass matrix: the system carries no mass; add XM or EM", "dynamics.singular-mass")
    if K == 0.0:
        return 1.0, _squared(tangent, 1.0)  # nothing restores anything: all eigenvalues are zero
    least = 0.0 if springs else RIGID / M  # without springs the entries of the constraints are of size one
    return with_shift(
        lambda square: _squared(tangent, square),
        max(1e-6 * K / M, least),
        lambda theta, square: max(SHIFT * max(1.0 / float(np.abs(theta[-1])) - square, SHIFT * square), least),
        start_block(tangent, wanted),
        wanted,
        tangent.dynamics.numbering.nddof,
    )


def _squared(tangent: SparseTangent, square: float) -> RefinedOperator:
    """op = (K_x + s^2 M)^-1 M, refined when asked for."""
    system = tangent.factor({**STATIC, "mass": square})
    M = tangent.assembled(("mass",))

    def operator(x: Array, refined: bool = False) -> Array:
        return tangent.displacement(system, M @ x, refined)

    return operator


def _undamped(
    tangent: SparseTangent, square: float, operator: RefinedOperator, wanted: int, symmetric: bool, report: Report
) -> tuple[Array, Array]:
    """omega^2 (wanted,) and shapes (nx, wanted); complex where the loading is not symmetric. Then no quotient gives the
    digits back that values lose to the factors, so that every solution is refined."""
    if not symmetric:
        operator = partial(operator, refined=True)
    theta, x = dominant(operator, start_block(tangent, wanted), wanted, tangent.dynamics.numbering.nddof)
    if symmetric:
        x = real_vectors(theta, x)
        theta = rayleigh(x, tangent.assembled(("mass",)) @ x, operator(x, refined=True))
    squares = 1.0 / theta - square
    squares[lost_pairs(operator, theta, x, squares, "omega^2", report)] = np.nan
    return squares, x


def _quadratic(tangent: SparseTangent, s: float, wanted: int, report: Report) -> tuple[Array, Array]:
    """lambda and displacement shapes of the damped, gyroscopic or unsymmetric system; 2 x wanted of them. Solutions are
    refined, as for `_undamped` without symmetry."""
    system = tangent.factor({**STATIC, "mass": s * s, "flow": s}, damping=s)
    n = tangent.dynamics.numbering.nx
    M, C = tangent.assembled(("mass",)), tangent.assembled(("flow",)) + tangent.viscous()
    size = s / np.sqrt(SHIFT)  # x is multiplied by a typical frequency, so that both halves compare

    def operator(z: Array) -> Array:
        x, v = z[:n] / size, z[n:]
        following = -tangent.displacement(system, M @ (v + s * x) + C @ x, refined=True)
        return np.vstack((size * following, x + s * following))

    rank = 2 * tangent.dynamics.numbering.nddof
    values, z = eigenvalues_of(operator, s, start_block(tangent, 2 * wanted, 2), 2 * wanted, rank, report)
    return values, z[:n]


def eigenvalues_of(
    operator: Operator, shift: float, start: Array, wanted: int, rank: int, report: Report
) -> tuple[Complex, Complex]:
    """The `wanted` eigenvalues shift + 1/theta and vectors of a system, the rest as in `dominant`. One of which no
    digit is known, or whose conjugate would be the next one, is nan and keeps its place."""
    theta, z = dominant(operator, start, wanted, rank)
    values = shift + 1.0 / theta
    values[lost_pairs(operator, theta, z, values, "eigenvalues", report)] = np.nan
    if theta[-1].imag and not np.any(np.isclose(theta[:-1], theta[-1].conj(), rtol=SUFFICIENT)):
        values[-1] = np.nan
    return values, z


def rayleigh(x: Array, F: Array, Y: Array) -> Array:
    """theta of op = Q^-1 B from the quotient (x^T B Y)/(x^T B x) of every vector, F = B x, Y = op(x)."""
    return np.asarray(np.sum(F * Y, axis=0) / np.sum(F * x, axis=0))


def is_symmetric_loading(tangent: SparseTangent) -> bool:
    """Is the loading part symmetric? Follower moments and tube flow make it unsymmetric."""
    if not any(len(tangent.parts[k].rows) for k in LOADING[1:]):
        return True  # second derivatives of the deformations are
    a, b = np.zeros((2, tangent.dynamics.numbering.nx))
    a[tangent.F], b[tangent.F] = np.random.default_rng(1).standard_normal((2, tangent.nf))
    G = tangent.assembled(LOADING)
    left, right, size = float(a @ (G @ b)), float(b @ (G @ a)), float(np.abs(a) @ np.abs(G @ np.abs(b)))
    return abs(left - right) <= SYMMETRIC * max(size, 1e-300)


def start_block(tangent: SparseTangent, wanted: int, parts: int = 1) -> Array:
    """Start block (parts nx, p) of positions, or of positions and rates, always the same."""
    n = tangent.dynamics.numbering
    columns = min(wanted + SPARE, parts * n.nddof)
    x = np.zeros((parts, n.nx, columns))
    x[:, tangent.F] = np.random.default_rng(1).standard_normal((parts, tangent.nf, columns))
    return x.reshape(parts * n.nx, columns)


def degrees_of_freedom_of(tangent: SparseTangent, x: Array) -> Array:
    """q_d of displacement shapes (nx, k)."""
    d = tangent.dynamics
    n = d.numbering
    rates = d.kinematics.sweep_rates(x.real)
    if np.iscomplexobj(x):
        rates = rates + 1j * d.kinematics.sweep_rates(x.imag)
    return np.vstack((x[n.x_class["dynamic"]], rates[n.e_class["dynamic"]]))


def lost_pairs(
    operator: Operator, theta: Array, z: Array, values: Array, what: str, report: Report
) -> NDArray[np.bool_]:
    """(k,) which pairs have no known digit. Warns about all with |op(z) - theta z| > SUFFICIENT |theta| |z|, by their
    `values`, the eigenvalues that belong to theta.
    """
    image = operator(z.real) + 1j * operator(z.imag) if np.iscomplexobj(z) else operator(z)
    size = np.maximum(np.abs(theta), LEAST * np.nanmax(np.abs(theta), initial=0.0)) * np.linalg.norm(z, axis=0)
    residual = np.linalg.norm(image - z * theta, axis=0) / np.where(size > 0.0, size, 1.0)
    lost, found = ~(residual <= NO_DIGIT), ~np.isnan(theta)
    if not found.all():
        report.add(
            f"warning: {int((~found).sum())} of {len(theta)} {what} are not found (nan): the search does not converge,"
            " as where many lie close together (strong damping in proportion to stiffness); MODES 0 asks for all"
        )
    advice = "MODES 0 asks for all of them"
    if lost[found].any():
        advice += f"; {int(lost[found].sum())} of which no digit is known are nan"
    backward_error.warn(report, residual[found], values[found], what, SUFFICIENT, advice)
    return np.asarray(lost)


# -- descriptor systems -----------------------------------------------------------------------------------------------
def lowest_modes(system: DescriptorSystem, n_positions: int, nx: int, report: Report, wanted: int) -> Modes:
    """The 2 `wanted` eigenvalues of smallest modulus with the motions of the coordinates (nx, 2 wanted). An eigenvalue
    whose conjugate would be the next one is nan.

    n_positions   rows of the state that are positions

    Raises AnalysisError where the accelerations are not unique.
    """
    n = system.n_states
    count = min(2 * wanted, n)
    start = np.random.default_rng(1).standard_normal((n, min(count + SPARE, n)))

    def better(theta: Complex, shift: float) -> float:
        modulus = np.max(np.abs(shift + 1.0 / np.where(theta != 0.0, theta, 1e-300)))
        return max(OF_MODULUS * float(modulus), 1e-12)

    _, inverse = with_shift(lambda s: _Inverse(system, n_positions, s), 1.0, better, start, count, n)
    values, z = eigenvalues_of(inverse, inverse.shift, start, count, n, report)
    motions = inverse.motions(z, nx)
    z[:n_positions] /= inverse.size
    return arranged(values, z, n_positions, motions)


class _Inverse:
    """The operator op of a descriptor system, for states with their positions multiplied by `size`."""

    def __init__(self, system: DescriptorSystem, n_positions: int, shift: float) -> None:
        from spacar.linear_systems.sparse_factors import SparseFactors

        self.system, self.shift, self.size = system, shift, shift / OF_MODULUS
        self.scale = np.ones(system.n_states)
        self.scale[:n_positions] = self.size
        try:
            self.factors = SparseFactors(system.shifted(shift))
        except RuntimeError:
            raise AnalysisError(MASSLESS, "dynamics.singular-mass") from None

    def everything(self, z: Array) -> Array:
        """All unknowns of (A - s E)^-1 (z, 0)."""
        right = np.zeros((self.system.A.shape[0], z.shape[1]))
        right[: len(z)] = z / self.scale[:, None]
        return np.asarray(self.factors.solve(right))

    def __call__(self, z: Array) -> Array:
        return self.scale[:, None] * self.everything(z)[: len(z)]

    def motions(self, z: Complex, nx: int) -> Complex:
        """dx (nx, k) of the vectors z (scaled) with op z = theta z, norm of z without the scale kept."""
        n = self.system.n_states
        image = self.everything(z.real) + 1j * self.everything(z.imag)
        factor = np.sum((image[:n] * self.scale[:, None]) * z.conj(), axis=0) / np.sum(np.abs(z) ** 2, axis=0)
        return np.asarray(image[n + nx : n + 2 * nx] / factor)
