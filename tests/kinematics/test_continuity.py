"""Dead points of random four-bar linkages and slider-cranks: right motions are not refused, wrong ones not silent.

Two masses turn the mechanism freely: with the crank as degree of freedom the motion has no dead points (crank-rockers
by Grashof's condition) and nothing may be said. With the follower as degree of freedom every half turn of the crank
passes one: the run says so or stops.
"""

import shutil

import numpy as np
import pytest

import spacar
from spacar.errors import AnalysisError

C = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
COMPILED = [pytest.param(False, marks=pytest.mark.slow), pytest.param(True, marks=C)]
SIZES = (1e-3, 1.0, 1e3)
TOLERANCES = (1e-3, 1e-5, 1e-6)


def four_bar(seed: int, size: float) -> tuple[list[tuple], np.ndarray]:
    """Crank 1-2-3, coupler 3-5-6, follower 4-7-6 with Grashof's condition; the bars' lengths."""
    rng = np.random.default_rng(seed)
    while True:
        a, b, c, d = lengths = rng.uniform([0.1, 0.5, 0.5, 0.7], [0.4, 1.2, 1.2, 1.3])
        if a == min(lengths) and a + max(lengths) < 0.9 * (lengths.sum() - a - max(lengths)) and d > a + 0.1:
            break
    angle = rng.uniform(0.3, 2.8)
    crank = a * np.array([np.cos(angle), np.sin(angle)])
    way = np.array([d, 0.0]) - crank
    r = float(np.hypot(*way))
    along = (r * r + b * b - c * c) / (2 * r)
    joint = crank + along * way / r + np.sqrt(b * b - along**2) * np.array([-way[1], way[0]]) / r
    rows = [
        ("PLRBEAM", 1, 1, 2, 3), ("PLRBEAM", 2, 3, 5, 6), ("PLRBEAM", 3, 4, 7, 6),
        ("X", 3, *(size * crank)), ("X", 4, size * d, 0.0), ("X", 6, *(size * joint)), ("FIX", 1), ("FIX", 4),
    ]  # fmt: skip
    return rows, lengths


def slider_crank(seed: int, size: float) -> list[tuple]:
    rng = np.random.default_rng(seed)
    r, l, angle = rng.uniform(0.1, 0.5), rng.uniform(0.7, 1.5), rng.uniform(0.5, 2.6)
    x, y = r * np.cos(angle), r * np.sin(angle)
    end = x + np.sqrt(l * l - y * y)
    return [
        ("PLRBEAM", 1, 1, 2, 3), ("PLRBEAM", 2, 3, 4, 5), ("X", 3, size * x, size * y), ("X", 5, size * end, 0.0),
        ("FIX", 1), ("FIX", 5, 2),
    ]  # fmt: skip


def run(rows: list[tuple], start: tuple, masses: list[tuple], tolerance: float, code: int, compiled: bool) -> list[str]:
    """What was said: lines about dead points, or the error."""
    dynamics = [*masses, start, ("TIMESTEP", 3.0, 15), ("ERROR", tolerance, tolerance), ("INTEGRAT", code, 0.1)]
    try:
        report = spacar.run(1, spacar.Deck.build(rows, dynamics), compiled=compiled).report
    except AnalysisError as error:
        return [str(error)]
    return [line for line in report if "not compiled" not in line]


@pytest.mark.parametrize("compiled", COMPILED)
@pytest.mark.parametrize("size", SIZES)
def test_motions_without_dead_points_are_not_refused(size: float, compiled: bool) -> None:
    for k, (tolerance, code) in enumerate((t, c) for t in TOLERANCES for c in (155, 853)):
        rows, _ = four_bar(k, size)
        masses = [("XM", 2, 1.0 * size**2), ("XM", 6, 0.2)]
        assert run([*rows, ("DYNX", 2)], ("STARTDX", 2, 1, 0.0, 3.0), masses, tolerance, code, compiled) == []
        rows = slider_crank(k, size)
        masses = [("XM", 2, 1.0 * size**2), ("XM", 5, 0.2)]
        assert run([*rows, ("DYNX", 2)], ("STARTDX", 2, 1, 0.0, 3.0), masses, tolerance, code, compiled) == []


@pytest.mark.slow
@pytest.mark.parametrize("compiled", COMPILED)
@pytest.mark.parametrize("size", SIZES)
def test_dead_points_are_never_passed_silently(size: float, compiled: bool) -> None:
    """The follower or the slider is no coordinate beyond its dead points, which the crank passes in 3 s."""
    for k, tolerance in enumerate((1e-2, 1e-3)):
        rows, _ = four_bar(k, size)
        masses = [("XM", 2, 1.0 * size**2), ("XM", 6, 0.2)]
        said = run([*rows, ("DYNX", 7)], ("STARTDX", 7, 1, 0.0, 1.0), masses, tolerance, 155, compiled)
        assert said
        rows = slider_crank(k, size)
        start = next(row[2] for row in rows if row[:2] == ("X", 5))
        masses = [("XM", 2, 1.0 * size**2), ("XM", 5, 0.2)]
        said = run([*rows, ("DYNX", 5, 1)], ("STARTDX", 5, 1, start, -size), masses, tolerance, 155, compiled)
        assert said


@pytest.mark.parametrize("compiled", COMPILED)
@pytest.mark.parametrize("tolerance", TOLERANCES)
def test_a_pendulum_that_turns_before_its_dead_point_is_not_refused(tolerance: float, compiled: bool) -> None:
    """The slider of a crank that swings between 0.02 rad and its mirror image before pi: it comes near its dead
    centres, where the determinant falls by a factor of 50, turns, and goes back on its branch."""
    r, l = 0.2, 0.5
    angle = 0.02
    x, y = r * np.cos(angle), r * np.sin(angle)
    end = x + np.sqrt(l * l - y * y)
    rows = [
        ("PLRBEAM", 1, 1, 2, 3), ("PLRBEAM", 2, 3, 4, 5), ("X", 3, x, y), ("X", 5, end, 0.0), ("FIX", 1),
        ("FIX", 5, 2), ("DYNX", 5, 1),
    ]  # fmt: skip
    # at rest under gravity along y: the crank swings down between angle and pi - angle, through dead points only beyond
    dynamics = [
        ("XM", 3, 1.0), ("GRAVITY", 0.0, 9.81), ("STARTDX", 5, 1, end, 0.0), ("TIMESTEP", 3.0, 60),
        ("ERROR", 1e-2 * tolerance, tolerance),
    ]  # fmt: skip
    result = spacar.run(1, spacar.Deck.build(rows, dynamics), compiled=compiled)
    assert [line for line in result.report if "not compiled" not in line] == []
    assert result.node(3, 2).min() > 0.0
