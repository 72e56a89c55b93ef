"""Singular and double cases are not refused: dead points, double critical loads, motions without stiffness."""

import numpy as np
import pytest
from models import pendulum

import spacar
from spacar.deck import parse_deck
from spacar.linear import form
from tests.stationary.test_kinds import PENDULUM


def run(text: str, mode: int) -> spacar.Result:
    return spacar.run(mode, parse_deck(text, mode=mode))


def square_column(n: int, factor: float) -> str:
    """Clamped column of n beams, EIy = EIz = 1, length 1, under `factor` times its double Euler load."""
    lines = [f"BEAM {k} {2 * k - 1} {2 * k} {2 * k + 1} {2 * k + 2} 0. 1. 0." for k in range(1, n + 1)]
    lines += [f"X {2 * k + 1} {k / n!r} 0. 0." for k in range(1, n + 1)]
    lines += ["FIX 1", "FIX 2", *(f"DYNE {k} 2 3 4 5 6" for k in range(1, n + 1)), "END", "HALT"]
    lines += [f"EM {k} 1. 0.01\nESTIFF {k} 1e4 1. 1. 1." for k in range(1, n + 1)]
    load = f"XF {2 * n + 1} {-factor * np.pi**2 / 4.0!r} 0. 0."
    return "\n".join([*lines, load, "ITERSTEP 20 4", "END", "END", ""])


def test_square_column_above_its_double_critical_load():
    """60 beams: both multipliers 1/1.2, and two unstable modes as fast as each other."""
    result = run(square_column(60, 1.2), 10)
    assert result["lmult"][0][:2] == pytest.approx(1 / 1.2, rel=1e-6)  # discretization, order 4
    unstable = np.sort(result["eigval"][0][:, 0])[-2:]
    assert unstable[0] == pytest.approx(unstable[1], rel=1e-6)  # omega^2 of 2.7 beside 1e9 of the stiffest mode
    assert unstable[0] > 1.0


@pytest.mark.parametrize("coordinate", [1, 2])  # a dead point, and not
@pytest.mark.parametrize(
    ("spring", "values"),
    [
        # across: mass 2 kg, a damper of 1/2 N s/m and a spring of 4 N/m
        ("ESTIFF 2 8.\nEDAMP 2 1.", np.roots([2.0, 0.5, 4.0])),
        ("EDAMP 2 1.", np.roots([2.0, 0.5, 0.0])),
    ],
)
def test_damped_modes_of_an_unloaded_dead_point(coordinate, spring, values):
    text = PENDULUM.format(coordinate=coordinate).replace("XF 2 5. 0. ", "").replace("ESTIFF 2 8.", spring)
    computed = run(text, 7)["eigval"][-1]
    computed = np.sort_complex(computed[:, 0] + 1j * computed[:, 1])
    assert computed == pytest.approx(np.sort_complex(values.astype(complex)), rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("coordinate", [1, 2])
def test_multiplier_zero_of_a_motion_without_stiffness(coordinate):
    """A rod that is pulled has no stiffness but that of the load, which is lost at the multiplier 0."""
    result = run(PENDULUM.format(coordinate=coordinate).replace("ESTIFF 2 8. ", ""), 8)
    assert result["lmult"][-1] == pytest.approx([0.0], abs=1e-12)
    assert any("a load multiplier is zero" in line for line in result.report)


def test_singular_stiffness_of_large_systems(monkeypatch):
    """Hanging rods have no stiffness but that of their weight: every multiplier is zero, as with dense matrices."""
    text = pendulum(12, 1.0, 10)
    dense = run(text, 8)["lmult"][0]
    monkeypatch.setattr(form, "LARGE", 5)
    sparse = run(text, 8)["lmult"][0]
    assert not dense.any()
    assert np.abs(sparse).max() <= 1e-8  # of the shift


def test_almost_no_load_at_a_dead_point():
    """w^2 = F/(l m) of the load alone, however small it is: F = 1e-18 N, m = 2 kg."""
    text = PENDULUM.format(coordinate=1).replace("ESTIFF 2 8. ", "").replace("5. 0.", "1e-18 0.")
    assert np.abs(run(text, 7)["eigval"][-1][:, 1]).max() == pytest.approx(np.sqrt(0.5e-18), rel=1e-6)
