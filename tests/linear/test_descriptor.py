"""The sparse form of the linearized equations of large models equals the dense one (theory-system.md 5.7).

Both are assembled from the same element blocks but reduced by different algorithms: transfer functions and products
there, one sparse factorization here. The dense one is compared with differences in test_state_space.py; responses to
frequencies, resolvents and stored tables are in the relation "sparse form" of tests/combinations.
"""

import numpy as np
import pytest

from spacar.linear.state_space import state_space
from spacar.linearization import linearize
from spacar.linearization.coefficients import coefficients
from spacar.linearization.signals import linearization_signals
from spacar.linearization.sparse_linearization import SparseLinearization

from .nonlinear import Nonlinear, random_state
from .test_state_space import MODELS


@pytest.mark.parametrize("name", MODELS)
def test_eliminated_it_is_the_state_space(name, tmp_path):
    model, scale = MODELS[name](tmp_path)
    base = random_state(model, scale, seed=3)
    nonlinear = Nonlinear(model, base)
    signals = linearization_signals(model)
    d = nonlinear.d
    xdd, sigma, _ = d.accelerate(0.0, nonlinear.place(base))
    dense = state_space(d, linearize(d, xdd, sigma), *signals)
    sparse = SparseLinearization(d, *signals)(coefficients(d, xdd, sigma))
    for letter, found in zip("ABCD", sparse.state_space(), strict=True):
        expected = getattr(dense, letter)
        size = max(np.abs(expected).max(initial=0.0), 1e-300)
        np.testing.assert_allclose(found, expected, atol=1e-10 * size, err_msg=letter)
