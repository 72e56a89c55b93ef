"""A result that is not exact to rounding is kept, with a warning; order and warnings of load multipliers."""

import numpy as np
import pytest
from cantilever_eigen import cantilever
from models import pendulum

import spacar
from spacar.compiled.library import why_off
from spacar.errors import Report
from spacar.linear import backward_error, eigen, form, lowest, subspace
from spacar.linear.buckling import buckling_modes, order_of
from spacar.linear.lowest import lost_pairs
from tests.examples import DATA
from tests.stationary.test_stability import PENDULUM
from tests.stationary.walk import walked


def test_a_doubtful_pair_is_kept_with_a_warning(monkeypatch):
    """A solver that is wrong in the seventh digit: its values are the result, and the worst one is named."""
    right = eigen.polished
    monkeypatch.setattr(eigen, "polished", lambda *a: (right(*a)[0] * [1.0, 1.0 + 1e-7], right(*a)[1]))
    report = Report()
    modes = eigen.undamped_modes(np.diag([4.0, 9.0]), np.eye(2), report)
    assert abs(modes.values[0]) == pytest.approx(3.0 * (1 + 5e-8), rel=1e-12)
    assert report.lines[0].startswith("warning: 1 of 2 omega^2 have fewer digits than usual; the worst one, 9,")


def test_right_pairs_need_no_word():
    report = Report()
    eigen.undamped_modes(np.diag([4.0, 9.0]), np.array([[2.0, 0.1], [0.1, 3.0]]), report)
    buckling_modes(np.diag([1.0, 2.0]), np.array([[0.1, 0.2], [0.2, -0.3]]), report)
    assert report.lines == []


def test_backward_error_does_not_depend_on_units():
    """Coordinates in metres or in millimetres: the same error of the same wrong pairs."""
    rng = np.random.default_rng(3)
    A, B = rng.normal(size=(2, 5, 5))
    K, M = A @ A.T, B @ B.T + 5 * np.eye(5)
    w, v = rng.normal(size=5) ** 2, rng.normal(size=(5, 5))
    unit = 10.0 ** rng.integers(-6, 7, 5)
    D = np.outer(unit, unit)
    plain = backward_error.of_pencil(K, M, w, v, 1 / np.sqrt(np.diag(M)))
    other = backward_error.of_pencil(K * D, M * D, w, v / unit[:, None], 1 / np.sqrt(np.diag(M * D)))
    assert np.allclose(plain, other, rtol=1e-12)


def test_the_backward_error_is_that_of_the_nearest_matrices():
    """A perturbation of relative size 1e-6 of one matrix gives pairs with backward errors of at most that size."""
    rng = np.random.default_rng(4)
    A = rng.normal(size=(6, 6))
    E = rng.normal(size=(6, 6))
    E *= 1e-6 * np.linalg.norm(A) / np.linalg.norm(E, 2)
    eta = backward_error.of_matrix(A, *np.linalg.eig(A + E))
    assert np.all((eta > 1e-10) & (eta <= 1.0001e-6))


def test_modes_of_large_systems_that_have_not_converged_are_told():
    report = Report()
    operator = np.diag([1.0, 0.5]).__matmul__
    z, squares = np.array([[1.0, 1e-6], [0.0, 1.0]]), np.array([4.0, 9.0])
    lost = lost_pairs(operator, np.array([1.0, 0.5]), z, squares, "omega^2", report)
    assert report.lines[0].startswith("warning: 1 of 2 omega^2 have fewer digits than usual; the worst one, 9,")
    assert not lost.any()


def test_a_mode_of_which_no_digit_is_known_is_nan(monkeypatch):
    """Two of the values do not converge: what has not converged at all is nan with a warning, the rest is right.

    A chain of 20 masses and springs in line: omega_k = 2 sin((2 k - 1) pi/(2 (2 n + 1))), clamped at one end.
    """
    n = 20
    rows = [("PLTRUSS", k, k, k + 1) for k in range(1, n + 1)]
    rows += [("X", k + 1, float(k)) for k in range(1, n + 1)] + [("FIX", 1)]
    rows += [("FIX", k + 1, 2) for k in range(1, n + 1)] + [("DYNE", k, 1) for k in range(1, n + 1)]
    dynamics = [("XM", k + 1, 1.0) for k in range(1, n + 1)] + [("ESTIFF", k, 1.0) for k in range(1, n + 1)]
    exact = np.sort(2 * np.sin((2 * np.arange(1, n + 1) - 1) * np.pi / (2 * (2 * n + 1))))
    solver = walked(spacar.Deck.build(rows, dynamics))
    tangent = solver.sparse_tangent()
    tangent.sigma = solver.solution.sigma
    monkeypatch.setattr(lowest, "SPARE", 0)  # the start block does not hold all modes
    arnoldi = subspace._arnoldi

    def cut(op, Q, start, count, within):
        theta, z = arnoldi(op, Q, start, count, within)
        return (theta[:-2], z[:, :-2]) if within == subspace.CONVERGED else (theta, z)

    for iterate, some in ((arnoldi, False), (cut, True)):
        monkeypatch.setattr(subspace, "_arnoldi", iterate)
        report = Report()
        found = np.sort(np.abs(lowest.lowest_vibration(tangent, report, 8).values.imag))[::2]
        known = found[np.isfinite(found)]
        assert (len(known) < 8) == some
        # a residual below a tenth: the value is an eigenvalue to that part
        assert all(np.min(np.abs(w**2 / exact**2 - 1)) < 0.2 for w in known)
        assert any("no digit is known are nan" in line for line in report.lines) == some


@pytest.mark.parametrize("noise", [0.0, 1e-13, -1e-13, 3e-9])
def test_of_a_pair_the_positive_multiplier_comes_first(noise):
    """Whatever the rounding of the moduli; infinite ones last, single negative ones at their place."""
    values = np.array([-3.0, np.inf, -1.0 + noise, 5.0, 1.0, -5.0 * (1 - noise), -5.0, -np.inf])
    assert values[order_of(values)].round(6).tolist() == [1.0, -1.0, -3.0, 5.0, -5.0, -5.0, np.inf, -np.inf]


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_antisymmetric_geometric_stiffness_gives_ordered_pairs(sign):
    """K = 1, G couples two halves: multipliers +- 1/g exactly in pairs, for the load and for the reversed load."""
    rng = np.random.default_rng(5)
    g = np.diag([2.0, 1.0, 0.5])
    Q = np.linalg.qr(rng.normal(size=(6, 6)))[0]
    G = Q.T @ np.block([[np.zeros((3, 3)), g], [g, np.zeros((3, 3))]]) @ Q
    modes = buckling_modes(np.eye(6), sign * (G + G.T) / 2, Report())
    assert np.allclose(modes.multipliers, [0.5, -0.5, 1.0, -1.0, 2.0, -2.0], rtol=1e-12)


# Singular and double cases are not refused: dead points, double critical loads, motions without stiffness.
def run(text: str, mode: int) -> spacar.Result:
    return spacar.run(mode, spacar.parse_deck(text, mode=mode))


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


# Buckling loads and compliances against closed forms; loads beyond the critical one; singular cases.
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
    return spacar.run(mode, spacar.parse_deck(text.replace(old, new) if surplus else text, mode=mode))


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
    rest as they are; beside complex ones motions on which the load has no effect (a leaf under a moment about a fixed
    axis had a margin of 6e15). Each with a line in the report."""
    Q = np.linalg.qr(np.random.default_rng(1).standard_normal((3, 3)))[0]
    follower = np.zeros((6, 6))
    follower[0, 1], follower[1, 0] = 1.0, -1.0
    pencils = (
        (np.diag([1.0, 2.0]), np.array([[0.0, 1.0], [-1.0, 0.0]]), [np.inf, np.inf], "complex"),
        (Q @ np.diag([1.0, 0.0, 2.0]) @ Q.T, Q @ np.diag([0.5, 0.0, -1.0]) @ Q.T, [2.0, -2.0, np.inf],
         "common null vector"),
        (np.diag([0.0, 2.0, 3.0]), np.diag([1.0, -1.0, 0.0]), [0.0, 2.0, np.inf], "singular"),
        (np.eye(6), np.kron(Q, np.eye(2)) @ follower @ np.kron(Q, np.eye(2)).T, [np.inf] * 6, "complex"),
    )  # fmt: skip
    for K, G, multipliers, word in pencils:
        report = Report()
        modes = buckling_modes(K, G, report)
        assert modes.multipliers == pytest.approx(multipliers, rel=1e-14, abs=1e-14)
        assert any(word in line for line in report.lines)
        if word == "common null vector":
            assert abs(modes.modes[:, 2] @ Q[:, 1]) == pytest.approx(1.0, rel=1e-14)


def test_rounding_is_no_follower_load():
    """Rows of the geometric stiffness on which the load does not act hold rounding, which is not symmetric: an inclined
    column on a hinge had "2 complex load multipliers (follower loads)"."""
    G = np.diag([-1.0, 0.5, 1e-17, -2e-17])
    G[2, 3], G[3, 2] = 2e-16, -1e-16
    report = Report()
    modes = buckling_modes(np.diag([1.0, 2.0, 3.0, 4.0]), G, report)
    assert modes.multipliers == pytest.approx([1.0, -4.0, np.inf, np.inf])
    assert not report.lines


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
    one = spacar.run(8, spacar.parse_deck(text, mode=8))["lmult"]
    small = spacar.run(8, spacar.parse_deck(text.replace("XF 5 -1.0", "XF 5 -1.0e-20"), mode=8))["lmult"]
    np.testing.assert_allclose(small, 1e20 * one, rtol=1e-9)


def test_symmetry_at_static_equilibrium():
    """M0, K0, G0 symmetric, N0 = C0 = 0 (theory-system.md 4.2) for a bent, loaded chain."""
    frame = column(4, "FIX 1\nFIX 2", "XF {t} -1. 2.\nGRAVITY 0. -3.").frames[0]
    for name in ("m0", "k0", "g0"):
        A = frame.matrices[name]
        assert np.max(np.abs(A - A.T)) <= 1e-12 * np.max(np.abs(A))
    assert not frame.matrices["n0"].any()
    assert not frame.matrices["c0"].any()
