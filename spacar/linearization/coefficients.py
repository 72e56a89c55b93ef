"""What the linearized equations consist of before any degrees of freedom are chosen: sums of element blocks.

Of the coordinates x, rates v = xd, accelerations a = xdd and stresses sigma, about one state (theory-system.md 0, 4.1):

    d(M a + h + V^T sigma)      = M da + inertia_v dv + (inertia_x + geometric) dx + V^T dsigma
    d(-f)                       = (load_x + user_x) dx + user_v dv
    d(ed) = V dv + rate_x dx,   rate_x = H1(v)
    d(edd) = V da + second_v dv + second_x dx,   second_v = H1(v) + H2(v), second_x = H1(a) + T(v)
    dsigma = S de + Sd ded + stress_x dx + stress_v dv of the active rows (+ deformation_inertia dedd everywhere,
             part of M0)

load_x: gravity, constant moments and forces of the user, with e = D(x), ed = V v in these; user_x: the stiffness that
the user states of forces (column k), which is no load. S, Sd, stress_x, stress_v contain the stresses of the user.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from spacar.arrays import EPS, Array, Index
from spacar.dynamics.array_evaluator import Dynamics
from spacar.dynamics.loaded_mechanism import StressLaw, moment_entries
from spacar.kinematics.element_sweep import ElementSweep, geometric_blocks, gradient_blocks
from spacar.linear_systems.linear_system import Matrix, diagonal_matrix, matrix, zero_matrix
from spacar.linearization.user_derivatives import UserDerivatives, user_derivatives
from spacar.mechanism.layout import Batch
from spacar.mechanism.mechanism import UserForces

Blocks = list[tuple[Batch, Array]]


def _sum(blocks: list[tuple[Index, Index, Array]], shape: tuple[int, int]) -> Matrix:
    """Sum of element blocks (a, b, n) at these rows (a, n) and columns (b, n)."""
    if not blocks:
        return zero_matrix(shape)
    rows = [np.broadcast_to(i[:, None], block.shape).ravel() for i, _, block in blocks]
    columns = [np.broadcast_to(j[None], block.shape).ravel() for _, j, block in blocks]
    values = [block.ravel() for *_, block in blocks]
    return matrix(np.concatenate(rows), np.concatenate(columns), np.concatenate(values), shape)


def _by_rows(sweep: ElementSweep, fill: Callable[[Batch, Array], None]) -> Matrix:
    """Sum of element blocks (n_deformations, n_coordinates, n) as (ne, nx)."""
    return _sum([(b.e, b.x, block) for b, block in gradient_blocks(sweep, fill)], (sweep.ne, sweep.nx))


def rate_gradients(sweep: ElementSweep, v: Array, a: Array) -> tuple[Matrix, Matrix, Matrix]:
    """H1(v), H1(v) + H2(v), H1(a) + T(v), (ne, nx) each: rate_x, second_v, second_x."""

    def of(method: Callable[[Batch], Callable[[Any, Array, Array], None]], u: Array) -> Matrix:
        return _by_rows(sweep, lambda b, out: method(b)(sweep.configuration[b.index], u[b.x], out))

    rate_x, by_a = (of(lambda b: b.family.gradient_rate, u) for u in (v, a))
    transport, by_x = of(lambda b: b.family.gradient_transport, v), of(lambda b: b.family.rate_gradient, v)
    return rate_x, rate_x + transport, by_a + by_x


def scatter(nx: int, blocks: Blocks) -> Matrix:
    """Sum of square element blocks as (nx, nx)."""
    return _sum([(b.x, b.x, block) for b, block in blocks], (nx, nx))


def geometric_stiffness(sweep: ElementSweep, sigma: Array) -> Matrix:
    """Hs(sigma), (nx, nx)."""
    if not sigma.any():
        return zero_matrix((sweep.nx, sweep.nx))
    return scatter(sweep.nx, geometric_blocks(sweep, sigma))


def geometric_rounding(sweep: ElementSweep, sigma: Array, scale: Array, W: Array) -> Array:
    """What rounding can make of W^T Hs(sigma) W for the motions W (nx, n), (n, n).

    An element knows its Hs to 8 eps of its largest entry, with coordinates in their sizes `scale` (nx,); motions along
    which the others cancel (a bar along its axis) leave nothing but that.
    """
    n = W.shape[1]
    out, moved = np.zeros((n, n)), np.abs(W) / scale[:, None]
    for b, block in geometric_blocks(sweep, sigma):
        size = scale[b.x]
        largest = np.abs(block * size[:, None] * size).max(axis=(0, 1))
        most = moved[b.x].max(axis=0)
        out += (most * largest[:, None]).T @ most
    return np.asarray(8.0 * EPS * out)


def mass_matrix(sweep: ElementSweep) -> Matrix:
    """M, (nx, nx), from the entries of the last mass evaluation."""
    return matrix(sweep.m_rows, sweep.m_columns, sweep.m_entries, (sweep.nx, sweep.nx))


def gradient_matrix(sweep: ElementSweep) -> Matrix:
    """V, (ne, nx), at the present configuration."""
    return matrix(sweep.v_rows, sweep.v_columns, sweep.v_entries, (sweep.ne, sweep.nx))


def inertia_blocks(sweep: ElementSweep, v: Array, a: Array) -> tuple[Blocks, Blocks]:
    """d(M a + h)/dx and dh/dv per batch of the configuration-dependent families."""
    found = [(b, b.family.inertia_gradient(sweep.configured(b), v[b.x], a[b.x])) for b in sweep.moving]
    return [(b, by_x) for b, (by_x, _) in found], [(b, by_v) for b, (_, by_v) in found]


@dataclass(frozen=True)
class Coefficients:
    """The matrices of the module's formulas, sparse when the model is large (`spacar.linear_systems.linear_system`).

    V, rate_x, second_v, second_x, stress_x, stress_v  (ne, nx);  S, Sd, deformation_inertia  (ne, ne);
    all others  (nx, nx)
    sigma   (ne,) stresses: rows fixed, input and dynamic from the equilibrium of the calculable coordinates
    moving  is there any motion? At rest rate_x, second_v, second_x are zero
    user    derivatives of the user function, if there is one
    """

    V: Matrix
    M: Matrix
    rate_x: Matrix
    second_v: Matrix
    second_x: Matrix
    inertia_x: Matrix
    inertia_v: Matrix
    geometric: Matrix
    load_x: Matrix
    user_x: Matrix
    user_v: Matrix
    S: Matrix
    Sd: Matrix
    deformation_inertia: Matrix
    stress_x: Matrix
    stress_v: Matrix
    sigma: Array
    moving: bool
    user: UserDerivatives | None = None


def coefficients(
    dynamics: Dynamics, xdd: Array, sigma: Array, *, law: StressLaw | None = None, t: float = 0.0
) -> Coefficients:
    """At the placed state with accelerations xdd (nx,), constitutive stresses sigma (ne,); arguments as `linearize`."""
    k, sweep, n = dynamics.kinematics, dynamics.sweep, dynamics.numbering
    law = law or dynamics.law
    x, xd = k.x, dynamics.xd
    sweep.mass()
    V, M = gradient_matrix(sweep), mass_matrix(sweep)
    user = dynamics.forces.user(t, sweep.e, V @ xd, x, xd) if dynamics.forces.user is not None else None
    edd = V @ xdd + sweep.convective(xd)
    sigma = equilibrium_stresses(dynamics, xdd, edd, sigma, user)
    moving = bool(xd.any() or xdd.any())
    rate_x = second_v = second_x = zero_matrix((n.ne, n.nx))
    if moving:
        rate_x, second_v, second_x = rate_gradients(sweep, xd, xdd)
    by_x, by_v = inertia_blocks(sweep, xd, xdd)
    Me = matrix(*dynamics.mechanism.deformation_inertia, (n.ne, n.ne))
    stress = sigma + Me @ edd if dynamics.coupling.present else sigma
    S, Sd = matrix(*law.stiffness, (n.ne, n.ne)), matrix(*law.damping, (n.ne, n.ne))
    load_x, user_x, user_v = load_gradient(dynamics), *2 * (zero_matrix((n.nx, n.nx)),)
    stress_x = stress_v = zero_matrix((n.ne, n.nx))
    by: UserDerivatives | None = None
    if user is not None:
        active = np.arange(n.ne) >= law.first
        by = user_derivatives(dynamics.mechanism, t, sweep.e, V @ xd, x, xd, active).with_stated(user, V)
        S, Sd = S + by.of("sigma", "e"), Sd + by.of("sigma", "ed")
        stress_x, stress_v = by.of("sigma", "x"), by.of("sigma", "xd")
        user_x = diagonal_matrix(user.force_k)
        load_x = load_x - user_x - (by.of("f", "x") + by.of("f", "e") @ V + by.of("f", "ed") @ rate_x)
        user_v = -(by.of("f", "xd") + by.of("f", "ed") @ V)
    inertia_x, inertia_v, geometric = scatter(n.nx, by_x), scatter(n.nx, by_v), geometric_stiffness(sweep, stress)
    return Coefficients(
        V=V, M=M, rate_x=rate_x, second_v=second_v, second_x=second_x, inertia_x=inertia_x, inertia_v=inertia_v,
        geometric=geometric, load_x=load_x, user_x=user_x, user_v=user_v, S=S, Sd=Sd, deformation_inertia=Me,
        stress_x=stress_x, stress_v=stress_v, sigma=sigma, moving=moving, user=by,
    )  # fmt: skip


def structure(dynamics: Dynamics, moving: bool, law: StressLaw | None = None) -> Coefficients:
    """Coefficients with a positive number wherever any state may have an entry. Sums and products of them show where
    those of a state may have entries. `moving`: may the mechanism move at all? `law` as `linearize`.
    """
    law = law or dynamics.law
    sweep, n, m = dynamics.sweep, dynamics.numbering, dynamics.mechanism
    blocks = _by_rows(sweep, lambda b, out: out.fill(1.0)) if moving else zero_matrix((n.ne, n.nx))
    curved, massive = (scatter(n.nx, [(b, np.ones((len(b.x), len(b.x), b.family.n))) for b in batches])
                       for batches in (sweep.curved, sweep.moving))  # fmt: skip
    moments = [loads.moment_rows for loads in (m.loads, m.additional) if loads is not None]
    by_moments = _sum([(rows, rows, np.ones((4, *rows.shape))) for rows in moments], (n.nx, n.nx))
    stresses, forces = (getattr(m.user_signal, rows, {}) for rows in ("stresses", "forces"))  # of calls before
    by_stress, by_push = _full_rows(stresses.values(), (n.ne, n.nx)), _full_rows(forces.values(), (n.nx, n.nx))
    laws = [matrix(rows, columns, np.ones(len(rows)), (n.ne, n.ne))
            for rows, columns, _ in (law.stiffness, law.damping, m.deformation_inertia)]  # fmt: skip
    return Coefficients(
        V=matrix(sweep.v_rows, sweep.v_columns, np.ones(len(sweep.v_rows)), (n.ne, n.nx)),
        M=matrix(sweep.m_rows, sweep.m_columns, np.ones(len(sweep.m_rows)), (n.nx, n.nx)),
        rate_x=blocks, second_v=blocks, second_x=blocks, inertia_x=massive, inertia_v=massive, geometric=curved,
        load_x=massive + by_moments, user_x=by_push, user_v=by_push,
        S=laws[0], Sd=laws[1], deformation_inertia=laws[2], stress_x=by_stress, stress_v=by_stress,
        sigma=np.zeros(n.ne), moving=moving,
    )  # fmt: skip


def _full_rows(rows: Iterable[int], shape: tuple[int, int]) -> Matrix:
    found = np.array(sorted(set(rows)), np.int64)
    columns = np.tile(np.arange(shape[1]), len(found))
    return matrix(found.repeat(shape[1]), columns, np.ones(len(columns)), shape)


def equilibrium_stresses(dynamics: Dynamics, xdd: Array, edd: Array, sigma: Array, user: UserForces | None) -> Array:
    """sigma with the rows fixed, input, dynamic from the equilibrium of the calculable coordinates (10)."""
    sweep = dynamics.sweep
    sigma = sigma.copy()
    force = sweep.mass_times(xdd) + dynamics.forces.inertia(sweep, dynamics.xd)
    force -= dynamics.forces(dynamics.kinematics.x, user)
    if dynamics.coupling.present:
        force += sweep.rate_transposed(dynamics.coupling.stress(edd))
    dynamics.kinematics.reactions(force, sigma)
    return sigma


def load_gradient(dynamics: Dynamics) -> Matrix:
    """-df/dx of gravity and of constant global moments, (nx, nx)."""
    n, sweep = dynamics.numbering, dynamics.sweep
    out = zero_matrix((n.nx, n.nx))
    forces = dynamics.forces
    zero = np.zeros(n.nx)
    if forces.heavy and sweep.moving:
        with_g, _ = inertia_blocks(sweep, zero, -forces.field)
        without, _ = inertia_blocks(sweep, zero, zero)
        out = scatter(n.nx, with_g) - scatter(n.nx, without)
    if forces.loads.moment_rows.size:
        out = out - matrix(*moment_entries(forces.loads.moment_rows, forces.loads.moment), (n.nx, n.nx))
    return out
