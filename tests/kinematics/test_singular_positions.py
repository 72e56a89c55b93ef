"""Dead centres, parallelograms, collapsed elements: pass through, or stop with a message that says where and why."""

import re
import warnings

import numpy as np
import pytest

import spacar
from spacar import Deck
from spacar.compiled.library import why_off
from spacar.errors import AnalysisError
from spacar.result import Result

PARALLELOGRAM = [
    ("PLRBEAM", 1, 1, 2, 3), ("PLRBEAM", 2, 4, 5, 6), ("PLRBEAM", 3, 3, 7, 6),
    ("X", 3, 0.0, 1.0), ("X", 4, 2.0, 0.0), ("X", 6, 2.0, 1.0), ("FIX", 1), ("FIX", 4),
]  # fmt: skip
R, L = 0.15, 0.35
START = float(np.sqrt(L**2 - R**2))  # slider with the crank upright
SLIDER = [
    ("PLRBEAM", 1, 1, 2, 3), ("PLRBEAM", 2, 3, 4, 5), ("X", 3, 0.0, R), ("X", 5, START, 0.0), ("FIX", 1), ("FIX", 5, 2),
]  # fmt: skip


def failure(rows: list[tuple], dynamics: list[tuple], mode: int = 1) -> tuple[AnalysisError, int]:
    """The error and the number of frames before it; NumPy must not warn."""
    count = 0
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            for _ in spacar.frames(mode, Deck.build(rows, dynamics)):
                count += 1
        except AnalysisError as error:
            assert "\n" not in str(error)  # noqa: PT017
            return error, count
    raise AssertionError("no failure")


def time_of(error: AnalysisError) -> float:
    found = re.search(r"t = ([0-9.]*[0-9])", str(error))
    assert found
    return float(found[1])


def test_a_driven_parallelogram_passes_its_dead_points() -> None:
    """Output times straddle the dead points: the cranks stay parallel over three turns."""
    dynamics = [("INPUTX", 2, 1, 0.0, 1.0, 0.0), ("TIMESTEP", 20.0, 200)]
    r = spacar.run(1, Deck.build([*PARALLELOGRAM, ("INPUTX", 2)], dynamics))
    np.testing.assert_allclose(r.node(5, 1), r.node(2, 1), atol=1e-9)
    np.testing.assert_allclose(r.node(7, 1), 0.0, atol=1e-9)


def test_a_free_parallelogram_passes_its_dead_points_with_a_warning() -> None:
    """Masses on both cranks: it turns with constant rate; the passage is reported because accuracy may suffer."""
    dynamics = [("XM", 2, 1.0), ("XM", 5, 1.0), ("STARTDX", 2, 1, 0.0, 1.0), ("TIMESTEP", 2.0, 20)]
    r = spacar.run(1, Deck.build([*PARALLELOGRAM, ("DYNX", 2)], dynamics))
    np.testing.assert_allclose(r.node(2, 1), r.t, atol=1e-6)
    np.testing.assert_allclose(r.node(5, 1), r.node(2, 1), atol=1e-6)
    (line,) = [line for line in r.report if "passed a singular position" in line]
    found = re.search(r"between t = (\S+) and (\S+) ", line)
    assert found
    assert float(found[1]) < np.pi / 2 < float(found[2])


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_a_slider_that_is_driven_past_its_dead_centre(size: float) -> None:
    """The crank cannot follow beyond x = R + L = 0.5, reached at t = 1.84, in a model of any size."""
    rows = [(*row[:2], *(size * c for c in row[2:])) if row[0] == "X" else row for row in SLIDER]
    drive = [("INPUTX", 5, 1, size * START, size * 0.1, 0.0), ("TIMESTEP", 3.0, 30)]
    error, frames = failure([*rows, ("INPUTX", 5, 1)], drive)
    assert error.code == "position.no-convergence"
    assert frames == 19  # up to t = 1.8
    for words in ("t = 1.9", "node 2 phi", "smallest singular value", "other degrees of freedom", "iterations"):
        assert words in str(error)
    found = re.search(r"scaled residual (\S+) \(history ([^)]*)\)", str(error))
    assert found, error
    assert found[2].split()[-1] == found[1]  # the printed residual is the last of the printed history


def around(said: str, moment: float, margin: float) -> bool:
    """Whether the times of a sentence are that moment, or lie on both sides of it."""
    times = [float(word) for word in re.findall(r"(?:t =|and) ([0-9.]+[0-9])", said)]
    return min(times) - margin <= moment <= max(times) + margin


@pytest.mark.parametrize("tolerances", [(1e-4, 1e-8), pytest.param((1e-6, 1e-10, 1e-12), marks=pytest.mark.slow)])
def test_a_free_slider_at_its_dead_centre_stops_or_warns(tolerances: tuple[float, ...]) -> None:
    """The slider is no coordinate at the dead centre, t = 2.2924 from the energy integral: never silently."""
    dynamics = [("XM", 5, 1.0), ("XM", 2, 0.1), ("STARTDX", 5, 1, START, 0.1), ("TIMESTEP", 3.0, 30)]
    rows = [*SLIDER, ("DYNX", 5, 1)]
    for tolerance in tolerances:
        run = spacar.frames(1, Deck.build(rows, [*dynamics, ("ERROR", tolerance, tolerance)]))
        try:
            for _ in run:
                pass
        except AnalysisError as error:
            said = str(error)
        else:
            (said,) = [line for line in run.report.lines if "dead point" in line]
        assert "singular position" in said
        assert around(said, 2.2924, 0.025)


# A body on a hinge, described by one Euler parameter: lambda3 = sin t. (All three of a node may pass half a turn, in
# modes 1 and 4: extremes/test_motions.py; with one there is no fourth that could take its place.)
ONE_PARAMETER = [("HINGE", 1, 1, 2, 0.0, 0.0, 1.0), ("FIX", 1), ("RLSE", 1, 1), ("DYNX", 2, 4)]
SPIN = [("XM", 2, 1.0, 0.0, 0.0, 1.0, 0.0, 1.0), ("STARTDX", 2, 4, 0.0, 1.0)]


@pytest.mark.parametrize("mode", [1, 4])
@pytest.mark.parametrize("compiled", [True, False])
@pytest.mark.parametrize("steps", [32, 33, pytest.param(129, marks=pytest.mark.slow)])
def test_one_euler_parameter_as_coordinate_ends_at_half_a_turn(mode: int, compiled: bool, steps: int) -> None:
    """Fixed steps that end near t = pi/2, on either side of it or there: the motion stops, and the message says why."""
    deck = Deck.build(ONE_PARAMETER, [*SPIN, ("TIMESTEP", np.pi, steps), ("INTEGRAT", 140)], mode=mode)
    with pytest.raises(AnalysisError) as found:
        list(spacar.frames(mode, deck, compiled=compiled))
    assert found.value.code == "position.singular"
    for words in ("node 2", "180 degrees", "HINGE", "t = 1.5"):
        assert words in str(found.value)


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-9])
def test_one_euler_parameter_never_turns_back_in_silence(tolerance: float) -> None:
    """Free steps may lead past the dead point, as past any other: then the motion is the right one, with a warning."""
    run = spacar.frames(1, Deck.build(ONE_PARAMETER, [*SPIN, ("TIMESTEP", 4.0, 4), ("ERROR", tolerance, tolerance)]))
    stopped: AnalysisError | None = None
    try:
        frames = list(run)
    except AnalysisError as error:
        stopped = error
    if stopped is not None:
        assert stopped.code == "position.singular"
        for words in ("node 2", "180 degrees", "HINGE", "t = 1.5"):
            assert words in str(stopped)
    else:
        assert any("passed a singular position" in line and "t = 1.5" in line for line in run.report.lines)
        lambda0 = run.mechanism.numbering.x_index(2, 1)
        np.testing.assert_allclose([f.x[lambda0] for f in frames], np.cos([f.t for f in frames]), atol=1e-3)


def test_start_values_that_cannot_be_reached() -> None:
    error, frames = failure([*SLIDER, ("INPUTX", 5, 1)], [("INPUTX", 5, 1, 0.6, 0.1, 0.0), ("TIMESTEP", 3.0, 30)])
    assert error.code == "position.no-convergence"
    assert frames == 0
    assert "start values that can be reached" in str(error)


SHORTENED = {
    "PLTRUSS": ([("PLTRUSS", 1, 1, 2), ("X", 2, 1.0), ("FIX", 1), ("FIX", 2, 2)], 2),
    "TRUSS": ([("TRUSS", 1, 1, 2), ("X", 2, 1.0), ("FIX", 1), ("FIX", 2, 2, 3)], 2),
    "PLBEAM": ([("PLBEAM", 1, 1, 2, 3, 4), ("X", 3, 1.0), ("FIX", 1), ("FIX", 2)], 3),
    "BEAM": ([("BEAM", 1, 1, 2, 3, 4), ("X", 3, 1.0), ("FIX", 1), ("FIX", 2)], 3),
}


@pytest.mark.parametrize(("driven", "rows", "mass"), [
    pytest.param(driven, *SHORTENED[name], id=f"{driven}-{name}",
                 marks=[pytest.mark.slow] * (not driven and name in ("PLBEAM", "BEAM", "PLTRUSS")))
    for driven in (True, False) for name in SHORTENED
])  # fmt: skip
def test_an_element_that_is_shortened_to_nothing(rows: list[tuple], mass: int, driven: bool) -> None:
    """1 m with -0.5 m/s: gone at t = 2, prescribed or free."""
    if driven:
        more, dynamics = [("INPUTE", 1, 1)], [("INPUTE", 1, 1, 0.0, -0.5, 0.0)]
    else:
        more, dynamics = [("DYNE", 1, 1)], [("XM", mass, 1.0), ("STARTDE", 1, 1, 0.0, -0.5)]
    error, frames = failure([*rows, *more], [*dynamics, ("TIMESTEP", 4.0, 8)])
    assert error.code == "element.range"
    assert frames == 4
    for words in ("element 1", rows[0][0], "collapsed", "undeformed 1 m"):
        assert words in str(error)
    assert time_of(error) == pytest.approx(2.0, abs=1e-6)


def test_nodes_that_meet() -> None:
    """A spring without stiffness between a fixed node and a mass that flies through it."""
    rows = [("PLTRUSS", 1, 1, 2), ("X", 2, 1.0), ("FIX", 1), ("DYNX", 2), ("RLSE", 1)]
    dynamics = [("XM", 2, 1.0), ("STARTDX", 2, 1, 1.0, -0.5), ("TIMESTEP", 4.0, 8)]
    error, _ = failure(rows, dynamics)
    assert "element 1 (PLTRUSS)" in str(error)
    assert time_of(error) == pytest.approx(2.0, abs=1e-6)


@pytest.mark.parametrize("tolerance", [1e-3, 1e-4, pytest.param(1e-5, marks=pytest.mark.slow)])
def test_an_integration_that_is_reflected_at_a_dead_point_stops(tolerance: float) -> None:
    """A diagonal as degree of freedom is longest where two bars are in line, t = 0.7815; beyond, it gets shorter again.

    Both bars are in line with their neighbours at once there, so that the determinant has a double zero. With wide
    tolerances the integration jumped over the point and came back on the old branch, with a wrong energy, or passed
    it: the one is an error, the other a warning.
    """
    rows = [
        ("PLTRUSS", 1, 1, 2), ("PLTRUSS", 2, 2, 3), ("PLTRUSS", 3, 3, 4), ("PLTRUSS", 4, 1, 3),
        ("X", 2, 0.0, 1.0), ("X", 3, 1.0, 1.0), ("X", 4, 1.0, 0.0), ("FIX", 1), ("FIX", 4), ("DYNE", 4),
    ]  # fmt: skip
    dynamics = [
        ("XM", 2, 1.0), ("XM", 3, 2.0), ("EM", 3, 0.5), ("ESTIFF", 4, 1.0), ("STARTDE", 4, 1, 0.1, 1.0),
        ("GRAVITY", 0.3, -1.0), ("TIMESTEP", 1.0, 20), ("ERROR", tolerance, tolerance), ("INTEGRAT", 0),
    ]  # fmt: skip
    run = spacar.frames(1, Deck.build(rows, dynamics))
    try:
        for _ in run:
            pass
    except AnalysisError as error:
        said = str(error)
    else:
        (said,) = run.report.lines
    assert around(said, 0.7815, 0.01)
    assert "dead point" in said


# Dead points and bifurcations inside single steps: each run stops or says so, and where it passes it is right. The
# truth is the motion with the crank as degree of freedom, which has no dead points, or a uniform rotation.
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


HALF_TURNED = [
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
        text, r = said(Deck.build(HALF_TURNED, [*cranks, *more]), compiled)
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
