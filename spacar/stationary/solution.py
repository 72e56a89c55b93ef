"""The stationary solution as the analyses see it: placed evaluator, stresses, stability, level by level."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import suppress

import numpy as np

from spacar.arrays import Array
from spacar.dynamics.array_evaluator import Dynamics
from spacar.dynamics.motion_equations import Accelerations
from spacar.errors import AnalysisError, Report
from spacar.frame import Frame
from spacar.linear_systems import SingularMatrixError
from spacar.mechanism.mechanism import Mechanism
from spacar.stationary.continuation import Continuation
from spacar.stationary.equilibrium import level_equilibrium
from spacar.stationary.loading import LoadLevel
from spacar.stationary.moving_tangent import MovingTangent
from spacar.stationary.newton import LENGTHS
from spacar.stationary.stability import Stability, critical_motion
from spacar.stationary.stationary_equations import Iterate, Motion, StationaryEquations, Tangent
from spacar.stationary.tangent import SparseTangent

SINGULAR_SLIP = 1e-8  # relative: the stress of a slip that its law does not give


class StationarySolver:
    """Goes through load levels. At a level that is stored `dynamics` is placed at the solution, `solution` says what
    steady motion and stresses there are, `residual` is the largest out-of-balance force [N, N m]; `iterations` is their
    number at the last level.

    Raises AnalysisError 'statics.no-convergence', 'statics.limit-point' or 'statics.no-solution'.
    """

    solution: Accelerations
    residual: float

    def __init__(self, mechanism: Mechanism, report: Report) -> None:
        self.mechanism, self.report = mechanism, report
        m, n = mechanism, mechanism.numbering
        start = m.drive.at(0.0) if n.ndof > n.nddof else None
        if start is not None and (start.xdd.any() or start.edd.any()):
            self.report.add("warning: prescribed accelerations are ignored in a stationary solution")
        self._statics = level_equilibrium(m)
        self._evaluator = e = self._statics.levels
        if e.leaves_rates:
            self.report.add("warning: start rates of dynamic degrees of freedom are ignored in a stationary solution")
        # When the loading does nothing, all levels have the solution of the first one.
        self._idle = e.plain and not m.loads.present and not e.whole.shift(m)
        self.iterations = 0
        self._said: Stability | None = None
        self._continuation: Continuation | None = None
        self._firm = True
        self._failed = False  # in one order of the loading?

    @property
    def dynamics(self) -> Dynamics:
        """The evaluator under the loads of the last level."""
        return self._evaluator.dynamics

    def frame(self, step: int) -> Frame:
        """Of the solution that was stored last, as that of a step (from 0)."""
        d = self.dynamics
        return d.complete(float(step), self.solution, d.forces.inertia(d.sweep, d.xd))

    @property
    def resting(self) -> bool:
        """Does the sparse tangent hold everything that the stiffness contains?"""
        return self._evaluator.plain

    @property
    def sparse(self) -> bool:
        """The same of the linearized equations."""
        return self.resting and not len(self.mechanism.deformation_inertia[0])

    def sparse_tangent(self) -> SparseTangent:
        """The sparse tangent of the present evaluator."""
        return self._evaluator.sparse

    def factorized(self) -> tuple[StationaryEquations, Tangent]:
        """The equations, and the exact tangent factored at the solution that was stored last.

        Raises SingularMatrixError.
        """
        assert self._continuation is not None
        e = self._evaluator
        tangent = e.tangent if e.tangent.exact else MovingTangent(e.equations, without_n0=False)
        tangent.factor(self._continuation.point)
        return e.equations, tangent

    @property
    def determined(self) -> bool:
        """Do the degrees of freedom determine the configuration of the solution that was stored last?"""
        return self.dynamics.kinematics.is_factored

    @property
    def moving(self) -> bool:
        """Does anything prescribed move?"""
        return self._evaluator.moving

    @property
    def y(self) -> Array:
        """The dynamic degrees of freedom of the last solution, (nddof,)."""
        n, d = self.mechanism.numbering, self.dynamics
        return np.concatenate((d.kinematics.x[n.x_class["dynamic"]], d.sweep.e[n.e_class["dynamic"]]))

    def stored(self, program: Iterable[LoadLevel]) -> Iterator[tuple[LoadLevel, int]]:
        """The levels of a program that are stored, one after the other, each solved, with the iterations that led there
        from the one before. Raises AnalysisError as the class says."""
        iterations = 0
        for level in program:
            self.solve(level)
            iterations += self.iterations
            if level.store:
                yield level, iterations
                iterations = 0

    def solve(self, target: LoadLevel) -> None:
        """Go to a load level. Raises AnalysisError as the class says."""
        continuation = self._begun(target)
        idle = self._idle and target.additional == 0.0
        if idle and continuation.level.path > 0.0 and not target.store:
            self.iterations = 0
            return
        if not self.mechanism.numbering.nddof and not target.store:
            return  # `Kinematics` itself divides the way to the prescribed values
        if idle and continuation.is_exact and self._evaluator.fading_force is None:
            continuation.stay(target)
        else:
            try:
                continuation.advance(target)
            except AnalysisError as failure:
                continuation = self._in_other_order(failure, target)
        self.iterations = continuation.iterations
        if target.store:
            self._place(continuation.point, target)

    def _begun(self, first: LoadLevel) -> Continuation:
        """The path so far. It begins with no loading, but with all of the initial loading where the start has motions
        without stiffness then, which the loading may give them, and is no equilibrium."""
        if self._continuation is None:
            n, e = self.mechanism.numbering, self._evaluator
            self._continuation = continuation = self._begin(first, False)
            self._firm = continuation.is_firm
            placed = self._is_placed or e.fading_force is not None
            if n.holonomic and n.nddof and not self._idle and not self._firm and placed:
                self._continuation = self._begin(first, True)
        return self._continuation

    def _begin(self, first: LoadLevel, whole: bool) -> Continuation:
        """The path from the start values. Where these are no equilibrium, forces hold them that fade on the way to the
        first level. `whole`: all of the initial loading acts from the start on."""
        e, n = self._evaluator, self.mechanism.numbering
        e.whole_from_start = whole
        e.set_fading_force(None)
        self._statics.load(LoadLevel(0.0, 0.0))
        p = self._reference()
        self._is_placed = p is None
        if p is None:
            d = e.dynamics
            d.kinematics.begin()
            d.place(0.0, e.y)
            sigma = d.law(d.sweep.e, np.zeros(n.ne))
            d.sweep.follow(d.kinematics.x, d.sweep.e)
            p = self._statics.point(d.kinematics.x, sigma)
        if not p.quiet:
            with suppress(SingularMatrixError):  # degrees of freedom that do not determine the start leave it as it is
                p = self._statics.point(p.x, e.equations.balanced(p))
        known = p.quiet
        if not known:
            q, force = e.equations, np.zeros(n.nx + n.ne)
            force[q.F], force[n.nx :] = p.right[: q.nf], -p.right[q.nf :] / q.flexibility.size
            e.set_fading_force(force, first.path)
            self._statics.load(e.level)
            p = self._statics.point(p.x, p.sigma)
        try:
            return Continuation(self._statics, p, known, self.report)
        except SingularMatrixError:
            return Continuation(self._statics, p, False, self.report)

    def _in_other_order(self, failure: AnalysisError, target: LoadLevel) -> Continuation:
        """The path to a level with the loading applied in the other order, or, where start values do not lead there,
        from the reference configuration. Raises the failure of growing loads."""
        e, n = self._evaluator, self.mechanism.numbering
        held = e.fading_force is not None
        limited = failure.code == "statics.limit-point" and self._firm and not held
        if self._failed or limited or target.additional or not (n.holonomic and n.nddof):
            raise failure
        self._failed, whole, said = True, not e.whole_from_start, failure
        try:
            self._continuation = continuation = self._begin(target, whole)
            continuation.advance(target)
        except AnalysisError as again:
            said = failure if whole else again
            if whole and failure.code == "statics.no-solution":  # of a motion that the loading may hold
                text = f"{failure}; with the whole loading from the start on: {again}"
                said = AnalysisError(text, failure.code, **failure.data)
        else:
            if whole and self._firm:
                self.report.add(
                    f"warning: the growing loading could not be followed ({failure.code}): the solution was found from"
                    " the start, held in balance under the whole loading by forces that fade; there may be others"
                )
            return continuation
        start, reference = e.y[: n.nddof], self._reference_values
        if not held or (start == reference).all():
            raise said from None
        start[:] = reference
        self._continuation = continuation = self._begin(target, False)
        continuation.advance(target)
        self.report.add(
            f"warning: the start values (STARTDX, STARTDE) do not lead to a solution ({failure.code}): this one was"
            " found from the reference configuration; there may be others"
        )
        return continuation

    @property
    def _reference_values(self) -> Array:
        """Of the dynamic degrees of freedom, (nddof,)."""
        n = self.mechanism.numbering
        x = self.mechanism.x0[n.x_class["dynamic"]]
        return np.concatenate((x, np.zeros(n.nddof - len(x))))

    def _reference(self) -> Iterate | None:
        """The reference configuration, if it is the start and its deformations are those wanted."""
        e, m, n = self._evaluator, self.mechanism, self.mechanism.numbering
        if e.moving or (e.y[: n.nddof] != self._reference_values).any():
            return None
        if not n.nddof:
            e.dynamics.kinematics.begin()  # it finds the positions of all levels
        p = self._statics.point(m.x0.copy(), np.zeros(n.ne))
        e.follow(m.x0)
        return p if p.gap <= LENGTHS else None

    def _place(self, p: Iterate, level: LoadLevel) -> None:
        """The evaluator at the point, in terms of the degrees of freedom as far as they determine it."""
        e, n = self._evaluator, self.mechanism.numbering
        d = e.stand_at(p.x)
        still_x, still_e, sigma = np.zeros(n.nx), np.zeros(n.ne), p.sigma.copy()
        m = p.motion or Motion(still_x, still_x, still_e, still_e, still_e)
        d.xd, d.ed = m.v, m.ed
        if p.motion and d.coupling.present:
            sigma -= d.coupling.stress(m.edd)
        self.solution, self.residual = Accelerations(m.a, sigma, m.convective), p.force
        if p.slip > SINGULAR_SLIP * p.work_size:
            text = f"no stationary solution at {level}: a slip that is a degree of freedom is not in equilibrium"
            raise AnalysisError(f"{text} with its rate", "statics.no-solution")
        self._say_stability(level)

    def _say_stability(self, level: LoadLevel) -> None:
        """Report where stored states become unstable, critical, or stable again."""
        assert self._continuation is not None
        now, said = self._continuation.stable, self._said
        self._said = now
        if now is None or not now.exact:
            return
        if said is not None and (now.negative, now.critical) == (said.negative, said.critical):
            return
        e = self._evaluator
        if now.critical or now.negative:
            what, it = f"an unstable equilibrium: the tangent stiffness has {now}", "the motion"
            if now.critical:
                what, it = "critical to working precision: a motion has no stiffness", "it"
            motion = critical_motion(e.equations, e.tangent, self._continuation.point, negative=not now.critical)
            where = f", {it} is largest at {motion}" if motion else ""
            self.report.add(f"warning: the solution at {level} is {what}{where}")
        elif said is not None:
            self.report.add(f"the solution at {level} is stable again")
