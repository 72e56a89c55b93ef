"""What linear analyses still give when a part of them is impossible, and what they say about it."""

import json
import shutil

import numpy as np
import pytest

import spacar
from spacar.deck import parse_deck
from tests.examples import DATA

FREE_BEAM = """PLBEAM 1 1 2 3 4
X 3 1 0
DYNX 1 1
DYNX 1 2
DYNX 2
DYNE 1 2 3
END
HALT
EM 1 1
ESTIFF 1 0 1
XF 3 1 0
XF 1 -1 0
END
END
"""


def test_motions_free_in_stiffness_and_load_have_no_multiplier_and_leave_the_rest(call, tmp_path):
    """A free beam in tension: K0 and G0 share two rigid motions, and rotation has the multiplier 0.

    Reversed, the beam buckles: -12 and -60 EI/l^2 are those of one cubic element between hinges (exact: -9.87, -39.5).
    """
    (tmp_path / "free.dat").write_text(FREE_BEAM)
    done = call.done(10, "free")
    assert "2 common null vectors" in done.err
    assert "2 common null vectors" in (tmp_path / "free.log").read_text()
    result = spacar.run(10, parse_deck(FREE_BEAM, mode=10))
    multipliers = np.ravel(result["lmult"])
    assert multipliers == pytest.approx([0.0, -12.0, -60.0, np.inf, np.inf], rel=1e-6, abs=1e-9)
    assert np.array_equal(multipliers, np.ravel(spacar.run(8, parse_deck(FREE_BEAM, mode=8))["lmult"]))
    assert result["xcompl"].shape == (1, result.mechanism.numbering.nx)
    assert np.array_equal(result["eigval"], spacar.run(7, parse_deck(FREE_BEAM, mode=7))["eigval"])
    squares = np.sort(np.hypot(*result["eigval"][0].T))[::2] ** 2
    # cubic shape functions: 720 and 8400 EI/(m l^4), raised by the tension N by less than N/EI
    assert squares[:2] == pytest.approx(0.0, abs=1e-4)
    assert 11.9 < squares[2] < 12.0  # rotation: N l theta against m l^2 / 12, lowered a little by bending
    assert np.all((squares[3:] > [720, 8400]) & (squares[3:] < [720 * 1.1, 8400 * 1.1]))


def test_eigen_of_mode_3(call, tmp_path):
    """Eigenvalues of the stored matrices of every step of a linearization along set-points, with names."""
    for name in ("robotinv", "robotinvlin"):
        shutil.copy(DATA / f"{name}.dat", tmp_path)
    assert call(2, "robotinv").status == 0
    assert call(3, "robotinvlin").status == 0
    rows = json.loads(call("eigen", "robotinvlin", "--json", "--at", "3").out)
    result = spacar.run(2, DATA / "robotinv.dat")
    linear = spacar.run(3, DATA / "robotinvlin.dat", nominal=result)
    M, K, C = (linear[name][2] for name in ("m0", "k0b", "c0b"))
    n = len(M)
    A = np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])
    truth = np.linalg.eigvals(A)
    found = np.array([row["real"] + 1j * row["imag"] for row in rows])
    assert len(found) == len(truth)
    for value in found[np.abs(found) > 1e-3]:
        assert np.min(np.abs(truth - value)) <= 1e-9 * abs(value)
    assert {row["dof"] for row in rows} <= {f"element {k} (HINGE) e1 relative rotation" for k in (1, 2, 3)}
