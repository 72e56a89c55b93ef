"""Newton's method for stationary solutions, and automatic cutting of load steps.

Unknown are the dynamic degrees of freedom q_d; their rates keep their start values (zero for holonomic systems). The
residual on the dynamic rows (17) is read off without transfer functions: with the multipliers sigma_E of the
equilibrium (10), it is the out-of-balance force at dynamic coordinates, and the difference between constitutive and
equilibrium stress at dynamic deformations. Converged when max |R| <= tolerance (ITERSTEP position 3) or
max |R| <= 100 eps max(|f|, |sigma|): an absolute tolerance cannot be reached below the rounding of the internal forces.

The tangent is the exact K0 + N0 + G0 (types 1, 3: without N0), dense for small mechanisms and for steady motion, the
sparse saddle-point form (18) for long static ones. A load step that does not converge is halved, down to 1/64.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from spacar.dynamics.dynamics import Dynamics
from spacar.errors import AnalysisError, Report
from spacar.linear.matrices import equilibrium_stresses, linearize
from spacar.mechanism.mechanism import Array, Mechanism
from spacar.stationary.loading import WITHOUT_N0, LoadLevel, SteadyDrive, loads_at, with_flow
from spacar.stationary.tangent import SparseTangent

ROUNDING = 100.0 * np.finfo(float).eps
SMALLEST_FRACTION = 1.0 / 64.0
SPARSE_FROM = 150  # coordinates; below, the dense tangent is faster (benchmarks/statics.py)
IN_RANGE = 1e-8  # relative: is the residual in the range of a singular stiffness?
SINGULAR = 1e-13


@dataclass
class StationarySolver:
    """Walks through load levels; `dynamics` holds the last solution.

    Raises AnalysisError 'statics.no-convergence' or 'statics.no-solution'.
    """

    mechanism: Mechanism
    report: Report
    dynamics: Dynamics = field(init=False)
    y: Array = field(init=False)
    level: LoadLevel = field(init=False)

    def __post_init__(self) -> None:
        self.level = LoadLevel(0.0, 0.0)
        self.dynamics = self._at_level(self.level)
        self.y = self.dynamics.start_values()
        self.iterations = 0
        self.history: list[float] = []
        rates = self.mechanism.drive.at(0.0)
        moving = bool(rates.xd.any() or rates.ed.any() or self.y[self.dynamics.n_positions :].any())
        accelerated = bool(rates.xdd.any() or rates.edd.any())
        if accelerated:
            self.report.add("warning: prescribed accelerations are ignored in a stationary solution")
        n = self.mechanism.numbering
        if n.holonomic:
            self.y[self.dynamics.n_positions :] = 0.0
            moving = bool(rates.xd.any() or rates.ed.any())
        self.sparse = (
            not moving
            and n.nx > SPARSE_FROM
            and n.holonomic
            and self.mechanism.user_signal is None
            and not self.dynamics.coupling.present
        )

    def _at_level(self, level: LoadLevel) -> Dynamics:
        loads = loads_at(self.mechanism, level)
        mechanism = with_flow(self.mechanism, loads)
        drive = SteadyDrive.at_level(self.mechanism, level)
        if hasattr(self, "dynamics") and mechanism is self.mechanism:
            self.dynamics.reload(loads, drive)
            return self.dynamics
        dynamics = Dynamics(mechanism, loads=loads, drive=drive)
        if hasattr(self, "dynamics"):
            dynamics.kinematics.start_from(self.dynamics.kinematics)
        return dynamics

    def solve(self, target: LoadLevel) -> None:
        """Go to a load level, in smaller steps where Newton's method needs it."""
        origin, fraction, step = self.level, 0.0, 1.0
        while fraction < 1.0:
            y, kinematics = self.y.copy(), self.dynamics.kinematics
            x, e_given = kinematics.x.copy(), kinematics.e_given.copy()
            following = min(1.0, fraction + step)
            level = origin.towards(target, following)
            try:
                self.dynamics = self._at_level(level)
                self._newton(level)
            except AnalysisError as error:
                self.y = y
                self.dynamics.kinematics.x, self.dynamics.kinematics.e_given = x, e_given
                step *= 0.5
                if step < SMALLEST_FRACTION:
                    raise error
                self.report.add(f"load step to {target}: cut to {step:.6g} of its size")
                continue
            fraction = following
            self.level = level
        self.level = target

    def _newton(self, level: LoadLevel) -> None:
        settings, dynamics = self.mechanism.settings, self.dynamics
        n, history = self.mechanism.numbering, []
        dynamics.kinematics.move(*dynamics.given(dynamics.drive.at(0.0), self.y))
        for iteration in range(settings.max_iterations + 1):
            drive = dynamics.place(0.0, self.y)
            xdd, sigma, full, residual, size, convective = self._residual(drive.xdd, drive.edd)
            norm = float(np.max(np.abs(residual), initial=0.0))
            history.append(norm)
            if norm <= settings.tolerance or norm <= ROUNDING * size:
                self.iterations, self.history = iteration, history
                self.xdd, self.sigma, self.full_sigma, self.convective = xdd, sigma, full, convective
                return
            if not np.isfinite(norm) or iteration == settings.max_iterations:
                break
            self.y[: n.nddof] += self._correction(xdd, sigma, full, residual)
        raise AnalysisError(
            f"the stationary solution did not converge at {level}: residuals {' '.join(f'{r:.3g}' for r in history)}"
            f" after {len(history) - 1} iterations (tolerance {settings.tolerance:.3g}); try more load steps, more iterations or"
            " a smaller load (ITERSTEP), or type 1 or 3",
            "statics.no-convergence",
        )

    def _residual(self, xdd_given: Array, edd_given: Array) -> tuple[Array, Array, Array, Array, float, Array]:
        """xdd, constitutive sigma, all sigma, R on the dynamic rows, the size of the forces in it, H(xd,xd)."""
        d = self.dynamics
        n, sweep = d.numbering, d.sweep
        convective = sweep.convective(d.xd)
        xdd, edd = np.zeros(n.nx), np.zeros(n.ne)
        xdd[n.x_class["input"]], edd[n.e_class["input"]] = xdd_given, edd_given
        xdd = d.kinematics.dependent(xdd, edd - convective)
        edd = sweep.rate(xdd) + convective
        sigma, user = d.constitutive(0.0)
        sweep.mass()
        full = equilibrium_stresses(d, xdd, edd, sigma, user)
        xm, em = n.x_class["dynamic"], n.e_class["dynamic"]
        applied = d.forces(d.kinematics.x, user)
        balance = sweep.mass_times(xdd) + d.forces.inertia(sweep, d.xd) - applied
        balance += sweep.rate_transposed(full + d.coupling.stress(edd))
        residual = np.concatenate((balance[xm], sigma[em] - full[em]))
        size = max(
            float(np.max(np.abs(full), initial=0.0)) * float(np.max(np.abs(sweep.v_entries), initial=0.0)),
            float(np.max(np.abs(applied), initial=0.0)),
        )
        return xdd, sigma, full, residual, size, convective

    def _correction(self, xdd: Array, sigma: Array, full: Array, residual: Array) -> Array:
        d = self.dynamics
        n = d.numbering
        if self.sparse:
            return SparseTangent(d).correction(sigma, full)
        L = linearize(d, xdd, sigma)
        K = L.k0 + L.g0
        if self.mechanism.settings.stationary_type not in WITHOUT_N0:
            K = K + L.n0
        K = K[np.ix_(n.dynamic, n.dynamic)]
        return -solve_tangent(K, residual, [n.q_names[i] for i in n.dynamic])


def solve_tangent(K: Array, residual: Array, names: list[str]) -> Array:
    """K^-1 R; the minimum norm solution when K is singular and R in its range, else AnalysisError."""
    scale = np.sqrt(np.maximum(np.abs(np.diag(K)), 1e-300))
    scale = np.where(scale > 1e-150, scale, max(float(scale.max(initial=1.0)), 1e-300))
    u, s, vt = np.linalg.svd(K / np.outer(scale, scale))
    regular = s > SINGULAR * max(float(s[0]), 1e-300)
    if regular.all():
        return np.linalg.solve(K, residual)
    projected = u.T @ (residual / scale)
    lost = float(np.linalg.norm(projected[~regular]))
    if lost > IN_RANGE * float(np.linalg.norm(projected)):
        worst = names[int(np.argmax(np.abs(vt[-1])))]
        text = (
            "no stationary solution: the stiffness matrix is singular and the load works on a motion without stiffness, mainly"
            f" {worst}; support it (FIX), prescribe it (INPUTX, INPUTE) or give it a stiffness (ESTIFF)"
        )
        raise AnalysisError(text, "statics.no-solution")
    return np.asarray((vt[regular].T @ (projected[regular] / s[regular])) / scale)
