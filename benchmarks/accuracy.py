"""The accuracy asked for and obtained: motions and meshes, targets 1e-3, 1e-5, 1e-7 (docs/studies.md, Accuracy).

python benchmarks/accuracy.py [motions | meshes] [MODEL ...]

Motions: the norm of `studies.runs.result_quantities` over the free coordinates against a reference of method 853 with
ERROR REFERENCE (595 with ten times of it for stiff models), on the mesh of the model; the screws and the pendulum on a
stiff truss against equations of one coordinate, which use nothing of spacar. What is below KNOWN
times that ERROR, error and estimate, says nothing about estimates. Cost: time and right-hand sides of all runs of the
search over those of the fastest single run (155, 853, 0, 595, ERROR in decades) that reaches the target.

Meshes: tip of the elastica and frequencies of a cantilever, Euler and lateral buckling against closed forms; the guide
of leaf springs against 16, 32 and 64 beams a leaf, extrapolated. Cost: over the cheapest single mesh of 1, 2 ... 64
beams in the place of each, of either measure, that reaches the target.
"""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass, field, replace
from pathlib import Path

import default_method
import models
import numpy as np

import spacar
from spacar.arrays import Array
from spacar.deck import Deck, parse_deck
from spacar.deck.rewrite.refine import refine
from spacar.errors import AnalysisError
from spacar.studies.runs.result_quantities import amplitudes, distance, free_coordinates

TARGETS = (1e-3, 1e-5, 1e-7)
REFERENCE, KNOWN = 1e-12, 10.0
CODES = (155, 853, 0, 595)
DECADES = tuple(10.0**-k for k in range(2, 11))
REPEATS, SHORT = 3, 1.0  # runs of a setting, while they take less than so many seconds together
LONGEST = 30.0  # seconds of a single mesh, after which no finer one is tried
LIMIT = 4.0  # times the cheapest so far: a single run that takes longer is not looked at

GYRO = """
RBEAM 1 1 2 3
HINGE 2 4 2 0 0 1
FIX 1
FIX 4
DYNE 2 1
X 3 1. 0. 0.2
END HALT
EM 1 1. 0.01 0.005 0.005
STARTDE 2 1 0. 4.
GRAVITY 0. -9.81 0.
TIMESTEP 3. 30
END END
"""


def oscillator(periods: float) -> str:
    """1 m truss, 20 rad/s, start 0.01 m."""
    time_ = periods * 2.0 * np.pi / 20.0
    return models.deck(
        ["PLTRUSS 1 1 2", "X 2 1. 0.", "FIX 1", "FIX 2 2", "DYNE 1 1"],
        ["XM 2 0.5", "ESTIFF 1 200.", "STARTDE 1 1 0.01 0.", f"TIMESTEP {time_!r} 50"],
    )


def released(n: int) -> str:
    return models.cantilever(n, EI=1.0, length=1.0, dynamics=("GRAVITY 0. -1.", "TIMESTEP 1.8 18"))


# Slider-crank under a constant torque, about 83 turns; double pendulum; manipulator under constant torques.
TURNING = models.deck(
    ["PLBEAM 1 1 2 3 4", "PLBEAM 2 3 5 6 7", "X 3 0.15 0.", "X 6 0.45 0.", "FIX 1", "FIX 6 2", "DYNX 2 1"],
    ["EM 1 0.2225", "EM 2 0.2225", "XM 6 0.033375", "XF 2 0.01", "GRAVITY 0. -9.81", "STARTDX 2 1 0. 30.",
     "TIMESTEP 10. 10"],
)  # fmt: skip
DOUBLE = models.deck(
    ["PLBEAM 1 1 2 4 3", "PLBEAM 2 4 5 7 6", "X 4 0.7071067811865475 -0.7071067811865476",
     "X 7 1.414213562373095 -1.4142135623730951", "FIX 1", "DYNX 2 1", "DYNX 5 1"],
    ["EM 1 1.", "EM 2 1.", "GRAVITY 0. -9.81", "TIMESTEP 10. 10"],
)  # fmt: skip
TORQUES = models.deck(
    ["HINGE 1 1 2 0. 0. 1.", "HINGE 2 2 3 0. -1. 0.", "BEAM 4 4 3 5 6 0. 1. 0.", "HINGE 3 6 7 0. -1. 0.",
     "BEAM 5 5 7 8 9 0. 1. 0.", "X 5 0.268 0. 0.6467", "X 8 0.536 0. 0.", "FIX 1", "FIX 4", "DYNE 1 1", "DYNE 2 1",
     "DYNE 3 1"],
    ["XM 5 10.", "XM 8 30.", "EM 4 4.", "EM 5 2.", "GRAVITY 0. 0. -10.", "ESIG 1 -15.", "ESIG 2 -197.",
     "ESIG 3 -82.5", "TIMESTEP 1.4 14"],
)  # fmt: skip

# The screw of data/, whose beam does not turn, with a turned end, until its vibration has died away by 99 %.
RELEASED = models.example("screw").replace("STARTDE 2 1 0.0 -1.0", "STARTDE 2 1 0.3 -1.0")
RELEASED = RELEASED.replace("TIMESTEP 10 200", "TIMESTEP 0.2 100")
SCREWS = {"screw": 0.0, "screw, beam released at 0.3 rad": 0.3}  # rotation at the start [rad]

# A pendulum whose rod is a spring of 1e10 N/m: 1e5 rad/s, so Radau; it is longer than the rigid one by 3e-9.
STIFF_ROD = models.deck(
    ["PLTRUSS 1 1 2", "X 2 1. 0.", "FIX 1", "DYNX 2", "RLSE 1"],
    ["XM 2 1.", "ESTIFF 1 1e10", "GRAVITY 0. -9.81", "TIMESTEP 3. 30"],
)  # fmt: skip

# Two masses on a spring that drift with 1 km/s.
DRIFTING = models.deck(
    ["PLTRUSS 1 1 2", "X 2 1. 0.", "DYNX 1 1 2", "DYNX 2 1 2", "RLSE 1"],
    ["XM 1 2.", "XM 2 1.", "ESTIFF 1 50.", "STARTDX 1 1 0. 1e3", "STARTDX 1 2 0. -1.", "STARTDX 2 1 1. 1e3",
     "STARTDX 2 2 0. 2.", "TIMESTEP 20. 40"],
)  # fmt: skip

SCENARIOS = Path(__file__).resolve().parent / "peers" / "scenarios"
MODELS: dict[str, str | Path | None] = {  # a path where functions of the user stand beside the file
    "oscillator, 3 periods": oscillator(3.0),
    "oscillator, 50 periods": oscillator(50.0),
    "pendulum, 1 rod": models.pendulum(1, 10.0, 50),
    "pendulum, 2 rods": models.pendulum(2, 5.0, 50),
    "pendulum, 6 rods": models.pendulum(6, 2.0, 20),
    "spatial pendulum, 3 rods": models.spatial_pendulum(3, 1.0, 20),
    "rotor on a hinge": GYRO,
    "free slider-crank, 2 s": models.free_slider_crank(2.0, 40),
    "free slider-crank, 10 s": models.free_slider_crank(10.0, 50),
    "manipulator": models.manipulator(),
    "crankfl": models.example("crankfl"),
    "finger": models.example("finger"),
    "fingersim": models.example("fingersim"),
    "screw": models.example("screw"),
    "screw, beam released at 0.3 rad": RELEASED,
    "trike2": models.example("trike2"),
    "trike3i": models.example("trike3i"),
    "trike3v": models.example("trike3v"),
    "slider-crank under torque, 83 turns": TURNING,
    "double pendulum, 10 s": DOUBLE,
    "manipulator under torques": TORQUES,
    "crankfl, 2 elements": models.slider_crank(2, 0.05, 50),
    "released cantilever, 2 elements": released(2),
    "released cantilever, 4 elements": released(4),
    "pendulum on a stiff truss": STIFF_ROD,
    "resonator of 1e-7 m": default_method.damper(0.0, 2.3, k=4e-2 * np.pi**2, start=1e-7).replace("X 2 1.", "X 2 0.01"),
    "stiff damper 1e8": default_method.damper(1e8, 1e8),
    "drifting masses": DRIFTING,
    "pulse that nobody declares": SCENARIOS / "pulse.dat",
    "S4": SCENARIOS / "S4.dat",
    **dict.fromkeys(("S1a", "S1b", "S3a", "S4c"), None),
    **{name: models.example(name) for name in ("cardan", "cardansimp", "crank", "crank2", "slider")},
}
MODELS |= {name: (SCENARIOS / f"{name}.dat").read_text() for name, text in MODELS.items() if text is None}


@dataclass(frozen=True)
class Reference:
    """Free coordinates (variables, times) and their amplitudes."""

    values: Array
    amplitude: Array

    def error(self, values: Array) -> float:
        return distance(values, self.values, self.amplitude)


def motion(deck: Deck, repeats: int = 1, **options: object) -> tuple[Array, spacar.Run, float, int]:
    """Free coordinates (variables, times), the run, processor time [s] (least of several), right-hand sides."""
    seconds: list[float] = []
    while not seconds or (len(seconds) < repeats and sum(seconds) < SHORT):
        begun = time.process_time()
        run = spacar.frames(1, deck, **options)
        shown = list(run)
        seconds.append(time.process_time() - begun)
    x, rhs = np.array([f.x for f in shown]), sum(f.statistics.get("rhs", 0) for f in shown)
    return x[:, free_coordinates(run.mechanism)].T, run, min(seconds), rhs


def cheapest(deck: Deck, ref: Reference) -> dict[float, tuple[float, int]]:
    """Time and right-hand sides of the fastest single run for each target."""
    best = dict.fromkeys(TARGETS, (np.inf, 0))
    for code in CODES:
        for tolerance in DECADES:
            try:
                values, _, *cost = motion(deck, REPEATS, integrator=code, rtol=tolerance, atol=0.1 * tolerance)
            except AnalysisError:  # so inaccurate that the model leaves its range
                continue
            error = ref.error(values)
            for target in TARGETS:
                if error <= target:
                    best[target] = min(best[target], (cost[0], cost[1]))
            if error <= TARGETS[-1] or cost[0] > LIMIT * best[TARGETS[-1]][0]:
                break
    return best


COLUMNS = ("model", "asked", "obtained", "estimate", "obtained / asked", "runs", "time [s]", "of the last",
           "of the cheapest", "right-hand sides")  # fmt: skip


def head() -> None:
    print(f"| {' | '.join(COLUMNS)} |\n|{'---|' * len(COLUMNS)}")


def told(found: list[tuple[float, float, float]]) -> None:
    """Obtained / asked, estimate / obtained, cost / that of the cheapest (nan: unknown) of all cases."""
    ratios, estimates, costs = np.array(found).T
    known, (median, most) = estimates[np.isfinite(estimates)], np.nanquantile(costs, (0.5, 0.9))
    kept, close = 100 * np.mean(ratios <= 1.0), 100 * np.mean((known >= 1.0) & (known <= 30.0))
    print(f"\nkept: {kept:.0f} % of {len(ratios)}, largest {ratios.max():.2g}; estimate 1 to 30 times the error: "
          f"{close:.0f} % of {len(known)}; cost: median {median:.2f}, nine tenths {most:.2f}\n")  # fmt: skip


def screw_motion(t: Array, start: float) -> Array:
    """The free coordinates of data/screw.dat (variables, times), from the rotation theta of the end of its beam, which
    is `start` [rad] and at rest at t = 0.

    The end is at (1 + 0.01 t, 0, 0) and turned about x by theta; the clamped end at (1, 0, -1), x' = z, y' = x, z' = y.
    With l = sqrt(1 + u^2), u = 0.01 t and the measures of theory-spatial.md section 3 (no torsion):

        e1 = l - 1,   e3 = 0,   e4 = -sin(theta)/l,   e5 = u/l,   e6 = -u/l,   e1 + quadratic, e2 + e4 e5

    sigma = S e + S_d de/dt, kinetic energy of the Hermite line 4/420 m theta'^2/2. Derivatives by SymPy.
    """
    import sympy as sp
    from scipy.integrate import solve_ivp

    theta, w, time_ = sp.symbols("theta w t")
    u = time_ / 100
    l = sp.sqrt(1 + u**2)
    raw = [l - 1, 0, 0, -sp.sin(theta) / l, u / l, -u / l]
    e1, e2, e3, e4, e5, e6 = raw
    e = sp.Matrix([
        e1 + (2 * (e3**2 + e4**2 + e5**2 + e6**2) + e3 * e4 + e5 * e6) / 30, e2 + e4 * e5 - e3 * e6,
        e3 + e2 * (e5 + e6) / 6, e4 - e2 * (e5 + e6) / 6, e5 - e2 * (e3 + e4) / 6, e6 + e2 * (e3 + e4) / 6,
    ])  # fmt: skip

    def law(EA: float, GIt: float, EIy: float, EIz: float) -> sp.Matrix:
        pair = sp.Matrix([[4, -2], [-2, 4]])
        return sp.diag(EA, GIt, EIy * pair, EIz * pair)

    rate = e.diff(theta) * w + e.diff(time_)
    stress = law(1000.0, 1.5, 100.0, 1.0) * e + law(1000.0, 0.015, 0.1, 0.0) * rate
    turning = sp.lambdify((time_, theta, w), -(e.diff(theta).T * stress)[0] / sp.Rational(4, 420), cse=True)
    run = solve_ivp(lambda s, y: (y[1], turning(s, *y)), (t[0], t[-1]), (start, 0.0), "DOP853", t_eval=t,
                    rtol=1e-13, atol=1e-15)  # fmt: skip
    turned, zero, one = run.y[0], 0.0 * t, 0.0 * t + 1.0
    place = (1.0 + 0.01 * t, zero, zero)
    tip = (place[0], 0.2 * np.cos(t), 0.2 * np.sin(t))
    half = (np.cos(0.5 * t), np.sin(0.5 * t), zero, zero), (np.cos(0.5 * turned), np.sin(0.5 * turned), zero, zero)
    return np.array((one, *place, *half[0], *half[1], one, *tip))  # lambda0 of the fixed nodes 2 and 7 are one


def rigid_pendulum(t: Array) -> Array:
    """Place of the end (2, times) of a pendulum of 1 m that is released horizontally, 9.81 m/s^2."""
    from scipy.integrate import solve_ivp

    run = solve_ivp(lambda _, y: (y[1], -9.81 * np.cos(y[0])), (t[0], t[-1]), (0.0, 0.0), "DOP853", t_eval=t,
                    rtol=1e-13, atol=1e-14)  # fmt: skip
    return np.array((np.cos(run.y[0]), np.sin(run.y[0])))


def motions(names: list[str]) -> None:
    head()
    ratios: list[tuple[float, float, float]] = []
    for name in names or MODELS:
        given = MODELS[name]
        assert given is not None
        deck = spacar.read_deck(given, 1) if isinstance(given, Path) else parse_deck(given, mode=1)
        motion(deck, accuracy=0.1, mesh=False)  # imports what is needed before the clock runs
        if name in SCREWS or given is STIFF_ROD:
            settings = spacar.frames(1, deck).mechanism.settings
            assert settings.duration is not None
            t, error = np.linspace(0.0, settings.duration, settings.n_steps + 1), REFERENCE
            values = rigid_pendulum(t) if given is STIFF_ROD else screw_motion(t, SCREWS[name])
        else:
            code, error = (595, 10.0 * REFERENCE) if name.startswith("stiff") else (853, REFERENCE)
            error *= 100.0 if isinstance(given, Path) else 1.0  # jumps of a user function are known to rounding of t
            values = motion(deck, integrator=code, rtol=error, atol=0.1 * error)[0]
        known = KNOWN * error
        ref = Reference(values, amplitudes(values, stationary=False))
        best = cheapest(deck, ref)
        for target in TARGETS:
            values, run, seconds, _ = motion(deck, REPEATS, accuracy=target, mesh=False)
            error, found = ref.error(values), run.header["accuracy"]
            rhs = sum(a.rhs for a in found.attempts) / best[target][1] if best[target][1] else np.nan
            if len(run.mechanism.numbering.dynamic):  # else nothing is integrated
                close = found.estimate / error if max(error, found.estimate) > known else np.nan
                ratios.append((error / target, close, rhs))
            runs = ", ".join(f"{a.integrator} {a.tolerance:.0e}" for a in found.attempts)
            print(f"| {name} | {target:.0e} | {error:.1e} | {found.estimate:.1e} | {error / target:.2g} | {runs} "
                  f"| {seconds:.3g} | {found.cost:.2f} | {seconds / best[target][0]:.2f} | {rhs:.2f} |",
                  flush=True)  # fmt: skip
    told(ratios)


BETA = np.array((1.8751040687119611, 4.694091132974175, 7.854757438237613))  # cos b cosh b = -1


@dataclass(frozen=True)
class MeshCase:
    """A model in a mode; which `coordinates`, how many `frequencies` [rad/s] and whether the load multiplier count."""

    deck: Deck
    mode: int
    coordinates: tuple[tuple[int, int], ...] = ()
    frequencies: int = 0
    multiplier: bool = False
    exact: Array = field(default_factory=lambda: np.zeros(0))
    amplitude: Array = field(default_factory=lambda: np.zeros(0))

    def of(self, result: spacar.Result) -> Array:
        values = [result.node(*c)[-1] for c in self.coordinates]
        if self.frequencies:
            values += list(2.0 * np.pi * result.frequencies[-1][: self.frequencies])
        return np.array(values + ([abs(result["lmult"][-1][0])] if self.multiplier else []))

    def variables(self) -> list[str]:
        """The same as expressions of the model: eigenvalues come by decreasing modulus."""
        names = [f"x[{node},{c}]" for node, c in self.coordinates]
        if self.frequencies:
            count = len(spacar.run(self.mode, self.deck)["eigval"][-1])
            names += [f"abs(eigval[{count - 2 * k}])" for k in range(self.frequencies)]
        return names + (["abs(lmult[1])"] if self.multiplier else [])

    def values(self, deck: Deck, **options: object) -> Array:
        return self.of(spacar.run(self.mode, deck, **options))

    def error(self, values: Array) -> float:
        return float(np.max(np.abs(values - self.exact) / self.amplitude))


def mesh_case(name: str) -> MeshCase:
    if name == "elastica, tip":
        text, tip = models.cantilever(2, dynamics=("XF 5 0. 14.",)), np.array((3.810897752359167, 8.404448390735478))
        return MeshCase(parse_deck(text, mode=7), 7, ((5, 1), (5, 2)), exact=tip, amplitude=tip)
    if name == "cantilever, three frequencies":
        deck = parse_deck(models.cantilever(3, EI=1.0, length=1.0, dynamics=()), mode=7)
        return MeshCase(deck, 7, frequencies=3, exact=BETA**2, amplitude=BETA**2)
    if name == "column2, Euler":
        exact = np.array([np.pi**2])
        return MeshCase(parse_deck(models.example("column2"), mode=8), 8, multiplier=True, exact=exact, amplitude=exact)
    if name == "lateral4, lateral buckling":
        exact = np.array([5.674672412058660])  # 2 sqrt(2) times the first zero of J_-1/4
        deck = parse_deck(models.example("lateral4"), mode=8)
        return MeshCase(deck, 8, multiplier=True, exact=exact, amplitude=exact)
    empty = MeshCase(parse_deck(models.example("leafguide"), mode=7), 7, ((7, 1), (7, 2)), frequencies=1)
    a, b, c = (empty.values(refine(empty.deck, n)) for n in (4, 8, 16))
    once = b + (b - a) / 3.0, c + (c - b) / 3.0
    exact = once[1] + (once[1] - once[0]) / 15.0
    return replace(empty, exact=exact, amplitude=np.abs(exact))


MESHES = ("elastica, tip", "cantilever, three frequencies", "column2, Euler", "lateral4, lateral buckling",
          "leafguide, body and first frequency")  # fmt: skip


def cheapest_mesh(case: MeshCase) -> dict[float, float]:
    best = dict.fromkeys(TARGETS, np.inf)
    for beams in ("sine", "angle"):
        for n in (1, 2, 4, 8, 16, 32, 64):
            begun = time.process_time()
            try:
                values = case.values(refine(case.deck, n), beams=beams)
            except AnalysisError:
                continue
            seconds = time.process_time() - begun
            error = case.error(values)
            for target in TARGETS:
                if error <= target:
                    best[target] = min(best[target], seconds)
            if error <= TARGETS[-1] or seconds > LIMIT * best[TARGETS[-1]] or seconds > LONGEST:
                break
    return best


def meshes(names: list[str]) -> None:
    head()
    ratios: list[tuple[float, float, float]] = []
    for name in names or MESHES:
        case = mesh_case(name)
        variables = case.variables()
        case.values(case.deck)  # imports what is needed before the clock runs
        best = cheapest_mesh(case)
        for target in TARGETS:
            begun = time.process_time()
            result = spacar.run(case.mode, case.deck, accuracy=target, variables=variables)
            seconds, found = time.process_time() - begun, result.header["accuracy"]
            error = case.error(case.of(result))
            over = seconds / best[target] if np.isfinite(best[target]) else np.nan
            ratios.append((error / target, found.estimate / error, over))
            pieces = f"{found.runs} to {max(found.pieces.values(), default=1)} beams"
            print(f"| {name} | {target:.0e} | {error:.1e} | {found.estimate:.1e} | {error / target:.2g} | {pieces} "
                  f"| {seconds:.3g} | {found.cost:.2f} | {over:.2f} | |", flush=True)  # fmt: skip
    told(ratios)


def main(words: list[str]) -> None:
    which = words[0] if words[:1] in (["motions"], ["meshes"]) else ""
    names = words[1:] if which else words
    if which != "meshes":
        motions(names)
    if which != "motions" and (which or not names):
        meshes(names)


if __name__ == "__main__":
    main(sys.argv[1:])
