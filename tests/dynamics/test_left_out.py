"""What is left out of the evaluation (rigid bodies of many elements, elements that cannot move) against all evaluated.

The truth is the same model with everything evaluated: another set of equations with other unknowns. Differences are
rounding, of the equations at the start, and of the integration afterwards.
"""

import numpy as np
import pytest

import spacar
import spacar.errors
from spacar import stream
from spacar.frame import E_FIELDS, X_FIELDS
from spacar.mechanism import build
from spacar.mechanism.rigid_search import rigid_parts
from spacar.modes import find_mode

TRANSFER = ("dx", "dxc", "de", "dec", "xcompl")


class Growing:
    """Random models: bodies of rigid beams, each a tree, joined by hinges."""

    def __init__(self, seed: int, planar: bool) -> None:
        self.random = np.random.default_rng(seed)
        self.planar, self.d = planar, 2 if planar else 3
        self.kinematics: list[tuple] = []
        self.dynamics: list[tuple] = []
        self.place = {1: np.zeros(self.d)}
        self.kinematics += [("FIX", 1), ("FIX", 2)]
        self.turned = {2}
        self.element, self.node = 0, 2

    def new(self) -> int:
        self.node += 1
        return self.node

    def step(self, size: float = 0.2) -> np.ndarray:
        return self.random.uniform(-1, 1, self.d) * size

    def beam(self, p: int, o: int, q: int, oq: int) -> int:
        """With mass; axes across the beam."""
        self.element += 1
        d = self.place[q] - self.place[p]
        across = () if self.planar else tuple(np.cross(d, self.random.normal(size=3)))
        self.kinematics.append(("PLBEAM" if self.planar else "BEAM", self.element, p, o, q, oq, *across))
        rotary = () if self.planar else (0.02, 0.01, 0.01)
        self.dynamics.append(("EM", self.element, self.random.uniform(0.5, 2.0), *rotary))
        return self.element

    def body(self, p: int, o: int, n: int) -> list[tuple[int, int]]:
        """n beams from a node with orientation; the nodes (position, orientation)."""
        found = [(p, o)]
        for _ in range(n):
            a, b = found[self.random.integers(len(found))]
            c, d = self.new(), self.new()
            self.place[c] = self.place[a] + self.step()
            self.beam(a, b, c, d)
            found.append((c, d))
        return found

    def hinge(self, o: int) -> int:
        self.element += 1
        q = self.new()
        axis = () if self.planar else tuple(self.random.normal(size=3))
        self.kinematics += [("PLTOR" if self.planar else "HINGE", self.element, o, q, *axis), ("DYNE", self.element, 1)]
        self.dynamics += [("ESTIFF", self.element, 300.0), ("STARTDE", self.element, 1, 0.1, 2.0)]
        return q

    def flexible(self, p: int, o: int, q: int, oq: int, keyword: str = "DYNE") -> None:
        """keyword: of its deformations; RLSE closes a loop."""
        element = self.beam(p, o, q, oq)
        self.kinematics.append((keyword, element, *range(1, 4 if self.planar else 7)))
        stiffness = (2e4, 30.0) if self.planar else (2e4, 30.0, 25.0, 20.0)
        self.dynamics.append(("ESTIFF", element, *stiffness))

    def model(self, loop: bool = False) -> tuple[list[tuple], list[tuple]]:
        """Wall, two bodies behind hinges, a flexible beam; loads and masses inside; `loop`: a beam back to the wall."""
        wall = self.body(1, 2, 9)
        p, o = wall[-1]
        first = self.body(p, self.hinge(o), 8)
        p, o = first[-1]
        second = self.body(p, self.hinge(o), 7)
        p, o = second[-2]
        tip, turn = self.new(), self.new()
        self.place[tip] = self.place[p] + self.step(0.5)
        self.flexible(p, o, tip, turn)
        if loop:
            self.flexible(first[4][0], first[4][1], wall[3][0], wall[3][1], "RLSE")
        ends = self.new(), self.new()  # an element that cannot move, with a preload
        self.place[ends[0]] = self.step(2.0)
        self.kinematics += [("FIX", ends[0]), ("FIX", ends[1])]
        still = self.beam(1, 2, *ends)
        self.kinematics.append(("RLSE", still, *range(1, 4 if self.planar else 7)))
        self.dynamics.append(("ESIG", still, 3.0, 2.0, 1.0))
        inside, node = first[2], second[3]
        tensor = (0.3,) if self.planar else (0.5, 0.05, 0.02, 0.6, 0.03, 0.7)
        self.dynamics += [("XM", inside[0], 0.7), ("XM", first[3][1], *tensor), ("XM", node[1], *tensor)]
        self.dynamics += [("XF", node[0], *self.step(5.0)), ("XF", tip, *self.step(5.0))]
        self.dynamics.append(("GRAVITY", *self.step(10.0)))
        self.kinematics += [("X", k, *place) for k, place in self.place.items()]
        return self.kinematics, self.dynamics


def whole_and_left_out(monkeypatch, mode, rows, **options):
    """Results with everything evaluated, and as it is run."""
    kinematics, dynamics, *third = rows
    deck = spacar.Deck.build(kinematics, dynamics, *third, mode=mode)
    assert rigid_parts(build(deck, mode), find_mode(mode)) is not None
    found = spacar.run(mode, deck, **options)
    with monkeypatch.context() as m:
        m.setattr(stream, "rigid_parts", lambda *_: None)
        return spacar.run(mode, deck, **options), found


def check(a, b, names, within):
    for name in names:
        u, v = getattr(a, name), getattr(b, name)
        assert (u is None) == (v is None)
        if u is not None:
            scale = max(np.abs(u).max(initial=0.0), 1.0)
            assert np.allclose(v, u, rtol=0.0, atol=within * scale), (name, np.abs(u - v).max() / scale)


@pytest.mark.parametrize(("seed", "planar", "loop", "engine"), [
    *((seed, planar, loop, {}) for seed in (1, 2) for planar in (True, False) for loop in (False, True)),
    (3, True, False, {"compiled": False}),
])  # fmt: skip
def test_motion(monkeypatch, seed, planar, loop, engine):
    kinematics, dynamics = Growing(seed, planar).model(loop)
    rows = kinematics, [*dynamics, ("TIMESTEP", 2e-3, 2)]
    whole, found = whole_and_left_out(monkeypatch, 1, rows, **engine, rtol=1e-8, atol=1e-10)
    # the start: no step was made. Condition numbers of such chains are 1e3.
    check(whole.frames[0], found.frames[0], (*X_FIELDS, *E_FIELDS), 1e-10)
    check(whole.frames[-1], found.frames[-1], ("x", "xd", "e", "ed"), 1e-7)  # the error that was asked for
    assert whole.frames[-1].t == found.frames[-1].t


@pytest.mark.parametrize("planar", [True, False])
@pytest.mark.parametrize("mode", [7, 8, 9, 10])
def test_stationary_modes(monkeypatch, mode, planar):
    kinematics, dynamics = Growing(4, planar).model(loop=True)
    rows = [kinematics, [row for row in dynamics if row[0] != "STARTDE"]]
    if mode == 9:
        rows.append([("OUTX", 1, 3, 1), ("INPUTF", 1, 3, 2)])
    whole, found = whole_and_left_out(monkeypatch, mode, rows)
    a, b = whole.frames[-1], found.frames[-1]
    check(a, b, (*X_FIELDS, *E_FIELDS, *TRANSFER), 1e-9)
    assert a.matrices.keys() == b.matrices.keys()
    assert a.state_space.keys() == b.state_space.keys()
    for name in {"m0", "k0", "g0", "lmult"} & a.matrices.keys():
        u, v = a.matrices[name], b.matrices[name]
        assert np.allclose(v, u, rtol=1e-8, atol=1e-9 * np.abs(u).max())


@pytest.mark.parametrize(("mode", "seed", "planar"), [(1, 5, True), (2, 9, True), (2, 9, False)])
def test_prescribed_motion(monkeypatch, mode, seed, planar):
    """No dynamic degree of freedom: kinematics, reactions; in mode 2 the moments at the driven hinges as inputs."""
    kinematics, dynamics = Growing(seed, planar).model()
    moved = [("INPUTE", *row[1:]) if row[0] == "DYNE" else row for row in kinematics]
    hinges = [row[1] for row in kinematics if row[0] in ("PLTOR", "HINGE")]
    kept = [row for row in dynamics if row[0] not in ("STARTDE", "ESTIFF")]
    if mode == 1:
        rows = moved, [*kept, ("INPUTE", hinges[0], 1, 0.0, 1.0, 0.5), ("TIMESTEP", 0.2, 4)]
    else:
        third = [("TRAJECT", 1), *[("TRE", e, 0.3) for e in hinges], ("TRTIME", 0.5, 4)]
        third += [("NOMS", k, e, 1) for k, e in enumerate(hinges, 1)] + [("REFE", 1, hinges[0], 1)]
        rows = moved, kept, third
    whole, found = whole_and_left_out(monkeypatch, mode, rows)
    for a, b in zip(whole.frames, found.frames, strict=True):
        check(a, b, (*X_FIELDS, *E_FIELDS), 1e-9)
    for name in ("u0", "y0") if mode == 2 else ():
        assert np.allclose(whole[name], found[name], rtol=0.0, atol=1e-9 * max(1.0, np.abs(whole[name]).max()))


def test_only_what_rests_is_left_out_of_moving_equations(monkeypatch):
    """The parts n0 and g0 of the stiffness about a motion are those of the elements."""
    kinematics, dynamics = Growing(6, True).model()
    rows = kinematics, [*dynamics, ("TIMESTEP", 1e-3, 1)]
    whole, found = whole_and_left_out(monkeypatch, 4, rows, rtol=1e-8, atol=1e-10)
    a, b = whole.frames[0], found.frames[0]
    check(a, b, (*X_FIELDS, *E_FIELDS), 1e-10)
    for name in ("m0", "c0", "k0", "n0", "g0"):
        assert np.allclose(a.matrices[name], b.matrices[name], rtol=1e-9, atol=1e-9 * np.abs(a.matrices[name]).max())


def test_a_rod_of_many_beams_is_evaluated_as_one():
    kinematics, dynamics = Growing(7, False).model()
    deck = spacar.Deck.build(kinematics, dynamics, mode=7)
    mechanism = build(deck, 7)
    parts = rigid_parts(mechanism, find_mode(7))
    assert len(parts.body_of) == 9 + 8 + 7 + 1
    # loads and other elements at four points of a body and its orientations, and the centre of mass
    assert all(body.n_ties <= 5 for body in parts.moving)


def test_what_stays():
    """Nothing is left out of a small model, and where second derivatives of all coordinates are asked for."""
    kinematics, dynamics = Growing(8, True).model()
    mechanism = build(spacar.Deck.build(kinematics, dynamics, mode=7), 7, sbd_level=3)
    assert rigid_parts(mechanism, find_mode(7)) is None
    small = [("PLBEAM", 1, 1, 2, 3, 4), ("X", 3, 1.0, 0.0), ("FIX", 1), ("DYNX", 2, 1)]
    assert rigid_parts(build(spacar.Deck.build(small, [("EM", 1, 1.0)], mode=7), 7), find_mode(7)) is None


def test_a_rigid_torsion_spring_has_nothing_that_stands_in_for_it(monkeypatch):
    """Only torsion springs hold it, while a truss is tied to the chain at rest."""
    points, turns = range(1, 14), range(21, 34)
    rows = [("PLBEAM", k + 1, points[k], turns[k], points[k + 1], turns[k + 1]) for k in range(12)]
    rows += [("X", node, 0.1 * node, 0.0) for node in points] + [("FIX", 1), ("FIX", 21)]
    rows += [("PLTRUSS", 13, 13, 14), ("X", 14, 1.3, 0.5), ("FIX", 14, 1), ("DYNE", 13, 1)]
    rows += [("PLTOR", 14, 33, 41), ("DYNE", 14, 1), ("PLTOR", 15, 41, 42)]
    dynamics = [("XM", 14, 1.0), ("ESTIFF", 13, 50.0), ("ESTIFF", 14, 2.0), ("XM", 42, 0.1), ("XF", 14, 0.0, 3.0)]
    deck = spacar.Deck.build(rows, [*dynamics, ("STARTDE", 14, 1, 0.2, 0.0), ("TIMESTEP", 1.0, 4)], mode=1)
    assert rigid_parts(build(deck), find_mode(1)) is not None
    found = spacar.run(1, deck, rtol=1e-10, atol=1e-10)
    assert np.allclose(found.element(14, 1), 0.2 * np.cos(np.sqrt(2.0 / 0.1) * found.t), rtol=0.0, atol=1e-8)


def test_a_failure_is_told_of_the_whole(monkeypatch):
    """A hinge turns about the rod behind it, which has no inertia about its axis: the message names real nodes."""
    rows = [("HINGE", 1, 1, 2, 1.0, 0.0, 0.0), ("FIX", 1), ("FIX", 3), ("DYNE", 1, 1), ("X", 3, 0.0, 0.0, 0.0)]
    points, turns = [3, *range(10, 22)], [2, *range(30, 42)]
    for k in range(12):
        rows.append(("BEAM", 2 + k, points[k], turns[k], points[k + 1], turns[k + 1], 0.0, 1.0, 0.0))
        rows.append(("X", points[k + 1], 0.1 * (k + 1), 0.0, 0.0))
    deck = spacar.Deck.build(rows, [*[("EM", 2 + k, 1.0) for k in range(12)], ("TIMESTEP", 0.1, 2)], mode=1)
    assert rigid_parts(build(deck), find_mode(1)) is not None
    texts = []
    for everything in (False, True):
        if everything:
            monkeypatch.setattr(stream, "rigid_parts", lambda *_: None)
        with pytest.raises(spacar.errors.AnalysisError) as error:
            spacar.run(1, deck)
        texts.append(str(error.value))
    assert texts[0] == texts[1]
