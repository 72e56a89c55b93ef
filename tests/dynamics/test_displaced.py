"""The absolute error of deformations is that of the displacement they cause: it keeps its meaning on fine meshes."""

import models
import numpy as np
import pytest

import spacar
from spacar.deck import parse_deck
from spacar.dynamics.array_evaluator import Dynamics
from spacar.forward.displaced import displaced
from spacar.mechanism import build


def cantilever(n, unit=1.0, more="TIMESTEP 0.2 4"):
    """Released under its weight; 1 m, EI = 1 N m^2, 1 kg/m. `unit`: of length, in m."""
    dynamics = (f"GRAVITY 0. {-1.0 / unit!r}", more)
    return models.cantilever(n, mass=unit, EI=1.0 / unit**2, length=1.0 / unit, dynamics=dynamics)


@pytest.mark.parametrize("unit", [1.0, 1e-3])
@pytest.mark.parametrize("n", [1, 4, 16])
def test_the_displacement_that_a_deformation_causes(n, unit):
    """e_p of element i turns the rest of the straight beam by e_p/l: the tip moves by (L - x_p)/l; e_q likewise."""
    evaluator = Dynamics(build(parse_deck(cantilever(n, unit), mode=1)))
    evaluator.rhs(0.0, evaluator.start())
    g = displaced(evaluator)
    behind = np.array([[n - i, n - i - 1] for i in range(n)], float)
    if n == 1:
        assert g is None
    else:
        np.testing.assert_allclose(g, np.tile(np.maximum(behind, 1.0).ravel(), 2), rtol=1e-9)


def test_rotations_and_rigid_models_keep_their_unit():
    text = "PLRBEAM 1 1 2 3\nX 3 5. 0.\nFIX 1\nDYNX 2 1\nEND HALT\nEM 1 1.\nTIMESTEP 1. 1\nEND END\n"
    evaluator = Dynamics(build(parse_deck(text, mode=1)))
    evaluator.rhs(0.0, evaluator.start())
    assert displaced(evaluator) is None


@pytest.mark.parametrize("code", [553, 595])
def test_error_keeps_its_meaning_on_fine_meshes(code):
    """Error over ERROR of the coordinates with 2 and with 8 elements; the same unit for all made it grow 8 and 16
    times."""
    ratios = []
    for n in (2, 8):
        deck = parse_deck(cantilever(n), mode=1)
        exact = spacar.run(1, deck, integrator=853, rtol=1e-6, atol=1e-7)["x"]
        x = spacar.run(1, deck, integrator=code, rtol=1e-14, atol=1e-2)["x"]
        ratios.append(np.abs(x - exact).max() / 1e-2)
    assert ratios[1] < 4.5 * ratios[0]
    assert ratios[1] < 1.0
