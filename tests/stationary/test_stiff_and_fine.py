"""Displacements under forces of the size of the stiffness are large where a model is soft in one way, stiff in another
and finely divided; that is no singularity as long as rounding of the entries leaves digits."""

import numpy as np
import pytest

import spacar
from spacar.deck import Deck
from spacar.errors import AnalysisError
from spacar.linear_systems.reciprocal_condition import entry_rounding, lost

N = 60


def cantilever(EA, *more):
    beams = [("PLBEAM", i + 1, 2 * i + 1, 2 * i + 2, 2 * i + 3, 2 * i + 4) for i in range(N)]
    places = [("X", 2 * i + 1, i / N, 0.0) for i in range(1, N + 1)]
    held = [("FIX", 1), ("FIX", 2), *(("DYNE", i + 1, 1, 2, 3) for i in range(N))]
    rows = [("ESTIFF", i + 1, EA, 1.0) for i in range(N)] + [("EM", i + 1, 1.0) for i in range(N)]
    return Deck.build(beams + places + held, [*rows, *more], mode=7)


@pytest.mark.parametrize("EA", [1e4, 1e12, 1e15])
def test_a_soft_cantilever_that_hardly_stretches(EA):
    """Tip under a transverse load: P L^3/(3 EI), less 4/35 P^2 of it (next term of the elastica's series at small P);
    frequencies from cos b cosh b = -1; both whatever the axial stiffness is."""
    P = 1e-3
    result = spacar.run(7, cantilever(EA, ("XF", 2 * N + 1, 0.0, P), ("ITERSTEP", 10, 1, 1e-9)), beams="angle")
    assert result.node(2 * N + 1, 2)[-1] == pytest.approx(P / 3.0, rel=P**2 + 1e-8)
    lowest = 2.0 * np.pi * result.frequencies[-1][:2]
    np.testing.assert_allclose(lowest, (1.8751040687119611**2, 4.694091132974175**2), rtol=2e-6)


def test_a_motion_without_stiffness_is_still_refused():
    """The same beam with its clamp turned into a pin: nothing resists the load."""
    beams = cantilever(1e15, ("XF", 2 * N + 1, 0.0, 1.0))
    rows = [(s.keyword, *s.values) for s in beams.statements if s.block == 1 and (s.keyword, *s.values) != ("FIX", 2)]
    loads = [(s.keyword, *s.values) for s in beams.statements if s.block == 2]
    with pytest.raises(AnalysisError, match=r"without stiffness|singular"):
        spacar.run(7, Deck.build([*rows, ("DYNX", 2)], loads, mode=7))


def test_lost_digits_tell_a_singular_matrix_from_a_soft_one():
    """diag(1, 1e-20) keeps all digits of every solution, [[1, 1], [1, 1 + eps]] none."""

    def of(A):
        rows, columns = map(np.ravel, np.indices(A.shape))
        z = np.linalg.solve(A, np.array([1.0, 1.5]))
        return lost(lambda b: np.linalg.solve(A, b), entry_rounding(2, rows, columns, A.ravel(), z), z, 2)

    assert of(np.diag([1.0, 1e-20])) < 1e-15
    assert of(np.array([[1.0, 1.0], [1.0, 1.0 + 2**-52]])) > 0.1
