"""Which form modes are computed in: the same numbers, and no jump of the work, on both sides of the decision."""

from __future__ import annotations

import numpy as np
import pytest

import spacar
from spacar.deck import parse_deck
from spacar.linear import form


def beam(n: int, mode_block: str = "MODES 3") -> str:
    """A planar cantilever of n elements that do not stretch."""
    rows = [f"PLBEAM {k + 1} {2 * k + 1} {2 * k + 2} {2 * k + 3} {2 * k + 4}" for k in range(n)]
    rows += [f"X {2 * k + 1} {k / n:.9g} 0." for k in range(n + 1)] + ["FIX 1", "FIX 2"]
    rows += [f"DYNE {k + 1} 2 3" for k in range(n)] + ["END", "HALT"]
    rows += [line for k in range(n) for line in (f"EM {k + 1} 0.1", f"ESTIFF {k + 1} 0. 1.5")]
    return "\n".join([*rows, f"XF {2 * n + 1} -1. -0.5", mode_block, "END", "END", ""])


@pytest.mark.parametrize("mode", [7, 10])
def test_few_modes_are_those_of_dense_matrices(mode, monkeypatch):
    """The sparse tangent of 80 elements, which takes less work, and the dense matrices."""
    deck = parse_deck(beam(80))
    sparse = spacar.run(mode, deck)
    assert any("sparse tangent: less work" in line for line in sparse.report)
    assert any("band of 25 diagonals" in line for line in sparse.report)
    monkeypatch.setattr(form, "SHARE", 1000)
    dense = spacar.run(mode, deck)
    assert not any("sparse tangent" in line for line in dense.report)
    for name, width in ("eigval", 6), ("lmult", 3):
        if name in dense.frames[0].matrices:
            a, b = (r.frames[0].matrices[name] for r in (sparse, dense))
            assert a.shape[0] == width
            np.testing.assert_allclose(a, b, rtol=1e-9, atol=1e-9 * np.abs(b).max())
    a, b = (np.abs(r.frames[0].matrices["eigvre"]) for r in (sparse, dense))
    np.testing.assert_allclose(a, b, atol=1e-7)
    assert (sparse.frames[0].matrices["k0"] == dense.frames[0].matrices["k0"]).all()
    if mode == 10:
        np.testing.assert_allclose(sparse.frames[0].xcompl, dense.frames[0].xcompl, rtol=1e-8, atol=1e-12)


def test_no_jump_where_the_stored_form_changes():
    """198 to 202 degrees of freedom: 2 n of n elements; frequencies on one smooth curve."""
    found = [spacar.run(7, parse_deck(beam(n))).frames[0].matrices["eigval"][-6:, 1] for n in (99, 100, 101)]
    second = found[0] - 2.0 * found[1] + found[2]
    assert (np.abs(second) < 1e-7 * np.abs(found[1])).all()


def test_small_models_are_dense():
    """Below 84 beams nothing changes: the count prefers dense matrices up to about a hundred degrees of freedom."""
    result = spacar.run(7, parse_deck(beam(40)))
    assert not any("sparse" in line for line in result.report)
