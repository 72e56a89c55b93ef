"""Flutter and divergence of columns under forces of the user that have no potential, against the literature.

V. V. Bolotin, Nonconservative Problems of the Theory of Elastic Stability, Pergamon 1963; H. Leipholz, Stability of
Elastic Systems, Sijthoff 1980. Critical loads in EI/l^2 (of the whole load for Leipholz).
"""

from math import sqrt

import numpy as np
import pytest

import spacar

from .follower_models import column, critical, deck_of, growth, ziegler

TIP = "FIX 2\n"
BECK = 20.0509536  # of `beck` below
SPRING = """
PLRBEAM 1 1 2 3   PLTOR 2 4 2   X 3 1 0   FIX 1   FIX 4   DYNE 2 1   END HALT
XM 3 1   ESTIFF 2 1   USERSIG push   {more}   END END
"""
FOLLOWER = "p = x[lnp[1, 0]]\nreturn t, [], [[3, 1, -2.5 * math.cos(p)], [3, 2, -2.5 * math.sin(p)]]"


def beck() -> float:
    """The lowest load of Beck's column, where two frequencies of its characteristic equation meet:
    p^2 + 2 w^2 (1 + cosh a cos b) + p w sinh a sin b = 0, a^2, b^2 = sqrt(p^2/4 + w^2) -+ p/2 (Beck, ZAMP 3, 1952)."""

    def lowest(p: float) -> float:
        w = np.linspace(5.0, 16.0, 20001)
        root = np.sqrt(p * p / 4 + w * w)
        a, b = np.sqrt(root - p / 2), np.sqrt(root + p / 2)
        return float((p * p + 2 * w * w * (1 + np.cosh(a) * np.cos(b)) + p * w * np.sinh(a) * np.sin(b)).min())

    return critical(lambda p: lowest(p) > 0, 15.0, 25.0)


@pytest.mark.parametrize("start", ["", "STARTDE 2 1 0.01 0", "STARTDE 2 1 0.5 0"])
@pytest.mark.parametrize("mode", [7, 9, 10])
def test_a_force_along_a_bar_leaves_its_frequency(tmp_path, mode, start):
    """J w^2 = k, whatever the force: it has no moment about the hinge. No load multiplier either."""
    deck = deck_of(tmp_path, SPRING.format(more=start), FOLLOWER, mode)
    r = spacar.run(mode, deck)
    K = r["k0"][0] + r["n0"][0] + r["g0"][0]
    assert K[0, 0] == pytest.approx(1.0, rel=1e-9)
    if mode == 10:
        assert not np.abs(r["lmult"][0]).min() < 1e6
    if mode != 9:
        assert r["eigval"][0][0] == pytest.approx((0.0, 1.0), abs=1e-9)


def test_the_same_along_a_motion(tmp_path):
    deck = deck_of(tmp_path, SPRING.format(more="STARTDE 2 1 0.5 0\nTIMESTEP 1 4"), FOLLOWER, 4)
    r = spacar.run(4, deck)
    for k0, n0, g0 in zip(r["k0"], r["n0"], r["g0"], strict=True):
        assert k0 + n0 + g0 == pytest.approx(1.0, rel=1e-8)


def test_ziegler(tmp_path):
    """Flutter at 7/2 - sqrt(2) without damping, at 41/28 with a little of it in both hinges."""
    for load, damping in ((3.5 - sqrt(2.0), 0.0), (41.0 / 28.0, 1e-3)):
        assert growth(ziegler(tmp_path, 0.9999 * load, damping)) < 1e-9
        assert growth(ziegler(tmp_path, 1.0001 * load, damping)) > 1e-8


CASES = {
    "Beck": (BECK, "a = x[lnp[{tip}, 0]]\nreturn t, [], [[{end}, 1, -P * math.cos(a)], [{end}, 2, -P * math.sin(a)]]"),
    "Reut": (BECK, "y = x[lnp[{end} - 1, 1]]\nreturn t, [], [[{end}, 1, -P], [{tip} + 1, 1, -P * y]]"),
    "Leipholz": (40.05, """rows = []
for k in range(1, {n} + 1):
    a, q = x[lnp[2 * k + 1, 0]], P / {n} * (1.0 if k < {n} else 0.5)
    rows += [[2 * k + 1, 1, -q * math.cos(a)], [2 * k + 1, 2, -q * math.sin(a)]]
return t, [], rows"""),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_columns(tmp_path, name):
    """12 beams have the flutter load to half a per cent, from both sides."""
    load, body = CASES[name]
    n = 12
    for factor in (0.995, 1.005):
        text = body.format(tip=2 * n + 1, end=2 * n + 1, n=n).replace("P", repr(factor * load))
        deck = deck_of(tmp_path, column(n, TIP, ""), text)
        assert (growth(deck) > 1e-3) == (factor > 1.0)


def test_the_load_of_beck():
    assert beck() == pytest.approx(BECK, rel=1e-6)


def test_a_stated_derivative_that_contradicts_the_force_is_named(tmp_path):
    """A force that jumps has no derivative; what the function states is taken, and a warning says so."""
    body = "return t, [], [[3, 2, 0.01 * math.ceil(1e-3 * x[lnp[2, 1]]), 3.0, 0.0]]"
    r = spacar.run(7, deck_of(tmp_path, SPRING.format(more=""), body))
    assert r["k0"][0][0, 0] == pytest.approx(4.0)
    assert any("states k = 3 at node 3 y" in line for line in r.report)
