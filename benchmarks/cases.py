"""The cases of the speed table: models, settings to choose from, references and targets.

References are converged answers of another setting or closed forms; those that take long are kept in
references.json (`run.py --references` computes them again). Targets: what the fastest compiled programs reached, see
docs/performance.md.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from functools import cache
from itertools import pairwise
from pathlib import Path

import models
import numpy as np
from measure import Array, Case, Setting, Target
from scipy.optimize import brentq
from scipy.special import ellipe, ellipeinc, ellipk, ellipkinc

import spacar
from spacar.compiled import CompiledDynamics
from spacar.deck import Deck, parse_deck
from spacar.dynamics import Dynamics
from spacar.mechanism import build
from spacar.mechanism.mechanism import Mechanism

REFERENCES = Path(__file__).with_name("references.json")
CONVERGED = 1e-12  # tolerance of references
TOLERANCES = (3e-3, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10)
NAMES = {0: "Adams (0)", 155: "RK 5(4) (155)", 853: "RK 8(5,3) (853)", 430: "SDIRK 3 (430)", 330: "Rosenbrock 3 (330)",
         553: "Radau 5 (553)", 595: "Radau 9 (595)"}  # fmt: skip


@cache
def parsed(text: str, mode: int) -> Deck:
    return parse_deck(text, mode=mode)


def positions(mechanism: Mechanism) -> Array:
    """Indices of the coordinates of all position nodes."""
    n = mechanism.numbering
    return np.concatenate([n.lnp[node.number - 1, : node.size] - 1 for node in n.nodes if node.kind == "position"])


def motion(text: str, code: int, tolerance: float, step: float | None = None, compiled: bool = False) -> Array:
    """Positions of all nodes at all outputs of mode 1."""
    run = spacar.frames(
        1, parsed(text, 1), integrator=code, atol=tolerance, rtol=tolerance, step=step, compiled=compiled
    )
    where = positions(run.mechanism)
    return np.array([frame.x[where] for frame in run])


def tip(text: str, code: int, tolerance: float, step: float | None = None, compiled: bool = False) -> Array:
    """The same of the last node only."""
    return motion(text, code, tolerance, step, compiled)[:, -2:]


def tolerances(
    text: str, codes: tuple[int, ...], asked: tuple[float, ...] = TOLERANCES, paths: tuple[bool, ...] = (False, True)
) -> Iterator[Setting]:
    """Variable-step methods with one tolerance after the other, general and compiled."""
    for compiled in paths:
        for code in codes:
            for tolerance in asked:
                yield Setting(
                    f"{NAMES[code]}, ERROR {tolerance:.0e}", tolerance,
                    lambda c=code, e=tolerance, k=compiled: motion(text, c, e, compiled=k), compiled,
                )  # fmt: skip


def extrapolated(answers: list[Array], orders: tuple[int, ...] = (2, 4)) -> Array:
    """Richardson: answers on n, 2 n, 4 n ... elements with an error of these powers of 1/n."""
    for order in orders[: len(answers) - 1]:
        answers = [fine + (fine - coarse) / (2.0**order - 1.0) for coarse, fine in pairwise(answers)]
    return answers[-1]


# -- rigid mechanisms -------------------------------------------------------------------------------------------------
def simple(
    name: str, title: str, text: str, codes: tuple[int, ...], targets: tuple[Target, ...],
    reference: tuple[int, float] = (853, CONVERGED),
) -> Case:  # fmt: skip
    """`reference`: code and ERROR of the converged answer."""
    return Case(name, title, lambda: motion(text, *reference, compiled=True), lambda: tolerances(text, codes), targets)


def reactions(compiled: bool = False) -> Array:
    """Moment on the crank and force on the slider guide of crank.dat at 101 times."""
    run = spacar.frames(1, parsed(models.example("crank"), 1), compiled=compiled)
    n = run.mechanism.numbering
    rows = [n.x_index(2, 1), n.x_index(6, 2), n.x_index(1, 1), n.x_index(1, 2)]
    return np.array([frame.fxtot[rows] for frame in run])


def reactions_exact() -> Array:
    """Newton and Euler by hand: rod (mass m l, moment m l^3/12) and slider; crank without mass at constant speed."""
    r, l, m, slider, omega = 0.15, 0.30, 0.2225, 0.033375, 150.0
    t = np.linspace(0.0, 0.1, 101)
    a, s, c = omega * t, np.sin(omega * t), np.cos(omega * t)
    sine = -r * s / l  # of the angle b of the rod
    cosine = np.sqrt(1.0 - sine**2)
    b1 = -r * c * omega / (l * cosine)
    b2 = (r * s * omega**2 / l + sine * b1**2) / cosine
    pin = np.array([-r * c, -r * s]) * omega**2
    arm = np.array([cosine, sine])
    across = np.array([-sine, cosine])
    centre = pin + 0.5 * l * (across * b2 - arm * b1**2)
    end = pin + l * (across * b2 - arm * b1**2)
    mass, inertia = m * l, m * l**3 / 12.0
    fx = -slider * end[0]  # of the slider on the rod
    # moments about the pin: inertia b2 + d x (mass centre) = l arm x F
    torque = inertia * b2 + 0.5 * l * mass * (arm[0] * centre[1] - arm[1] * centre[0])
    fy = (torque / l + arm[1] * fx) / arm[0]
    on_pin = mass * centre - np.array([fx, fy])  # of the crank on the rod
    moment = r * (np.cos(a) * on_pin[1] - np.sin(a) * on_pin[0])
    return np.array([moment, fy, *on_pin]).T


def reaction_settings() -> Iterator[Setting]:
    for compiled in (False, True):
        yield Setting(
            "kinematics and reactions at 101 times, no integration", None, lambda k=compiled: reactions(k), compiled
        )


# -- flexible mechanisms ----------------------------------------------------------------------------------------------
def rod_middle(n: int, code: int, tolerance: float, step: float | None = None, compiled: bool = True) -> Array:
    """Deflection of the middle of the rod of crankfl.dat from the line through its ends, over its length."""
    run = spacar.frames(
        1, parsed(models.slider_crank(n), 1), integrator=code, atol=tolerance, rtol=tolerance, step=step,
        compiled=compiled,
    )  # fmt: skip
    number = run.mechanism.numbering
    nodes = [3, 2 * (n // 2) + 4, 2 * n + 4]
    rows = [[number.x_index(k, 1), number.x_index(k, 2)] for k in nodes]
    x = np.array([[frame.x[r] for r in rows] for frame in run])
    p, middle, q = x[:, 0], x[:, 1], x[:, 2]
    return np.asarray(((q - p)[:, 0] * (middle - p)[:, 1] - (q - p)[:, 1] * (middle - p)[:, 0]) / 0.3**2)


def rod_settings() -> Iterator[Setting]:
    """Radau and Adams on both paths, RK 8(5,3) compiled. The highest frequency limits the steps of the explicit
    codes, so ERROR hardly matters to them."""
    for compiled in (False, True):
        for n, code, error in (
            (4, 553, 1e-2), (8, 553, 1e-3), (8, 595, 1e-2), (8, 595, 3e-3), (16, 595, 1e-3), (16, 595, 5e-4),
            (32, 595, 1e-4), (32, 595, 5e-5), (32, 595, 3e-5),
        ):  # fmt: skip
            yield Setting(
                f"n = {n}, {NAMES[code]}, ERROR {error:.0e}", None,
                lambda n=n, c=code, e=error, k=compiled: rod_middle(n, c, e, compiled=k), compiled,
            )  # fmt: skip
    for compiled, code in ((False, 0), (True, 0), (True, 853)):
        for meshes in ((2,), (4,), (2, 4), (8,)):
            label = f"n = {', '.join(map(str, meshes))}{' extrapolated' if meshes[1:] else ''}, {NAMES[code]}"
            yield Setting(
                f"{label}, ERROR 1e-04", None,
                lambda m=meshes, c=code, k=compiled: extrapolated(
                    [rod_middle(n, c, 1e-4, compiled=k) for n in m], (4, 6)
                ),
                compiled,
            )  # fmt: skip


def rod_time_settings(text: str) -> Iterator[Setting]:
    yield from tolerances(text, (0,), (1e-4, 1e-6), (False,))
    yield from tolerances(text, (0, 155, 853), (1e-2, 1e-4, 1e-6), (True,))


def released(n: int) -> str:
    """Unit cantilever (L = EI = m = 1) under the suddenly applied gravity 1; tip deflection up to 0.25."""
    return models.cantilever(n, EI=1.0, length=1.0, dynamics=("GRAVITY 0. -1.", "TIMESTEP 1.8 9"))


def released_settings() -> Iterator[Setting]:
    """Implicit codes (the Jacobian is never compiled) and explicit ones, on both paths."""
    for compiled in (False, True):
        for meshes, code, errors in (
            ((8,), 553, (1e-2,)), ((16,), 553, (3e-3,)), ((4, 8), 553, (1e-2, 1e-2)), ((4, 8), 595, (1e-2, 5e-3)),
            ((8, 16), 595, (1e-3, 1e-3)), ((8, 16, 32), 595, (4e-4, 2e-4, 1e-4)), ((16, 32), 595, (2e-4, 1e-4)),
            ((16, 32), 595, (1e-4, 5e-5)), ((64,), 595, (2e-5,)), ((256,), 595, (1e-5,)),
        ):  # fmt: skip
            if meshes[0] > 32 and not compiled:
                continue  # half a minute for nothing: coarse meshes, extrapolated, are better
            yield Setting(
                f"n = {', '.join(map(str, meshes))}{' extrapolated' if meshes[1:] else ''}, {NAMES[code]}, "
                f"ERROR {errors[-1]:.0e}", None,
                lambda m=meshes, c=code, e=errors, k=compiled: extrapolated(
                    [tip(released(n), c, error, compiled=k) for n, error in zip(m, e, strict=True)]
                ),
                compiled,
            )  # fmt: skip
        for n, code, step in (
            (4, 330, 0.02), (8, 330, 0.02), (8, 430, 0.02), (16, 330, 0.01), (16, 430, 0.01),
        ):  # fmt: skip
            if compiled and n > 8:
                continue  # the Jacobian costs most of the time, and C has no band storage
            yield Setting(
                f"n = {n}, {NAMES[code]}, step {step}", None,
                lambda n=n, c=code, h=step, k=compiled: tip(released(n), c, 1e-9, h, k), compiled,
            )  # fmt: skip
        for meshes, step in (((2, 4), 0.02), ((4, 8), 0.01), ((2, 4, 8), 0.01)):
            yield Setting(
                f"n = {', '.join(map(str, meshes))} extrapolated, {NAMES[330]}, step {step}", None,
                lambda m=meshes, h=step, k=compiled: extrapolated([tip(released(n), 330, 1e-9, h, k) for n in m]),
                compiled,
            )  # fmt: skip
    for compiled, code in ((False, 0), (True, 0), (True, 155), (True, 853)):
        for meshes in ((4,), (8,), (2, 4), (4, 8)):
            label = f"n = {', '.join(map(str, meshes))}{' extrapolated' if meshes[1:] else ''}, {NAMES[code]}"
            yield Setting(
                f"{label}, ERROR 1e-04", None,
                lambda m=meshes, c=code, k=compiled: extrapolated(
                    [tip(released(n), c, 1e-4, compiled=k) for n in m]
                ),
                compiled,
            )  # fmt: skip


# -- statics and vibration --------------------------------------------------------------------------------------------
def bent(n: int, load_steps: int) -> str:
    """Tip of plbeam5.dat with n equal elements under 14 N."""
    return models.cantilever(n, mass=0.0, load="0. -14.", dynamics=(f"ITERSTEP 20 {load_steps} 1e-9",))


def statics_tip(n: int, load_steps: int = 4) -> Array:
    """Only the stationary solution of mode 7, without its eigenvalue problem."""
    from spacar.errors import Report
    from spacar.stationary import LoadProgram, StationarySolver

    mechanism = build(parsed(bent(n, load_steps), 7), 7)
    solver = StationarySolver(mechanism, Report())
    for level in LoadProgram(mechanism.settings):
        solver.solve(level)
    return np.asarray(solver.dynamics.kinematics.x[positions(mechanism)][-2:])


def elastica() -> Array:
    """Tip of the inextensible cantilever of plbeam5.dat under 14 N: elliptic integrals."""
    alpha = 14.0 * 10.0**2 / 102.0

    def modulus(theta: float) -> tuple[float, float]:
        k2 = 0.5 * (1.0 + np.sin(theta))
        return k2, float(np.arcsin(1.0 / np.sqrt(2.0 * k2)))

    def equation(theta: float) -> float:
        k2, phi = modulus(theta)
        return float(ellipk(k2) - ellipkinc(phi, k2) - np.sqrt(alpha))

    theta = brentq(equation, 1e-6, 0.5 * np.pi - 1e-9, xtol=1e-15, rtol=1e-15)
    k2, phi = modulus(theta)
    x = 10.0 * np.sqrt(2.0 * np.sin(theta) / alpha)
    y = 10.0 * (1.0 - 2.0 / np.sqrt(alpha) * (ellipe(k2) - ellipeinc(phi, k2)))
    return np.array([x, -y])


def bent_settings() -> Iterator[Setting]:
    for n in (5, 10, 20, 50, 100, 200, 500, 1000):
        yield Setting(f"n = {n}", None, lambda n=n: statics_tip(n))
    for first in (5, 10, 20, 40):
        for count in (2, 3, 4):
            meshes = [first * 2**k for k in range(count)]
            yield Setting(
                f"n = {', '.join(map(str, meshes))} extrapolated", None,
                lambda m=meshes: extrapolated([statics_tip(n) for n in m], (2, 4, 6)),
            )  # fmt: skip


def lowest_frequency(n: int) -> Array:
    """[rad/s] of the unit cantilever in mode 7."""
    text = models.cantilever(n, EI=1.0, length=1.0)
    last = None
    for last in spacar.frames(7, parsed(text, 7)):  # noqa: B007
        pass
    assert last is not None
    values = np.abs(last.matrices["eigval"][:, 1])
    return np.array([values[values > 0.0].min()])


def exact_frequency() -> Array:
    root = brentq(lambda b: np.cos(b) * np.cosh(b) + 1.0, 1.5, 2.5, xtol=1e-15, rtol=1e-15)
    return np.array([root**2])


def frequency_settings() -> Iterator[Setting]:
    for n in (1, 2, 3, 4, 8, 16, 32, 64):
        yield Setting(f"n = {n}", None, lambda n=n: lowest_frequency(n))
    for meshes in ((2, 4), (4, 8), (2, 4, 8), (4, 8, 16)):
        yield Setting(
            f"n = {', '.join(map(str, meshes))} extrapolated", None,
            lambda m=meshes: extrapolated([lowest_frequency(n) for n in m], (4, 6)),
        )  # fmt: skip


# -- one right-hand side ----------------------------------------------------------------------------------------------
CHAINS = {
    "planar flexible": lambda n: models.cantilever(
        n, EI=1.0, length=1.0, dynamics=("GRAVITY 0. -9.81", "TIMESTEP 0.01 1")
    ),
    "planar rigid": lambda n: models.pendulum(n, 0.01, 1),
    "spatial flexible": models.spatial_chain,
    "spatial rigid": lambda n: models.spatial_pendulum(n, 0.01, 1),
}


class Evaluator:
    """Calls of F along a motion, as an integrator makes them: time and state move a little each time.

    Steps shrink with the square of the number of elements, as the highest frequency makes those of explicit codes do.
    """

    def __init__(self, text: str, kind: str | None = None, compiled: bool = False) -> None:
        mechanism = build(parsed(text, 1), 1)
        self.dynamics = CompiledDynamics(mechanism) if compiled else Dynamics(mechanism, kind=kind)
        self.y = self.dynamics.start()
        self.half = mechanism.numbering.nddof
        self.y[self.half :] = 1e-2 * np.random.default_rng(1).normal(size=len(self.y) - self.half)
        elements = sum(b.family.n for b in mechanism.batches)
        self.t, self.step = 0.0, 1e-6 * min(1.0, 100.0 / elements) ** 2
        self.dynamics.rhs(self.t, self.y)

    def __call__(self) -> Array:
        self.t += self.step
        self.y[: self.half] += self.step * self.y[self.half :]
        return self.dynamics.rhs(self.t, self.y)


@cache
def references() -> dict[str, list[list[float]]]:
    return dict(json.loads(REFERENCES.read_text())) if REFERENCES.exists() else {}


def kept(name: str) -> Callable[[], Array]:
    return lambda: np.array(references()[name])


def released_reference() -> Array:
    """n = 32, 64, 128, code 595; mesh error extrapolated; see docs/performance.md for its error."""
    return extrapolated([tip(released(n), 595, 1e-6, compiled=True) for n in (32, 64, 128)])


def rod_reference() -> Array:
    """n = 32 and 64, code 595, extrapolated with order 2; see docs/performance.md for its error."""
    return extrapolated([rod_middle(n, 595, 1e-6) for n in (32, 64)], (2,))


# What `--references` computes: half a minute.
SLOW_REFERENCES: dict[str, Callable[[], Array]] = {"released": released_reference, "rod": rod_reference}

CASES: tuple[Case, ...] = (
    simple(
        "slider-crank", "free slider-crank, 1 degree of freedom, 10 s, 100 outputs", models.free_slider_crank(10.0,
        100),
        (0, 155, 853), (Target(1e-4, 0.27), Target(1e-6, 0.45), Target(1e-8, 0.67)),
    ),
    Case(
        "reactions", "prescribed slider-crank (crank.dat) with reactions, 101 times", reactions_exact,
        reaction_settings,
        (Target(1e-4, 0.015), Target(1e-6, 0.129), Target(1e-8, 1.6)),
    ),
    simple(
        "pendulum", "planar pendulum of 10 links, 10 s, 100 outputs", models.pendulum(10, 10.0, 100), (0, 155),
        (Target(1e-4, 0.043, 3.0), Target(1e-6, 0.086, 3.0), Target(1e-8, 0.123, 3.0), Target(1e-10, 0.215, 3.0)),
        (155, 1e-11),
    ),
    simple(
        "manipulator", "spatial manipulator, 3 degrees of freedom, 1.4 s, 14 outputs", models.manipulator(), (0, 155,
        853),
        (Target(1e-4, 0.0013, 5.0), Target(1e-6, 0.0032, 5.0), Target(1e-6, 0.290, 0.05)),
    ),
    Case(
        "crankfl", "flexible slider-crank, converged over the mesh, 0.1 s: deflection of the middle over the length",
        kept("rod"), rod_settings, (Target(1e-4, 0.52), Target(2e-5, 2.0)), (1e-1, 1e-2, 1e-4),
    ),
    Case(
        "crankfl-2", "crankfl.dat with 2 elements: error in time only", lambda: motion(models.slider_crank(2), 853,
        1e-8, compiled=True),
        lambda: rod_time_settings(models.slider_crank(2)), levels=(1e-4, 1e-6, 1e-8),
    ),
    Case(
        "crankfl-8", "crankfl.dat with 8 elements, 0.01 s: error in time only",
        lambda: motion(models.slider_crank(8, 0.01, 10), 853, 1e-8, compiled=True),
        lambda: rod_time_settings(models.slider_crank(8, 0.01, 10)), levels=(1e-4, 1e-6, 1e-8),
    ),
    Case(
        "released", "released cantilever, 1.8 s, tip, converged over the mesh", kept("released"), released_settings,
        (Target(1e-4, 0.175), Target(1e-6, 6.3)), (1e-3, 1e-4, 1e-5, 1e-6),
    ),
    Case(
        "bent", "cantilever of 10 m under 14 N, statics against the elastica", elastica, bent_settings,
        (Target(4e-5, 0.003, 5.0), Target(1e-6, 0.008, 5.0), Target(2e-8, 0.015, 5.0), Target(3e-10, 0.030, 5.0)),
    ),
    Case(
        "frequency", "lowest frequency of a cantilever (mode 7)", exact_frequency, frequency_settings,
        (Target(1e-4, 0.0015, 3.0), Target(1e-6, 0.006, 3.0), Target(1e-8, 0.022, 3.0)),
    ),
)  # fmt: skip
