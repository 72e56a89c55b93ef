"""A release that becomes singular during a motion: the message names it and another one, which runs."""

import re

import numpy as np
import pytest

import spacar
from spacar.deck import parse_deck
from spacar.errors import AnalysisError

JOINTS = ("0 1 0", "0 0 1", "1 0 0")
CUBE = ((0, 0, 0), (1, 0, 0), (1, -1, 0), (1, -1, 1), (0, -1, 1), (0, 0, 1))


def bricard(release: str, size: float, g: float) -> spacar.Result:
    """The orthogonal linkage on the edges of a cube, which moves though it has one equation too many."""
    lines = [f"HINGE {k} {k} {k + 1} {JOINTS[(k - 1) % 3]}" for k in range(1, 7)]
    lines += [f"RBEAM {k} {k} {k - 9} {k + 1}" for k in range(11, 16)]
    lines += [f"X {11 + k} {size * x} {size * y} {size * z}" for k, (x, y, z) in enumerate(CUBE)]
    lines += ["FIX 1", "FIX 7", "FIX 11", "FIX 16", "DYNE 1 1", *(f"RLSE {k} 1" for k in range(2, 7)), release]
    lines += ["END", "HALT", "TIMESTEP 3 30", *(f"EM {k} 1.0" for k in range(11, 16)), f"GRAVITY 0 {-g!r} 0"]
    return spacar.run(1, parse_deck("\n".join([*lines, "END", "END", ""]), mode=1))


@pytest.mark.parametrize(
    ("release", "size"), [("RLSE 11 1", 1.0), ("RLSE 11 1", 0.02), ("RLSE 12 3", 1.0)], ids=["stops", "small", "passes"]
)
def test_a_release_that_becomes_singular_is_named_with_another_that_runs(release: str, size: float) -> None:
    g = 9.81 * size
    try:
        told = "\n".join(bricard(release, size, g).report)
    except AnalysisError as stopped:
        told = str(stopped)
    text = r"the release (RLSE \d+ \d+) becomes singular here: give (RLSE \d+ \d+) in its place"
    found = re.search(text, told)
    assert found
    assert found[1] == release
    result = bricard(found[2], size, g)
    element, mode = map(int, found[2].split()[1:])
    assert np.abs(result.element(element, mode, "e")).max() < 1e-9 * size  # what is released does not move
    assert not result.report


def test_an_ordinary_dead_point_has_no_such_advice() -> None:
    text = """
PLRBEAM 1 1 2 3   PLRBEAM 2 3 4 5   X 1 0 0   X 3 1 0   X 5 2.5 0.1   FIX 1   FIX 5 2   DYNX 5 1
END HALT
XM 5 1   STARTDX 5 1 2.4 3.   TIMESTEP 2 20   END END
"""
    with pytest.raises(AnalysisError) as stopped:
        spacar.run(1, parse_deck(text, mode=1))
    assert "RLSE" not in str(stopped.value)
