"""The constraint analysis of large models with sparse matrices: the same as that with singular values."""

import numpy as np
import pytest
from models import cantilever
from scipy.sparse import csr_array

import spacar
from spacar.kinematics import diagnosis, self_stress
from spacar.kinematics.null_space import norm_estimate, null_space, on_null_space

from .guides import guide

SIZES = [(90, 90, 87), (100, 80, 80), (80, 100, 75), (60, 60, 60), (200, 200, 180)]


@pytest.mark.parametrize(("m", "n", "rank"), SIZES)
def test_null_space_of_a_random_matrix(m, n, rank):
    """Against the definition: A x = 0 to rounding, as many vectors as the rank leaves, smallest value beside it."""
    rng = np.random.default_rng(m + n + rank)
    A = rng.standard_normal((m, rank)) @ rng.standard_normal((rank, n)) * (np.arange(n) % 3 + 0.1)
    s = np.linalg.svd(A, compute_uv=False)
    sparse = csr_array(A)
    size = norm_estimate(sparse)
    assert 0.9 * s[0] < size <= s[0] * (1 + 1e-12)
    X, others = null_space(sparse, size, 1.5e-8)
    assert X.shape == (n, n - rank)
    np.testing.assert_allclose(X.T @ X, np.eye(n - rank), atol=1e-13)
    assert np.max(np.abs(A @ X), initial=0.0) < 100 * np.finfo(float).eps * s[0]
    assert others[0] == pytest.approx(s[rank - 1], rel=1e-7)
    z = rng.standard_normal((n, 3))
    v = on_null_space(sparse, size, z)
    np.testing.assert_allclose(v, X @ (X.T @ z), atol=1e-9)


def both_ends_clamped(n: int) -> str:
    return cantilever(n).replace("FIX 1\n", f"FIX 1\nFIX {2 * n + 1}\nFIX {2 * n + 2}\n")


MODELS = {
    "leaves": lambda: guide(9),
    "clamped": lambda: both_ends_clamped(40),
    "loose": lambda: cantilever(40).replace("FIX 1\n", "").replace("DYNE 20 2 3\n", ""),
    "regular": lambda: cantilever(30),
}


@pytest.mark.parametrize("name", MODELS)
def test_sparse_and_full_decomposition_agree(name, monkeypatch):
    """Numbers, shares and advice are the same; shares to 1e-9, with which they are rounded."""
    deck = spacar.parse_deck(MODELS[name](), mode=0)
    full = spacar.run(0, deck).header["diagnosis"]
    monkeypatch.setattr(diagnosis, "LARGEST_DECOMPOSED", 0)
    monkeypatch.setattr(self_stress, "LARGEST_DECOMPOSED", 0)
    sparse = spacar.run(0, deck).header["diagnosis"]
    assert (sparse.over, sparse.under) == (full.over, full.under)
    assert sparse.releases == full.releases
    assert sparse.freedoms == full.freedoms
    assert sparse.paste == full.paste
    assert [p.name for p in sparse.parts] == [p.name for p in full.parts]
    np.testing.assert_allclose([p.share for p in sparse.parts], [p.share for p in full.parts], atol=2e-9)
    if np.isfinite(full.condition):
        assert sparse.condition == pytest.approx(full.condition, rel=0.1)  # the norm is known to some percent
