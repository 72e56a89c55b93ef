"""Numbering beside statements about nodes that nobody uses, owners of coordinates, and tensors that meet in a node."""

import numpy as np
import pytest

from spacar.deck import parse_deck
from spacar.mechanism import build

BAR = "PLBEAM 1 1 2 3 6\nX 3 1. 0.\nFIX 1\n{}\nEND\nHALT\nEM 1 1.\nTIMESTEP 1 1\nEND\nEND\n"


@pytest.mark.parametrize("statement", ["FIX 9", "FIX 9 2", "FIX 4 1", "FIX 5", "FIX 0"])
def test_a_statement_about_an_unused_node_changes_no_class(statement):
    with_it, without = (build(parse_deck(BAR.format(s))).numbering for s in (statement, ""))
    assert with_it.x_class == without.x_class
    assert with_it.x_places.tolist() == without.x_places.tolist()


SPATIAL = """
BEAM 7 1 2 3 4 0. 1. 0.   BEAM 3 3 4 5 8 0. 1. 0.   X 1 0. 0. 0.   X 3 2. 0. 0.   X 5 2. 0. 4.
FIX 1   FIX 2   DYNE 3 2 3   END HALT
XM 4 0.5   EM 7 1. 10. 2. 3. 0.25   EM 3 1. 20. 4. 5. 0.5   TIMESTEP 1 1   END END
"""


def test_coordinates_know_their_nodes():
    n = build(parse_deck(SPATIAL)).numbering
    assert n.x_node.tolist() == [n.x_owner(i)[0] for i in range(n.nx)]


def test_tensors_of_all_elements_and_of_xm_add_up_in_a_node():
    """Half the rotary inertia of each beam, turned from its frame to the axes, theory-spatial.md section 1."""
    bodies = next(b.family for b in build(parse_deck(SPATIAL)).batches if b.family.keyword == "rigid body")
    along_x = np.array([[10.0, 0.0, 0.0], [0.0, 2.0, 0.25], [0.0, 0.25, 3.0]])  # x', y', z' are x, y, z; half of 2 m
    turn = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])  # columns x' = z, y' = y, z' = -x
    local = np.array([[20.0, 0.0, 0.0], [0.0, 4.0, 0.5], [0.0, 0.5, 5.0]])
    along_z = 2.0 * turn @ local @ turn.T
    given = np.diag([0.5, 0.0, 0.0])
    assert bodies.numbers.tolist() == [2, 4, 8]
    for k, expected in enumerate((along_x, along_x + along_z + given, along_z)):
        np.testing.assert_allclose(bodies.J[..., k], expected, rtol=0.0, atol=1e-14 * 40.0)
