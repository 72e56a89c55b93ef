"""Large models: the number of modes, what is stored of them, and that all of it equals the dense results.

Sparse and dense results are two algorithms on the same equations; the tolerances are what the dense one loses, whose
matrices have entries up to the condition of the degrees of freedom squared (1e5 here) times their lowest eigenvalues.
"""

import frames
import numpy as np
import pytest
from cantilever_eigen import ROOTS
from models import cantilever, spatial_chain
from scipy.sparse.linalg import splu
from spacar_cli.main import main
from spacar_formats.compliance import node_compliance

import spacar
from spacar import linear_systems
from spacar.compiled.compiled_elements import band_inverse
from spacar.compiled.library import why_off
from spacar.deck import parse_deck
from spacar.dynamics import Dynamics
from spacar.errors import UsageError
from spacar.linear import form
from spacar.linear_systems import assemble, linear_system, sparse_factors
from spacar.linear_systems.selected_inverse import inverse_diagonal
from spacar.linearization import coefficients, linearize
from spacar.linearization.descriptor import of_frame
from spacar.linearization.sparse_response import response
from spacar.mechanism import build

MODELS = {
    "planar": lambda: cantilever(24, load="-1. -1."),
    "spatial": lambda: spatial_chain(10),
}


@pytest.fixture(params=MODELS)
def pair(request, monkeypatch):
    """Results of mode 10 with sparse and with dense matrices, 6 modes."""
    deck = parse_deck(MODELS[request.param](), mode=10)
    dense = spacar.run(10, deck, modes=0)
    monkeypatch.setattr(form, "LARGE", 5)
    return spacar.run(10, deck, modes=6), dense


def test_frequencies_and_multipliers(pair):
    sparse, dense = pair
    assert sparse["eigval"][0].shape == (12, 2)
    np.testing.assert_allclose(sparse.frequencies[0], dense.frequencies[0][:6], rtol=1e-6)
    np.testing.assert_allclose(sparse["lmult"][0].ravel(), dense["lmult"][0].ravel()[:6], rtol=1e-7)
    np.testing.assert_allclose(sparse["xcompl"][0], dense["xcompl"][0], rtol=1e-8, atol=1e-12)


def test_motions_are_the_transfer_functions_times_the_vectors(pair):
    sparse, dense = pair
    dx = dense["dx"][0]
    vectors = sparse["eigvre"][0] + 1j * sparse["eigvim"][0]
    motions = sparse["eigxre"][0] + 1j * sparse["eigxim"][0]
    np.testing.assert_allclose(motions, dx @ vectors[: dx.shape[1]], atol=1e-8 * np.abs(motions).max())
    shapes = sparse["bmodex"][0]
    np.testing.assert_allclose(shapes, dx @ sparse["bmode"][0], atol=1e-8 * np.abs(shapes).max())


def test_vectors_are_those_of_the_dense_matrices(pair):
    sparse, dense = pair
    found = sparse["eigvre"][0][: sparse["eigvre"][0].shape[0] // 2]
    K = sum(dense[k][0] for k in ("k0", "n0", "g0"))
    omega = np.hypot(*sparse["eigval"][0].T)
    work = dense["m0"][0] @ found * omega**2
    np.testing.assert_allclose(K @ found, work, atol=1e-6 * np.abs(K @ found).max())


def test_sparse_tangent_and_mass_as_they_are_stored(pair):
    """The inverse of ktan gives the directional compliances; sizes and numbering are those of files.md section 5."""
    sparse, _ = pair
    i, j, v = sparse["ktan"][0].T
    n = int(i.max())
    A = np.zeros((n, n))
    A[i.astype(int) - 1, j.astype(int) - 1] = v
    nxp = np.ravel(sparse["nxp"]).astype(int)
    free = np.r_[nxp[0] : nxp[0] + nxp[1], nxp[:3].sum() : nxp[:4].sum()]
    np.testing.assert_allclose(np.diag(np.linalg.inv(A))[: len(free)], sparse["xcompl"][0][free], rtol=1e-8, atol=1e-12)
    i, j, v = sparse["mtan"][0].T
    assert i.max() <= len(free)


def test_fewer_modes_of_a_small_model():
    """All matrices are there, and the lowest modes only, in the same order."""
    deck = parse_deck(MODELS["planar"](), mode=10)
    fewer = parse_deck(deck.text.replace("HALT\n", "HALT\nMODES 3\n"), mode=10)
    every, some = spacar.run(10, deck), spacar.run(10, fewer)
    assert some["m0"][0].shape == (48, 48)
    # few modes come from another routine of LAPACK
    np.testing.assert_allclose(some["eigval"][0], every["eigval"][0][-6:], rtol=1e-14, atol=0)
    np.testing.assert_allclose(some["eigvre"][0], every["eigvre"][0][:, -6:], rtol=0, atol=1e-14)
    np.testing.assert_array_equal(some["lmult"][0].ravel(), every["lmult"][0].ravel()[:3])
    assert some["bmode"][0].shape == (48, 3)


@pytest.mark.parametrize("wrong", [-1, 1.5, "3"])
def test_wrong_number_of_modes(wrong):
    with pytest.raises(UsageError, match="modes"):
        spacar.run(7, parse_deck(MODELS["planar"](), mode=7), modes=wrong)


def test_commands_work_on_large_results(tmp_path, capsys):
    """The number of modes from the command line; eigen, compliance, visual and draw without dx and reduced matrices."""
    path = tmp_path / "model.dat"
    path.write_text(cantilever(110, load="-1. -1."))

    def call(*words: str) -> str:
        assert main([str(word) for word in words]) == 0, (words, capsys.readouterr())
        return capsys.readouterr().out

    call("10", path, "--modes", "4", "-q")
    sparse = node_compliance(tmp_path / "model", 221)[0]
    assert call("visual", tmp_path / "model", "--list").count("vibration mode") == 4
    assert call("visual", tmp_path / "model", "7", "-o", tmp_path / "mode.svg")
    assert call("draw", tmp_path / "model", "-o", tmp_path / "model.svg")
    assert call("eigen", tmp_path / "model").count("PLBEAM") == 8
    call("checksbf", tmp_path / "model.sbm")
    call("10", path, "--modes", "0", "-q")
    dense = node_compliance(tmp_path / "model", 221)[0]
    np.testing.assert_allclose(sparse.fixed, dense.fixed, rtol=1e-7)
    np.testing.assert_allclose(sparse.body, dense.body, rtol=1e-7)


@pytest.mark.parametrize("moving", [False, True])
def test_sparse_and_dense_linearization(moving, monkeypatch):
    """All matrices of theory-system.md (13), at rest and in motion, to rounding of sums of some hundred terms."""
    m = build(parse_deck(spatial_chain(5), mode=4), 4)
    d = Dynamics(m)
    d.start()
    rng = np.random.default_rng(2)
    d.xd = d.kinematics.dependent(0.1 * moving * rng.standard_normal(m.numbering.nx), np.zeros(m.numbering.ne))
    xdd = 0.1 * moving * rng.standard_normal(m.numbering.nx)
    full = linearize(d, xdd, np.zeros(m.numbering.ne))
    monkeypatch.setattr(linear_system, "DENSE_LIMIT", 0)
    sparse = linearize(d, xdd, np.zeros(m.numbering.ne))
    assert not isinstance(coefficients.mass_matrix(d.sweep), np.ndarray)
    for name in ("m0", "c0", "d0", "k0", "n0", "g0", "ak0", "bk0"):
        a, b = getattr(sparse, name), getattr(full, name)
        np.testing.assert_allclose(a, b, atol=1e-12 * max(np.abs(b).max(), 1e-300), rtol=0.0, err_msg=name)


@pytest.mark.parametrize("by", [None, *([] if why_off() else [band_inverse])])
@pytest.mark.parametrize(("n", "lower", "upper"), [(1, 0, 0), (40, 1, 1), (60, 3, 7), (150, 9, 2), (30, 29, 29)])
def test_diagonal_of_the_inverse_of_a_band(n, lower, upper, by):
    """In NumPy and C, against the inverse itself; exchanges of rows in every second step, as the diagonal is small."""
    rng = np.random.default_rng(n)
    i, j = np.nonzero(np.ones((n, n)))
    inside = (i - j <= lower) & (j - i <= upper)
    i, j = i[inside], j[inside]
    v = rng.standard_normal(len(i)) * np.where(i == j, 0.05, 1.0)
    system = assemble(n, np.r_[i, j], np.r_[j, i], "banded")  # a symmetric pattern
    system.factor(np.r_[v, np.zeros(len(v))])
    A = np.zeros((n, n))
    A[i, j] = v
    inverse = np.linalg.inv(A)
    error = np.abs(inverse_diagonal(system, by) - np.diag(inverse))
    assert error.max() <= 1e-15 * n * np.linalg.cond(A) * np.abs(inverse).max()


@pytest.mark.parametrize("beams", [400, pytest.param(2000, marks=pytest.mark.slow)])
def test_thousands_of_beams(beams):
    """Planar cantilever without load: f = (1.87510407)^2/(2 pi L^2) sqrt(EI/m); what division leaves, with order 4, is
    below 1e-10, and rounding, refined, too (not refined: 1e-6 of 2000 beams)."""
    r = spacar.run(7, parse_deck(cantilever(beams), mode=7), modes=12)
    exact = np.array(ROOTS) ** 2 / (2.0 * np.pi * 100.0) * np.sqrt(102.0)
    assert r.frequencies[0][0] == pytest.approx(exact[0], rel=1e-10)
    assert r.frequencies[0][:5] == pytest.approx(exact, rel=1e-6)
    assert r["eigxre"][0].shape == (3 * beams + 3, 24)


@pytest.mark.parametrize("load", ["XF 9 0.1 -0.2 0.3 XF 10 0.3 0.1 0.2", "XF 6 0. 0.4 0. XF 9 0.2 0. 0."])
def test_complex_multipliers_give_way_to_real_ones(load, monkeypatch):
    """Moments that keep their direction: among the multipliers of smallest modulus are complex ones."""
    rows = [f"BEAM {k} {2 * k - 1} {2 * k} {2 * k + 1} {2 * k + 2} 0 1 0 DYNE {k} 1 2 3 4 5 6" for k in range(1, 5)]
    rows += [f"X {2 * k + 1} {k / 4} 0 0" for k in range(5)] + ["FIX 1", "FIX 2", "END HALT"]
    rows += [f"EM {k} 0.1 1e-5 1e-5 ESTIFF {k} 2e3 1 1.5 1.2" for k in range(1, 5)] + [load, "END END"]
    deck = parse_deck("\n".join(rows))
    dense = spacar.run(8, deck, modes=0).frames[-1].matrices["lmult"]
    monkeypatch.setattr(form, "LARGE", 0)
    monkeypatch.setattr(form, "SHARE", 1)
    large = spacar.run(8, deck, modes=5)
    # unsymmetric, with values over three decades, and not refined in the dense matrices
    np.testing.assert_allclose(large.frames[-1].matrices["lmult"], dense[:5], rtol=1e-8)
    assert any("load multipliers are complex (follower loads): they are left out" in line for line in large.report)


def test_outputs_that_vanish_by_symmetry(monkeypatch):
    """The middle of a lattice under a force along z does not move along y: what is left is rounding, which settles at
    no frequency and must not be solved for at each of them."""
    text = frames.deck((2, 2, 2), 9).split("XF")[0] + "END HALT INPUTF 1 45 3 OUTX 1 45 3 OUTX 2 45 2 END END"
    monkeypatch.setattr(form, "LARGE", 0)
    result = spacar.run(9, parse_deck(text))
    system = of_frame(result.frames[-1].state_space, result.header)
    omega = np.geomspace(1.0, 3000.0, 300)
    factored = []
    monkeypatch.setattr(sparse_factors, "splu", lambda *given, **how: factored.append(1) or splu(*given, **how))
    found = response(system, omega)
    assert len(factored) <= 8
    for k in range(0, 300, 60):
        alone = response(system, omega[k : k + 1])[0]
        np.testing.assert_allclose(found[k, 0], alone[0], rtol=1e-8)  # 1e-10 of the state, near poles
        np.testing.assert_allclose(found[k, 1], 0.0, atol=1e-10 * abs(alone[0, 0]))


# Which form modes are computed in: the same numbers on both sides of every decision.
def beam(n: int, mode_block: str = "MODES 3") -> str:
    """A planar cantilever of n elements that do not stretch."""
    rows = [f"PLBEAM {k + 1} {2 * k + 1} {2 * k + 2} {2 * k + 3} {2 * k + 4}" for k in range(n)]
    rows += [f"X {2 * k + 1} {k / n:.9g} 0." for k in range(n + 1)] + ["FIX 1", "FIX 2"]
    rows += [f"DYNE {k + 1} 2 3" for k in range(n)] + ["END", "HALT"]
    rows += [line for k in range(n) for line in (f"EM {k + 1} 0.1", f"ESTIFF {k + 1} 0. 1.5")]
    return "\n".join([*rows, f"XF {2 * n + 1} -1. -0.5", mode_block, "END", "END", ""])


@pytest.mark.parametrize("general", ["", "1"])
@pytest.mark.parametrize("cells", [(9, 2), (2, 1, 1)])
def test_no_jump_where_the_storage_changes(cells, general, monkeypatch):
    """Frequencies, multipliers and compliances of a frame in dense, band and condensed form, by C and by NumPy."""
    monkeypatch.setenv("SPACAR_GENERAL", general)
    deck = parse_deck(frames.deck(cells, 10), mode=10)
    dense = spacar.run(10, deck, modes=0)
    monkeypatch.setattr(form, "LARGE", 3)
    for least, storage in (1e12, "band of "), (0.0, "condensed matrix"):
        monkeypatch.setattr(linear_systems, "CONDENSED", (least, 0.0))
        sparse = spacar.run(10, deck)
        assert any(f"storage of the sparse tangent: {storage}" in line for line in sparse.report)
        for name, power in ("eigval", 2), ("lmult", 1), ("xcompl", 1):
            a, b = (np.sort(np.abs(r[name][-1]).ravel()) ** power for r in (sparse, dense))
            few = b[b > 0.0][: np.count_nonzero(a)]
            np.testing.assert_allclose(a[a > 0.0], few, rtol=0.0, atol=1e-10 * few.max(), err_msg=name)


def test_no_jump_where_the_stored_form_changes():
    """198 to 202 degrees of freedom: 2 n of n elements; frequencies on one smooth curve."""
    found = [spacar.run(7, parse_deck(beam(n))).frames[0].matrices["eigval"][-6:, 1] for n in (99, 100, 101)]
    second = found[0] - 2.0 * found[1] + found[2]
    assert (np.abs(second) < 1e-7 * np.abs(found[1])).all()
