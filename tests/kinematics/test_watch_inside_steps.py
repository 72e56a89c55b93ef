"""Dead points and bifurcations inside single steps: each run stops or says so, and where it passes it is right.

The truth is the motion with the crank as degree of freedom, which has no dead points, or a uniform rotation.
"""

import numpy as np
import pytest

import spacar
from spacar import Deck
from spacar.compiled.library import why_off
from spacar.errors import AnalysisError
from spacar.result import Result

R, L = 0.15, 0.35
COMPILED = pytest.mark.skipif(why_off() is not None, reason="no engine")
ENGINES = [False, pytest.param(True, marks=COMPILED)]
SLOW = pytest.mark.slow
CODES = (0, 155, 853, 553, 595, 225)


def free_slider(angle: float, mass: float, tolerance: float, code: int, step: float, end: float) -> Deck:
    """A heavy crank turns with -1 rad/s from `angle` to the dead centre in line, with the slider as coordinate."""
    x, y = R * np.cos(angle), R * np.sin(angle)
    rod = np.sqrt(L**2 - y**2)
    rows = [
        ("PLRBEAM", 1, 1, 2, 3), ("PLRBEAM", 2, 3, 4, 5), ("X", 3, x, y), ("X", 5, x + rod, 0.0), ("FIX", 1),
        ("FIX", 5, 2), ("DYNX", 5, 1),
    ]  # fmt: skip
    dynamics = [
        ("XM", 2, 1.0), ("XM", 5, mass), ("STARTDX", 5, 1, x + rod, y * (1.0 + x / rod)), ("TIMESTEP", end, 1),
        ("ERROR", tolerance, tolerance), ("INTEGRAT", code, step),
    ]  # fmt: skip
    return Deck.build(rows, dynamics)


def said(deck: Deck, compiled: bool) -> tuple[str, Result | None]:
    """What a run says of dead points, its warning or its error; the result, if there is one."""
    try:
        result = spacar.run(1, deck, compiled=compiled)
    except AnalysisError as error:
        return str(error), None
    return " ".join(line for line in result.report if "dead point" in line), result


# the watch is one for both engines: in the fast tests the general one looks on with the codes that cost it least
@pytest.mark.parametrize(("code", "compiled"), [
    *(pytest.param(code, False, marks=[SLOW] * (code in (155, 595, 853))) for code in CODES),
    *(pytest.param(code, True, marks=COMPILED) for code in CODES),
])  # fmt: skip
def test_a_first_step_over_a_dead_point_is_looked_at(code: int, compiled: bool) -> None:
    """The start state is remembered, and a run that ends just behind the dead point says that it has passed."""
    for angle, ahead in ((0.1, 2.0), (0.1, 3.0)):
        deck = free_slider(angle, 1e-3, 1e-3, code, ahead * angle, ahead * angle)
        assert "dead point" in said(deck, compiled)[0], ahead


@pytest.mark.parametrize(("code", "compiled"), [
    pytest.param(code, engine, marks=COMPILED if engine else SLOW) for code in (155, 853) for engine in (True, False)
])  # fmt: skip
def test_a_dead_point_in_the_middle_of_a_step_is_looked_at(code: int, compiled: bool) -> None:
    """Loose tolerances and light sliders: steps of up to half a radian."""
    for angle in (0.3, 0.5):
        assert "dead point" in said(free_slider(angle, 1e-4, 1e-2, code, 0.5, angle + 0.6), compiled)[0]


PARALLELOGRAM = [
    ("PLRBEAM", 1, 1, 2, 3), ("PLRBEAM", 2, 4, 5, 6), ("PLRBEAM", 3, 3, 7, 6),
    ("X", 3, 0.0, 1.0), ("X", 4, 2.0, 0.0), ("X", 6, 2.0, 1.0), ("FIX", 1), ("FIX", 4), ("DYNX", 2),
]  # fmt: skip
ROD = 0.3
EQUAL = [
    ("PLRBEAM", 1, 1, 2, 3), ("PLRBEAM", 2, 3, 4, 5), ("X", 3, 0.5 * ROD, np.sqrt(0.75) * ROD), ("X", 5, ROD, 0.0),
    ("FIX", 1), ("FIX", 5, 2), ("DYNX", 2),
]  # fmt: skip


@pytest.mark.parametrize("compiled", ENGINES)
@pytest.mark.parametrize("code", [0, 853, pytest.param(155, marks=SLOW), pytest.param(553, marks=SLOW),
                                  pytest.param(595, marks=SLOW), pytest.param(225, marks=SLOW)])
def test_bifurcations_are_passed_on_the_right_branch(code: int, compiled: bool) -> None:
    """A parallelogram in line keeps its cranks parallel (uniform rotation: both masses on the cranks), and a slider
    whose rod is as long as the crank runs through the pivot: x = 2 l cos(phi), from the crank's energy
    (J + 4 l^2 m sin^2 phi) phi'^2 = constant.

    A step of 225 has the tolerance w sqrt(w) (head of `spacar.integrators.nystrom`), which with ERROR 1e-6 is 1e-12:
    accelerations beside the slider's bifurcation are not that exact, so that it depends on where a step ends whether
    the motion passes. With 1e-5 a step may err by 3e-11."""
    tight = 1e-5 if code == 225 else 1e-6
    for tolerance in (1e-3, 1e-7, 1e-11) if compiled and code == 0 else (1e-3, tight):
        more = [("TIMESTEP", 2.0, 2), ("ERROR", tolerance, tolerance), ("INTEGRAT", code)]
        cranks = [("XM", 2, 1.0), ("XM", 5, 1.0), ("STARTDX", 2, 1, 0.0, 1.0)]
        text, r = said(Deck.build(PARALLELOGRAM, [*cranks, *more]), compiled)
        assert r is not None
        assert "passed" in text
        np.testing.assert_allclose(r.node(5, 1), r.t, atol=1e-9)
        crank = [("XM", 2, 1.0), ("XM", 5, 0.1), ("STARTDX", 2, 1, 0.0, 1.0)]
        text, r = said(Deck.build(EQUAL, [*crank, *more]), compiled)
        assert r is not None
        assert "passed" in text
        angle, rate = np.pi / 3 + r.node(2, 1), r.node(2, 1, "xd")
        np.testing.assert_allclose(r.node(5, 1), 2.0 * ROD * np.cos(angle), atol=1e-9)
        energy = (1.0 + 0.4 * ROD**2 * np.sin(angle) ** 2) * rate**2
        np.testing.assert_allclose(energy, energy[0], rtol=max(tolerance, 1e-9))


@pytest.mark.parametrize("compiled", ENGINES)
def test_two_dead_points_with_a_wide_error_are_not_silent(compiled: bool) -> None:
    """With ERROR 0.1 of a stroke of 0.3 m all is nearer to a dead point than it is known: the first one was still being
    left when the second was passed, and the determinant had the sign of the begin again."""
    text, _ = said(free_slider(2.2, 0.01, 0.1, 853, 3.0, 5.7), compiled)
    assert "dead point" in text


@pytest.mark.parametrize("compiled", ENGINES)
@pytest.mark.parametrize(("code", "mass", "angle"), [(155, 0.01, 0.9), (135, 1e-4, 1.6)])
def test_an_error_as_wide_as_the_motion_is_not_silent(code: int, mass: float, angle: float, compiled: bool) -> None:
    """Steps of one radian went around the dead point on their way back, and small ones turned before it: ERROR is
    0.3, as the stroke of the slider."""
    text, _ = said(free_slider(angle, mass, 0.3, code, 0.1, angle + 0.6), compiled)
    assert "dead point" in text or "no convergence" in text
