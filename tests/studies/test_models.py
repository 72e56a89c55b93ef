"""Refined, rigid and linear variants of a model against closed forms, energies and each other."""

import numpy as np
import pytest

import spacar
from spacar.deck.rewrite import divide
from spacar.deck.rewrite.refine import flexible_beams, linear_strain, refine, rigid
from spacar.errors import UsageError
from spacar.mechanism import build

BEAM2 = np.array([[4.0, -2.0], [-2.0, 4.0]])  # stiffness of a bending pair, times EI/l^3


def split_pairs(e_p, e_q, n):
    return tuple(np.array(rows) for rows in divide.split_pair(tuple(e_p), tuple(e_q), n))


def test_bending_of_the_parts_has_the_energy_of_the_parent():
    """Both are the same cubic, whose energy 1/2 int EI w''^2 is exact in every part: equal to rounding."""
    rng = np.random.default_rng(1)
    for n in (2, 3, 7):
        e = rng.normal(size=2)
        p, q = split_pairs(e[:1], e[1:], n)
        parts = np.concatenate((p, q), axis=1)
        energy = n**3 * np.einsum("ki,ij,kj->", parts, BEAM2, parts)
        assert energy == pytest.approx(e @ BEAM2 @ e, rel=1e-13)


def test_pure_bending_is_pure_bending_of_the_parts():
    """w'' constant: every part has e_p = e_q, 1/n^2 of the parent's (slope times length)."""
    p, q = split_pairs(np.array([1.0]), np.array([1.0]), 4)
    assert np.allclose(p, 1 / 16, rtol=1e-13)
    assert np.allclose(q, 1 / 16, rtol=1e-13)


def test_preload_does_the_work_of_the_parent():
    """sum sigma e over the parts = sigma e of the parent for every deformation of the parent: same moments."""
    rng = np.random.default_rng(2)
    n = 5
    sigma, e = rng.normal(size=6), rng.normal(size=6)
    table = np.array(divide.split_preload("BEAM", tuple(sigma), n))
    parts = np.empty((n, 6))
    parts[:, 0], parts[:, 1] = e[0] / n, e[1] / n**2
    for p, q in ((2, 3), (4, 5)):
        a, b = split_pairs(e[[p]], e[[q]], n)
        parts[:, p], parts[:, q] = a[:, 0], b[:, 0]
    assert np.sum(table * parts) == pytest.approx(sigma @ e, rel=1e-12)


def test_column_converges_to_eulers_load(deck):
    """Clamped, tip guided, l = EI = 1: pi^2 (keywords DYNX and RLSE); the error of cubic beams falls with n^4."""
    column = deck("column2", 8)
    error = [spacar.run(8, refine(column, n)).frames[-1].matrices["lmult"].min() - np.pi**2 for n in (1, 2, 4)]
    assert error[0] / error[1] == pytest.approx(16, rel=0.1)
    assert error[1] / error[2] == pytest.approx(16, rel=0.1)


def test_mass_and_rigid_motion_are_kept(deck):
    """The slider-crank with a rigid rod is case 1 of the manual (bibliography.md), whatever the mesh.

    Reactions agree to rounding.
    """
    flexible, stiff = deck("crankfl", 1), deck("crank", 1)
    truth = spacar.run(1, stiff, duration=0.01, n_steps=5)
    for n in (1, 3):
        found = spacar.run(1, rigid(refine(flexible, n)), duration=0.01, n_steps=5)
        assert np.allclose(found.node(8, 1), truth.node(6, 1), rtol=1e-12)
        # each rod has the consistent mass of a straight rigid bar: the same for any division
        assert np.allclose(found.node(8, 2, "fxtot"), truth.node(6, 2, "fxtot"), rtol=1e-9, atol=1e-9)


def test_parts_carry_everything_over(deck):
    crank = deck("crankfl", 1)
    text = crank.text.replace("LDEFORM", "").replace("HALT", "HALT\nEDAMP 2 0. 0.5\nESIG 3 1. 2. 3.", 1)
    crank = spacar.deck.parse_deck(text.replace("FIX 1", "FIX 1\nLDEFORM 3", 1), mode=1)
    fine = refine(crank, 3)
    elements = {s.values[0]: s.values[1:] for s in fine.of("PLBEAM")}
    assert elements[2][:2] == (3, 5)
    assert elements[5][2:] == (6, 7)
    assert sorted(elements) == [1, 2, 3, 4, 5, 6, 7]
    assert {s.values for s in fine.of("EM")} == {(n, 0.2225) for n in range(2, 8)}
    assert {s.values for s in fine.of("EDAMP")} == {(n, 0.0, 0.5) for n in (2, 4, 5)}
    assert {s.values[0] for s in fine.of("LDEFORM")} == {3, 6, 7}
    assert [s.values[1] for s in fine.of("ESIG")] == [1.0] * 3
    middle = [s.values[1:] for s in fine.of("X") if s.values[0] > 9]
    assert np.allclose(sorted(x for x, _ in middle), [0.2, 0.25, 0.35, 0.4], rtol=1e-14)


def test_start_deformations_give_the_same_shape():
    """A beam bent by e2 = e3 = a: the tip agrees to the second order in a that the linear theory leaves out."""
    rows = [("PLBEAM", 1, 1, 2, 3, 4), ("X", 3, 1.0, 0.0), ("FIX", 1), ("FIX", 2), ("DYNE", 1, 2, 3)]
    for a in (1e-2, 1e-3):
        start = [("EM", 1, 1.0), ("ESTIFF", 1, 0.0, 1.0), ("STARTDE", 1, 2, a, 0.0), ("STARTDE", 1, 3, a, 0.0)]
        coarse = spacar.Deck.build(rows, start, mode=1)
        tip = [spacar.run(1, d).frames[0].x for d in (coarse, refine(coarse, 4))]
        meshes = [build(d).numbering for d in (coarse, refine(coarse, 4))]
        x = [t[n.x_index(3, 2)] for t, n in zip(tip, meshes, strict=True)]
        assert abs(x[0]) > 0.5 * a
        assert abs(x[1] - x[0]) < a**2


def test_what_cannot_be_split(deck):
    rows = [("PLBEAM", 1, 1, 2, 3, 4), ("X", 3, 1.0, 0.0), ("FIX", 1), ("FIX", 2)]
    mass = [("EM", 1, 1.0), ("ESTIFF", 1, 0.0, 1.0)]
    with pytest.raises(UsageError, match="no flexible"):
        refine(deck("crank", 1), 2)
    with pytest.raises(UsageError, match="no beam with dynamic"):
        rigid(deck("crank", 1))
    with pytest.raises(UsageError, match="no flexible beam with non-linear"):
        linear_strain(deck("crank", 1))
    with pytest.raises(UsageError, match="released without stiffness"):
        refine(spacar.Deck.build([*rows, ("DYNE", 1, 2, 3), ("RLSE", 1, 1)], mass, mode=1), 2)
    with pytest.raises(UsageError, match=r"different classes \(DYNE, fixed\)"):
        refine(spacar.Deck.build([*rows, ("DYNE", 1, 2)], mass, mode=1), 2)
    with pytest.raises(UsageError, match="MEE 1: it is about beam 1"):
        refine(spacar.Deck.build([*rows, ("DYNE", 1, 2, 3)], [*mass, ("MEE", 1, 2, 1.0)], mode=1), 2)
    with pytest.raises(UsageError, match="1 or more"):
        refine(deck("crankfl", 1), 0)


def test_linear_strain_is_ldeform(deck):
    column = linear_strain(deck("plbeam5", 7))
    assert [s.values for s in column.of("LDEFORM")] == [(n,) for n in range(1, 6)]
    with pytest.raises(UsageError, match="non-linear"):
        linear_strain(column)


def test_flexible_beams(deck):
    assert sorted(flexible_beams(deck("crankfl", 1))) == [2, 3]
    assert sorted(flexible_beams(deck("column2", 8))) == [1, 2]
    assert flexible_beams(deck("robotsim", 1)) == {}
