"""Mode 3 of a large model: the sparse equations of all degrees of freedom, prescribed ones too, are those of the full
matrices; and the warning about inertia that is rounding."""

import numpy as np
import pytest

import spacar
from spacar import Deck
from spacar.errors import AnalysisError, UsageError
from spacar.linear import form
from spacar.simulation.time_varying import TimeVarying
from tests.dynamics.test_mass_check import in_line
from tests.examples import DATA

PAIRS = [("robotinv", "robotinvlin"), ("robotflexinv", "robotflexinvlin")]


@pytest.mark.parametrize(("first", "second"), PAIRS)
def test_the_sparse_form_is_that_of_the_full_matrices(first, second, monkeypatch):
    """A, B, C after elimination; set-points and stresses are the same numbers."""
    nominal = spacar.run(2, DATA / f"{first}.dat")
    full = spacar.run(3, DATA / f"{second}.dat", nominal=nominal)
    monkeypatch.setattr(form, "LARGE", 0)
    sparse = spacar.run(3, DATA / f"{second}.dat", nominal=nominal)
    assert any("sparse linearized equations" in line for line in sparse.report)
    assert "A" not in sparse.frames[0].state_space
    for name in ("u0", "y0", "sig0"):
        np.testing.assert_array_equal(sparse[name], full[name])
    a, b = (TimeVarying.of(r) for r in (full, sparse))
    assert b.D is None
    for name in "ABC":  # the elimination loses some digits, as in modes 4 and 9
        mine, theirs = getattr(b, name), getattr(a, name)
        size = np.abs(theirs).max(initial=1e-300)
        np.testing.assert_allclose(mine, theirs, rtol=0, atol=1e-9 * size)
    with pytest.raises(UsageError, match="MODES 0"):
        b.need("m0")
    everything = spacar.run(3, DATA / f"{second}.dat", nominal=nominal, modes=0)
    np.testing.assert_array_equal(everything["A"], full["A"])


@pytest.mark.parametrize("tilt", [0.0, 0.3])
def test_inertia_of_rounding_is_said(tilt):
    """The slider carries the mass and stands at its dead point: the crank's own motion has no inertia."""
    rows = in_line(tilt, 1e-4)
    deck = Deck.build(rows, [("XM", 3, 1.0), ("ESTIFF", 3, 100.0)], mode=8)
    nominal = spacar.run(8, deck)
    try:
        text = " ".join(spacar.run(3, deck, nominal=nominal).report)
    except AnalysisError as error:
        text = str(error)
    assert "is that of rounding" in text or "singular mass matrix" in text
    crank = Deck.build(rows, [("XM", 2, 1e-8), ("XM", 3, 1.0), ("ESTIFF", 3, 100.0)], mode=8)
    assert "inertia" not in " ".join(spacar.run(3, crank, nominal=spacar.run(8, crank)).report)
