"""Matrices of theory-system.md (13) against differences of the non-linear residual at moving, loaded, flexible states.

1e-7 relative is the accuracy that the project demands; differences of order 8 reach about 1e-10.
"""

from dataclasses import replace

import numpy as np
import pytest

from spacar import run
from spacar.deck import parse_deck
from spacar.kinematics.transfer import configuration_transfer, second_order_transfer, third_order_transfer
from spacar.linearization import linearize

from .linear_models import PLANAR, SPATIAL, TRIKE_SPRING, TUBE, example, mechanism
from .nonlinear import Nonlinear, jacobian, random_state

MODELS = {
    "planar": lambda folder: (mechanism(PLANAR), 0.05),
    "planar with user function": lambda folder: (mechanism(PLANAR, extra="USERSIG forces", folder=folder), 0.05),
    "spatial": lambda folder: (mechanism(SPATIAL), 0.05),
    "planar tubes": lambda folder: (mechanism(TUBE), 0.05),
    "planar tricycle": lambda folder: (example("trike2", 4, TRIKE_SPRING), 0.1),
    "spatial tricycle": lambda folder: (example("trike3v", 4), 0.02),
    "finger": lambda folder: (example("finger", 4), 0.05),
    "spatial crank": lambda folder: (example("lateral4", 4), 0.05),
}


def close(value: np.ndarray, truth: np.ndarray, tolerance: float = 1e-7) -> bool:
    size = np.max(np.abs(truth), initial=0.0)
    return bool(np.max(np.abs(value - truth), initial=0.0) <= tolerance * max(size, 1e-3))


@pytest.fixture(params=MODELS, scope="module")
def case(request, tmp_path_factory):
    m, size = MODELS[request.param](tmp_path_factory.mktemp("model"))
    base = random_state(m, size, seed=3)
    model = Nonlinear(m, base)
    model.place(base)
    xdd = model.accelerations(base)
    sigma, _ = model.d.constitutive(0.0)
    return model, base, linearize(model.d, xdd, sigma)


def test_matrices(case):
    model, base, L = case
    assert close(L.m0, jacobian(lambda a: model.residual(replace(base, qdd=a)), base.qdd))
    assert close(L.m0, L.m0.T, 1e-13)
    assert close(L.c0 + L.d0, jacobian(lambda v: model.residual(replace(base, qd=v)), base.qd))
    assert close(L.d0, L.d0.T, 1e-13)
    assert close(L.k0 + L.n0 + L.g0, jacobian(lambda s: model.residual(replace(base, s=s)), base.s))
    assert close(L.ak0, jacobian(lambda v: model.kinematic_rates(replace(base, qd=v)), base.qd))
    assert close(L.bk0, jacobian(lambda s: model.kinematic_rates(replace(base, s=s)), base.s))


# Third order transfer functions against differences of the second order ones, and what the log gets.
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
