"""The sign of the determinant, which tells of unsymmetric tangents whether the negative eigenvalues are even or odd."""

import numpy as np
import pytest

import spacar
from spacar.deck import parse_deck
from spacar.linear_systems import assemble

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
    return [w for w in spacar.run(8, parse_deck(f"{BAR}{loads}\nEND\nEND\n", mode=8)).report if "critical" in w]


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
