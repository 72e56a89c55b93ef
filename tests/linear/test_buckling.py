"""Buckling loads and compliances against closed forms; loads beyond the critical one; singular cases."""

import numpy as np
import pytest
from cantilever_eigen import cantilever

import spacar
from spacar.compiled.library import why_off
from spacar.deck import parse_deck
from spacar.errors import Report
from spacar.linear.buckling import buckling_modes
from tests.examples import DATA

ENGINE = pytest.mark.skipif(why_off() is not None, reason=str(why_off()))

# supports: statements about the ends (nodes 1, 2 and tip, tip rotation), the effective length factor
EULER = {
    "cantilever": ("FIX 1\nFIX 2", 2.0),
    "pinned": ("FIX 1\nFIX {t} 2\nDYNX 2", 1.0),
    "clamped-pinned": ("FIX 1\nFIX 2\nFIX {t} 2", 0.6991556596428412),
    "clamped-clamped": ("FIX 1\nFIX 2\nFIX {t} 2\nFIX {r}", 0.5),
}


def column(n: int, supports: str, load: str = "XF {t} -1. 0.", mode: int = 8) -> spacar.Result:
    """The surplus supports take the place of bending deformations of the last element."""
    names = {"t": 2 * n + 1, "r": 2 * n + 2}
    text = cantilever(n, supports.format(**names), load.format(**names))
    surplus = supports.count("{t}") + supports.count("{r}")
    free = {0: "2 3", 1: "3", 2: ""}[surplus]
    old = f"DYNE {n} 2 3"
    new = f"RLSE {n} 2" + (" 3" if surplus == 2 else "") + (f"\nDYNE {n} {free}" if free else "")
    return spacar.run(mode, parse_deck(text.replace(old, new) if surplus else text, mode=mode))


@pytest.mark.parametrize("name", EULER)
def test_euler_columns_converge_with_fourth_order(name):
    supports, factor = EULER[name]
    exact = (np.pi / factor) ** 2
    errors = [abs(column(n, supports)["lmult"][0][0] / exact - 1) for n in (4, 8, 16)]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert errors[-1] < 1e-4
    assert np.all(np.abs(orders - 4.0) < 0.25), (errors, orders)


def test_load_beyond_the_critical_one_and_reversed():
    """The straight column at 1.6 and at -0.5 times the Euler load: multipliers 1/1.6 and -2."""
    exact = np.pi**2 / 4
    for factor in (1.6, -0.5):
        result = column(10, "FIX 1\nFIX 2", f"XF {{t}} {-factor * exact!r} 0.")
        assert result["lmult"][0][0] == pytest.approx(1 / factor, rel=1e-5)
        compliance = result["xcompl"][0][result.mechanism.numbering.x_index(21, 2)]
        k = np.sqrt(abs(factor)) * np.pi / 2
        # tip of a beam-column under P: (tan k / k - 1)/P, with tension (1 - tanh k / k)/|P|
        truth = (np.tan(k) / k - 1) / (factor * exact) if factor > 0 else (1 - np.tanh(k) / k) / (-factor * exact)
        assert compliance == pytest.approx(truth, rel=1e-4)


def test_exactly_critical_load():
    """At the computed critical load of the model the tangent stiffness is singular: multiplier 1, infinite
    compliance.
    """
    critical = float(column(4, "FIX 1\nFIX 2")["lmult"][0][0])
    result = column(4, "FIX 1\nFIX 2", f"XF {{t}} {-critical!r} 0.", mode=10)
    assert result["lmult"][0][0] == pytest.approx(1.0, abs=1e-12)
    assert abs(result["xcompl"][0][result.mechanism.numbering.x_index(9, 2)]) > 1e11
    assert np.min(np.hypot(*result["eigval"][0].T)) < 1e-4


def test_indefinite_stiffness():
    """K0 indefinite: the general problem, with the right pairs."""
    K, G = np.diag([1.0, -2.0, 3.0]), np.array([[2.0, 0.5, 0], [0.5, 1.0, 0], [0, 0, -1.0]])
    modes = buckling_modes(K, G, Report())
    for value, v in zip(modes.multipliers, modes.modes.T, strict=True):
        assert np.linalg.norm(K @ v + value * (G @ v)) < 1e-12
    assert np.all(np.diff(np.abs(modes.multipliers)) >= 0)


def test_pencils_without_all_multipliers():
    """A pair with complex multipliers is shown as infinite; K0 = diag(1, 0, 2), G0 = diag(1/2, 0, -1) in turned
    coordinates: -2, 2 and a motion without multiplier; K0 v = 0 with geometric stiffness along v: 0, and those of the
    rest as they are. Each with a line in the report."""
    Q = np.linalg.qr(np.random.default_rng(1).standard_normal((3, 3)))[0]
    pencils = (
        (np.diag([1.0, 2.0]), np.array([[0.0, 1.0], [-1.0, 0.0]]), [np.inf, np.inf], "complex"),
        (Q @ np.diag([1.0, 0.0, 2.0]) @ Q.T, Q @ np.diag([0.5, 0.0, -1.0]) @ Q.T, [2.0, -2.0, np.inf],
         "common null vector"),
        (np.diag([0.0, 2.0, 3.0]), np.diag([1.0, -1.0, 0.0]), [0.0, 2.0, np.inf], "singular"),
    )  # fmt: skip
    for K, G, multipliers, word in pencils:
        report = Report()
        modes = buckling_modes(K, G, report)
        assert modes.multipliers == pytest.approx(multipliers, rel=1e-14, abs=1e-14)
        assert any(word in line for line in report.lines)
        if word == "common null vector":
            assert abs(modes.modes[:, 2] @ Q[:, 1]) == pytest.approx(1.0, rel=1e-14)


@pytest.mark.parametrize("compiled", [pytest.param(True, marks=ENGINE), False])
def test_no_stress_no_multiplier(compiled):
    """Springs that are pulled: of their geometric stiffness, N/l across, rounding is left along the axis: with it one
    multiplier was -5e16."""
    for result in (column(4, "FIX 1\nFIX 2", ""), spacar.run(8, DATA / "massspring.dat", compiled=compiled)):
        assert np.all(np.isinf(result["lmult"]))
        assert any("no stress" in line for line in result.report)


def test_multipliers_of_the_smallest_loads():
    """What is rounding of the geometric stiffness does not depend on the size of the load."""
    text = (DATA / "column2.dat").read_text()
    one = spacar.run(8, parse_deck(text, mode=8))["lmult"]
    small = spacar.run(8, parse_deck(text.replace("XF 5 -1.0", "XF 5 -1.0e-20"), mode=8))["lmult"]
    np.testing.assert_allclose(small, 1e20 * one, rtol=1e-9)


def test_symmetry_at_static_equilibrium():
    """M0, K0, G0 symmetric, N0 = C0 = 0 (theory-system.md 4.2) for a bent, loaded chain."""
    frame = column(4, "FIX 1\nFIX 2", "XF {t} -1. 2.\nGRAVITY 0. -3.").frames[0]
    for name in ("m0", "k0", "g0"):
        A = frame.matrices[name]
        assert np.max(np.abs(A - A.T)) <= 1e-12 * np.max(np.abs(A))
    assert not frame.matrices["n0"].any()
    assert not frame.matrices["c0"].any()
