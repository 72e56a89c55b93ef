"""Beams whose mass and stiffness change along x.

A wedge of constant width (ρ ∝ 1 − x/L, EI ∝ (1 − x/L)³), clamped at the thick end, has a closed form
in Bessel functions (Kirchhoff 1882): J1(z) I2(z) + I1(z) J2(z) = 0 with z = 2 √ω in units L = ρ₀ = EI₀ = 1; the first
frequency is ω₁ = 5.3151.
"""

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import iv, jv

pytest.importorskip("sympy")

from spacar.symbolic import MultibodySystem
from spacar.symbolic.beam_shapes import X

UNIT = {"L": 1.0, "rho": 1.0, "EI": 1.0}


def wedge_frequency() -> float:
    z = brentq(lambda z: jv(1, z) * iv(2, z) + iv(1, z) * jv(2, z), 4.0, 5.0, xtol=1e-14)
    return float((z / 2) ** 2)


@pytest.mark.parametrize("strategy", ["held", "recursive"])
def test_a_wedge_has_the_frequency_of_bessel_functions(strategy):
    S = MultibodySystem()
    beam = {"mass": "rho*(1 - x/L)", "EI": "EI*(1 - x/L)**3", "field": 6, "foreshortening": False}
    S.beam("wedge", S.N, S.O, "L", **beam)
    w = np.sort(np.abs(S.derive(strategy).linearize(UNIT).eigenvalues().imag))[0]
    exact = wedge_frequency()
    assert exact == pytest.approx(5.3151, abs=1e-4)  # published digits
    assert -1e-11 < w / exact - 1 < 1e-6  # from above; the error of Ritz with six polynomials


@pytest.mark.parametrize("strategy", [pytest.param("held", marks=pytest.mark.slow), "recursive"])
def test_a_swinging_tapered_beam_keeps_the_balance_of_energy(strategy):
    S = MultibodySystem(gravity=("0", "-g", "0"))
    q, _ = S.coordinate("q", speed="s")
    B = S.frame("B", S.N, 3, q)
    beam = S.beam(
        "beam", B, S.O, "L", "rho*(1 - x/(2*L))", EI="EI*(1 - tau*x/L)", bends=(2, 3), field=2, foreshortening=True,
        twist=1, GJ="GJ*(1 - x/(3*L))", polar="jp*(1 - x/(4*L))", stretch=1, EA="EA*(2 - x/L)",
    )  # fmt: skip
    S.particle("load", beam.tip, "m")
    checked = S.derive(strategy).check()
    assert checked.positive
    assert checked.error < 1e-28  # 30 digits


def test_total_mass_and_strong_form():
    S = MultibodySystem()
    L, rho, EI = S.parameters("L rho EI")
    beam = S.beam("beam", S.N, S.O, L, "rho*(1 - x/(2*L))", EI="EI*(1 - x/L)", field=2)
    assert beam.total_mass.equals(3 * rho * L / 4)
    strong = S.derive("held").strong_form(beam)
    # EI u_xx = EI0 (1 − x/L) u_xx: at the tip the moment vanishes with the stiffness, the shear force is EI0/L u_xx
    u = beam.fields[0].function
    (moment, _), (shear, _) = strong.natural
    tip = {X: L}
    assert moment.coeff(u.diff(X, 2)).subs(tip) == 0
    assert shear.expand().coeff(u.diff(X, 2)).equals(EI / L)
    assert strong.equation.doit().expand().coeff(u.diff(X, 3)).equals(-2 * EI / L)
