"""Steady motion, user functions, dead points, gravity that comes late, the count of negative eigenvalues."""

import numpy as np
import pytest
from statics import cantilever

import spacar
from spacar.deck import parse_deck
from spacar.errors import Report
from spacar.linear import form
from spacar.linear_systems.matrix_inertia import Inertia
from spacar.mechanism import build
from spacar.stationary import LoadProgram, StationarySolver


def run(text: str, mode: int = 8) -> spacar.Result:
    return spacar.run(mode, parse_deck(text, mode=mode))


@pytest.mark.parametrize("kind", [0, 1])
def test_rotating_rod(kind):
    """Elastic rod turning with w: EA u'' + m w^2 (x + u) = 0, tip at tan(k)/k, k = w l sqrt(m/EA); order h^2.

    ITERSTEP with and without N0 give the same state.
    """
    k, errors = 0.6, []
    for n in (4, 8):
        lines = [f"PLBEAM {i} {2 * i - 1} {2 * i} {2 * i + 1} {2 * i + 2}" for i in range(1, n + 1)]
        lines += [f"X {2 * i + 1} {i / n!r} 0." for i in range(1, n + 1)] + ["FIX 1", "INPUTX 2 1"]
        lines += [f"DYNE {i} 1" for i in range(1, n + 1)] + ["END", "HALT"]
        lines += [f"EM {i} 1.\nESTIFF {i} 1." for i in range(1, n + 1)] + [f"INPUTX 2 1 0. {k!r}"]
        text = "\n".join([*lines, f"ITERSTEP 60 2 1e-11 1 {kind}", "END", "END", ""])
        errors.append(abs(run(text, 7).node(2 * n + 1, 1)[-1] - np.tan(k) / k))
    assert abs(np.log2(errors[0] / errors[1]) - 2.0) < 0.15
    assert errors[1] < 2e-3


@pytest.mark.parametrize("stated", [0.0, 30.0, 60.0])
def test_user_spring(tmp_path, monkeypatch, stated):
    """A spring of 40 N/m by USERSIG beside one of 100 N/m: 7 N give 0.05 m whatever stiffness the function states."""
    (tmp_path / "spring.py").write_text(f"def spring(t, ne, le, e, ep, nx, lnp, x, xp):\n"
                                        f"    return t, [[1, 1, 40.0 * e[le[0, 0]], {stated}, 0.0]], []\n")  # fmt: skip
    monkeypatch.chdir(tmp_path)
    text = """
PLTRUSS 1 1 2   X 1 0. 0.   X 2 1. 0.   FIX 1   FIX 2 2   DYNE 1 1   END HALT
ESTIFF 1 100.   XM 2 1.   XF 2 7. 0.   USERSIG spring   ITERSTEP 40 4 1e-10   END END
"""
    assert run(text, 7).node(2, 1)[-1] == pytest.approx(1.05, abs=1e-11)  # tolerance / stiffness


PENDULUM = """
PLTRUSS 1 1 2   PLTRUSS 2 2 3   X 1 0. 0.   X 2 1. 0.   X 3 1. 2.
FIX 1   FIX 3   DYNX 2 {coordinate}   RLSE 2   END HALT
ESTIFF 2 8.   XM 2 2.   XF 2 5. 0.   ITERSTEP 30 2 1e-10   END END
"""


@pytest.mark.parametrize("mode", [7, 8, 10])
def test_dead_point_of_the_degrees_of_freedom(mode):
    """A rigid link on the x axis is pulled along it; x of its end is no coordinate there: the result is the same as
    with y. With the spring of 4 N/m across: w^2 = (F/l + 4)/m = 4.5."""
    dead, regular = (run(PENDULUM.format(coordinate=c), mode) for c in (1, 2))
    for result in (dead, regular):
        assert np.allclose([result.node(2, c)[-1] for c in (1, 2)], [1.0, 0.0], rtol=0, atol=1e-12)
    assert any("dead point" in line for line in dead.report)
    assert not any("dead point" in line for line in regular.report)
    if mode != 8:
        for result in (dead, regular):
            assert np.abs(result["eigval"][-1][:, 1]).max() == pytest.approx(np.sqrt(4.5), rel=1e-8)
    if mode != 7:
        compliance = [r["xcompl"][-1][r.mechanism.numbering.x_index(2, 2)] for r in (dead, regular)]
        assert compliance == pytest.approx([1 / 9, 1 / 9], rel=1e-9)


def test_gravity_that_comes_with_the_additional_loading(monkeypatch):
    """DELGRAV without GRAVITY: the pencil of large systems has the gravity stiffness (2.770514, dense matrices)."""
    mass = "\n".join(f"EM {k} 1." for k in range(1, 31))
    text = cantilever(30).replace("XF 61 0. 10.0", f"{mass}\nXF 61 -1. 0.3\nDELGRAV 0. -0.5")
    text = "\n".join("ITERSTEP 20 4 1e-11 4 2 1" if s.startswith("ITERSTEP") else s for s in text.splitlines())
    dense = run(text, 7)["eigval"][-1]
    monkeypatch.setattr(form, "LARGE", 10)
    sparse = run(text, 7)["eigval"][-1]
    lowest = [np.sort(np.hypot(*v.T))[0] for v in (dense, sparse)]
    assert lowest[0] == pytest.approx(2.770514, abs=1e-6)
    assert lowest[1] == pytest.approx(lowest[0], rel=1e-8)  # residual that the sparse path promises


@pytest.mark.parametrize(("n", "band"), [(40, 5), (400, 9), (900, 60)])
def test_inertia_of_banded_matrices_with_zeros_on_the_diagonal(n, band):
    """Against the eigenvalues of the dense matrix; none is near zero."""
    rng = np.random.default_rng(n)
    A = np.triu(np.tril(rng.standard_normal((n, n)), 0), -band)
    A = A + A.T
    A[np.diag_indices(n)] *= rng.random(n) < 0.4
    rows, columns = np.nonzero(A)
    negative = int(np.sum(np.linalg.eigvalsh(A) < 0.0))
    assert Inertia(n, rows, columns)(A[rows, columns]) == (negative, 0)


def statics_report(text: str) -> list[str]:
    """What the stationary solution alone says."""
    m, report = build(parse_deck(text, mode=7), 7), Report()
    solver = StationarySolver(m, report)
    for level in LoadProgram(m.settings):
        solver.solve(level)
    return report.lines


def column(load: float, n: int) -> str:
    """Square column, clamped: buckles in both directions at once at pi^2/4."""
    lines = [f"BEAM {k} {2 * k - 1} {2 * k} {2 * k + 1} {2 * k + 2} 0. 1. 0." for k in range(1, n + 1)]
    lines += [f"X {2 * k + 1} {k / n!r} 0. 0." for k in range(1, n + 1)] + ["FIX 1", "FIX 2"]
    lines += [f"DYNE {k} 2 3 4 5 6" for k in range(1, n + 1)] + ["END", "HALT"]
    lines += [f"ESTIFF {k} 0. 1. 1. 1." for k in range(1, n + 1)] + [f"EM {k} 1. 0.01" for k in range(1, n + 1)]
    return "\n".join([*lines, f"XF {2 * n + 1} {-load!r} 0. 0.", "ITERSTEP 20 4 1e-9", "END", "END", ""])


@pytest.mark.parametrize("n", [4, 60])
def test_double_critical_state_is_said(n):
    """Two eigenvalues change their signs together; with 60 beams the mixed matrix has more than 600 unknowns, and the
    sign of its determinant does not change."""
    below, above = statics_report(column(2.4, n)), statics_report(column(2.6, n))
    assert not any("critical" in line or "unstable" in line for line in below)
    assert any("unstable" in line and "2 negative eigenvalues" in line for line in above)
    assert any("critical state is passed" in line and "2 negative eigenvalues more" in line for line in above)
    assert any(f"node {2 * n + 1}" in line or f"node {2 * n + 2}" in line for line in above)
