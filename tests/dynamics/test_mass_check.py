"""Whether a mass matrix is singular does not depend on how well the degrees of freedom are chosen.

Truths: a free mass m obeys F = m a in whatever coordinates; a motion whose nodes carry no mass has no energy.
"""

import warnings

import models
import numpy as np
import pytest

import spacar
from spacar import Deck
from spacar.compiled import cases, compiled_evaluator
from spacar.compiled.library import why_off
from spacar.dynamics import array_evaluator
from spacar.errors import AnalysisError
from spacar.forward.accepted_steps import fail_at
from spacar.simulation import Diagram, Spasim, simulate
from tests.ensembles import ensemble
from tests.examples import DATA

STEP = ("TIMESTEP", 1e-3, 1)
ENGINES = pytest.mark.parametrize("compiled", [False, True])


def crossed(angle: float) -> list[tuple]:
    """Node 2 held by two trusses that cross at a small angle, their elongations the degrees of freedom."""
    return [
        ("PLTRUSS", 1, 1, 2), ("PLTRUSS", 2, 3, 2), ("X", 2, 1.0, 0.0),
        ("X", 3, 1.0 - np.cos(angle), np.sin(angle)), ("FIX", 1), ("FIX", 3), ("DYNE", 1), ("DYNE", 2),
    ]  # fmt: skip


def in_line(tilt: float, slope: float, beyond: float = 0.0) -> list[tuple]:
    """A slider-crank whose crank and rod are in line (but for the angle `beyond`); the elongation of truss 3 turns the
    crank, ever faster the smaller its slope to it."""
    u = np.array([np.cos(tilt), np.sin(tilt)])
    n = np.array([-u[1], u[0]])
    crank, slider = np.cos(beyond) * u + np.sin(beyond) * n, (np.cos(beyond) + 1.5) * u
    drive = crank + np.cos(slope) * u + np.sin(slope) * n
    return [
        ("PLTRUSS", 1, 1, 2), ("PLTRUSS", 2, 2, 3), ("PLTRUSS", 3, 2, 4), ("PLTRUSS", 4, 3, 5), ("X", 2, *crank),
        ("X", 3, *slider), ("X", 4, *drive), ("X", 5, *(slider + n)), ("FIX", 1), ("FIX", 4), ("FIX", 5),
        ("DYNE", 3),
    ]  # fmt: skip


def refused(rows: list[tuple], dynamics: list[tuple], compiled: bool) -> str:
    with pytest.raises(AnalysisError) as caught:
        spacar.run(1, Deck.build(rows, [*dynamics, STEP]), compiled=compiled)
    assert caught.value.code == "dynamics.singular-mass"
    return str(caught.value)


@ENGINES
@pytest.mark.parametrize("angle", [1.0, 1e-4, 1e-7, 1e-8, 1e-9])
def test_a_free_mass_is_not_refused_for_its_coordinates(angle: float, compiled: bool) -> None:
    """The smallest eigenvalue of the scaled mass matrix is angle^2/2: 1e-18 in the last case."""
    rows = crossed(angle)
    r = spacar.run(1, Deck.build(rows, [("XM", 2, 2.0), ("XF", 2, 1.0, 0.0), STEP]), compiled=compiled)
    np.testing.assert_allclose(r.node(2, 1, "xdd")[0], 0.5, rtol=1e-6)
    assert not [line for line in r.report if "inertia" in line]


@ENGINES
@pytest.mark.parametrize("angle", [1.0, 1e-4, 1e-8])
def test_a_node_without_mass_is_named_beside_badly_chosen_coordinates(angle: float, compiled: bool) -> None:
    rows = [*crossed(angle), ("PLTRUSS", 3, 2, 4), ("PLTRUSS", 4, 5, 4), ("X", 4, 1.7, 0.4), ("X", 5, 2.3, 1.9),
            ("FIX", 5), ("DYNE", 3)]  # fmt: skip
    text = refused(rows, [("XM", 2, 1.0)], compiled)
    assert "element 3 (PLTRUSS) e1 elongation" in text
    text = refused(rows, [("XM", 4, 1.0)], compiled)
    assert "element 1 (PLTRUSS) e1 elongation, element 2 (PLTRUSS) e1 elongation" in text


@ENGINES
@pytest.mark.parametrize("tilt", [0.0, 0.3, 0.7, 2.1])
def test_a_slider_at_its_dead_point_gives_the_crank_no_mass(tilt: float, compiled: bool) -> None:
    """Its velocity is zero; in a skew frame rounding gives it some 1e-16, whose square is no mass."""
    assert "element 3 (PLTRUSS) e1 elongation" in refused(in_line(tilt, 1.5), [("XM", 3, 1.0)], compiled)


@ENGINES
@pytest.mark.parametrize("slope", [1e-2, 1e-4, 1e-6])
@pytest.mark.parametrize("tilt", [0.0, 0.3, 0.7])
def test_a_dead_point_that_is_placed_badly_is_not_passed_over(tilt: float, slope: float, compiled: bool) -> None:
    """The position is known to eps/slope: what the slider seems to move there is refused, or said to be rounding."""
    try:
        r = spacar.run(1, Deck.build(in_line(tilt, slope), [("XM", 3, 1.0), STEP]), compiled=compiled)
        text = next(line for line in r.report if line.startswith("warning: the inertia on the motion of"))
    except AnalysisError as error:
        text = str(error)
    assert text.startswith(("warning", "singular mass matrix"))
    assert "element 3 (PLTRUSS) e1 elongation" in text


@ENGINES
@pytest.mark.parametrize("beyond", [1e-2, 1e-6, 1e-9])
def test_a_slider_near_its_dead_point_is_accelerated_right(beyond: float, compiled: bool) -> None:
    """A force on the slider, the only mass: F = m a, and the position gives eps/beyond of it."""
    rows = in_line(0.0, 1.5, beyond)
    r = spacar.run(1, Deck.build(rows, [("XM", 3, 2.0), ("XF", 3, 1e-9 * beyond**2), STEP]), compiled=compiled)
    assert r.node(3, 1, "xdd")[0] == pytest.approx(0.5e-9 * beyond**2, rel=1e-6)


@ENGINES
@pytest.mark.parametrize("mass", [1.0, 1e-10, 1e-13])
def test_a_light_crank_is_enough_at_the_dead_point(mass: float, compiled: bool) -> None:
    """The crank alone carries the motion: a = F/m of its node, along its path."""
    rows = in_line(0.0, 1.5)
    dynamics = [("XM", 2, mass), ("XM", 3, 1.0), ("XF", 2, 0.0, mass), STEP]
    r = spacar.run(1, Deck.build(rows, dynamics), compiled=compiled)
    assert r.node(2, 2, "xdd")[0] == pytest.approx(1.0, rel=1e-6)


LANES = pytest.mark.skipif(why_off() is not None, reason="no engine")


@LANES
def test_a_case_of_a_batch_at_its_dead_point_is_not_passed_over() -> None:
    """The only degree of freedom has nothing to be compared with but the masses; the first case is a regular one."""
    decks = [Deck.build(in_line(0.3, 1e-4, beyond), [("XM", 3, 1.0), STEP]) for beyond in (0.1, 0.0)]
    _, found = ensemble(decks)
    assert found is None or "inertia" in "".join(found.report)


@pytest.fixture
def rounding(monkeypatch: pytest.MonkeyPatch) -> str:
    """Every inertia is taken for rounding: whether one is depends on the processor."""
    monkeypatch.setattr(array_evaluator, "is_doubtful", lambda *found: True)
    for module in (compiled_evaluator, cases):
        monkeypatch.setattr(module, "is_checked", lambda n: False)  # C is not asked
    monkeypatch.setattr(array_evaluator, "require_regular_mass", lambda *found: "little inertia")
    return "little inertia"


@ENGINES
def test_simulations_say_what_is_rounding(rounding: str, compiled: bool) -> None:
    plant = Spasim(Deck.build(crossed(1.0), [("XM", 2, 1.0)], mode="simulation"))
    plant.choose(compiled)
    assert simulate(Diagram().add(plant), [0.0, 1e-3]).notes == (f"plant: {rounding}",)


@LANES
def test_batches_say_what_is_rounding(rounding: str) -> None:
    deck = Deck.build(crossed(1.0), [("XM", 2, 1.0), STEP])
    assert [found.report for found in ensemble([deck, deck]) if found] == [(f"warning: {rounding}",)] * 2


def beside_many(rows: list[tuple], n: int = 410) -> tuple[list[tuple], list[tuple]]:
    """The rows with numbers above those of a chain of n trusses with a mass at every joint."""
    heading = 0.3 + 0.02 * np.sin(np.arange(n))
    x, y = 0.1 * np.cumsum([np.cos(heading), np.sin(heading)], axis=1)
    chain: list[tuple] = [("FIX", 1)]
    for i in range(n):
        chain += [("PLTRUSS", i + 1, i + 1, i + 2), ("X", i + 2, x[i], y[i]), ("DYNX", i + 2, 1)]
    further = n + 10
    for row in rows:
        k = 4 if row[0] == "PLTRUSS" else 2
        chain.append((row[0], *(further + number for number in row[1:k]), *row[k:]))
    return chain, [("XM", i + 2, 1.0) for i in range(n)]


@ENGINES
@pytest.mark.parametrize("tilt", [0.3, 0.7])
def test_a_dead_point_in_a_large_model_is_not_passed_over(tilt: float, compiled: bool) -> None:
    """411 degrees of freedom: accelerations of 1e16 m/s^2 were given without a word."""
    rows, masses = beside_many(in_line(tilt, 1.5))
    slider = ("XM", 423, 1.0)
    assert "element 423 (PLTRUSS) e1 elongation" in refused(rows, [*masses, slider], compiled)
    held = [*masses, slider, ("XM", 422, 1e-12), ("XF", 422, 0.0, 1e-12)]
    r = spacar.run(1, Deck.build(rows, [*held, STEP]), compiled=compiled)
    assert not [line for line in r.report if "inertia" in line]
    across = np.array([-np.sin(tilt), np.cos(tilt)])  # the crank moves across itself only: a = F/m along that
    assert across @ [r.node(422, i, "xdd")[0] for i in (1, 2)] == pytest.approx(across[1], rel=1e-4)


def test_a_released_beam_in_parts_is_not_advised_to_be_released() -> None:
    """The printed spatial model without inertia of torsion: what the message asks for is enough."""
    text = (DATA / "screw.dat").read_text()
    with pytest.raises(AnalysisError, match=r"torsion; add mass .*J of EM") as found:
        spacar.run(1, spacar.parse_deck(text, "screw", 1), elements=2)
    assert "(RLSE)" not in str(found.value)
    with_inertia = spacar.parse_deck(text.replace("EM 3 1.0", "EM 3 1.0 1e-4"), "screw", 1)
    spacar.run(1, with_inertia, elements=2, duration=0.1, n_steps=1)


# A light body that carries a heavy one, in relative coordinates: the mass matrix is nearly singular, and right. Two
# bars in line, the degrees of freedom their elongations: M = [[m1 + m2, m2], [m2, m2]], with the smallest eigenvalue
# m1/(2 m2) when scaled. A force F on the light mass m1 gives it F/m1, the heavy one nothing.
SPRING = [("PLTRUSS", 1, 1, 2), ("X", 2, 1.0), ("FIX", 1), ("FIX", 2, 2), ("DYNE", 1)]
TWO_SPRINGS = [*SPRING, ("PLTRUSS", 2, 2, 3), ("X", 3, 2.0), ("FIX", 3, 2), ("DYNE", 2)]


@ENGINES
@pytest.mark.parametrize("ratio", [1.0, 1e4, 1e8, 1e12, 1e13])
def test_a_light_part_is_accelerated_right(ratio: float, compiled: bool) -> None:
    """To 1e-6: sums of M lose eps times the ratio in the reduced form, nothing in the saddle-point form."""
    dynamics = [("XM", 2, 1.0), ("XM", 3, ratio), ("XF", 2, 1.0), STEP]
    r = spacar.run(1, Deck.build(TWO_SPRINGS, dynamics), compiled=compiled)
    assert r.node(2, 1, "xdd")[0] == pytest.approx(1.0, rel=1e-6)
    assert abs(r.node(3, 1, "xdd")[0]) <= 1e-6


# States outside the theory of an element, missing mass: what the user gets to read.
def failure(deck: Deck, mode: int = 1) -> AnalysisError:
    """The error of a run, in one line and without a warning of NumPy."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(AnalysisError) as caught:
            spacar.run(mode, deck)
    assert "\n" not in str(caught.value)
    return caught.value


PLANAR = [("PLBEAM", 1, 1, 2, 3, 4), ("X", 3, 1.0), ("FIX", 1), ("FIX", 2), ("DYNE", 1, 2, 3)]
SPATIAL = [("BEAM", 1, 1, 2, 3, 4, 0.0, 1.0, 0.0), ("X", 3, 1.0), ("FIX", 1), ("FIX", 2), ("DYNE", 1, 2, 3, 4, 5, 6)]


@pytest.mark.parametrize(
    ("rows", "em", "stiffness", "force"),
    [
        (PLANAR, (1.0, 0.1), (0.0, 1.0), (2.0,)),  # twice the stiffness: the end turns beyond 85 degrees to the chord
        *((SPATIAL, (1.0, 0.1, 0.1, 0.1), (0.0, 1.0, 1.0, 1.0), moment)
          for moment in ((0.0, 0.0, 2.0), (0.0, 2.0, 0.0), (2.0, 0.0, 0.0))),
    ],
    ids=["planar", "bent about z", "bent about y", "twisted"],
)  # fmt: skip
def test_a_beam_bent_or_twisted_beyond_one_element(rows, em, stiffness, force) -> None:
    dynamics = [("EM", 1, *em), ("ESTIFF", 1, *stiffness), ("XF", 4, *force), ("TIMESTEP", 5.0, 200)]
    error = failure(Deck.build(rows, dynamics))
    for words in (f"element 1 ({rows[0][0]})", "t = ", "degrees", "use more elements"):
        assert words in str(error)


def test_a_warning_comes_first() -> None:
    """Between 60 and 85 degrees the run goes on and the report says so once."""
    dynamics = [("XM", 3, 1.0), ("XM", 4, 0.1), ("EM", 1, 0.1), ("ESTIFF", 1, 0.0, 1.0), ("STARTDE", 1, 2, 0.9, 0.0)]
    report = spacar.run(1, Deck.build(PLANAR, dynamics)).report
    assert len([x for x in report if "warning: element 1 (PLBEAM)" in x and "use more elements" in x]) == 1


def test_roll_up_with_too_few_elements_has_no_equilibrium() -> None:
    """Full circle with 4 elements: 90 degrees each, no equilibrium exists; the message asks for more elements."""
    circle = (f"XF 10 {2 * np.pi}", "ITERSTEP 20 10")
    text = models.cantilever(4, mass=0.0, EI=1.0, length=1.0, dynamics=circle)
    assert "element" in str(failure(spacar.parse_deck(text, mode=8), 8))


@pytest.mark.parametrize(
    ("rows", "mass", "mode", "words"),
    [
        (TWO_SPRINGS, ("XM", 2, 1.0), 1, ("element 2 (PLTRUSS) e1 elongation", "XM", "EM", "RLSE")),
        # One mass for two degrees of freedom: both have inertia, their difference has none.
        (TWO_SPRINGS, ("XM", 3, 1.0), 1, ("elongation",)),
        (TWO_SPRINGS, ("XM", 3, 1.0), 7, ("elongation",)),
        (SPRING, ("XM", 2, -1.0), 1, ()),
    ],
    ids=["no mass", "dependent masses", "dependent masses, frequencies", "negative"],
)
def test_singular_mass_names_the_motion(rows, mass, mode, words) -> None:
    error = failure(Deck.build(rows, [mass, ("TIMESTEP", 1.0, 10)]), mode)
    assert error.code == "dynamics.singular-mass"
    assert all(word in str(error) for word in words)
    assert mass[1] != 2 or mass[2] < 0 or "element 1 (PLTRUSS)" not in str(error)


def test_the_time_stands_once_whatever_the_words_of_the_cause() -> None:
    with pytest.raises(AnalysisError, match=r"^at t = 0.5: a plate of t = 3 mm$") as first:
        fail_at(0.5, AnalysisError("a plate of t = 3 mm", "element.range", element=1))
    with pytest.raises(AnalysisError, match=r"^at t = 0.5: a plate of t = 3 mm$") as second:
        fail_at(0.75, first.value)
    assert second.value.data == {"element": 1, "t": 0.5}


def test_a_spring_that_explodes() -> None:
    """Negative stiffness and damping: exponential growth until a limit of the element, never inf or nan in a frame."""
    dynamics = [("XM", 2, 1.0), ("ESTIFF", 1, -1e4), ("STARTDE", 1, 1, -0.01, 0.0), ("TIMESTEP", 50.0, 50)]
    error = failure(Deck.build(SPRING, dynamics))
    assert "element 1 (PLTRUSS)" in str(error)
    assert "collapsed" in str(error)
