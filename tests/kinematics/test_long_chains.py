"""A long chain is badly conditioned, but no singular position."""

import numpy as np
import pytest

import spacar


@pytest.mark.parametrize("n", [100, 5000])
def test_rigid_row_of_beams_that_turns(n):
    """n rigid beams in a row of length 1, turned by 0.1 rad at their support."""
    lines = [f"PLBEAM {k} {2 * k - 1} {2 * k} {2 * k + 1} {2 * k + 2}" for k in range(1, n + 1)]
    lines += [f"X {2 * k + 1} {k / n!r} 0." for k in range(1, n + 1)]
    lines += ["FIX 1", "INPUTX 2 1", "END", "HALT", "INPUTX 2 1 0. 1.", "TIMESTEP 0.1 1", "END", "END", ""]
    result = spacar.run(1, spacar.parse_deck("\n".join(lines), mode=1))
    tip = [result.node(2 * n + 1, c)[-1] for c in (1, 2)]
    # condition 2 n^2, rounding eps in every beam
    assert tip == pytest.approx([np.cos(0.1), np.sin(0.1)], abs=2 * n**2 * np.finfo(float).eps)
