"""The tangent of steady motion: both forms are the derivative of the residual and agree, also in their sign."""

from contextlib import nullcontext
from functools import partial

import numpy as np
import pytest

import spacar
from spacar.arrays import EPS
from spacar.errors import Report
from spacar.linear import form, subspace
from spacar.linear_systems import SingularMatrixError
from spacar.mechanism import build
from spacar.stationary import LoadLevel, LoadProgram, StationarySolver, moving_tangent
from spacar.stationary.moving_tangent import MovingTangent
from spacar.stationary.stationary_equations import require_digits
from tests.examples import DATA


def blade(n: int, rate: float = 10.0) -> str:
    """A planar blade of n elements that turns with its hub, with a force at its tip."""
    rows = [f"PLBEAM {k} {2 * k - 1} {2 * k} {2 * k + 1} {2 * k + 2}" for k in range(1, n + 1)]
    rows += [f"X {2 * k + 1} {0.1 + k / n:.9g} 0." for k in range(n + 1)] + ["FIX 1", "INPUTX 2 1"]
    rows += [f"DYNE {k}" for k in range(1, n + 1)] + ["END", "HALT"]
    rows += [line for k in range(1, n + 1) for line in (f"EM {k} 0.1", f"ESTIFF {k} 2e5 1.5", f"EDAMP {k} 10. 0.01")]
    rows += [f"INPUTX 2 1 0. {rate} 0.", f"XF {2 * n + 1} 0. -0.2", "MODES 4", "ITERSTEP 20 3 1e-8", "END", "END", ""]
    return "\n".join(rows)


MODELS = {name: (DATA / f"{name}.dat").read_text() for name in ("crankfl", "massspring", "trike3v", "finger")}
MODELS["blade"] = blade(6)


@pytest.mark.parametrize("name", MODELS)
def test_both_forms_are_the_derivative_of_the_residual(name, monkeypatch):
    mechanism = build(spacar.parse_deck(MODELS[name], mode=7), 7)
    solver = StationarySolver(mechanism, Report())
    list(solver.stored(LoadProgram(mechanism.settings)))
    e, p = solver._evaluator, solver._continuation.point
    q = e.equations
    p = q.point(p.x, p.sigma, e.given)
    small = MovingTangent(q, without_n0=False)
    small.factor(p)
    monkeypatch.setattr(moving_tangent, "DENSE_LIMIT", 0)
    large = MovingTangent(q, without_n0=False)
    large.factor(p)
    rng = np.random.default_rng(2)
    right = rng.standard_normal((q.nf + q.ne, 2))
    A = small.dense()
    size = np.abs(A).max(axis=1)
    np.testing.assert_allclose(large.dense(), A, atol=1e-12 * size.max())
    if q.holonomic:  # wheels that roll have a singular matrix
        z = large.solve(right)
        rest = np.abs(A @ z - right) / (np.abs(A) @ np.abs(z) + np.abs(right))
        assert rest.max() < 1e-9
        assert large.sign() == small.sign()
    dx, h = rng.standard_normal(q.d.numbering.nx) * q.scale, 1e-7
    dx[np.setdiff1d(np.arange(len(dx)), q.F)] = 0.0
    dsigma = np.where(q.passive, 0.0, rng.standard_normal(q.ne) * q.flexibility.size)  # passive ones follow the law
    ends = [q.point(p.x + s * h * dx, p.sigma + s * h * dsigma, e.given).right for s in (1.0, -1.0)]
    z = np.concatenate((dx[q.F], dsigma / q.flexibility.size))
    expected = (ends[1] - ends[0]) / (2.0 * h)
    bound = np.abs(A) @ np.abs(z) + 1e-3 * np.abs(right).max()
    assert (np.abs(A @ z - expected) <= 1e-6 * bound.max()).all()


def test_a_long_blade_is_that_of_the_dense_tangent(monkeypatch):
    deck = spacar.parse_deck(blade(60))
    sparse = spacar.run(7, deck).frames[0]
    monkeypatch.setattr(moving_tangent, "DENSE_LIMIT", 10_000)
    dense = spacar.run(7, deck).frames[0]
    np.testing.assert_allclose(sparse.x, dense.x, atol=1e-11)
    np.testing.assert_allclose(sparse.sig, dense.sig, atol=1e-8 * np.abs(dense.sig).max())


@pytest.mark.parametrize("n", [250, pytest.param(1000, marks=pytest.mark.slow)])
def test_modes_of_a_long_blade(n):
    """What division leaves is of order 4: 20 and 40 elements, dense, give the limit to 3e-7. In degrees of freedom that
    are relative the mass matrix has a condition of n^4; not refined, no digit of 500 elements is left."""
    found = {}
    for k in (20, 40, n):
        lines = [line for line in blade(k).splitlines() if not line.startswith(("EDAMP", "XF"))]
        found[k] = spacar.run(7, spacar.parse_deck("\n".join(lines))).frequencies[-1][:2]
    limit = found[40] + (found[40] - found[20]) / 15.0
    np.testing.assert_allclose(found[n], limit + (found[40] - limit) * (40.0 / n) ** 4, rtol=3e-7)


HINGED = blade(12).replace("ESTIFF 1 2e5 1.5", "ESTIFF 1 2e5 0.").replace("XF 25 0. -0.2", "XF 25 1. 0.02")
HINGED = "\n".join(line for line in HINGED.splitlines() if not line.startswith("EDAMP"))
AT_REST = MODELS["blade"].replace("INPUTX 2 1 0. 10.0 0.\n", "").replace("XF 13 0.", "XF 13 -1.")
PUSH = """
def spring(t, ne, le, e, ep, nx, lnp, x, xp):
    return t, [[1, 2, -3 * e[le[0, 1]]]], []

def push(t, ne, le, e, ep, nx, lnp, x, xp):
    a, bent = x[lnp[13, 0]], le[0, 1]
    return t, [[1, 2, -3 * e[bent] - e[bent] ** 3]], [[13, 1, -0.5 * math.cos(a)], [13, 2, -0.5 * math.sin(a)]]
"""


def spatial_blade(n: int) -> str:
    """In the angle measure, whose beams have a twist gradient of their own; it turns with its hub about z."""
    rows, before = ["HINGE 1 2 3 0 0 1 FIX 1 FIX 2 INPUTE 1 1 X 1 0.1 0. 0."], "1 3"
    for k in range(1, n + 1):
        p = 2 * k + 2
        rows.append(f"BEAM {k + 1} {before} {p} {p + 1} 0 0 1 DYNE {k + 1} 1 2 3 4 5 6 X {p} {0.1 + k / n:.9g} 0. 0.")
        before = f"{p} {p + 1}"
    rows += ["ADEFORM", "END HALT"] + [f"EM {k} 0.1 1e-5 1e-5 ESTIFF {k} 2e5 1. 1.5 1.2" for k in range(2, n + 2)]
    return "\n".join([*rows, "INPUTE 1 1 0. 10. 0.", f"XF {p} 0. -0.1 0.1", "ITERSTEP 20 3 1e-8", "END END"])


@pytest.mark.parametrize(
    "model",
    [
        pytest.param(MODELS["blade"], id="motion"),
        pytest.param(spatial_blade(6), id="spatial motion, angle measure"),
        pytest.param(MODELS["crankfl"], id="crank"),
        pytest.param(HINGED, id="without stiffness"),
        pytest.param(AT_REST.replace("XF", "MEE 3 2 0.01\nXF"), id="inertia of deformations"),
        pytest.param(AT_REST.replace("XF", "USERSIG push\nXF"), id="user functions"),
    ],
)
def test_few_modes_of_a_large_model(model, monkeypatch, tmp_path):
    """Those of the descriptor system, multipliers and compliances are those of the reduced matrices."""
    (tmp_path / "push.py").write_text(f"import math\n{PUSH}")
    file = tmp_path / "model.dat"
    file.write_text(model)
    dense = spacar.run(10, file, modes=0).frames[-1]
    monkeypatch.setattr(form, "LARGE", 0)
    monkeypatch.setattr(form, "SHARE", 1)
    monkeypatch.setattr(moving_tangent, "DENSE_LIMIT", 0)
    large = spacar.run(10, file, modes=2).frames[-1]
    found, known = large.matrices["eigval"], dense.matrices["eigval"][-4:]
    assert not {"m0", "ktan"} & set(large.matrices)
    np.testing.assert_allclose(found, known, rtol=1e-7, atol=1e-7 * np.abs(known).max())
    assert large.matrices["eigxre"].shape[1] == 4
    np.testing.assert_allclose(large.matrices["lmult"], dense.matrices["lmult"][:2], rtol=1e-8)
    np.testing.assert_allclose(large.xcompl, dense.xcompl, rtol=1e-9, atol=1e-11 * dense.xcompl.max())


@pytest.mark.parametrize(("direction", "singular"), [(1e-12, False), (3e-16, True), (1e-19, True)])
def test_a_stiffness_of_rounding_is_singular(direction, singular):
    """A bar across the only motion: its direction, a sine or a cosine, is known to eps, the stiffness to eps^2 of the
    bar's. Rounding of the entries, which are what they are, does not tell this."""
    A = np.array([[0.0, direction], [direction, -1.0]])  # [0, V^T; V, -C], S = 1
    solve = partial(np.linalg.solve, A)
    z = solve(np.array([1.0, 0.0]))
    assert z[0] == pytest.approx(direction**-2)
    with pytest.raises(SingularMatrixError) if singular else nullcontext():
        require_digits(solve, lambda z: EPS * (np.abs(A) @ np.abs(z)), z, 1)


def test_compliances_are_infinite_where_the_stiffness_is_singular(monkeypatch, tmp_path):
    """The last beam of a blade with a user function does not resist bending: nothing holds its end."""
    (tmp_path / "spring.py").write_text(PUSH)
    model = AT_REST.replace("ESTIFF 6 2e5 1.5", "ESTIFF 6 2e5 0.").replace("XF 13 -1. -0.2", "USERSIG spring")
    file = tmp_path / "model.dat"
    file.write_text(model)
    dense = spacar.run(10, file, modes=0).frames[-1].xcompl
    monkeypatch.setattr(form, "LARGE", 0)
    monkeypatch.setattr(form, "SHARE", 1)
    monkeypatch.setattr(moving_tangent, "DENSE_LIMIT", 0)
    large = spacar.run(10, file, modes=2).frames[-1].xcompl
    assert np.isinf(large[np.isinf(dense)]).all()
    assert np.isinf(dense).any()


def test_modes_that_accumulate_end_the_search(monkeypatch):
    """Damping c = k/150 makes the fast modes rates about -150 1/s. What differs from them is found, the others are nan:
    a second search for as many finds none, which has to end it (40 of them took minutes)."""
    calls = []
    search = subspace._arnoldi
    monkeypatch.setattr(subspace, "_arnoldi", lambda *given: calls.append(1) or search(*given))
    deck = spacar.parse_deck(blade(80).replace("MODES 4", "MODES 6"))
    large = spacar.run(7, deck)
    found, dense = (result.frames[-1].matrices["eigval"] for result in (large, spacar.run(7, deck, modes=0)))
    assert len(found) == 12
    assert len(calls) <= 6
    known = ~np.isnan(found).any(axis=1)
    assert known.sum() >= 4
    # relative to 150 1/s the dense ones have eight digits
    np.testing.assert_allclose(found[known], dense[-known.sum() :], atol=150 * 1e-7)
    assert any("are not found (nan): the search does not converge" in line for line in large.report)


# The tangent of tubes with flow contains the momentum of the fluid, with and without gravity.
@pytest.mark.parametrize("word", ["TUBE", "PLTUBE"])
def test_tangent_of_a_discharging_tube(word: str) -> None:
    """Against central differences of the residual: a bent tube with a jet at its end, no gravity."""
    spatial = word == "TUBE"
    y = (0.0, 1.0, 0.0) if spatial else ()
    stiffness = (90.0, 2.0, 3.0, 4.0) if spatial else (90.0, 3.0)
    rows = [(word, 1, 1, 2, 3, 4, *y), ("X", 3, 1.0, 0.2), ("FIX", 1), ("FIX", 2), ("DYNE", 1)]
    law = [("EM", 1, 0.7, 0.3, 0.4, 1.1, 2), ("ESTIFF", 1, *stiffness), ("XF", 3, 0.1, 0.3), ("ITERSTEP", 20, 1, 1e-9)]
    mechanism = build(spacar.Deck.build(rows, law, mode=7), 7)
    solver = StationarySolver(mechanism, spacar.errors.Report())
    solver.solve(LoadLevel(1.0, 0.0, True, 1, 1))
    q, tangent = solver.factorized()
    x, sigma = solver.dynamics.kinematics.x.copy(), solver.solution.sigma
    given = solver._evaluator.given
    matrix = tangent.dense()[: q.nf, : q.nf]
    for column, i in enumerate(q.F):
        h = 1e-6
        moved = []
        for s in (-1.0, 1.0):
            z = x.copy()
            z[i] += s * h
            moved.append(q.point(z, sigma, given).right[: q.nf])
        # `right` is minus the residual
        np.testing.assert_allclose(-(moved[1] - moved[0]) / (2 * h), matrix[:, column], atol=1e-7, rtol=1e-6)
