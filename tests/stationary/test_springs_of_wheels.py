"""Wheels: released beams with stiffness bear load in the stationary solution (they had no stress)."""

import numpy as np
import pytest

from spacar import parse_deck, run

TEXT = """X 1 0.1 0.2 0.5   X 3 0.1 0.2 0.0   DYNX 2 2 3 4   KINX 1 1 2   TWHEEL 1 1 2 3 0.5 0.1 0.0 1.0 0.0
X 4 1.035 -0.452 -0.38   FIX 4   FIX 5   BEAM 2 4 5 1 2 0.015 1. 0.3   RLSE 2 1 2 3 4 5 6   END HALT
XM 1 5.014   XM 2 0.39 0. 0. 0.334 0. 0.316   ESTIFF 2 76.189 10.747 10.804 14.127   ESIG 2 0.3
XF 2 0.1 0.2 -0.1 0.05   GRAVITY 0.02 0.03 -1.0   ITERSTEP 60 2 1e-12 1 0   END END
"""


@pytest.mark.parametrize("compiled", [True, False])
def test_released_beams_have_the_stress_of_their_law(tmp_path, compiled):
    """sigma_1 = E A e_1 / l + preload, sigma_2 = G I_t e_2 / l^3: closed forms; the end's force is that of sigma_1."""
    path = tmp_path / "wheel.dat"
    path.write_text(TEXT)
    r = run(7, path, compiled=compiled)
    places = np.asarray(r["le"])[1] - 1
    e, sigma = r["e"][0][places], r["sig"][0][places]
    length = np.linalg.norm([0.935, -0.652, -0.88])
    assert sigma[0] == pytest.approx(76.189 * e[0] / length + 0.3, rel=1e-9)
    assert sigma[1] == pytest.approx(10.747 * e[1] / length**3, rel=1e-9)
    assert abs(sigma[0]) > 0.1


def test_a_linear_convergence_is_followed_to_its_end():
    """Slips let the iteration converge linearly: what is left is that of a geometric series, not of a square."""
    text = TEXT.replace("KINX 1 1 2", "KINX 1 1\nDYNX 1 2").replace("RLSE 2 1", "RLSE 1 6\nDYNE 1 1\nRLSE 2 1")
    text = text.replace("ESTIFF 2", "ESTIFF 1 60.4 73.9 62.1 75.7 65.3 86.3\nESTIFF 2")
    exact, ordinary = (run(7, parse_deck(text), tolerance=tolerance)["x"][-1] for tolerance in (1e-15, 1.0))
    assert np.abs(ordinary - exact).max() <= 2e-11 * 1.5  # of two runs; size of the model
