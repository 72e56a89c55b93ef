"""The sparse form of the linearized equations of large models equals the dense one (theory-system.md 5.7).

Both are assembled from the same element blocks but reduced by different algorithms: transfer functions and products
there, one sparse factorization here. The dense one is compared with differences in test_state_space.py.
"""

import numpy as np
import pytest
from scipy.sparse.linalg import splu

from spacar.linear.state_space import state_space
from spacar.linear_systems import sparse_factors
from spacar.linearization import linearize
from spacar.linearization.coefficients import coefficients
from spacar.linearization.descriptor import DescriptorSystem
from spacar.linearization.signals import linearization_signals
from spacar.linearization.sparse_linearization import SparseLinearization
from spacar.linearization.sparse_response import response

from .nonlinear import Nonlinear, random_state
from .test_state_space import MODELS


def close(found: np.ndarray, expected: np.ndarray, what: str) -> None:
    size = max(np.abs(expected).max(initial=0.0), 1e-300)
    np.testing.assert_allclose(found, expected, atol=1e-10 * size, err_msg=what)


@pytest.fixture(params=MODELS)
def both(request, tmp_path):
    model, scale = MODELS[request.param](tmp_path)
    base = random_state(model, scale, seed=3)
    nonlinear = Nonlinear(model, base)
    signals = linearization_signals(model)
    d = nonlinear.d
    xdd, sigma, _ = d.accelerate(0.0, nonlinear.place(base))
    dense = state_space(d, linearize(d, xdd, sigma), *signals)
    sparse = SparseLinearization(d, *signals)(coefficients(d, xdd, sigma))
    return dense, sparse


def test_eliminated_it_is_the_state_space(both):
    dense, sparse = both
    for name, matrix in zip("ABCD", sparse.state_space(), strict=True):
        close(matrix, getattr(dense, name), name)


def test_frequency_response(both, monkeypatch):
    """Every one of 60 frequencies, by a tenth of the factorizations."""
    factored = []
    monkeypatch.setattr(sparse_factors, "splu", lambda *given, **form: factored.append(1) or splu(*given, **form))
    dense, sparse = both
    omega = np.geomspace(0.3, 40.0, 60)
    eye = np.eye(len(dense.A))
    expected = np.array([dense.C @ np.linalg.solve(1j * w * eye - dense.A, dense.B) + dense.D for w in omega])
    found = response(sparse, omega)
    assert len(factored) <= 6
    for k in range(len(omega)):
        close(found[k], expected[k], f"response at {omega[k]}")


def test_tables_of_entries_and_back(both):
    _, sparse = both
    n_u, n_y = sparse.B.shape[1], sparse.C.shape[0]
    again = DescriptorSystem.of_entries(sparse.entries(), sparse.n_states, n_u, n_y)
    for name in "ABC":
        assert np.array_equal(getattr(again, name).toarray(), getattr(sparse, name).toarray())
