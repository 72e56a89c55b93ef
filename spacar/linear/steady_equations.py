"""Are the linearized equations about a steady motion the same at every time?

Eigenvalues, multipliers and state space matrices mean something where the equations in the degrees of freedom q keep
their coefficients while the prescribed motion goes on. In coordinates that turn with a rotor they do. In coordinates
of fixed directions those of an unsymmetric rotor are periodic in time (Floquet), and a mass that is off the axis is in
no equilibrium. So the prescribed values go on by STEP (rad, or lengths of the model) at the same q, and M, C, K there,
and the generalized force r that is zero at the solution, are compared with those at the solution:

    |dM_ij| / sqrt(m_i m_j),   |dC_ij| / sqrt(c_i c_j),   |dK_ij| / sqrt(k_i k_j),   |r_i| / (k_i size_i)
    m_i = M_ii,   k_i = |K0|_ii + |N0|_ii + |G0|_ii,   c_i = |C|_ii + sqrt(k_i m_i),   size_i that of q_i

where m_i and k_i are at least LEAST times those of the heaviest and the stiffest q (in their sizes), and k_i at least
SAID w^2 m_i, w the largest prescribed rate: below that they are rounding.
A prescribed angle goes on with its rate. Euler parameters l of a uniform rotation go on along a great circle,
l cos wt + l' sin(wt)/w with w = |l'|, half the angular velocity.

Where the mechanism can turn along with what is prescribed, degrees of freedom that do so are the remedy. Where not
(a crank, a rod that lengthens) the equations are those of a frozen position in any degrees of freedom; this is said.

Non-holonomic systems, which go on along their kinematic coordinates too, are not compared.
"""

from dataclasses import replace

import numpy as np

from spacar.arrays import Array, Index
from spacar.dynamics.array_evaluator import Dynamics
from spacar.errors import AnalysisError, Report
from spacar.kinematics.kinematics import largest
from spacar.kinematics.transfer import moved_along
from spacar.linear_systems import SingularMatrixError
from spacar.linearization.matrices import Linearization, linearize, selected
from spacar.mechanism.mechanism import DriveState, Mechanism
from spacar.stationary.loading import LoadLevel, SteadyDrive

STEP = 0.1  # chosen: far enough to see any change, near enough to be reached from the solution
SAID = 1e-6  # chosen: numbers of a file have six digits, a rotor whose blades stand at 0.866025 is a symmetric one
LEAST = 1e-10  # chosen: far above rounding
REFUSED = 1e-3  # chosen: eigenvalues then change by more than masses and stiffnesses are known


def require_steady(now: Linearization, dynamics: Dynamics, y: Array, level: LoadLevel, report: Report) -> None:
    """Compare the equations about a steady solution, where `dynamics` stands, with those a little later.

    `now`: the linearized equations; y (nddof,): the degrees of freedom. Warns where the equations change; raises
    AnalysisError 'statics.not-steady' where they do in degrees of freedom that are coordinates.
    """
    n, m = dynamics.numbering, dynamics.mechanism
    if not len(n.dynamic):
        return
    w = _fastest(m, dynamics.drive.at(0.0))
    try:
        later, force = _later(dynamics, y, STEP / w)
    except (AnalysisError, SingularMatrixError):
        return  # out of reach: nothing can be told
    size = np.concatenate((m.scale[n.q_x], m.deformation_scale[n.q_e]))[n.dynamic]
    change = _change(now, later, force[n.dynamic], n.dynamic, size, w)
    worst = largest(change)
    if not worst > SAID:
        return
    text = (
        f"at {level} the linearized equations do not stay the same while the prescribed motion goes on: they change by"
        f" {worst:.2g} (relative) on the next {STEP} rad or model lengths"
    )
    fixed = [n.q_names[i] for i, c in zip(n.dynamic, change, strict=True) if c > REFUSED and i < len(n.q_x)]
    if fixed and _turns_along(dynamics, w):
        named = ", ".join(fixed[:4]) + (", ..." if fixed[4:] else "")
        raise AnalysisError(
            f"{text}, so that they have no eigenvalues: {named} (DYNX) keep their directions while the mechanism moves."
            " Take degrees of freedom that move along (DYNE: deformations and relative angles of elements), or no"
            " prescribed rate for the mechanism at rest",
            "statics.not-steady",
        )
    report.add(f"warning: {text}: this is no steady motion, the results are those of equations frozen in this position")


def _turns_along(dynamics: Dynamics, w: float) -> bool:
    """Can the mechanism go along with prescribed displacements and angles while nothing that has a stress deforms?

    Then degrees of freedom that move along make a steady motion of it, else none do.
    """
    n, m, law, drive = dynamics.numbering, dynamics.mechanism, dynamics.law, dynamics.drive.at(0.0)
    given, inputs = n.x_class["fixed"].stop, n.x_class["input"]
    ed = np.zeros(n.ne)
    ed[n.e_class["input"]] = drive.ed
    if m.is_length[ed != 0.0].any():
        return False
    V = dynamics.sweep.gradient()
    loose = np.setdiff1d(np.arange(law.first, n.ne), np.concatenate((law.stiffness[0], law.damping[0])))
    rows = np.setdiff1d(np.arange(n.ne), loose)
    columns = np.r_[given : inputs.start, inputs.stop : n.nx]
    A = V[rows[:, None], columns] * m.scale[columns] / m.deformation_scale[rows, None]
    b = (ed[rows] - V[rows, inputs] @ drive.xd) / m.deformation_scale[rows]
    v = np.linalg.lstsq(A, b, rcond=None)[0]
    return largest(A @ v - b) <= SAID * w


def _fastest(m: Mechanism, drive: DriveState) -> float:
    n = m.numbering
    sizes = m.scale[n.x_class["input"]], m.deformation_scale[n.e_class["input"]]
    return max(largest(drive.xd / sizes[0]), largest(drive.ed / sizes[1]))


def _later(dynamics: Dynamics, y: Array, t: float) -> tuple[Linearization, Array]:
    """The linearized equations when the prescribed motion has gone on for t, and the generalized force (ndof,) that
    is missing there for the same degrees of freedom. Raises AnalysisError or SingularMatrixError out of reach."""
    n = dynamics.numbering
    drive = dynamics.drive.at(0.0)
    x, xd, xdd = np.zeros((3, n.nx))
    places = n.x_class["input"]
    x[places], xd[places] = drive.x + t * drive.xd, drive.xd
    if len(n.turning):
        turned = np.isin(n.euler, np.arange(places.start, places.stop))
        now, rate = dynamics.kinematics.x[n.euler], dynamics.xd[n.euler]
        half = np.sqrt(np.sum(rate * rate, axis=0))  # of the angular velocity
        along = now * np.cos(half * t) + rate * t * np.sinc(half * t / np.pi)
        x[n.euler[turned]], xdd[n.euler[turned]] = along[turned], -(half**2 * along)[turned]
        xd[n.euler[turned]] = (rate * np.cos(half * t) - now * half * np.sin(half * t))[turned]
    e = drive.e + t * drive.ed
    later = dynamics.fork()
    state = DriveState(x[places], xd[places], xdd[places], e, drive.ed, drive.edd)
    later.use(replace(dynamics.model, drive=SteadyDrive(state)))
    later.place(0.0, np.concatenate((y, np.zeros(n.nddof))))
    k, sweep = later.kinematics, later.sweep
    sigma, user = later.constitutive(0.0)
    convective = sweep.convective(later.xd)
    a = k.dependent(xdd, -convective)
    sweep.mass()
    stress = sigma + later.coupling.stress(sweep.rate(a) + convective) if later.coupling.present else sigma
    force = sweep.mass_times(a) + later.forces.inertia(sweep, later.xd) - later.forces(k.x, user)
    return linearize(later, a, sigma), moved_along(k, force + sweep.rate_transposed(stress))


def _change(a: Linearization, b: Linearization, force: Array, rows: Index, size: Array, w: float) -> Array:
    """The change of every degree of freedom of `rows`, relative as the module says."""

    def of(name: str) -> tuple[Array, Array]:
        A, B = (selected(getattr(L, name), rows, rows) for L in (a, b))
        return np.maximum(abs(A), abs(B)).diagonal(), B - A

    def graded(d: Array) -> Array:
        return np.asarray(d + LEAST * largest(d * size**2) / size**2 + np.finfo(float).tiny)

    (m, dm), parts, (c, dc) = of("m0"), [of(name) for name in ("k0", "n0", "g0")], of("damping")
    m = graded(m)
    k = graded(sum(d for d, _ in parts) + SAID * w**2 * m)
    c = c + np.sqrt(k * m)
    changes = (sum(A for _, A in parts), k), (dc, c), (dm, m)
    relative = [(abs(A) / np.sqrt(np.outer(d, d))).max(axis=1) for A, d in changes]
    return np.asarray(np.maximum(np.max(relative, axis=0), abs(force) / (k * size)))
