"""Constraints while a program runs: assembly of start values, projection, and integration without drift.

A displacement in the speeds δ moves the coordinates by W δ, W = ∂q̇/∂s. All corrections are least squares in mass
units, |D^(−1) δ| with D = diag(I)^(−1/2), so that metres and radians are weighed as the system weighs them:

    gap        J_g δ = −g,  q += W δ   (Newton iterations)
    velocity   J δ = −e,  s += δ

Assembly keeps the values that were given and changes the others, amplitudes of beam fields only when nothing else can
close the gap. The integration runs on all coordinates and speeds; what drifts off by more than the tolerance is
projected back. Source: decision; `symbolic.md`, section 3.5.
"""

from collections.abc import Callable, Mapping
from typing import Any, NoReturn

import numpy as np

from spacar.arrays import EPS
from spacar.errors import AnalysisError, UsageError
from spacar.symbolic.ordered import OrderedProgram

ITERATIONS = 60
DRIFT = {"DOP853": 0.1, "Radau": 0.1, "LSODA": 10.0}
"""Correction, in tolerances, from which a run restarts at the projected state; dear for multistep methods."""
ROUNDING = 8 * EPS  # of a coordinate of order one
SHARE = 1e-3  # chosen: of the largest part that a constraint has in a dependence; smaller ones are not named
NEARLY = 1e-3  # largest relative change of given start values that is taken as their rounding


class Manifold:
    """The states that satisfy the constraints of a program; `function` has `manifold(t, y)`."""

    def __init__(self, program: OrderedProgram, function: Any) -> None:
        assert program.constraints is not None
        self.program, self.function, self.constraints = program, function, program.constraints
        self.nq, self.notes = len(program.coordinates), list[str]()
        self.names = [s.name for s in program.state]
        self.at = 0.0, np.zeros(len(self.names))  # time and state that were evaluated last

    def numbers(self, t: float, y: np.ndarray) -> tuple[np.ndarray, ...]:
        """D, J, J_g, e, g, W."""
        self.at = t, y.copy()
        M, J, e, g, W = self.function.manifold(t, y.tolist())
        diagonal = M.diagonal()
        D = 1 / np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
        return D, J, J[list(self.constraints.position)], e, g, W

    def project(self, t: float, y: np.ndarray) -> np.ndarray:
        """The nearest state that satisfies the constraints; AnalysisError when Newton's method finds none."""
        y = np.array(y, dtype=float)
        n = self.nq
        last = np.inf
        for _ in range(ITERATIONS):
            D, _, Jg, _, g, W = self.numbers(t, y)
            if not len(g):
                last = 0.0
                break
            move = W @ (D * np.linalg.lstsq(Jg * D, -g, rcond=None)[0])
            size = float(np.max(np.abs(move)) / max(np.max(np.abs(y[:n])), 1e-300))
            if not size < last / 2:  # rounding: no further digit is gained
                break
            y[:n] += move
            last = size
            if size == 0.0:
                break
        if not last < 1e-8:
            raise AnalysisError(f"the constraints cannot be satisfied at t = {t:.6g} s", "constraint")
        D, J, _, e, _, _ = self.numbers(t, y)
        y[n:] += D * np.linalg.lstsq(J * D, -e, rcond=None)[0]
        return y

    def dependent(self) -> str:
        """The names of the constraints that hold the same motion where the program was evaluated last; none where all
        pivots of J M^-1 J^T, the squares of singular values, are above their rounding (`emit.solvers`)."""
        D, J, *_ = self.numbers(*self.at)
        J = J * D
        size = np.max(np.abs(J), axis=1, keepdims=True)
        U, s, _ = np.linalg.svd(J / np.where(size > 0, size, 1.0))
        if len(s) == len(J) and s[-1] ** 2 > len(J) * ROUNDING * s[0] ** 2:
            return ""
        parts = np.abs(U[:, -1])
        names = [name for name, part in zip(self.constraints.names, parts, strict=True) if part > SHARE * max(parts)]
        return ", ".join(names)

    # -- start ---------------------------------------------------------------------------------------------------

    def assemble(self, y: np.ndarray, given: set[str]) -> np.ndarray:
        """Start values at t = 0 near y that satisfy the constraints and keep the `given` states.

        Raises UsageError when the given values leave an open gap or velocity that nothing else can close.
        """
        began, names = np.array(y, dtype=float), self.names
        y = self._close_gaps(began.copy(), [n in given for n in names[: self.nq]])
        y = self._close_speeds(y, [n in given for n in names[self.nq :]])
        changed = [k for k in range(len(y)) if abs(y[k] - began[k]) > 1e-12 * (1 + abs(began[k]))]
        if changed:
            rows = ", ".join(f"{names[k]} = {y[k]:.12g}" for k in changed)
            self.notes.append(f"assembled    {rows}")
        rounded = [k for k in changed if names[k] in given]
        if rounded:
            worst = max(rounded, key=lambda k: abs(y[k] - began[k]))
            self.notes.append(
                f"warning: the start values do not fit the constraints exactly; {names[worst]} was moved by "
                f"{y[worst] - began[worst]:.3g}"
            )
        return y

    def _groups(self) -> list[np.ndarray]:
        """Speeds that may be changed: first those of no field, then all."""
        soft = {s.name for s in self.program.fields}
        rigid = np.array([s.name not in soft for s in self.program.speeds])
        return [rigid, np.ones(len(rigid), dtype=bool)]

    def _close_gaps(self, y: np.ndarray, fixed: list[bool]) -> np.ndarray:
        if self._gap(y) == 0.0:
            return y
        hold = np.flatnonzero(fixed)
        for allowed in self._groups():
            found = self._newton(y, hold, allowed)
            if found is not None:
                return found
        found = self._newton(y, np.array([], dtype=int), np.ones(self.program.n, dtype=bool))
        if found is not None and np.max(np.abs(found - y)) <= NEARLY * max(np.max(np.abs(y[: self.nq])), 1e-300):
            return found
        self._refuse(y, self.numbers(0.0, y)[4], list(self.constraints.position), hold, "open by")

    def _refuse(self, y: np.ndarray, gaps: Any, rows: Any, hold: np.ndarray, words: str) -> NoReturn:
        worst = int(np.argmax(np.abs(gaps)))
        kept = ", ".join(f"{self.names[k]} = {y[k]:g}" for k in hold) or "none"
        raise UsageError(
            f"start: {self.constraints.names[rows[worst]]} is {words} {gaps[worst]:.6g} and cannot be closed with the "
            f"values given ({kept}): leave one of them out, or give values that fit",
            "constraint",
        )

    def _gap(self, y: np.ndarray) -> float:
        return float(np.max(np.abs(self.numbers(0.0, y)[4]), initial=0.0))

    def _newton(self, y: np.ndarray, hold: np.ndarray, allowed: np.ndarray) -> np.ndarray | None:
        """Damped Newton iterations on the coordinates that are free; None when the gap stays open."""
        y, n = y.copy(), self.nq
        start = gap = self._gap(y)
        for _ in range(ITERATIONS):
            D, _, Jg, _, g, W = self.numbers(0.0, y)
            D = np.where(allowed, D, 0.0)
            basis = _null_space((W * D)[hold]) * D[:, None]
            delta = basis @ np.linalg.lstsq(Jg @ basis, -g, rcond=1e-10)[0]
            step = W @ delta
            for halving in range(12):
                trial = y.copy()
                trial[:n] += step / 2**halving
                if self._gap(trial) < gap:
                    break
            else:
                break
            y, gap = trial, self._gap(trial)
            if gap <= 1e-14 * start:
                break
        D, _, Jg, _, g, W = self.numbers(0.0, y)
        # the rounding of coordinates of their size, or of angles near zero, whose own size says nothing
        scale = 1e-11 * np.abs(Jg) @ np.abs(np.linalg.pinv(W) @ y[:n]) + np.max(np.abs(Jg), axis=1) * ROUNDING
        return y if np.all(np.abs(g) <= scale) else None

    def _close_speeds(self, y: np.ndarray, fixed: list[bool]) -> np.ndarray:
        n, held = self.nq, np.array(fixed, dtype=bool)
        D, J, _, e, _, _ = self.numbers(0.0, y)

        def closed(delta: np.ndarray) -> bool:
            scale = np.abs(J) @ (np.abs(y[n:]) + np.abs(delta)) + np.abs(e)
            return bool(np.all(np.abs(J @ delta + e) <= 1e-11 * scale))

        for allowed in [g & ~held for g in self._groups()]:
            d = np.where(allowed, D, 0.0)
            delta = d * np.linalg.lstsq(J * d, -e, rcond=1e-10)[0]
            if closed(delta):
                y[n:] += delta
                return y
        delta = D * np.linalg.lstsq(J * D, -e, rcond=None)[0]
        if closed(delta) and np.max(np.abs(delta)) <= NEARLY * max(np.max(np.abs(y[n:])), 1e-300):
            y[n:] += delta
            return y
        self._refuse(y, e, range(len(e)), n + np.flatnonzero(held), "violated at a rate of")

    # -- end -----------------------------------------------------------------------------------------------------

    def tangent(self, t: float, y: np.ndarray) -> np.ndarray:
        """Orthonormal basis of the state changes that keep e = 0 and g = 0, by central differences."""
        rows = []
        for k in range(len(y)):
            h = 6e-6 * max(abs(y[k]), 1e-3)
            step = h * np.eye(len(y))[k]
            ahead, behind = (np.concatenate(self.numbers(t, moved)[3:5]) for moved in (y + step, y - step))
            rows.append((ahead - behind) / (2 * h))
        return _null_space(np.array(rows).T)


def _null_space(A: np.ndarray) -> np.ndarray:
    from scipy.linalg import null_space

    return np.asarray(null_space(A, rcond=1e-10)) if A.size else np.eye(A.shape[1])


def integrate(
    manifold: Manifold, f: Callable[..., Any], times: np.ndarray, y0: np.ndarray, method: str,
    options: Mapping[str, Any],
) -> Any:  # fmt: skip
    """Integrate and keep to the constraints: outputs are projected, and so is the state when it has drifted.

    What `solve_ivp` gives, and the number of `projections`.
    """
    from scipy import integrate as scipy_integrate
    from scipy.optimize import OptimizeResult

    make = getattr(scipy_integrate, method)
    rtol, atol = options["rtol"], options["atol"]
    solver = make(f, float(times[0]), y0, float(times[-1]), **options)
    found, count, nfev, njev, projections, message = [y0], 1, 0, 0, 0, None
    while solver.status == "running":
        message = solver.step()
        if solver.status == "failed":
            break
        if count < len(times) and times[count] <= solver.t:
            dense = solver.dense_output()
            while count < len(times) and times[count] <= solver.t:
                found.append(manifold.project(times[count], dense(times[count])))
                count += 1
        state = manifold.project(solver.t, solver.y)
        drift = np.max(np.abs(state - solver.y) / (atol + rtol * np.abs(state)))
        if drift > DRIFT[method] and solver.status == "running":
            nfev, njev, projections = nfev + solver.nfev, njev + solver.njev, projections + 1
            first = {} if method == "LSODA" else {"first_step": min(solver.h_abs, abs(times[-1] - solver.t))}
            solver = make(f, solver.t, state, float(times[-1]), **options, **first)
    return OptimizeResult(
        t=times[:count], y=np.array(found).T, success=solver.status != "failed", message=f"{message}. ",
        nfev=nfev + solver.nfev, njev=njev + solver.njev, projections=projections,
    )  # fmt: skip
