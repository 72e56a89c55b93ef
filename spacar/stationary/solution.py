"""Walking through load levels: prediction, Newton's iteration, automatic cutting of load steps (theory-system.md 6.3).

Each level starts from the polynomial through up to four earlier solutions along the same loading (the values at a
larger load), else from the last solution; when Newton's method does not converge from the prediction it starts again
from the last solution. A step that fails is halved, down to 1/64 of its size.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from spacar.dynamics.dynamics import Dynamics
from spacar.errors import AnalysisError, Report
from spacar.mechanism.mechanism import Array, Mechanism
from spacar.stationary.loading import LoadLevel, SteadyDrive, loads_at, with_flow
from spacar.stationary.newton import Converged, newton
from spacar.stationary.tangent import SparseTangent

SMALLEST_FRACTION = 1.0 / 64.0
SPARSE_FROM = 30  # coordinates; below, the dense tangent is as fast (benchmarks/statics.py)
REMEMBERED = 4  # solutions that the prediction uses: a cubic polynomial


@dataclass
class StationarySolver:
    """Walks through load levels; `dynamics` is placed at the last solution, `solution` describes it.

    Raises AnalysisError 'statics.no-convergence' or 'statics.no-solution'.
    """

    mechanism: Mechanism
    report: Report
    dynamics: Dynamics = field(init=False)
    solution: Converged = field(init=False)
    level: LoadLevel = field(init=False)

    def __post_init__(self) -> None:
        self.level = LoadLevel(0.0, 0.0)
        self._tangent: SparseTangent | None = None
        loads = loads_at(self.mechanism, self.level)
        mechanism = with_flow(self.mechanism, loads)
        self.dynamics = Dynamics(mechanism, loads=loads, drive=SteadyDrive.at_level(self.mechanism, self.level))
        d, n = self.dynamics, self.mechanism.numbering
        start, motion = self.mechanism.drive.at(0.0), SteadyDrive.at_level(self.mechanism, LoadLevel(1.0, 0.0))
        if start.xdd.any() or start.edd.any():
            self.report.add("warning: prescribed accelerations are ignored in a stationary solution")
        self.y = d.start_values()
        if n.holonomic:
            if self.y[d.n_positions :].any():
                self.report.add(
                    "warning: start rates of dynamic degrees of freedom are ignored in a stationary solution"
                )
            self.y[d.n_positions :] = 0.0
        # everything that the static tangent (18) contains, and nothing else
        static = n.holonomic and not motion.moving and self.mechanism.user_signal is None and not d.coupling.present
        self.sparse = static and n.nx > SPARSE_FROM
        self._known: list[tuple[float, Array]] = []
        x_reference = self.mechanism.x0[n.x_class["dynamic"]]
        if not (self.y[: d.n_xm] - x_reference).any() and not self.y[d.n_xm : n.nddof].any():
            self._known = [(0.0, self.y.copy())]  # the reference configuration is the solution without load
        loads = loads_at(self.mechanism, LoadLevel(1.0, 0.0))
        self._idle = bool(static and self._known) and not loads.present and not motion.shift(self.mechanism)

    def sparse_tangent(self) -> SparseTangent:
        """The sparse tangent of the present evaluator."""
        if self._tangent is None or self._tangent.dynamics is not self.dynamics:
            self._tangent = SparseTangent(self.dynamics)
        return self._tangent

    def solve(self, target: LoadLevel) -> None:
        """Go to a load level, in smaller steps where Newton's method needs it."""
        if self._idle and self.level.path > 0.0 and target.additional == 0.0 and self._at_rest():
            self.level, self.solution = target, replace(self.solution, history=self.solution.history[-1:])
            return
        origin, fraction, step = self.level, 0.0, 1.0
        while fraction < 1.0:
            following = min(1.0, fraction + step)
            level = target if following == 1.0 else origin.towards(target, following)
            try:
                self._reach(level)
            except AnalysisError as error:
                if error.code == "statics.no-solution":  # smaller steps do not create a stiffness
                    raise
                step *= 0.5
                if step < SMALLEST_FRACTION:
                    raise self._given_up(error, origin, target, fraction) from None
                self.report.add(f"{target}: no convergence, cut to {step:.6g} of its size")
                continue
            fraction = following
            if level.additional == 0.0 and level.initial >= 1.0:
                self._known = self._known[-1:]  # from here on the path of the additional loading
        self.level = target

    def _at_rest(self) -> bool:
        """Is the last solution accurate? Then it is that of all levels of a loading that does nothing."""
        return self.solution.state.reached(self.mechanism.settings.tolerance, 0.0)

    def _reach(self, level: LoadLevel) -> None:
        """Newton's iteration at a level from the prediction, then from the last solution."""
        starts = [self.y] if len(self._known) < 2 else [self._predicted(level.path), self.y]
        before, kinematics = self.dynamics, self.dynamics.kinematics
        x, e = kinematics.x, kinematics.sweep.e.copy()
        for k, start in enumerate(starts):
            try:
                self._load(level)
                self.solution = newton(self.dynamics, start, level, self.sparse_tangent if self.sparse else None)
            except AnalysisError:
                self.dynamics = before
                kinematics.start_at(x, e)
                if k + 1 == len(starts):
                    raise
                continue
            break
        self.y = self.solution.y
        self._known = [*self._known, (level.path, self.y.copy())][-REMEMBERED:]

    def _load(self, level: LoadLevel) -> None:
        """Put the loads of a level on the evaluator; a change of the flow in tubes needs a new one."""
        loads, drive = loads_at(self.mechanism, level), SteadyDrive.at_level(self.mechanism, level)
        mechanism = with_flow(self.mechanism, loads)
        if mechanism is self.mechanism:
            self.dynamics.reload(loads, drive)
            return
        following = Dynamics(mechanism, loads=loads, drive=drive)
        following.kinematics.start_from(self.dynamics.kinematics)
        self.dynamics = following

    def _predicted(self, path: float) -> Array:
        """Lagrange's polynomial through the known solutions."""
        at = np.array([p for p, _ in self._known])
        weights = [np.prod((path - np.delete(at, i)) / (at[i] - np.delete(at, i))) for i in range(len(at))]
        y = sum(w * known for w, (_, known) in zip(weights, self._known, strict=True))
        y[self.dynamics.n_positions :] = self.y[self.dynamics.n_positions :]
        return np.asarray(y)

    def _given_up(self, error: AnalysisError, origin: LoadLevel, target: LoadLevel, fraction: float) -> AnalysisError:
        """The error of the smallest step, with how far the load step came."""
        reached = origin.towards(target, fraction)
        text = str(error)
        if error.code != "statics.no-convergence":
            text = f"the stationary solution did not converge at {target}: {text}"
            text += "; try more load steps or a smaller load (ITERSTEP)"
        text += (
            f"; the step was cut to {SMALLEST_FRACTION:.3g} of its size, the last solution is at"
            f" {reached.initial:.6g} x initial + {reached.additional:.6g} x additional loading"
        )
        return AnalysisError(text, "statics.no-convergence", **error.data)
