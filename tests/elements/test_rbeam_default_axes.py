"""RBEAM without a direction has the default axes of a BEAM; start values with DRPINBOD count from its projections."""

import numpy as np
import pytest

import spacar
from spacar.mechanism import build

RIGID = "RBEAM 1 1 2 3{direction}\nX 3 1 2 2\nFIX 1\nFIX 2\nDYNE 1 {mode}\n{more}END HALT\nXM 3 1\nXM 2 1 0 0 1 0 1\n"
BEAM = "BEAM 1 1 2 3 4\nX 3 1 2 2\nFIX 1\nFIX 2\nDYNE 1\nEND HALT\nXM 3 1\nXM 4 1 0 0 1 0 1\nESTIFF 1 1 1 1 1\n"
END = "TIMESTEP 1e-3 1\nEND END\n"


def place(mode: int, value: float, direction: str = "", more: str = "") -> np.ndarray:
    text = RIGID.format(direction=direction, mode=mode, more=more) + f"STARTDE 1 {mode} {value}\n" + END
    result = spacar.run(1, spacar.parse_deck(text, mode=1))
    return np.array([result.node(3, c)[0] for c in (1, 2, 3)])


def test_the_first_direction_is_the_line_pq() -> None:
    assert place(1, 0.3) == pytest.approx([1.1, 2.2, 2.2], abs=1e-12)


@pytest.mark.parametrize("mode", [2, 3])
def test_the_other_directions_are_those_of_a_beam(mode: int) -> None:
    """The frame of a BEAM between the same nodes: rows x', y', z'."""
    beam = build(spacar.parse_deck(BEAM + "END END\n", mode=1)).batches[0].family
    axes = beam.frame_p[0].reshape(3, 3)
    expected = np.array([1.0, 2.0, 2.0]) + 0.1 * axes[mode - 1]
    assert place(mode, 0.1) == pytest.approx(expected, abs=1e-12)


def test_the_default_direction_may_be_written_out() -> None:
    """The basis vector at the largest angle with pq = (1, 2, 2)/3 is x."""
    assert place(3, 0.1) == pytest.approx(place(3, 0.1, " 1 0 0"), abs=1e-14)


def test_start_values_count_from_the_projections_of_drpinbod() -> None:
    """r = 2.7 along pq: STARTDE 0.3 puts node q at the distance 3.0, without STARTDE it starts at 2.7."""
    u = np.array([1.0, 2.0, 2.0]) / 3.0
    assert place(1, 0.3, more="DRPINBOD 1 2.7 0 0\n") == pytest.approx(3.0 * u, abs=1e-12)
    assert place(1, 0.0, more="DRPINBOD 1 2.7 0 0\n") == pytest.approx(2.7 * u, abs=1e-12)
