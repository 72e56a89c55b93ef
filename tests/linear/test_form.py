"""Which form modes are computed in: the same numbers on both sides of every decision."""

import frames
import numpy as np
import pytest

import spacar
from spacar import linear_systems
from spacar.deck import parse_deck
from spacar.linear import form


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
