"""How the stationary state moves with a number of the deck: direct differentiation of the mixed equations.

The state satisfies r(x, sigma; p) = 0 (`spacar.stationary.stationary_equations`), T is its tangent:

    T [dx_F; dsigma] = dr/dp            one solution with the factors of the solution, no iteration

dr/dp at fixed x, sigma comes from one complex step of all elements, in which the prescribed coordinates move as the
level prescribes (sensitivity.md section 1). With e = C (sigma - sigma_0) and C = S^-1 the rows with stiffness give
de/dp + C (dS/dp e + dsigma_0/dp): the inverse itself is not differentiated.
"""

from dataclasses import dataclass

import numpy as np

from spacar.arrays import Array
from spacar.deck.directed import STEP, nothing_lost
from spacar.dynamics.array_evaluator import Dynamics
from spacar.errors import AnalysisError
from spacar.linear_systems import SingularMatrixError
from spacar.mechanism.mechanism import Mechanism
from spacar.sensitivities.directed_elements import DirectedElements
from spacar.stationary import LoadLevel, StationarySolver
from spacar.stationary.moving_tangent import MovingTangent
from spacar.stationary.singular import minimum_norm_solutions
from spacar.stationary.stationary_equations import Tangent, require_digits


@dataclass(frozen=True)
class StateDerivative:
    """The state and its derivatives along one direction.

    elements      evaluated at x + i STEP dx
    sigma, v, a   (ne,), (nx,), (nx,) complex, with the direction; sigma with the stresses of MEE
    dx, de, dsigma, fx, fxgrav, fxtot   derivatives (nx,), (ne,), (ne,), (nx,) ... of what frames call x, e, sig, fx ...
    """

    elements: DirectedElements
    sigma: Array
    v: Array
    a: Array
    dx: Array
    de: Array
    dsigma: Array
    fx: Array
    fxgrav: Array
    fxtot: Array


def state_derivatives(solver: StationarySolver, level: LoadLevel, directions: list[Mechanism]) -> list[StateDerivative]:
    """One for every directed mechanism, at the level that was stored last.

    Raises AnalysisError 'sensitivity.singular' where the tangent is singular: there the state has no derivative.
    """
    try:
        q, tangent = solver.factorized()
    except SingularMatrixError as error:
        raise _critical(level, error) from None
    d, n, C = solver.dynamics, solver.mechanism.numbering, q.flexibility
    x, near = d.kinematics.x, d.sweep.e
    user = tangent.user if isinstance(tangent, MovingTangent) else None
    # The tangent at rest has no unknowns for stresses of rows without stiffness, as these are known; the dense one has.
    known_rows = q.passive & (not isinstance(tangent, MovingTangent))
    motion = _SteadyMotion(d, solver.solution.xdd, solver.moving)
    sigma = solver.solution.sigma + motion.coupling
    elements, rights, starts = [], [], []
    with nothing_lost():
        for mechanism in directions:
            e = DirectedElements(mechanism, level)
            moved = np.zeros(n.nx)
            moved[n.x_class["fixed"]] = e.mechanism.x0.imag[n.x_class["fixed"]]
            moved[q.P] = e.drive.x.imag
            e.at(x + 1j * moved, near)
            v, a = motion.of(e)
            given = np.zeros(n.ne)
            given[n.e_class["input"]] = e.drive.e.imag
            strained = e.deformations().imag
            # The law is taken at the real deformations: its imaginary part holds changes of its numbers and of rates.
            law = (e.law(near + 0j) + motion.stresses(e, v, a)).imag
            known = sigma + 1j * np.where(known_rows, law, 0.0)
            force = e.applied() - e.inertia(v, a, gravity=True) - e.stress_forces(known)
            if user is not None:
                changes = {"e": strained, "x": moved, "ed": e.strain_rate(v).imag, "xd": v.imag}
                law = law + user.along("sigma", **changes)
                force = force + 1j * user.along("f", **changes)
            gap = C.coupled * (strained - given) + C.times(np.where(q.constrained, 0.0, law))
            if not n.holonomic:  # the equations of slips are those of kinematic coordinates and deformations
                begun_x, begun_e = _starts(e, mechanism)
                begun = np.zeros(n.nx)
                begun[n.x_class["dynamic"]] = mechanism.start.x_value.imag
                starts.append(np.concatenate((begun[q.F] / STEP, np.zeros(q.ne))))
                gap[q.slips] = np.concatenate((-begun_x, strained[q.e_kinematic] - begun_e))
            rights.append(np.concatenate((force.imag[q.F], -C.size * gap)) / STEP)
            elements.append((e, moved / STEP))
        if n.holonomic or not rights:
            solutions = _solutions(tangent, rights, C.size, q.nf, level)
        else:  # wheels roll without stiffness: they stay where the file puts them, as in the iteration
            A, begun_at = tangent.dense(), np.column_stack(starts)
            try:
                solutions = begun_at + minimum_norm_solutions(A, np.column_stack(rights) - A @ begun_at)
            except SingularMatrixError as error:
                raise _critical(level, error) from None
        found = []
        for (e, dx), z in zip(elements, solutions.T, strict=True):
            dx[q.F] = z[: q.nf]
            dsigma = C.size * z[q.nf :]
            e.at(x + 1j * STEP * dx, near)
            v, a = motion.of(e)
            s = sigma + 1j * STEP * dsigma
            light, heavy = e.inertia(v, a, gravity=False), e.inertia(v, a, gravity=True)
            rates = (e.applied(), light - heavy, light + e.stress_forces(s))
            fx, fxgrav, fxtot = (r.imag / STEP for r in rates)
            de = e.deformations().imag / STEP
            if user is not None:
                motions = {"ed": e.strain_rate(v).imag / STEP, "xd": v.imag / STEP}
                fx = fx + user.along("f", e=de, x=dx, **motions)
            dsigma = dsigma - e.coupling(motion.second_rates(e, v, a)).imag / STEP
            found.append(StateDerivative(e, s, v, a, dx, de, dsigma, fx, fxgrav, fxtot))
    return found


def _starts(elements: DirectedElements, mechanism: Mechanism) -> tuple[Array, Array]:
    """Changes of the start values of kinematic coordinates and deformations. A deformation without a value in the file
    starts with that of the reference configuration, which changes with the direction."""
    start, ek = mechanism.start, mechanism.numbering.e_class["kinematic"]
    reference = DirectedElements(mechanism, LoadLevel(0.0, 0.0))
    reference.at(mechanism.x0, np.zeros(elements.ne))
    own = reference.deformations().imag[ek]
    return start.x_kinematic.imag, np.where(np.isnan(start.e_kinematic.real), own, start.e_kinematic.imag)


@dataclass
class _SteadyMotion:
    """Velocities and accelerations of steady motion, zero at rest, and how they move with a direction.

    With wheels the rates of the dynamic degrees of freedom are those of the start.

    V v = ed and V a = -H(v, v) on the fixed, prescribed and dynamic rows hold along every direction:
    V dv = d(ed) - dV v,  V da = -dH(v, v) - dV a, with the factors of the configuration.
    """

    d: Dynamics
    a: Array
    moving: bool

    def __post_init__(self) -> None:
        d, self.v = self.d, self.d.xd
        edd = d.sweep.rate(self.a) + d.sweep.convective(self.v)
        self.coupling = d.coupling.stress(edd) if d.coupling.present else np.zeros(len(edd))

    def of(self, e: DirectedElements) -> tuple[Array, Array]:
        """v and a (nx,) with their directions, at the configuration of the elements."""
        if not self.moving:
            return self.v + 0j, self.a + 0j
        n, k = self.d.numbering, self.d.kinematics
        xd, ed = np.zeros(n.nx), np.zeros(n.ne)
        xd[n.x_class["input"]], ed[n.e_class["input"]] = e.drive.xd.imag, e.drive.ed.imag
        if not n.holonomic:
            start = e.mechanism.start
            xd[n.x_class["dynamic"]], ed[n.e_class["dynamic"]] = start.x_rate.imag, start.e_rate.imag
        v = self.v + 1j * k.dependent(xd, ed - e.strain_rate(self.v + 0j).imag)
        swept = e.convective(v).imag + e.strain_rate(self.a + 0j).imag
        return v, self.a + 1j * k.dependent(np.zeros(n.nx), -swept)

    def second_rates(self, e: DirectedElements, v: Array, a: Array) -> Array:
        """edd (ne,)."""
        return e.strain_rate(a) + e.convective(v)

    def stresses(self, e: DirectedElements, v: Array, a: Array) -> Array:
        """Stresses of dampers and MEE, (ne,)."""
        if not self.moving:
            return np.zeros(e.ne, complex)
        return e.viscous(e.strain_rate(v)) + e.coupling(self.second_rates(e, v, a))


def _solutions(tangent: Tangent, rights: list[Array], size: float, nf: int, level: LoadLevel) -> Array:
    """Solutions (n, k) for all right-hand sides.

    One more right-hand side, a load of the size of the stiffness, tells whether the matrix is singular to working
    precision, as in Newton's iteration. Raises AnalysisError 'sensitivity.singular' then.
    """
    if not rights:
        return np.zeros((0, 0))
    probe = np.zeros(len(rights[0]))
    probe[:nf] = size * (1.0 + np.arange(nf) / max(nf, 1))
    try:
        solutions = np.asarray(tangent.solve(np.column_stack([*rights, probe])))
        require_digits(tangent.solve, tangent.rounding, solutions[:, -1], nf)
    except SingularMatrixError as error:
        raise _critical(level, error) from None
    if not np.isfinite(solutions).all():
        raise _critical(level, "numbers that are not finite")
    return solutions[:, :-1]


def _critical(level: LoadLevel, reason: object) -> AnalysisError:
    text = f"no derivatives at {level}: the tangent is singular there ({reason}); the state is critical, a limit point"
    return AnalysisError(f"{text} or a motion without stiffness", "sensitivity.singular")
