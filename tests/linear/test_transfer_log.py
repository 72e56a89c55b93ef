"""Third order transfer functions against differences of the second order ones, and what the log gets."""

import numpy as np
import pytest

from spacar import run
from spacar.deck import parse_deck
from spacar.kinematics.transfer import configuration_transfer, second_order_transfer, third_order_transfer

from .linear_models import PLANAR, SPATIAL, mechanism
from .nonlinear import Nonlinear, jacobian, random_state


@pytest.mark.parametrize("text", [PLANAR, SPATIAL], ids=["planar", "spatial"])
def test_third_order_transfer(text):
    m = mechanism(text)
    base = random_state(m, 0.05, seed=1)
    model = Nonlinear(m, base)

    def second(s: np.ndarray) -> np.ndarray:
        model.place(type(base)(s, 0 * base.qd, 0 * base.qdd))
        k = model.d.kinematics
        return np.concatenate([A.ravel() for A in second_order_transfer(k, configuration_transfer(k))])

    truth = jacobian(second, base.s)
    model.place(base)
    k = model.d.kinematics
    G = configuration_transfer(k)
    ours = np.concatenate(
        [A.reshape(-1, G.shape[1]) for A in third_order_transfer(k, G, second_order_transfer(k, G)[0])]
    )
    # differences of order 8 of numbers of size 10 to 1000: 1e-8 relative is far above their rounding
    assert np.max(np.abs(ours - truth)) <= 1e-8 * np.max(np.abs(truth))


@pytest.mark.parametrize("mode", [4, 7, 8, 9])
def test_log_levels(mode):
    text = PLANAR.format(extra="", third="").replace("DYNE 1 2 3 ", "DYNE 1 2 3   OUTLEVEL 15 0 ", 1)
    if mode != 4:
        text = text.replace("1.6 0.3 0.2", "1.6").replace("0.1 0.2 0.3", "0.1")
    frame = run(mode, parse_deck(text, mode=mode)).frames[0]
    assert set(frame.log) == {"dx", "de", "d2x", "d2e", "d3x", "d3e", "bigd"}
    assert frame.dx is None  # not asked for in the result file
    n = frame.log["dx"].shape[1]
    assert frame.log["d2x"].shape[1] == n**2
    assert frame.log["d3e"].shape == (len(frame.e), n**3)
