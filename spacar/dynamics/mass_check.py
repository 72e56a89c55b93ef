"""Is the reduced mass matrix of the dynamic degrees of freedom regular? Says which motion carries no mass.

M_dd = W_d^T (M + V^T M_e V) W_d is singular when a motion w that the constraints admit, V_R w = 0, has no kinetic
energy. What is known of M_dd depends on the condition of D = V[E, U], which W comes from, in both directions: two
degrees of freedom that cross at an angle d give the smallest eigenvalue d^2 to a free mass, and a motion without mass
gets the energy (eps cond D)^2 of rounding, which scaling to a unit diagonal makes 1. So there are two looks.

The first is cheap, and says where there is nothing to doubt. The position, and with it V, is known to n eps cond D (n
coordinates), columns of W to that times their size, which is cond D at most: of M_dd, in the sizes of the degrees of
freedom (length or radian), rounding can give a motion without mass the part r = (8 n eps cond^2 D)^2 of the largest
mass m. There is no doubt where each degree of freedom has more than max(sqrt(eps), r) m, and no eigenvalue of M_dd
scaled to a unit diagonal is below sqrt(eps), or r m over the smallest. The sums are known to q eps (Weyl), far below.

The second asks the constraints, without the degrees of freedom. Coordinates are scaled to a unit diagonal of M and
rows of V_R to norm 1 (the scales of the saddle-point form, so that mass ratios do not count either); Z is an
orthonormal basis of the admissible motions, from a QR factorization of V_R^T (n coordinates). The eigenvector z of the
smallest eigenvalue of Z^T M Z has the energy E = z^T M z. Z is known to n eps |V_R|/s, s the smallest singular value of
V_R (Wedin), and M times a motion to n eps |M| |z|. Energies are squares, so the first error z' of a motion without
energy gives z'^T M z', not more:

    regular:  E > 8 n eps |z|^T |M| |z| + |M| (8 n eps |V_R|/s)^2

Below that not one digit of the accelerations along z is known: it is refused. A nearly dead position with sin d as the
transfer to the only mass has E of order d^2, and is accepted from d of some n eps on. V_R is that of the position as it
was placed, which the degrees of freedom give to n eps cond D only: a motion whose energy is below the same with cond D
as one more factor is accepted with a warning, as there may be a dead point within rounding. M is semi-definite when it
comes from masses; a negative one (XM, MEE) that makes E negative is refused too.

A large model is asked by the factors of its saddle-point form, in the same scales. The upper left block of the inverse
is Z (Z^T M Z)^-1 Z^T, of norm 1/E, so that a few solutions (power method) give the motion with the least energy. With
|V_R|/s >= 1 and |M| >= 1 that is refused where E <= 8 n eps |z|^T |M| |z| + (8 n eps)^2, and with the condition of D
for |V_R|/s, which it is at most, there is a warning.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import EPS, Array
from spacar.dynamics.loaded_mechanism import DeformationInertia
from spacar.dynamics.saddle_point import SaddlePoint
from spacar.errors import AnalysisError
from spacar.kinematics.element_sweep import ElementSweep
from spacar.kinematics.kinematics import Kinematics
from spacar.kinematics.transfer import velocity_transfer
from spacar.linear_systems import SingularMatrixError
from spacar.mechanism.mechanism import Mechanism
from spacar.mechanism.numbering import Numbering

DOUBTFUL = EPS**0.5  # half of the digits: eigenvalue scaled to a unit diagonal, mass over the largest
LARGEST_CHECKED = 400  # dense work of order nx nq^2; larger models are asked by the factors of their equations
ITERATIONS = 3  # of the power method: a motion without inertia exceeds all others by 1/eps in the first
LOOKED_AT = 1e-6  # energy, in units of an ordinary coordinate, from which the condition is not asked: cost only


def is_doubtful(mechanism: Mechanism, M: Array, condition: float, largest: float) -> bool:
    """Whether the first look leaves a doubt.

    M: reduced mass matrix of the dynamic degrees of freedom, (nddof, nddof); condition: of D, in any norm; largest:
    `largest_mass`, kg m^2.
    """
    n = mechanism.numbering
    x, e = n.x_class["dynamic"], n.e_class["dynamic"]
    size = np.concatenate((mechanism.scale[x], mechanism.deformation_scale[e]))
    diagonal = M.diagonal()
    mass = diagonal * size**2
    rounding = (8.0 * n.nx * EPS * condition**2) ** 2 * largest
    if not mass.min() > max(DOUBTFUL * largest, rounding, 0.0):
        return True
    scale = 1.0 / np.sqrt(diagonal)
    A = M * (scale[:, None] * scale)
    A.reshape(-1)[:: len(A) + 1] -= max(DOUBTFUL, rounding / mass.min())
    try:  # an eigenvalue below that is a negative one now
        np.linalg.cholesky(A)
    except np.linalg.LinAlgError:
        return True
    return False


def largest_mass(mechanism: Mechanism, sweep: ElementSweep) -> float:
    """Largest diagonal entry of M in the sizes of the coordinates, kg m^2, at the configuration of the sweep."""
    return _largest(mechanism, sweep.mass_diagonal())


def _largest(mechanism: Mechanism, diagonal: Array) -> float:
    """The same of the diagonal of M, (nx,)."""
    return float(np.max(diagonal * mechanism.scale**2, initial=0.0))


def require_regular_mass(mechanism: Mechanism, saddle: SaddlePoint, condition: float) -> str | None:
    """The second look, at the configuration of the sweep; condition: of D there. A warning where it matters.

    Raises AnalysisError 'dynamics.singular-mass' naming the degrees of freedom without mass.
    """
    massless, doubtful = _motions_of_rounding(mechanism, saddle, condition)
    if massless:
        raise _without_inertia(mechanism, massless)
    return _of_rounding(doubtful, condition) if doubtful else None


def require_inertia_of_many(mechanism: Mechanism, saddle: SaddlePoint, condition: Callable[[], float]) -> str | None:
    """The look at a large model, at the configuration of the sweep; see the head of the module.

    Raises AnalysisError 'dynamics.singular-mass' naming the degrees of freedom without mass.
    """
    sweep, F = saddle.sweep, saddle.F
    try:
        saddle.factor()
    except SingularMatrixError:
        return None  # the equations of motion say it, with the unknown
    scale, nothing = saddle.scale[: len(F)], np.zeros(sweep.ne)
    force, z = np.zeros(sweep.nx), np.ones(len(F))
    for _ in range(ITERATIONS):
        force[F] = z / (scale * np.linalg.norm(z))
        z = saddle.solve(force, nothing)[0] / scale
        if not (np.isfinite(z).all() and z.any()):
            return None
    v = np.zeros(sweep.nx)
    v[F] = scale * z / np.linalg.norm(z)
    rates = sweep.rate(v)
    i, j, value = saddle.coupling.table
    kinetic = sweep.m_entries * v[sweep.m_rows] * v[sweep.m_columns]
    terms = np.concatenate((kinetic, value * rates[i] * rates[j]))
    energy, known = float(terms.sum()), 8.0 * len(F) * EPS
    if not energy > known * float(np.abs(terms).sum()) + known**2:
        raise _without_inertia(mechanism, _named(mechanism, v[:, None], rates[:, None]))
    if energy > LOOKED_AT or energy > (known * condition()) ** 2:
        return None
    return _of_rounding(_named(mechanism, v[:, None], rates[:, None]), condition())


def linearized_doubt(
    mechanism: Mechanism, elements: Callable[[], ElementSweep], masses: Array, M: Array, condition: float,
    everything: bool = False,
) -> str | None:  # fmt: skip
    """What linearized equations at the configuration of the sweep `elements` are warned of, None: nothing.

    masses: (nx,) diagonal of the mass matrix of the coordinates; M: as for `is_doubtful`; condition: of D. A degree of
    freedom without any entry is not looked at: who needs its inertia refuses it. Neither is a large model: its lowest
    modes come from the sparse pencil, which keeps all coordinates.
    `everything`: M is that of all degrees of freedom, prescribed ones too (mode 3).
    """
    if everything:
        mechanism = replace(mechanism, numbering=mechanism.numbering.all_dynamic)
    n = mechanism.numbering
    if not is_checked(n) or not M.diagonal().all():
        return None
    with np.errstate(over="ignore"):
        largest = _largest(mechanism, masses)
    if not np.isfinite(largest) or not is_doubtful(mechanism, M, condition, largest):
        return None
    massless, doubtful = _motions_of_rounding(mechanism, SaddlePoint(mechanism, elements()), condition)
    if not (massless or doubtful):
        return None
    result = "frequencies of this motion have no right digit; add mass (XM, EM)"
    return _of_rounding(massless or doubtful, condition, result)


def _without_inertia(mechanism: Mechanism, names: str) -> AnalysisError:
    advice = "add mass (XM, EM) or prescribe (INPUTX, INPUTE) or release (RLSE) it"
    if mechanism.deck.divided:
        advice = "add mass (XM, EM): all parts of a divided beam but the last need it, even released (torsion: J of EM)"
    text = f"singular mass matrix: no inertia on the motion of {names}; {advice}"
    return AnalysisError(text, "dynamics.singular-mass")


def _of_rounding(
    names: str, condition: float, result: str = "the accelerations may have no right digit; begin elsewhere"
) -> str:
    text = f"the inertia on the motion of {names} is that of rounding in the position (condition {condition:.2g})"
    return f"{text}: {result}, or choose other degrees of freedom"


def _motions_of_rounding(mechanism: Mechanism, saddle: SaddlePoint, condition: float) -> tuple[str, str]:
    """Names of the degrees of freedom that move without inertia, and of those whose inertia may be rounding."""
    n, sweep, F = mechanism.numbering, saddle.sweep, saddle.F
    nf, m = len(F), saddle.n_rows
    x, row = saddle.scale[:nf], saddle.scale[nf:]
    V = sweep.gradient()
    mass = np.zeros((n.nx, n.nx))
    np.add.at(mass, (sweep.m_rows, sweep.m_columns), sweep.m_entries)
    i, j, value = saddle.coupling.table
    mass += V[i].T @ (value[:, None] * V[j])
    mass = mass[np.ix_(F, F)] * (x[:, None] * x)
    Z, known = _admissible(V[:m, F] * (row[:, None] * x))
    energy, vectors = np.linalg.eigh(Z.T @ mass @ Z)
    z = Z @ vectors
    size = float(np.abs(mass).sum(axis=1).max(initial=0.0))
    # eigh knows the energies to eps |M| only: they are formed again from the motions
    energy = np.einsum("ik,ik->k", z, mass @ z)
    sums = 8.0 * nf * EPS * np.einsum("ik,ik->k", np.abs(z), np.abs(mass) @ np.abs(z))
    physical = np.zeros((n.nx, len(energy)))
    physical[F] = x[:, None] * z

    def named(motions: NDArray[np.bool_]) -> str:
        moved = physical[:, motions]
        return _named(mechanism, moved, V @ moved) if motions.any() else ""

    massless = ~(energy > sums + size * known**2)
    return named(massless), named(~(energy > sums + size * (known * condition) ** 2))


def _named(mechanism: Mechanism, motions: Array, rates: Array) -> str:
    """Names of the degrees of freedom that take part in the motions (nx, k) with these rates (ne, k), six at most."""
    n = mechanism.numbering
    of_x = motions[n.q_x] / mechanism.scale[n.q_x, None]
    of_e = rates[n.q_e] / mechanism.deformation_scale[n.q_e, None]
    moved = np.abs(np.concatenate((of_x, of_e))[n.dynamic])
    weight = (moved / moved.max(axis=0)).max(axis=1)
    return ", ".join([n.q_names[n.dynamic[k]] for k in np.flatnonzero(weight > 0.1)][:6])


def _admissible(V: Array) -> tuple[Array, float]:
    """Orthonormal basis of the null space of V (m, n), (n, n - m), and to what it is known."""
    m, n = V.shape
    if not m:
        return np.eye(n), 0.0
    Q, R = np.linalg.qr(V.T, mode="complete")
    s = np.linalg.svd(R[:m], compute_uv=False)
    return Q[:, m:], 8.0 * n * EPS * float(s[0] / s[-1]) if s[-1] > 0.0 else float("inf")


def is_checked(n: Numbering) -> bool:
    """Whether the model is small enough for the check."""
    return n.nddof > 0 and n.ndof <= LARGEST_CHECKED


def dynamic_mass(k: Kinematics, coupling: DeformationInertia) -> Array:
    """W^T (M + V^T M_e V) W of the dynamic degrees of freedom, (nddof, nddof), at the placed configuration."""
    W = velocity_transfer(k)[:, k.numbering.dynamic]
    M = np.array([k.sweep.mass_times(column) for column in W.T]) @ W
    if coupling.present:
        i, j, value = coupling.table
        We = k.sweep_rates(W)
        M += We[i].T @ (value[:, None] * We[j])
    return M
