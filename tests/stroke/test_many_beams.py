"""Large models: the sparse path gives the numbers of the dense one, whatever the drive; and it is fast."""

import time

import numpy as np
import pytest

import spacar
from spacar.deck import parse_deck, read_deck
from spacar.linear import form
from spacar.stroke import station
from spacar.stroke.drive_equations import MixedDrive
from tests.examples import DATA

from . import stroke_models as models
from .test_hinge import column

GUIDE = models.two_leaves(models.GUIDE, 5)
PAYLOAD = {"loads": ["9y=-20"], "extra": ["9y=-4"]}
CASES = {
    "move": (GUIDE, {"move": "9x=+-0.004", "steps": 2} | PAYLOAD),
    "force": (GUIDE, {"force": "9x=20", "steps": 2} | PAYLOAD),
    "deformation": (GUIDE, {"move": "e[3,2]=0.0005", "steps": 1, "node": 9} | PAYLOAD),
    "planar rotation": (models.two_leaves(models.CROSS, 4), {"move": "6r=0.05", "steps": 1}),
    "spatial": (
        column(6, True), {"move": "13x=0.002", "steps": 1, "loads": ["13y=-2", "14rz=0.01"], "extra": ["14rx=0.1"]},
    ),
    "spatial angle": (
        column(6, True),
        {"move": "13x=0.002", "steps": 1, "loads": ["13y=-2", "13z=1"], "extra": ["13z=2"], "beams": "angle"},
    ),
    "spatial moment": (column(6, True), {"force": "14rz=0.05", "steps": 1, "extra": ["13y=-2"]}),
    "warping": (DATA / "crosshingew.dat", {"move": "8rz=0.05", "steps": 1, "extra": ["7y=-1"]}),
    "published": (DATA / "published" / "leafspring_guide.dat", {"steps": 1}),
}  # fmt: skip


@pytest.mark.parametrize("name", [
    pytest.param(n, marks=[pytest.mark.slow] * (n in ("move", "spatial", "spatial moment"))) for n in CASES
])  # fmt: skip
def test_the_same_numbers_without_dense_matrices(name, monkeypatch):
    """Every column. What the dense matrices lose is up to cond^2 eps, of the place of a far pole more."""
    source, asked = CASES[name]
    deck = parse_deck(source) if isinstance(source, str) else read_deck(source, 10)
    dense = spacar.flexure(deck, **asked)
    calls = []
    inner = MixedDrive.path
    monkeypatch.setattr(form, "LARGE", 3)
    monkeypatch.setattr(MixedDrive, "path", lambda *a: calls.append(1) or inner(*a))
    sparse = spacar.flexure(deck, **asked)
    assert len(calls) >= len(sparse)
    theirs = dense.table()
    for column_, values in sparse.table().items():
        expected = theirs[column_]
        assert (np.isfinite(values) == np.isfinite(expected)).all(), column_
        known = np.isfinite(expected)
        size = np.abs(expected[known]).max(initial=0.0)
        limit = 1e-6 if "pivot" in column_ or "pole" in column_ else 2e-7
        np.testing.assert_allclose(values[known], expected[known], rtol=limit, atol=limit * size, err_msg=column_)
    C = dense.compliance()
    np.testing.assert_allclose(sparse.compliance(), C, rtol=1e-6, atol=1e-7 * np.abs(C).max())


def test_what_the_lowest_values_do_not_contain(monkeypatch):
    """A column under tension has negative multipliers only; pushed along its axis it moves in a high mode. What is not
    among the values that are computed is nan or infinite, with a warning."""
    monkeypatch.setattr(form, "LARGE", 3)
    monkeypatch.setattr(station, "FIRST", 1)
    monkeypatch.setattr(station, "MOST", 2)
    deck = parse_deck(column(4, False))
    study = spacar.flexure(deck, move="9y=1e-7", steps=1, modes=1, extra=["9y=1"])
    assert np.isnan(study.of("drive_hertz")).all()
    assert study.of("unwanted_free") == pytest.approx(study.free_frequencies[:, 0])
    assert np.isinf(study.of("extra_free")).all()
    said = "\n".join(study.result.report)
    assert "the motion of the drive is none of the 2 lowest free modes" in said
    assert "none of the 2 lowest multipliers of the extra load is positive" in said


@pytest.mark.slow
def test_a_thousand_elements_take_seconds():
    """24 EI/L^3 and 2 pi^2 EI/L^2; Awtar's support stiffness, 0.2 % too high at 0.04 L."""
    deck = parse_deck(models.two_leaves(models.GUIDE, 500))
    start = time.process_time()
    study = spacar.flexure(deck, move="9x=0.004", steps=4, extra=["9y=-4"])
    assert time.process_time() - start < 60.0
    expected = 2.0 / (models.LENGTH / models.EA + models.LENGTH * study.stroke**2 / (700.0 * models.EI))
    assert study.stiffness()[:, 1] == pytest.approx(expected, rel=3e-3)
    assert study.drive_stiffness[0] == pytest.approx(24.0 * models.EI / models.LENGTH**3, rel=1e-4)
    assert 4.0 * study.of("extra_free")[0] == pytest.approx(2.0 * np.pi**2 * models.EI / models.LENGTH**2, rel=1e-3)
    assert study.of("unwanted_free") == pytest.approx(study.free_frequencies[:, 1])


def test_a_blade_that_turns_keeps_its_reduced_matrices(monkeypatch):
    """In motion there is no sparse tangent of a drive, however large the model is."""
    rows = [f"PLBEAM {k} {2 * k - 1} {2 * k} {2 * k + 1} {2 * k + 2} DYNE {k}" for k in range(1, 5)]
    rows += [f"X {2 * k + 1} {0.1 + k / 4} 0." for k in range(5)] + ["FIX 1", "INPUTX 2 1", "END HALT"]
    rows += [f"EM {k} 0.1 ESTIFF {k} 2e5 1.5" for k in range(1, 5)] + ["INPUTX 2 1 0. 10. 0.", "END END"]
    deck = parse_deck("\n".join(rows))
    small = spacar.flexure(deck, move="x[9,2]=-0.02:0.02", steps=2)
    monkeypatch.setattr(form, "LARGE", 0)
    large = spacar.flexure(deck, move="x[9,2]=-0.02:0.02", steps=2)
    np.testing.assert_array_equal(large.drive_stiffness, small.drive_stiffness)
