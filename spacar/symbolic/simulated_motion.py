"""Simulation of a generated program.

`lsoda` (variable order, switching between Adams and BDF) has the exact generated Jacobian, as `radau` has; one by
finite differences is not offered, because its noise stalls stiff integrators (`symbolic.md`, section 8.6). A relative
tolerance above 1e-2 is refused: a stiff method may then step over an unstable fast mode without notice. The
eigenvalue with the largest real part at the end of the run is reported for the same reason.
"""

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from spacar.errors import AnalysisError, UsageError
from spacar.symbolic.closure import Manifold, integrate
from spacar.symbolic.emit import emit
from spacar.symbolic.ordered import OrderedProgram

Feeds = Mapping[str, Callable[..., float]]  # functions of (t, y) for inputs without law

INTEGRATORS = {"lsoda": "LSODA", "radau": "Radau", "dop853": "DOP853"}
LOOSEST = 1e-2
TIGHTEST_SCALED = 1e-10  # below this fraction of its scale a state at rest under load is rounding noise
MOST_STEPS = 100_000_000
MOST_EVALUATIONS = 1_000_000  # stiff runs need 1e3 to 1e5; more means that the step is at the level of rounding


@dataclass(frozen=True, eq=False)
class SimulatedMotion:
    """A simulated motion.

    time (m,) [s]; state (m, len(y)) in the order of `names`; inputs (m, len(u)); outputs {name: (m,)};
    `statistics` of the integrator; `eigenvalue` with the largest real part at the end [1/s], of motions that the
    constraints leave; `notes` on the assembly of the start values.
    """

    names: tuple[str, ...]
    time: np.ndarray
    state: np.ndarray
    inputs: np.ndarray
    input_names: tuple[str, ...]
    outputs: dict[str, np.ndarray]
    statistics: dict[str, Any]
    eigenvalue: complex
    notes: tuple[str, ...] = ()

    def __getitem__(self, name: str) -> np.ndarray:
        """A state, input or output by name."""
        if name in self.names:
            return self.state[:, self.names.index(name)]
        if name in self.outputs:
            return self.outputs[name]
        if name in self.input_names:
            return self.inputs[:, self.input_names.index(name)]
        raise UsageError(
            f"no result named {name!r}: known are {', '.join([*self.names, *self.input_names, *self.outputs])}"
        )


def check_values(
    program: OrderedProgram, values: Mapping[str, float], feeds: Feeds | None
) -> dict[str, float]:
    """The parameter values as floats. UsageError for one that is missing, not finite, or of the wrong sign, and for an
    input with neither a law nor a function."""
    result: dict[str, float] = {}
    for s in program.parameters:
        if s.name not in values:
            raise UsageError(f"parameter {s.name} has no value", "parameter")
        result[s.name] = float(values[s.name])
        if not math.isfinite(result[s.name]):
            raise UsageError(f"parameter {s.name} = {result[s.name]} is not finite", "parameter")
    for what, s, strict in program.positive:
        value = result[s.name]
        if value < 0 or (strict and value == 0):
            raise UsageError(
                f"parameter {s.name} = {value:g} is a {what} and must be {'> 0' if strict else '>= 0'}", "parameter"
            )
    missing = [s.name for s, e in program.inputs.items() if e is None and s.name not in (feeds or {})]
    if missing:
        raise UsageError(f"input {missing[0]} has no law: give an expression, or a function in `feeds`", "input")
    return result


def make_function(
    program: OrderedProgram, values: Mapping[str, float], jacobian: bool = False,
    feeds: Feeds | None = None,
) -> Any:  # fmt: skip
    """The generated Python right-hand side f(t, y) for parameter values, with f.jac, f.inputs, f.outputs, f.accel.

    The Jacobian takes most of the time: it is derived at once where `jacobian` says that it will be needed, otherwise
    by the first call of f.jac.
    """
    numbers = check_values(program, values, feeds)
    rhs, jac = generated(program, jacobian)(numbers, feeds)

    def derived(t: float, y: Sequence[float]) -> np.ndarray:
        rhs.jac = generated(program, True)(numbers, feeds)[1]
        return rhs.jac(t, y)

    rhs.jac = jac or derived
    return rhs


@lru_cache(maxsize=32)
def generated(program: OrderedProgram, jacobian: bool) -> Callable[..., Any]:
    """`make_rhs` of the generated Python: the text does not depend on the parameter values."""
    space: dict[str, Any] = {}
    exec(compile(emit(program, "python", jacobian, headed=False), "<equations of motion>", "exec"), space)
    return space["make_rhs"]


def simulate(
    program: OrderedProgram,
    values: Mapping[str, float],
    start: Mapping[str, float] | None = None,
    *,
    guess: Mapping[str, float] | None = None,
    t_end: float,
    steps: int = 1000,
    integrator: str = "lsoda",
    rtol: float = 1e-8,
    atol: float | Mapping[str, float] | None = None,
    feeds: Feeds | None = None,
    function: Any = None,
    at: np.ndarray | None = None,
    progress: Callable[[float], None] | None = None,
    limit: int = MOST_EVALUATIONS,
) -> SimulatedMotion:
    """Integrate from `start` (states by name, others zero or `guess`) to t_end [s] with `steps` equal output steps.

    With constraints the states of `start` are kept and the others, beginning at `guess`, are assembled so that loops
    close and velocities fit; during the run the state is projected (`closure.py`). `at`: output times instead.
    atol: one number, numbers by state name, or None for rtol times the scale of each state (the larger of start
    value and static deflection; of speeds, if there are as many as coordinates, of start value and the scale of the
    coordinate in the same place per second; 1 where it is zero).
    `feeds`: functions of (t, y) for inputs without law. `function` replaces the generated Python (compiled code).
    `progress` is called with the time; `limit` evaluations end a run that stalls. Raises UsageError for unknown
    names or tolerances above 1e-2, AnalysisError when the integrator stops.
    """
    from scipy.integrate import solve_ivp

    if integrator not in INTEGRATORS:
        raise UsageError(f"unknown integrator {integrator!r}: choose one of {', '.join(INTEGRATORS)}")
    if not 0 < rtol <= LOOSEST:
        raise UsageError(
            f"rtol = {rtol:g} must be positive and at most {LOOSEST:g}: looser runs may hide unstable motion"
        )
    if not (math.isfinite(t_end) and t_end > 0 and steps >= 1):
        raise UsageError(f"time {t_end:g} s and {steps} steps: both must be positive")
    if steps > MOST_STEPS:
        raise UsageError(f"{steps} steps: at most {MOST_STEPS:.0e}, as the motion stays in memory")
    names = tuple(s.name for s in program.state)
    for what, given in (("start", start), ("guess", guess), ("atol", atol)):
        unknown = [] if isinstance(given, (int, float)) else [name for name in given or () if name not in names]
        if unknown:
            raise UsageError(f"{what}: {unknown[0]} is not a state (states: {', '.join(names)})")
    f = function or make_function(program, values, True, feeds)
    values_at_start = {**(guess or {}), **(start or {})}
    y0 = np.array([float(values_at_start.get(name, 0.0)) for name in names])
    began_at = _unit_quaternions(program, y0, set(values_at_start))
    manifold = Manifold(program, f) if program.constraints else None
    times = np.linspace(0.0, t_end, steps + 1) if at is None else np.asarray(at, dtype=float)
    options: dict[str, Any] = {} if integrator == "dop853" else {"jac": lambda t, y: f.jac(t, y.tolist())}
    began = time.perf_counter()
    try:
        y0 = manifold.assemble(y0, set(start or {})) if manifold else y0
        options |= {"rtol": rtol, "atol": absolute_tolerance(program, y0, f, rtol, atol)}
        watched, method = _watched(f, progress, limit), INTEGRATORS[integrator]
        if manifold is not None:
            every = times if times[0] == 0.0 else np.concatenate(([0.0], times))
            solution: Any = integrate(manifold, watched, every, y0, method, options)
            solution.y = solution.y[:, len(every) - len(times) :]
        else:
            solution = solve_ivp(watched, (0.0, float(times[-1])), y0, method=method, t_eval=times, **options)
    except ArithmeticError as error:
        why = str(error)
        if manifold is not None and (dependent := manifold.dependent()):
            why = (
                f"the constraints {dependent} depend on each other near t = {manifold.at[0]:.6g} s: leave "
                "out one that the others imply everywhere (a direction of a loop, a constraint); at a dead point, "
                "begin or end elsewhere"
            )
        raise AnalysisError(f"simulation stopped: {why}", "pivot") from None
    if not solution.success or solution.y.shape[1] != len(times) or not np.all(np.isfinite(solution.y)):
        reached = solution.t[-1] if len(solution.t) else 0.0
        raise AnalysisError(
            f"simulation stopped after t = {reached:.6g} s of {t_end:g} s: {solution.message} "
            "Try a tighter rtol, or another integrator",
            "integrator",
        )
    statistics = {
        "integrator": integrator, "method": method, "rtol": rtol, "evaluations": int(solution.nfev),
        "jacobians": int(solution.njev), "seconds": time.perf_counter() - began,
        **({"projections": solution.projections} if manifold else {}),
    }  # fmt: skip
    y = solution.y.T
    for places in program.quaternions:  # the motion does not depend on the length, which an integration lets drift
        y[:, list(places)] /= np.linalg.norm(y[:, list(places)], axis=1, keepdims=True)
    outputs, inputs = (
        np.array([of(t, row) for t, row in zip(times, y.tolist(), strict=True)]).reshape(len(times), -1)
        for of in (f.outputs, f.inputs)
    )
    A = np.asarray(f.jac(float(times[-1]), y[-1].tolist()))
    if manifold is not None:
        free = manifold.tangent(float(times[-1]), y[-1])
        A = free.T @ A @ free
    eigenvalues = np.linalg.eigvals(A) if A.size else np.zeros(1)
    return SimulatedMotion(
        names, times, y, inputs, tuple(s.name for s in program.inputs),
        dict(zip(program.outputs, outputs.T, strict=True)), statistics,
        complex(eigenvalues[np.argmax(eigenvalues.real)]), (*began_at, *(manifold.notes if manifold else ())),
    )  # fmt: skip


def _unit_quaternions(program: OrderedProgram, y: np.ndarray, given: set[str]) -> list[str]:
    """Scale the quaternions of a start to length one, (1, 0, 0, 0) when nothing is given; what was scaled, in words.

    UsageError for a quaternion of which values are given and all are zero.
    """
    notes = []
    for places in program.quaternions:
        names = [program.state[k].name for k in places]
        chosen = list(places)
        if not given.intersection(names):
            y[chosen[0]] = 1.0
        length = float(np.linalg.norm(y[chosen]))
        if length == 0.0:
            raise UsageError(f"start: the quaternion {', '.join(names)} is zero: give a direction, such as 1, 0, 0, 0")
        if abs(length - 1.0) > 1e-12:
            notes.append(f"start        {', '.join(names)} were divided by their length {length:.12g}")
        y[chosen] /= length
    return notes


def absolute_tolerance(
    program: OrderedProgram, y0: np.ndarray, f: Any, rtol: float, atol: float | Mapping[str, float] | None
) -> np.ndarray:
    """One absolute tolerance a state; without wishes rtol times a scale, see `simulate`."""
    names, nq = [s.name for s in program.state], len(program.coordinates)
    if isinstance(atol, (int, float)):
        return np.full(len(names), float(atol))
    scale = np.maximum(np.abs(y0), _static(f, y0))
    if nq == program.n:  # at rest speeds are noise: their scale is that of the coordinate per second
        scale[nq:] = np.maximum(np.abs(y0[nq:]), scale[:nq])
    result = max(rtol, TIGHTEST_SCALED) * np.where(scale > 1e-12, scale, 1.0)
    for name, value in (atol or {}).items():
        result[names.index(name)] = float(value)
    return result


def _static(f: Any, y0: np.ndarray) -> np.ndarray:
    """Size of the first Newton step to rest, a deflection that stiff states will show; zero where it is not finite."""
    J = np.array(f.jac(0.0, y0.tolist()), dtype=float)
    step = np.linalg.lstsq(J, -np.array(f(0.0, y0.tolist()), dtype=float), rcond=1e-14)[0]
    return np.where(np.isfinite(step), np.abs(step), 0.0)


def _watched(f: Callable[..., Any], progress: Callable[[float], None] | None, limit: int) -> Callable[..., Any]:
    evaluations = 0

    def watched(t: float, y: np.ndarray) -> Any:
        nonlocal evaluations
        evaluations += 1
        if evaluations > limit:
            raise AnalysisError(
                f"simulation stalls at t = {t:.6g} s after {limit} evaluations: loosen rtol or atol, or try radau",
                "stall",
            )
        if progress is not None:
            progress(t)
        return f(t, y.tolist())

    return watched
