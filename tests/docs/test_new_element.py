"""The worked example of the developer guide: its texts, put into the tables, give an element that works."""

from __future__ import annotations

import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

import spacar
from spacar.deck import table, table_elements
from spacar.deck.table_types import Block
from tests.docs.documents import blocks
from tests.elements.derivatives import check_stiffness, check_strain, group

GUIDE = Path(__file__).resolve().parents[2] / "docs" / "developer.md"


@pytest.fixture
def cam(monkeypatch):
    """The texts of the guide by name, with PLCAM registered as the guide says."""
    texts = {b.name: b.text for b in blocks(GUIDE) if b.name}
    module = ModuleType("spacar.elements.plcam")
    exec(compile(texts["plcam.py"], "plcam.py", "exec"), module.__dict__)
    monkeypatch.setitem(sys.modules, module.__name__, module)
    (kind,) = eval("(" + texts["table-row"] + ")", dict(vars(table_elements)))
    statement = table_elements._statement(kind)
    monkeypatch.setitem(table_elements.ELEMENT_TYPES, kind.keyword, kind)
    monkeypatch.setitem(table.KEYWORDS, (kind.keyword, Block.KINEMATICS), statement)
    monkeypatch.setitem(table.NAMES[1], kind.keyword, statement.most)
    return texts, module.PlanarCam


def test_derivatives(cam):
    rng = np.random.default_rng(5)
    x0, x, v = rng.normal(size=(3, 3, 4))
    family = cam[1](group("PLCAM", x0, geometry=rng.normal(size=(4, 3)), estiff=[[2.0]] * 4))
    check_strain(family, x, v, rng.normal(size=(1, 4)))
    check_stiffness(family)


def test_motion_force_and_torque(cam):
    """Closed form of the guide. 1e-12: rounding of numbers of the size of the lift, the force and the torque."""
    result = spacar.run(1, spacar.parse_deck(cam[0]["cam.dat"], "cam.dat", 1))
    t, m, a, w = result.t, 0.5, 0.01, 10.0
    y, yd, ydd = 0.1 + a * (1 - np.cos(w * t)), a * w * np.sin(w * t), a * w**2 * np.cos(w * t)
    assert result.node(2, 2) == pytest.approx(y, abs=1e-12)
    assert result.node(2, 2, "xdd") == pytest.approx(ydd, abs=1e-12)
    assert result.element(1, 1, "sig") == pytest.approx(-m * ydd, abs=1e-12)
    assert result.node(1, 1, "fxtot") == pytest.approx(m * ydd * yd / w, abs=1e-12)


def test_mistakes_are_named(cam):
    with pytest.raises(spacar.errors.InputError, match=r"cam\.dat:1: PLCAM.*too few arguments"):
        spacar.parse_deck(cam[0]["cam.dat"].replace("  0. 1. ", "  0. "), "cam.dat", 1)
