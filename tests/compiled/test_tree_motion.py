"""Rigid trees: C evaluates them without equations for the positions; all must be as on the general path.

Both know a position to 1e-11 of the sizes in it and accelerations to the rounding of sums of some hundred terms: 1e-9
of the largest value of each kind.
"""

import models
import numpy as np
import pytest

import spacar
from spacar.compiled import CompiledDynamics
from spacar.compiled.library import unavailable, why_off
from spacar.dynamics import Dynamics
from spacar.errors import Report
from spacar.forward.accepted_steps import singularity_monitor
from spacar.frame import E_FIELDS, X_FIELDS
from spacar.mechanism import build
from spacar.studies.assignments import change, setting
from tests.ensembles import ensemble
from tests.examples import DATA

from .other_ways import started

pytestmark = pytest.mark.skipif(unavailable() is not None, reason=str(unavailable()))


def row(*words: object) -> str:
    return " ".join(repr(float(w)) if isinstance(w, float) else str(w) for w in words)


class Grower:
    """Text of a random tree. Joints are at the ends of what is there; elements point either way, some hinges are
    prescribed or locked, and there are masses, springs, dampers and forces of all kinds."""

    def __init__(self, seed: int) -> None:
        self.rng = np.random.default_rng(seed)
        self.rows: list[str] = []
        self.dynamics: list[str] = []
        self.nodes = self.elements = 0

    def chance(self, part: float) -> bool:
        return bool(self.rng.random() < part)

    def number(self) -> float:
        return float(self.rng.uniform(0.2, 2.0))

    def vector(self, n: int) -> list[float]:
        return [float(a) for a in self.rng.standard_normal(n)]

    def node(self) -> int:
        self.nodes += 1
        return self.nodes

    def element(self) -> int:
        self.elements += 1
        return self.elements

    def hinge(self, keyword: str, carrier: int, axis: list[float], first: bool) -> int:
        """A hinge from `carrier`; its new orientation."""
        k, new = self.element(), self.node()
        pair = (carrier, new) if self.chance(0.7) else (new, carrier)
        self.rows.append(row(keyword, k, *pair, *axis))
        if first or self.chance(0.7):
            self.rows.append(row("DYNE", k, 1))
            self.dynamics.append(row("STARTDE", k, 1, *self.vector(2)))
            self.dynamics += [row("ESTIFF", k, self.number()), row("EDAMP", k, self.number())]
            if self.chance(0.5):
                self.dynamics.append(row("ESIG", k, self.number()))
        elif self.chance(0.6):
            self.rows.append(row("INPUTE", k, 1))
            self.dynamics.append(row("INPUTE", k, 1, *self.vector(3)))
        return new

    def orientation(self, first: bool) -> int:
        """A new one, which is prescribed or free."""
        new, motion = self.node(), "INPUTX" if not first and self.chance(0.4) else "STARTDX"
        self.rows.append(row("DYNX" if motion == "STARTDX" else motion, new, 1))
        self.dynamics.append(row(motion, new, 1, *self.vector(2 if motion == "STARTDX" else 3)))
        return new

    def rod(self, place: dict, at: int, orientation: int, size: int, inertia: list[float]) -> tuple[int, int]:
        """A rod, rigid or a beam, from node `at` on: its tip and the orientation node behind it."""
        tip, k, pl = self.node(), self.element(), "PL" if size == 2 else ""
        place[tip] = [a + b for a, b in zip(place[at], self.vector(size), strict=True)]
        if self.chance(0.5):
            far = self.node()
            nodes = (at, orientation, tip, far) if self.chance(0.5) else (tip, far, at, orientation)
            self.rows.append(row(f"{pl}BEAM", k, *nodes, *self.vector(0 if pl else 3)))
            orientation = far if self.chance(0.5) else orientation
        else:
            self.rows.append(row(f"{pl}RBEAM", k, at, orientation, tip))
        self.dynamics.append(row("EM", k, self.number(), *(inertia if self.chance(0.5) else [])))
        return tip, orientation

    def some_of(self, statements: tuple) -> None:
        for chance, words in statements:
            if self.chance(chance) and not any(line.startswith(row(*words[:2]) + " ") for line in self.dynamics):
                self.dynamics.append(row(*words))

    def text(self) -> str:
        if self.chance(0.5):
            self.rows.append("ADEFORM")
        gravity = row("GRAVITY", *self.vector(2 if self.rows[0].startswith("PL") else 3))
        return "\n".join([*self.rows, "END", "HALT", *self.dynamics, gravity, "TIMESTEP 0.5 5", "END", "END", ""])


def random_tree(size: int, seed: int, links: int) -> str:
    """In the plane (size 2) joints may be orientation nodes that move by themselves. The base may be a slide."""
    g, planar = Grower(seed), size == 2
    base, ground = g.node(), g.node()
    place = {base: g.vector(size)}
    ends = [(base, ground)]
    moving = g.chance(0.5)
    for link in range(links):
        at, carrier = ends[g.rng.integers(len(ends))]
        if planar and g.chance(0.5):
            orientation = g.orientation(link == 0)
        else:
            orientation = g.hinge("PLTOR" if planar else "HINGE", carrier, [] if planar else g.vector(3), link == 0)
        tip, orientation = g.rod(place, at, orientation, size, [0.02] if planar else [0.02, 0.01, 0.015, 0.001])
        ends.append((tip, orientation))
        tensor = [g.number()] if planar else [0.1, 0.01, 0.0, 0.2, 0.02, 0.15]
        g.some_of((
            (0.4, ["XM", tip, g.number()]), (0.3, ["XM", orientation, *tensor]), (0.3, ["XF", tip, *g.vector(size)]),
            (0.2, ["XF", orientation, *g.vector(1 if planar else 4)]),
            (0.2, ["XF", orientation, *g.vector(1 if planar else 3)]),
        ))  # fmt: skip
    g.rows.sort(key=lambda line: line.startswith(("DYN", "INPUT")))  # elements first
    g.rows += [row("X", n, *where) for n, where in place.items()]
    if moving:
        g.rows += [row("INPUTX", base, 2), row("DYNX", base, 1) if planar else row("FIX", base, 1, 3)]
        g.dynamics += [row("INPUTX", base, 2, place[base][1], 0.4, -0.7), row("XM", base, 2.0)]
    else:
        g.rows.append(row("FIX", base))
    g.rows.append(row("FIX", ground))
    return g.text()


CASES = [(size, seed, 1 + seed % 7) for size in (3, 2) for seed in range(20)]


@pytest.mark.parametrize("angle", [0.0, 2.0, 7.0, -15.0])
def test_a_start_some_turns_away(angle):
    """Euler parameters turn through with the angle, as on the path that the general evaluator follows to it."""
    text = random_tree(3, 3, 4).replace("TIMESTEP 0.5 5", "TIMESTEP 0.05 2")
    lines = [row(*line.split()[:3], angle, 1.0) if line.startswith("STARTDE") else line for line in text.split("\n")]
    deck = spacar.parse_deck("\n".join(lines), 1)
    general, compiled = (spacar.run(1, deck, compiled=flag, atol=1e-10, rtol=1e-10) for flag in (False, True))
    for name in ("x", "xd", "e", "sig"):
        want = general[name]
        np.testing.assert_allclose(compiled[name], want, atol=1e-8 * max(1.0, np.abs(want).max()), rtol=0, err_msg=name)


@pytest.mark.skipif(why_off() is not None, reason=str(why_off()))
def test_cases_side_by_side():
    """As each alone: rods, bodies, hinges of all kinds with other masses."""
    base = spacar.parse_deck(random_tree(3, 5, 4).replace("TIMESTEP 0.5 5", "TIMESTEP 0.1 2"), 1)
    settings = [setting("EM.*[mass per length]"), setting("ESTIFF.*[S1]")]
    decks = [change(base, settings, [1.0 + 0.1 * k, 2.0 - 0.5 * k]) for k in range(3)]
    options = {"rtol": 1e-9, "atol": 1e-9}
    for one, result in zip(decks, ensemble(decks, compiled=True, **options), strict=True):
        alone = spacar.run(1, one, **options)
        for name in ("x", "xd", "e", "sig"):
            want = alone[name]
            within = 1e-7 * max(1.0, np.abs(want).max())  # steps differ: some tolerances
            np.testing.assert_allclose(result[name], want, atol=within, rtol=0, err_msg=name)


@pytest.mark.parametrize("name", ["crank2", "fourbar", "crankfl", "trike2"])
def test_other_mechanisms_have_the_equations_of_all_elements(name):
    """Loops, flexible elements, wheels: positions are iterated, and there are dead points."""
    compiled = CompiledDynamics(spacar.frames(1, DATA / f"{name}.dat").mechanism)
    compiled._y[:] = compiled.start()
    assert not compiled.position_matrix().regular_everywhere()
    assert singularity_monitor(compiled, Report()) is not None
    at = 1e-6  # the start itself is known
    assert compiled.solver.rhs(compiled.state, at, *compiled._addresses, 1e-12) >= 1


# Outputs of rigid trees: stresses from the tips inwards, nodal forces and rates, all as on the general path, which
# solves the equations of all elements. Both know forces to the rounding of sums of some hundred terms, in
# accelerations of the condition of the mass matrix: 1e-9 of the largest value of each kind.
def tree(text: str) -> tuple[Dynamics, CompiledDynamics, np.ndarray]:
    return started(build(spacar.parse_deck(text, 1), 1))


@pytest.mark.parametrize(("size", "seed", "links"), CASES)
def test_frames_of_random_trees(size, seed, links):
    general, compiled, y = tree(random_tree(size, seed, links))
    rng = np.random.default_rng(seed)
    rigid = slice(0, compiled.numbering.e_class["input"].start)
    for k in range(3):
        t, state = 0.01 * k, y + 0.3 * k * rng.standard_normal(len(y))
        a, b = general.frame(t, state), compiled.frame(t, state)
        assert not b.e[rigid].any()  # the equations of all elements leave rounding there
        scale = max(1.0, *(np.abs(getattr(a, of)).max() for of in ("xdd", "fxtot")))
        for name in (*X_FIELDS, *E_FIELDS):
            want = getattr(a, name)
            size = max(scale, np.abs(want).max())
            np.testing.assert_allclose(getattr(b, name), want, atol=1e-9 * size, rtol=0, err_msg=name)
        compiled._y[:] = state
        assert compiled.solver.rhs(compiled.state, t + 1e-9, *compiled._addresses, 1e-14) == 0  # others iterate
        want = general.rhs(t + 1e-9, state, 1e-14)
        np.testing.assert_allclose(compiled._out, want, atol=1e-9 * max(1.0, np.abs(want).max()), rtol=0)


def test_forces_of_a_hanging_chain():
    """At rest every hinge carries the weight below it, N = m g (closed form); nothing moves."""
    n, mass, g = 5, 2.0, 9.81
    rows = []
    for k in range(n):
        rows.append(f"PLTOR {2 * k + 1} {2 * k + 1 if k else 100} {2 * k + 3}")
        rows.append(f"PLRBEAM {2 * k + 2} {2 * k + 2} {2 * k + 3} {2 * k + 4}")
    rows += [f"X {2 * k + 2} 0.0 {-float(k)}" for k in range(n + 1)]
    rows += ["FIX 100", "FIX 2", *(f"DYNE {2 * k + 1} 1" for k in range(n)), "END", "HALT"]
    rows += [f"XM {2 * k + 4} {mass}" for k in range(n)]
    rows += [f"GRAVITY 0.0 {-g}", "TIMESTEP 0.1 1", "END", "END", ""]
    _, compiled, y = tree("\n".join(rows))
    frame = compiled.frame(0.0, y)
    numbering = compiled.numbering
    for k in range(n):
        along = [abs(frame.sig[numbering.e_index(2 * k + 2, mode)]) for mode in (1, 2)]
        assert max(along) == pytest.approx((n - k) * mass * g, rel=1e-14)
        assert min(along) <= 1e-14 * n * mass * g
    assert np.abs(frame.xdd).max() <= 1e-13 * g
    np.testing.assert_allclose(frame.fxtot[numbering.x_index(2, 2)], n * mass * g, rtol=1e-14)


@pytest.mark.parametrize(("size", "seed", "links"), CASES[3::9])
def test_a_state_that_is_there_is_not_evaluated_again(size, seed, links):
    """The start is handed on: as derivative, frame and fork; other loads at the same state are seen."""
    _, compiled, y = tree(random_tree(size, seed, links))
    shown = compiled.fork()
    frames = [e.frame(0.0, y) for e in (compiled, shown)]
    rates = compiled.rhs(0.0, y)
    fresh = CompiledDynamics(compiled.model.mechanism)
    fresh.rhs(0.5, y)
    want, again = fresh.rhs(0.0, y), fresh.frame(0.0, y)
    size = max(1.0, np.abs(want).max())
    np.testing.assert_allclose(rates, want, atol=1e-12 * size, rtol=0)
    for frame in frames:
        for name in (*X_FIELDS, *E_FIELDS):
            value = getattr(again, name)
            np.testing.assert_allclose(
                getattr(frame, name), value, atol=1e-12 * max(size, np.abs(value).max()), rtol=0, err_msg=name
            )
    force = np.zeros(len(frames[0].x))
    force[compiled.numbering.x_class["calculable"]] = 1.0
    compiled.solver.push(np.zeros(len(frames[0].e)), force)
    np.testing.assert_allclose(compiled.frame(0.0, y).fx, frames[0].fx + force, atol=1e-13, rtol=1e-13)


@pytest.mark.parametrize(("size", "seed", "links"), CASES)
def test_the_bound_of_the_condition_holds_everywhere(size, seed, links):
    """Never above the reciprocal condition of the general path, which is an estimate from above within a factor of
    three; and of use: above the limit of a doubtful position, so that dead points are not looked for."""
    general, compiled, y = tree(random_tree(size, seed, links))
    bound = compiled.solver.rcond_everywhere()
    rng = np.random.default_rng(seed)
    for k in range(3):
        general.frame(0.0, y + k * rng.standard_normal(len(y)))
        assert bound <= general.position_matrix().rcond()
    assert bound > 1e-6
    assert compiled.position_matrix().regular_everywhere()
    assert singularity_monitor(compiled, Report()) is None


# Chains and trees of rigid links, whose accelerations C takes from the reduced form or from the saddle-point form.
@pytest.mark.parametrize(("n", "branches"), [(3, 1), (12, 1), (12, 2), (45, 1)])
def test_links_in_both_forms(n, branches):
    """Accelerations, stresses and the reduced mass matrix are those of the general path."""
    general, compiled, y = tree(models.spatial_pendulum(n, 1.0, 10, branches))
    compiled._in_general = None
    y += 0.05 * np.random.default_rng(n).standard_normal(len(y))
    for k in range(1, 3):
        a, b = general.frame(0.01 * k, k * y), compiled.frame(0.01 * k, k * y)
        for name in ("x", "xd", "xdd", "sig"):
            want, got = getattr(a, name), getattr(b, name)
            np.testing.assert_allclose(got, want, atol=1e-10 * max(1.0, np.abs(want).max()), rtol=0, err_msg=name)
    M = compiled.solver.reduced_mass()
    numpy_evaluator, rates = compiled.numpy_evaluator(), 2 * y[n:]
    numpy_evaluator.sweep.mass()
    energy = b.xd @ numpy_evaluator.sweep.mass_times(b.xd)  # kinetic energy, twice
    assert rates @ M[:, :, 0] @ rates == pytest.approx(energy, rel=1e-12)


SWING = """
{joint} X 1 0 0{z} X 4 1 0{z} FIX 1 FIX 2 DYNE 1 1 DRPINBOD 2 0.5 0{z} END HALT
ESTIFF 1 1. XM 4 1. STARTDE 1 1 0.1 0 TIMESTEP 1 4 ERROR 1e-9 1e-9 END END
"""
JOINTS = {
    "PLPINBOD": SWING.format(joint="PLTOR 1 2 3 PLPINBOD 2 1 3 4", z=""),
    "PLRBEAM": SWING.format(joint="PLTOR 1 2 3 PLRBEAM 2 1 3 4", z=""),
    "PINBODY": SWING.format(joint="HINGE 1 2 3 0 0 1 PINBODY 2 1 3 4", z=" 0"),
    "RBEAM": SWING.format(joint="HINGE 1 2 3 0 0 1 RBEAM 2 1 3 4", z=" 0"),
}


@pytest.mark.parametrize("body", JOINTS)
@pytest.mark.parametrize("compiled", [True, False])
def test_arm_of_drpinbod(body, compiled):
    """1 kg at 0.5 m on a spring of 1 N m/rad: 0.1 cos 2t, though the reference has 1 m."""
    result = spacar.run(1, spacar.parse_deck(JOINTS[body]), compiled=compiled)
    np.testing.assert_allclose(result.element(1, 1), 0.1 * np.cos(2.0 * result.t), atol=1e-8)
