"""Eigenvalues, multipliers and compliances of spatial beams in the angle measure in steady motion; the factor G."""

import numpy as np
import pytest

from spacar.deck import parse_deck
from spacar.elements.spatial.angle_measure import rotation_factor
from tests.linear import linear_models

from .difference_truth import agree


@pytest.mark.parametrize("c", [0.95, 0.81, 0.79, 0.3, -0.4, 1.02])
def test_the_factor_carries_a_complex_step_through_all_its_derivatives(c):
    """G^(k)(c + ih): the imaginary parts are h G^(k+1), of the third by a difference of the third (SERIES lies at 0.8).
    """
    step, h = 1e-50, 1e-5
    moved = rotation_factor(np.array([c + 1j * step]))[:, 0]
    real = rotation_factor(np.array([c]))[:, 0]
    np.testing.assert_allclose(moved.real, real, rtol=1e-15)
    np.testing.assert_allclose(moved.imag[:3] / step, real[1:], rtol=1e-13)
    third = [rotation_factor(np.array([c + k * h]))[3, 0] for k in (-2, -1, 1, 2)]
    fourth = (third[0] - 8 * third[1] + 8 * third[2] - third[3]) / (12 * h)
    assert moved.imag[3] / step == pytest.approx(fourth, rel=1e-7)


@pytest.mark.slow
def test_linearized_equations_in_steady_motion():
    """All matrices hold third derivatives of the deformations, whose complex step takes fourth ones."""
    text = linear_models.SPATIAL.format(extra="ITERSTEP 60 8 1e-10", third="").replace("FIX 1 ", "FIX 1   ADEFORM ")
    names = ["ESTIFF.1[GIt]", "ESTIFF.3[EIy]", "EM.1", "XM.7[4]", "EDAMP.3[4]", "X.6[2]", "XGYRO.7[2]",
             "INPUTX.8.1[start rate]", "INPUTE.5.1[start rate]", "GRAVITY[2]"]  # fmt: skip
    deck = parse_deck(text, mode=10)
    agree(deck, names, ["x[6,1]", "sig[1,2]"], rel=1e-6)
    agree(deck, names, ["frequency[1]", "frequency[4]", "real(eigval[2])", "xcompl[6,2]", "lmult[1]"], rel=1e-5)


@pytest.mark.slow
def test_multipliers_with_the_twist_gradient_in_steady_motion():
    """A deep cantilever on a turning hub: lateral buckling, in which the twist gradient is an unknown of its own."""
    lines = ["ADEFORM", "FIX 1", "FIX 2 3 4", "INPUTX 2 2"]
    for k in (1, 2):
        nodes = f"{2 * k - 1} {2 * k} {2 * k + 1} {2 * k + 2}"
        lines += [f"BEAM {k} {nodes} 0 1 0", f"DYNE {k}", f"X {2 * k + 1} {0.5 * k} 0 0"]
    lines += ["X 1 0 0 0", "END", "HALT", "INPUTX 2 2 0 0.4"]
    lines += [f"ESTIFF {k} 1e4 1 40 1 0 0\nEM {k} 0.3 0.001 0.0005 0.0005" for k in (1, 2)]
    deck = parse_deck("\n".join([*lines, "XM 5 0.1", "XF 5 0 0 2", "END", "END"]), mode=10)
    names = ["ESTIFF.1[GIt]", "ESTIFF.2[EIz]", "XF.5[4]", "INPUTX.2.2[start rate]", "X.5[2]"]
    agree(deck, names, ["lmult[1]", "frequency[1]"], rel=1e-5)
