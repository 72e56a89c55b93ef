"""Numbering and classification against tables that were written by hand from files.md section 3."""

import numpy as np
import pytest

from spacar import Deck
from spacar.mechanism import Mechanism, build

PLANAR = (
    ("PLBEAM", 3, 1, 2, 5, 6), ("PLTOR", 7, 6, 9), ("PLTRUSS", 1, 5, 4), ("X", 5, 1.0, 0.0), ("X", 4, 1.0, 1.0),
    ("DYNX", 4, 2), ("INPUTX", 4, 1), ("FIX", 2), ("FIX", 1), ("RLSE", 3, 1), ("INPUTE", 7, 1), ("DYNE", 3, 3),
)  # fmt: skip
SPATIAL = (
    ("BEAM", 5, 1, 3, 6, 8, 0.0, 1.0, 0.0), ("HINGE", 2, 4, 3, 0.0, 0.0, 1.0), ("X", 6, 1.0, 0.0, 0.0), ("FIX", 1),
    ("FIX", 4), ("INPUTE", 2, 1), ("DYNE", 5, 3, 5), ("RLSE", 5, 2),
)  # fmt: skip
ROLLING = (
    ("RBEAM", 1, 1, 2, 3, 1.0, 0.0, 0.0), ("HINGE", 2, 2, 4, 0.0, 1.0, 0.0), ("WHEEL", 3, 3, 4, 5, 0.0, 1.0, 0.0),
    ("X", 1, 0.0, 0.0, 0.3), ("X", 3, 0.0, 0.5, 0.3), ("X", 5, 0.0, 0.5, 0.0), ("DYNX", 1, 1), ("KINX", 1, 2),
    ("KINE", 2, 1),
)  # fmt: skip


def mechanism(rows: tuple, dynamics: tuple = ()) -> Mechanism:
    return build(Deck.build(rows, dynamics))


def nonzero(table: np.ndarray) -> dict[int, list[int]]:
    """Rows of a 1-based table that are not empty, by number."""
    return {i: row[row != 0].tolist() for i, row in enumerate(table, 1) if row.any()}


def test_planar_tables() -> None:
    n = mechanism(PLANAR).numbering
    # fixed 1x 1y 2phi | calculable 5x 5y 6phi 9phi | input 4x | dynamic 4y
    assert nonzero(n.lnp) == {1: [1, 2], 2: [3], 4: [8, 9], 5: [4, 5], 6: [6], 9: [7]}
    assert n.lnp.shape == (9, 4)
    # fixed 1:e1 3:e2 | input 7:e1 | dynamic 3:e3 | calculable 3:e1
    assert nonzero(n.le) == {1: [1], 3: [5, 2, 4], 7: [3]}
    assert n.le.shape == (7, 6)
    assert nonzero(n.ln) == {1: [5, 4], 3: [1, 2, 5, 6], 7: [6, 9]}
    assert n.ln.shape == (7, 4)
    assert n.it.tolist() == [7, 0, 5, 0, 0, 0, 6]
    assert n.nxp.tolist() == [3, 4, 1, 1, 0]
    assert n.nep.tolist() == [2, 1, 1, 1, 0]
    assert (n.nx, n.ne, n.ndof, n.nddof, n.nkdof, n.nkddof) == (9, 5, 4, 2, 4, 2)
    assert n.q_names == ["node 4 x", "node 4 y", "element 7 (PLTOR) e1 relative rotation", n.e_name(3)]
    assert n.dynamic.tolist() == [1, 3]
    assert n.rheonomic.tolist() == [0, 2]


def test_spatial_tables_put_the_normalizations_last_among_the_fixed() -> None:
    n = mechanism(SPATIAL).numbering
    # fixed 1xyz, 4: lambda1..3 | calculable 3: 4, 4: lambda0, 6xyz, 8: 4
    assert nonzero(n.lnp) == {
        1: [1, 2, 3], 3: [7, 8, 9, 10], 4: [11, 4, 5, 6], 6: [12, 13, 14], 8: [15, 16, 17, 18],
    }  # fmt: skip
    # fixed 2:e2 e3, 5:e1 e4 e6, normalizations of 3, 4, 8 | input 2:e1 | dynamic 5:e3 e5 | calculable 5:e2
    assert nonzero(n.le) == {2: [9, 1, 2], 5: [3, 12, 10, 4, 11, 5]}
    assert n.normalization.tolist() == [[3, 5], [4, 6], [8, 7]]
    assert n.nxp.tolist() == [6, 12, 0, 0, 0]
    assert n.nep.tolist() == [8, 1, 1, 2, 0]
    assert n.e_name(6) == "normalization of node 4"
    assert nonzero(n.ln) == {2: [4, 3], 5: [1, 3, 6, 8]}
    assert n.it.tolist() == [0, 3, 0, 0, 1]


def test_kinematic_classes_come_between_dynamic_and_calculable_deformations() -> None:
    n = mechanism(ROLLING).numbering
    assert n.nxp.tolist() == [0, 3 + 3 + 3 + 4 + 4 - 2, 0, 1, 1]
    assert n.x_index(1, 1) == n.nx - 2
    assert n.x_index(1, 2) == n.nx - 1
    # fixed: RBEAM 3, HINGE 2, WHEEL 6, normalizations 2; then kinematic
    assert n.nep.tolist() == [13, 0, 0, 0, 1]
    assert n.e_index(2, 1) == n.ne - 1
    assert n.e_class["kinematic"] == slice(13, 14)
    assert n.slips.nonzero()[0].tolist() == [n.e_index(3, 5), n.e_index(3, 6)]
    assert (n.ndof, n.nddof, n.nkdof, n.nkddof) == (1, 1, 3, 3)
    assert n.k_names == ["node 1 y", n.e_name(13)]


def test_the_order_of_statements_does_not_matter() -> None:
    rng = np.random.default_rng(0)
    n = mechanism(SPATIAL).numbering
    for _ in range(5):
        other = mechanism(tuple(SPATIAL[i] for i in rng.permutation(len(SPATIAL)))).numbering
        for name in ("lnp", "le", "ln", "it", "nxp", "nep"):
            np.testing.assert_array_equal(getattr(other, name), getattr(n, name))


@pytest.mark.parametrize(
    ("keyword", "node", "expected"),
    [
        ("FIX", 1, {(1, 1), (1, 2), (1, 3)}),  # all independent coordinates of a position node
        ("FIX", 3, {(3, 2), (3, 3), (3, 4)}),  # lambda1..3; lambda0 follows from the normalization
        ("DYNX", 3, {(3, 2), (3, 3), (3, 4)}),
        ("INPUTX", 6, {(6, 1), (6, 2), (6, 3)}),
    ],
)
def test_default_coordinates_of_a_class(keyword: str, node: int, expected: set[tuple[int, int]]) -> None:
    n = mechanism((("BEAM", 5, 1, 3, 6, 8, 0.0, 1.0, 0.0), ("X", 6, 1.0), (keyword, node))).numbering
    name = {"FIX": "fixed", "DYNX": "dynamic", "INPUTX": "input"}[keyword]
    place = n.x_class[name]
    assert {n.x_owner(i) for i in range(place.start, place.stop)} == expected


def test_default_modes_of_a_class_and_a_planar_orientation() -> None:
    for keyword, name in (("RLSE", "calculable"), ("DYNE", "dynamic"), ("INPUTE", "input")):
        n = mechanism((("PLBEAM", 1, 1, 2, 3, 4), ("X", 3, 1.0), (keyword, 1))).numbering
        place = n.e_class[name]
        assert [n.e_owner(i) for i in range(place.start, place.stop)] == [(1, 1), (1, 2), (1, 3)]
    n = mechanism((("PLBEAM", 1, 1, 2, 3, 4), ("X", 3, 1.0), ("FIX", 2), ("FIX", 1))).numbering
    assert n.nxp.tolist() == [3, 3, 0, 0, 0]  # it has one coordinate


def test_reference_configuration() -> None:
    m = mechanism(SPATIAL)
    n = m.numbering
    assert m.x0[n.lnp[5, :3] - 1].tolist() == [1.0, 0.0, 0.0]
    for node in (3, 4, 8):
        assert m.x0[n.lnp[node - 1] - 1].tolist() == [1.0, 0.0, 0.0, 0.0]
    assert m.length == pytest.approx(1.0)
