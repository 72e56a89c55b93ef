"""The proof that a stationary state is stable, against eigenvalues of the tangent stiffness on admissible motions."""

import numpy as np
import pytest
from statics import cantilever

from spacar.deck import parse_deck
from spacar.errors import Report
from spacar.linear_systems import matrix_inertia
from spacar.mechanism import build
from spacar.stationary import LoadProgram, StationarySolver
from spacar.stationary.resting_tangent import RestingTangent
from tests.examples import DATA

EULER = np.pi**2 / 4.0  # critical load of a clamped column with l = EI = 1, its end free


def column(n: int, force: float) -> str:
    """Clamped column of n inextensible beams, l = EI = 1, pressed by a force along its axis; the state is straight."""
    return cantilever(n).replace(f"XF {2 * n + 1} 0. 10.0", f"XF {2 * n + 1} {-force!r} 0.")


def asked(text: str) -> list[tuple[bool, tuple[int, int], int]]:
    """At every state that the walk looks at: is it proved to be stable, the count, the number of stresses."""
    m = build(parse_deck(text, mode=7), 7)
    found = []
    with pytest.MonkeyPatch.context() as patch:
        proof = RestingTangent.is_definite

        def both(self, point):
            proved = proof(self, point)
            found.append((proved, self.inertia(point), self.t.ne))
            return proved

        patch.setattr(RestingTangent, "is_definite", both)
        solver = StationarySolver(m, Report())
        for level in LoadProgram(m.settings):
            solver.solve(level)
    return found


@pytest.mark.parametrize("n", [2, 8, 40])
@pytest.mark.parametrize("part", [0.5, 0.99, 0.9999])
def test_a_column_below_its_critical_load_is_proved_to_be_stable(n, part):
    # displacement methods have their critical load above that of the continuum
    assert all(proved for proved, *_ in asked(column(n, part * EULER)))


@pytest.mark.parametrize("n", [2, 8, 40])
def test_a_column_beyond_its_critical_load_is_not(n):
    found = asked(column(n, 1.05 * EULER))
    proved, (negative, zero), ne = found[-1]
    assert not proved
    assert (negative, zero) == (ne + 1, 0)


@pytest.mark.parametrize("name", ["plbeam5", "lateral4", "lateral4cw", "leafguide", "crosshingew", "column2", "lever"])
def test_what_is_proved_has_no_negative_eigenvalue(name):
    """In examples, planar and spatial, with warping, rigid parts and prescribed displacements."""
    found = asked((DATA / f"{name}.dat").read_text())
    for proved, (negative, zero), ne in found:
        if proved:
            assert (negative, zero) == (ne, 0)


def test_large_models_are_counted_only_where_nothing_is_proved(monkeypatch):
    """A bent chain of 30 beams, above the limit of dense storage, is stable at all levels: nothing is counted."""
    monkeypatch.setattr(matrix_inertia.Inertia, "__call__", lambda *_: pytest.fail("eigenvalues were counted"))
    m = build(parse_deck(cantilever(30), mode=7), 7)
    solver = StationarySolver(m, Report())
    for level in LoadProgram(m.settings):
        solver.solve(level)
    assert solver._continuation is not None
    assert str(solver._continuation.stable) == "0 negative eigenvalues"
