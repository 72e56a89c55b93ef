"""The proof that a stationary state is stable, against eigenvalues of the tangent stiffness on admissible motions."""

import numpy as np
import pytest
from statics import cantilever

import spacar
from spacar.linear import form
from spacar.linear_systems import assemble, matrix_inertia
from spacar.linear_systems.matrix_inertia import Inertia
from spacar.stationary.resting_tangent import RestingTangent
from tests.examples import DATA

from .walk import walked

EULER = np.pi**2 / 4.0  # critical load of a clamped column with l = EI = 1, its end free


def column(n: int, force: float) -> str:
    """Clamped column of n inextensible beams, l = EI = 1, pressed by a force along its axis; the state is straight."""
    return cantilever(n).replace(f"XF {2 * n + 1} 0. 10.0", f"XF {2 * n + 1} {-force!r} 0.")


def asked(text: str) -> list[tuple[bool, tuple[int, int], int]]:
    """At every state that the walk looks at: is it proved to be stable, the count, the number of stresses."""
    found = []
    with pytest.MonkeyPatch.context() as patch:
        proof = RestingTangent.is_definite

        def both(self, point):
            proved = proof(self, point)
            found.append((proved, self.inertia(point), self.t.ne))
            return proved

        patch.setattr(RestingTangent, "is_definite", both)
        walked(text)
    return found


@pytest.mark.parametrize("n", [2, 8, 40])
@pytest.mark.parametrize("part", [0.5, 0.99, 0.9999, 1.05])
def test_a_column_is_proved_to_be_stable_below_its_critical_load(n, part):
    # displacement methods have their critical load above that of the continuum
    found = asked(column(n, part * EULER))
    proved, counted, ne = found[-1]
    assert all(proved for proved, *_ in found) if part < 1.0 else not proved
    assert part < 1.0 or counted == (ne + 1, 0)


@pytest.mark.parametrize("name", ["plbeam5", "lateral4", "lateral4cw", "leafguide", "crosshingew", "column2", "lever"])
def test_what_is_proved_has_no_negative_eigenvalue(name):
    """In examples, planar and spatial, with warping, rigid parts and prescribed displacements."""
    found = asked((DATA / f"{name}.dat").read_text())
    for proved, (negative, zero), ne in found:
        if proved:
            assert (negative, zero) == (ne, 0)


def test_large_models_are_counted_only_where_nothing_is_proved(monkeypatch):
    """A bent chain of 30 beams, above the limit of dense storage, is stable at all levels: nothing is counted."""
    monkeypatch.setattr(matrix_inertia.Inertia, "__call__", lambda *_: pytest.fail("eigenvalues were counted"))
    solver = walked(cantilever(30))
    assert solver._continuation is not None
    assert str(solver._continuation.stable) == "0 negative eigenvalues"


# The sign of the determinant, which tells of unsymmetric tangents whether the negative eigenvalues are even or odd.
BAR = """
BEAM 1  1 2  5 6  0 1 0   BEAM 2  5 6  3 4  0 1 0   X 5 0.25 0. 0.   X 3 0.5 0. 0.
FIX 1   FIX 2   DYNE 1 1 2 3 4 5 6   DYNE 2 1 2 3 4 5 6   END HALT
ESTIFF 1 1000. 1. 2. 1.   ESTIFF 2 1000. 1. 2. 1.   EM 1 1. 0.01 0.01 0.01   EM 2 1. 0.01 0.01 0.01
ITERSTEP 30 4 1e-9 1 2 2
"""


@pytest.mark.parametrize("kind", ["dense", "banded", "sparse"])
def test_sign_of_every_storage(kind):
    """Against NumPy; a pattern without symmetry, so that rows and columns are ordered differently."""
    rng = np.random.default_rng(3)
    signs = set()
    for n in range(5, 25):
        rows, columns = np.nonzero(rng.random((n, n)) < 2.0 / n)
        rows, columns = np.append(rows, rng.permutation(n)), np.append(columns, np.arange(n))
        entries = rng.normal(size=len(rows))
        A = np.zeros((n, n))
        np.add.at(A, (rows, columns), entries)
        system = assemble(n, rows, columns, kind)
        system.factor(entries)
        assert system.determinant_sign() == np.linalg.slogdet(A)[0]
        signs.add(system.determinant_sign())
    assert signs == {-1.0, 1.0}


def warnings(loads: str) -> list[str]:
    return [w for w in spacar.run(8, spacar.parse_deck(f"{BAR}{loads}\nEND\nEND\n", mode=8)).report if "critical" in w]


@pytest.mark.parametrize("moment", ["1e-4 0. 0.", "0. 2e-4 1e-4", "3e-5 2e-4 -1e-4"])
def test_a_small_moment_passes_no_critical_state(moment):
    """A moment on an orientation makes the tangent unsymmetric: from then on only the sign is known.

    The loads are 1e-4 of those that bend or twist the bar by a radian, far below every critical one.
    """
    assert warnings(f"DELXF 4 {moment}") == []
    assert warnings(f"XF 3 0. 1e-3 0.\nDELXF 4 {moment}") == []


def test_a_critical_state_of_an_unsymmetric_tangent_is_said():
    """Compression of a twisted bar with 2.2 and then 2.8 EI/l^2 (EI = 1): one bending motion buckles at 2.47."""
    twist = "XF 4 1e-3 0. 0."
    assert warnings(f"{twist}\nDELXF 3 -8.8 0. 0.") == []
    [said] = warnings(f"{twist}\nDELXF 3 -11.2 0. 0.")
    assert "sign of its determinant" in said


# Count of negative eigenvalues: exact, and with linear cost.
def chain(k: int, free: bool) -> tuple[int, np.ndarray, np.ndarray, np.ndarray]:
    """k masses and k or k - 1 springs of compliance 1 in a row, every third one rigid and one mass in four drawn by a
    negative spring to the ground; unknowns in random order."""
    n = 2 * k
    A = np.zeros((n, n))
    for i in range(free, k):  # spring i between masses i - 1 and i
        A[k + i, i] = A[i, k + i] = 1.0
        if i:
            A[k + i, i - 1] = A[i - 1, k + i] = -1.0
        A[k + i, k + i] = -1.0 * (i % 3 > 0)
    A[k, k] = -1.0 if free else A[k, k]
    A[range(3, k, 4), range(3, k, 4)] = -0.03
    p = np.random.default_rng(k).permutation(n)
    A = A[np.ix_(p, p)]
    rows, columns = np.nonzero(A)
    return n, rows, columns, A[rows, columns]


@pytest.mark.parametrize("free", [False, True])
@pytest.mark.parametrize("k", [20, 100, 317])
def test_both_ways_agree_with_the_spectrum(k, free):
    n, rows, columns, entries = chain(k, free)
    A = np.zeros((n, n))
    A[rows, columns] = entries
    spectrum = np.linalg.eigvalsh(A)
    assert np.abs(spectrum).min() > 1e-6  # no sign is in doubt
    expected = int(np.sum(spectrum < 0.0)), 0
    count = Inertia(n, rows, columns)
    assert count(entries) == expected
    if n > matrix_inertia.SINGLE:
        values = count._equilibrated(entries)
        assert matrix_inertia._by_spectra(n, count._blocks(values, False, matrix_inertia.SMALLEST_BLOCK)) == expected
        blocks = count._blocks(values, False, matrix_inertia.FACTORED_BLOCK)
        assert matrix_inertia._by_factors(n, blocks) in (expected[0], None)


def test_few_directions_wait(monkeypatch):
    """A chain of beams before and after its bending: what is small but not coupled must not wait for the last block.

    The blocks of all orders together would make the cost grow with the cube of the number of beams.
    """
    orders, eigh = [], np.linalg.eigh
    seen: list[tuple[int, int]] = []

    def counted(self, point):
        count = self.t.pattern(("geometric", "load", "moment"))
        solver = Inertia(self.t.nf + self.t.ne, *count)
        blocks = solver._blocks(solver._equilibrated(self.entries(point)), False, matrix_inertia.SMALLEST_BLOCK)
        monkeypatch.setattr(np.linalg, "eigh", lambda S: (orders.append(len(S)), eigh(S))[1])
        seen.append(matrix_inertia._by_spectra(solver.n, blocks))
        monkeypatch.setattr(np.linalg, "eigh", eigh)
        assert seen[-1] == self.inertia(point)
        return False  # not proved: the walk counts

    monkeypatch.setattr(RestingTangent, "is_definite", counted)
    walked(cantilever(200))
    assert seen
    assert max(orders) <= 2 * matrix_inertia.SMALLEST_BLOCK


# Steady motion, user functions, dead points, gravity that comes late, the count of negative eigenvalues.
def run(text: str, mode: int = 8) -> spacar.Result:
    return spacar.run(mode, spacar.parse_deck(text, mode=mode))


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


def clamped_column(load: float, n: int) -> str:
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
    below, above = (walked(clamped_column(load, n)).report.lines for load in (2.4, 2.6))
    assert not any("critical" in line or "unstable" in line for line in below)
    assert any("unstable" in line and "2 negative eigenvalues" in line for line in above)
    assert any("critical state is passed" in line and "2 negative eigenvalues more" in line for line in above)
    assert any(f"node {2 * n + 1}" in line or f"node {2 * n + 2}" in line for line in above)
