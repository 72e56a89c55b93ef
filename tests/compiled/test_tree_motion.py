"""Rigid trees: C evaluates them without equations for the positions; all must be as on the general path.

Both know a position to 1e-11 of the sizes in it and accelerations to the rounding of sums of some hundred terms: 1e-9
of the largest value of each kind.
"""

import numpy as np
import pytest

import spacar
from spacar.compiled import CompiledDynamics
from spacar.compiled.library import unavailable, why_off
from spacar.deck import parse_deck
from spacar.studies.assignments import change, setting
from tests.ensembles import ensemble
from tests.examples import DATA

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

    def text(self) -> str:
        if self.chance(0.5):
            self.rows.append("ADEFORM")
        gravity = row("GRAVITY", *self.vector(2 if self.rows[0].startswith("PL") else 3))
        return "\n".join([*self.rows, "END", "HALT", *self.dynamics, gravity, "TIMESTEP 0.5 5", "END", "END", ""])


def spatial(seed: int, links: int) -> str:
    g = Grower(seed)
    base, ground = g.node(), g.node()
    place = {base: g.vector(3)}
    ends = [(base, ground)]
    for link in range(links):
        at, carrier = ends[g.rng.integers(len(ends))]
        orientation = g.hinge("HINGE", carrier, g.vector(3), link == 0)
        tip, k = g.node(), g.element()
        place[tip] = [a + b for a, b in zip(place[at], g.vector(3), strict=True)]
        if g.chance(0.5):
            far = g.node()
            nodes = (at, orientation, tip, far) if g.chance(0.5) else (tip, far, at, orientation)
            g.rows.append(row("BEAM", k, *nodes, *g.vector(3)))
            orientation = far if g.chance(0.5) else orientation
        else:
            g.rows.append(row("RBEAM", k, at, orientation, tip))
        g.dynamics.append(row("EM", k, g.number(), *([0.02, 0.01, 0.015, 0.001] if g.chance(0.5) else [])))
        ends.append((tip, orientation))
        for chance, words in (
            (0.4, ["XM", tip, g.number()]), (0.3, ["XF", tip, *g.vector(3)]), (0.2, ["XF", orientation, *g.vector(4)]),
            (0.3, ["XM", orientation, 0.1, 0.01, 0.0, 0.2, 0.02, 0.15]), (0.2, ["XF", orientation, *g.vector(3)]),
        ):  # fmt: skip
            if g.chance(chance) and not any(line.startswith(row(*words[:2]) + " ") for line in g.dynamics):
                g.dynamics.append(row(*words))
    g.rows += [row("X", n, *where) for n, where in place.items()]
    if g.chance(0.3):
        g.rows += [row("INPUTX", base, 2), row("FIX", base, 1, 3)]
        g.dynamics.append(row("INPUTX", base, 2, place[base][1], 0.4, -0.7))
    else:
        g.rows.append(row("FIX", base))
    g.rows.append(row("FIX", ground))
    return g.text()


def planar(seed: int, links: int) -> str:
    g = Grower(seed)
    base, ground = g.node(), g.node()
    place = {base: g.vector(2)}
    ends = [(base, ground)]
    moving = g.chance(0.5)  # the base: a slide with a prescribed or a free direction
    for link in range(links):
        at, carrier = ends[g.rng.integers(len(ends))]
        if g.chance(0.5):
            orientation = g.hinge("PLTOR", carrier, [], link == 0)
        else:
            orientation = g.node()
            prescribed = link > 0 and g.chance(0.4)
            g.rows.append(row("INPUTX" if prescribed else "DYNX", orientation, 1))
            motion = "INPUTX" if prescribed else "STARTDX"
            g.dynamics.append(row(motion, orientation, 1, *g.vector(3 if prescribed else 2)))
        tip, k = g.node(), g.element()
        place[tip] = [a + b for a, b in zip(place[at], g.vector(2), strict=True)]
        if g.chance(0.5):
            far = g.node()
            nodes = (at, orientation, tip, far) if g.chance(0.5) else (tip, far, at, orientation)
            g.rows.append(row("PLBEAM", k, *nodes))
            orientation = far if g.chance(0.5) else orientation
        else:
            g.rows.append(row("PLRBEAM", k, at, orientation, tip))
        g.dynamics.append(row("EM", k, g.number(), *([0.02] if g.chance(0.5) else [])))
        ends.append((tip, orientation))
        for chance, words in (
            (0.4, ["XM", tip, g.number()]), (0.3, ["XM", orientation, g.number()]), (0.3, ["XF", tip, *g.vector(2)]),
            (0.3, ["XF", orientation, *g.vector(1)]),
        ):  # fmt: skip
            if g.chance(chance) and not any(line.startswith(row(*words[:2]) + " ") for line in g.dynamics):
                g.dynamics.append(row(*words))
    g.rows.sort(key=lambda line: not line.startswith("PL"))  # elements first
    g.rows += [row("X", n, *where) for n, where in place.items()]
    if moving:
        g.rows += [row("DYNX", base, 1), row("INPUTX", base, 2)]
        g.dynamics += [row("INPUTX", base, 2, place[base][1], 0.4, -0.7), row("XM", base, 2.0)]
    else:
        g.rows.append(row("FIX", base))
    g.rows.append(row("FIX", ground))
    return g.text()


CASES = [(grow, seed, 1 + seed % 7) for grow in (spatial, planar) for seed in range(20)]


@pytest.mark.parametrize("angle", [0.0, 2.0, 7.0, -15.0])
def test_a_start_some_turns_away(angle):
    """Euler parameters turn through with the angle, as on the path that the general evaluator follows to it."""
    text = spatial(3, 4).replace("TIMESTEP 0.5 5", "TIMESTEP 0.05 2")
    lines = [row(*line.split()[:3], angle, 1.0) if line.startswith("STARTDE") else line for line in text.split("\n")]
    deck = parse_deck("\n".join(lines), 1)
    general, compiled = (spacar.run(1, deck, compiled=flag, atol=1e-10, rtol=1e-10) for flag in (False, True))
    for name in ("x", "xd", "e", "sig"):
        want = general[name]
        np.testing.assert_allclose(compiled[name], want, atol=1e-8 * max(1.0, np.abs(want).max()), rtol=0, err_msg=name)


@pytest.mark.skipif(why_off() is not None, reason=str(why_off()))
def test_cases_side_by_side():
    """As each alone: rods, bodies, hinges of all kinds with other masses."""
    base = parse_deck(spatial(5, 4).replace("TIMESTEP 0.5 5", "TIMESTEP 0.1 2"), 1)
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
    """Loops, flexible elements, wheels: positions are iterated."""
    compiled = CompiledDynamics(spacar.frames(1, DATA / f"{name}.dat").mechanism)
    compiled._y[:] = compiled.start()
    at = 1e-6  # the start itself is known
    assert compiled.solver.rhs(compiled.state, at, *compiled._addresses, 1e-12) >= 1
