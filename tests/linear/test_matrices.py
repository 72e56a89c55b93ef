"""Matrices of theory-system.md (13) against differences of the non-linear residual at moving, loaded, flexible states.

1e-7 relative is the accuracy that the project demands; differences of order 8 reach about 1e-10.
"""

from dataclasses import replace

import numpy as np
import pytest

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


def test_mass(case):
    model, base, L = case
    truth = jacobian(lambda a: model.residual(replace(base, qdd=a)), base.qdd)
    assert close(L.m0, truth)
    assert close(L.m0, L.m0.T, 1e-13)


def test_damping(case):
    model, base, L = case
    truth = jacobian(lambda v: model.residual(replace(base, qd=v)), base.qd)
    assert close(L.c0 + L.d0, truth)
    assert close(L.d0, L.d0.T, 1e-13)


def test_stiffness(case):
    model, base, L = case
    truth = jacobian(lambda s: model.residual(replace(base, s=s)), base.s)
    assert close(L.k0 + L.n0 + L.g0, truth)


def test_kinematic_matrices(case):
    model, base, L = case
    assert close(L.ak0, jacobian(lambda v: model.kinematic_rates(replace(base, qd=v)), base.qd))
    assert close(L.bk0, jacobian(lambda s: model.kinematic_rates(replace(base, s=s)), base.s))
