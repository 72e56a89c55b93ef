"""Linearized equations of motion about any motion (theory-system.md (12), (13)).

    M0 dqdd + (C0 + D0) dqd + (K0 + N0 + G0) ds = W^T df + We^T du,      dsd = Bk0 ds + Ak0 dqd

With G the configuration transfer, Z = d(xd)/ds at fixed qd, Y = d(xdd)/ds at fixed qd and qdd, Yv = d(xdd)/d(qd):

    M0 = W^T M W                        C0 = W^T (M Yv + h_v W)              D0 = We^T S_d We
    K0 = We^T S Ge                      G0 = W^T (Hs(sigma) - df/dx) G
    N0 = W^T (M Y + [d(M xdd)/dx + h_x] G + h_v Z) + We^T S_d Ze

sigma holds all stresses; those of the rows fixed, input and dynamic come from the equilibrium of the calculable
coordinates (10), which makes the sum the exact derivative of the residual also away from equilibrium.
Configuration-dependent gravity and forces of the user (USERSIG) belong to G0 because they are proportional to the load,
the stiffness and the stresses that a user function states to K0; released dampers and tube flow
to N0 and C0.

State z = (ds, dqd) with s = (q, k) and qd restricted to the chosen rows (dynamic ones; all in mode 3):

    A = [Bk0, Ak0; -M^-1 K, -M^-1 C]                                                                           (15)
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from spacar.arrays import EPS, Array, Index
from spacar.dynamics.array_evaluator import Dynamics
from spacar.dynamics.loaded_mechanism import StressLaw
from spacar.errors import AnalysisError
from spacar.kinematics.transfer import Transfer, configuration_transfer, deformation_transfer, velocity_transfer
from spacar.linear_systems.linear_system import Matrix, dense, is_zero_matrix, zero_matrix
from spacar.linearization.coefficients import Coefficients, coefficients
from spacar.mechanism.numbering import Numbering


@dataclass(frozen=True)
class Linearization:
    """Matrices over all degrees of freedom, rows q (ndof), columns q or s (nkdof), and maps to coordinates and
    deformations.

    m0, c0, d0 (ndof, ndof); k0, n0, g0 (ndof, nkdof); ak0 (nkdof, ndof); bk0 (nkdof, nkdof)
    W, We   velocity transfer;  G, Ge   configuration transfer
    Z, Ze   d(xd, ed)/ds;  Y, Ye  d(xdd, edd)/ds;  Yv, Yev  d(xdd, edd)/d(qd)
    c       of coordinates, rates, accelerations and stresses; its sigma (ne,) is that of g0

    Those of type Matrix are sparse when the model is large, but Z to Yev only at rest, where they vanish; in motion
    these are dense.
    """

    m0: Array
    c0: Array
    d0: Array
    k0: Array
    n0: Array
    g0: Array
    ak0: Array
    bk0: Array
    W: Array
    We: Array
    G: Array
    Ge: Array
    Z: Matrix
    Ze: Matrix
    Y: Matrix
    Ye: Matrix
    Yv: Matrix
    Yev: Matrix
    c: Coefficients

    @property
    def transfer(self) -> Transfer:
        return Transfer(self.W, self.We, self.G, self.Ge)

    @cached_property
    def stiffness(self) -> Array:
        return self.k0 + self.n0 + self.g0

    @cached_property
    def damping(self) -> Array:
        return self.c0 + self.d0

    def chosen(self, q: Index, s: Index) -> tuple[Array, Array, Array, Array, Array]:
        """M, C (q, q), K (q, s), ak0 (s, q), bk0 (s, s) of these rows of q and s."""
        M, C, K = selected(self.m0, q, q), selected(self.damping, q, q), selected(self.stiffness, q, s)
        return M, C, K, selected(self.ak0, s, q), selected(self.bk0, s, s)


def linearize(
    dynamics: Dynamics, xdd: Array, sigma: Array, *, law: StressLaw | None = None, t: float = 0.0
) -> Linearization:
    """Linearize about the placed state with accelerations xdd (nx,) and constitutive stresses sigma (ne,).

    The rows fixed, input and dynamic of sigma are replaced by the equilibrium values. `law` overrides which rows are
    elastic (mode 3 treats prescribed deformations as dynamic).
    """
    k = dynamics.kinematics
    c = coefficients(dynamics, xdd, sigma, law=law, t=t)
    W = velocity_transfer(k)
    We, G = deformation_transfer(k, W, c.V), configuration_transfer(k, W)
    Ge = We if G is W else c.V @ G
    M, Me = c.M, c.deformation_inertia
    Z, Ze, Y, Ye, Yv, Yev = _rates(dynamics, c, W, G)
    m0, c0 = _between((W, M, W), (We, Me, We)), _between((W, c.inertia_v, W))
    d0, n0 = _between((We, c.Sd, We), (We, c.stress_v, W), (W, c.user_v, W)), _between((W, c.inertia_x, G))
    if c.moving:
        c0 += W.T @ (M @ Yv) + _between((We, Me, Yev))
        n0 += W.T @ (M @ Y + c.inertia_v @ Z + c.user_v @ Z)
        n0 += _between((We, c.Sd, Ze), (We, c.stress_v, Z), (We, Me, Ye))
    k0 = _between((We, c.S, Ge), (We, c.stress_x, G), (W, c.user_x, G))
    g0 = _between((W, c.geometric + c.load_x, G))
    ak0, bk0 = _kinematic(dynamics, W, We, Z, Ze)
    return Linearization(
        m0=m0, c0=c0, d0=d0, k0=k0, n0=n0, g0=g0, ak0=ak0, bk0=bk0,
        W=W, We=We, G=G, Ge=Ge, Z=Z, Ze=Ze, Y=Y, Ye=Ye, Yv=Yv, Yev=Yev, c=c,
    )  # fmt: skip


def _between(*terms: tuple[Array, Matrix, Array]) -> Array:
    """Sum of left^T A right, dense; products with zero are left out."""
    left, _, right = terms[0]
    products = [np.asarray((u.T @ A) @ v) for u, A, v in terms if not is_zero_matrix(A)]
    return sum(products[1:], products[0]) if products else np.zeros((left.shape[1], right.shape[1]))


def _rates(dynamics: Dynamics, c: Coefficients, W: Array, G: Array) -> tuple[Matrix, ...]:
    """Z, Ze, Y, Ye, Yv, Yev, which vanish at rest."""
    k, V = dynamics.kinematics, c.V
    if not c.moving:
        xs, es = zero_matrix(G.shape), zero_matrix((len(c.sigma), G.shape[1]))
        return xs, es, xs, es, zero_matrix(W.shape), zero_matrix((len(c.sigma), W.shape[1]))
    zero_x = np.zeros_like
    Z = k.dependent(zero_x(G), -c.rate_x @ G)
    Ze = V @ Z + c.rate_x @ G
    convected = c.second_x @ G + c.second_v @ Z
    Y = k.dependent(zero_x(G), -convected)
    Ye = V @ Y + convected
    swept = c.second_v @ W
    Yv = k.dependent(zero_x(W), -swept)
    return Z, Ze, Y, Ye, Yv, V @ Yv + swept


def _kinematic(dynamics: Dynamics, W: Array, We: Array, Z: Matrix, Ze: Matrix) -> tuple[Array, Array]:
    """Ak0 = [I; W_xk; We_ek], Bk0 = [0; Z_xk; Ze_ek]."""
    n = dynamics.numbering
    xk, ek = n.x_class["kinematic"], n.e_class["kinematic"]
    bk0 = np.zeros((n.nkdof, n.nkdof))
    if not n.nk:
        return np.eye(n.ndof), bk0
    bk0[n.ndof :] = np.vstack((dense(Z[xk]), dense(Ze[ek])))
    return np.vstack((np.eye(n.ndof), W[xk], We[ek])), bk0


def chosen_rows(n: Numbering, everything: bool = False) -> tuple[Index, Index]:
    """Rows of q and of s that are states: the dynamic ones (and the kinematic ones), or all of them (mode 3)."""
    q = np.arange(n.ndof) if everything else n.dynamic
    return q, np.concatenate((q, np.arange(n.ndof, n.nkdof))) if n.nk else q


def selected(A: Array, rows: Index, columns: Index) -> Array:
    """A copy of A at these rows and columns."""
    return A.take(rows, axis=0).take(columns, axis=1)


MASSLESS = "singular mass matrix: a degree of freedom carries no mass; add XM or EM"


def require_mass(L: Linearization, q: Index) -> None:
    """Raises AnalysisError when the mass of a degree of freedom of the rows q is rounding of what it is the sum of.

    The sign of that rounding decides nothing: W^T M W is known to eps times nx times the sum of the sizes of its terms.
    Masses that overflow are not told here.
    """
    diagonal, W = L.m0.diagonal()[q], np.abs(L.W[:, q])
    with np.errstate(over="ignore", invalid="ignore"):
        terms = (W * np.asarray(abs(L.c.M) @ W)).sum(0)
    if np.any((diagonal <= EPS * len(W) * terms) & (terms > 0.0) & np.isfinite(terms)):
        raise AnalysisError(MASSLESS, "dynamics.singular-mass")


def state_matrix(L: Linearization, q: Index, s: Index) -> Array:
    """A of (15). Raises AnalysisError when the mass matrix of the rows q is singular."""
    return assembled_state_matrix(*L.chosen(q, s))


def assembled_state_matrix(M: Array, C: Array, K: Array, ak0: Array, bk0: Array) -> Array:
    """A of (15) from M, C (q, q), K (q, s), ak0 (s, q), bk0 (s, s). Raises AnalysisError when M is singular."""
    return np.block([[bk0, ak0], [-solve_mass(M, np.hstack((K, C)))]])


def solve_mass(M: Array, b: Array) -> Array:
    """M^-1 b for a symmetric positive definite M, scaled to a unit diagonal. Raises AnalysisError for a singular M."""
    diagonal = np.diag(M)
    if np.any(diagonal <= 0.0):
        raise AnalysisError(MASSLESS, "dynamics.singular-mass")
    try:
        return scaled_solution(M, b, 1.0 / np.sqrt(diagonal))
    except np.linalg.LinAlgError:
        raise AnalysisError("singular mass matrix; add XM or EM", "dynamics.singular-mass") from None


def scaled_solution(A: Array, b: Array, d: Array) -> Array:
    """A^-1 b (n, k) with the rows and columns of A multiplied by d (n,). Raises LinAlgError."""
    return np.asarray(np.linalg.solve(A * np.outer(d, d), b * d[:, None]) * d[:, None])
