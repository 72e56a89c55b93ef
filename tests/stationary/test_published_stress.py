"""The largest stress of the published leaf-spring guide (SPACAR Light, 20 mm to both sides) against exact rods."""

import numpy as np
import pytest
from spacar_drawing.picture_source import source_of_result
from spacar_drawing.stresses import along, resultants

import spacar
from spacar.deck import parse_deck
from tests.examples import DATA

from . import planar_models as models
from . import rods

MODEL = DATA / "published" / "leafspring_guide.dat"
WIDTH, THICKNESS = 0.05, 5e-4


@pytest.fixture(scope="module")
def moments() -> np.ndarray:
    """At the clamps of both leaves [N m], and the normal forces there [N]: the leaves stand upright."""
    EA, EI = models.section(THICKNESS)
    return np.abs(rods.clamps(models.GUIDE, (0.0, 0.1), EA, EI, 0.02 * np.linspace(0.1, 1.0, 10)))[:, [2, 1]]


def test_largest_stress_of_the_published_guide(moments):
    """654 MPa at 20 mm, in the compressed leaf at its clamp, with three beams a leaf; 2 % below the exact rods."""
    source = source_of_result(spacar.run(8, MODEL))
    found = {}
    for e in source.scene.elements:
        r = resultants(source.scene, e, source.get("sig", 10), source.get("e", 10), 3)
        assert r is not None
        stress = along("mises", r, source.settings.beams[e.number])
        assert stress is not None
        found[e.number] = stress
    assert found[1].max() == found[1][0] == pytest.approx(654e6, abs=0.5e6)
    exact = moments @ [6.0 / (WIDTH * THICKNESS**2), 1.0 / (WIDTH * THICKNESS)]
    assert [found[1][0], found[8][-1]] == pytest.approx(exact, rel=0.025)


def test_the_moment_at_the_clamp_converges_to_that_of_the_rod(moments):
    """The 2 % are those of three beams: the error falls by four with every halving."""
    errors = []
    for n in (6, 12):
        text, _ = models.guide(n, THICKNESS, 0.02)
        source = source_of_result(spacar.run(8, parse_deck(text, mode=8)))
        last, e = len(source.x()), source.scene.elements[0]
        r = resultants(source.scene, e, source.get("sig", last), source.get("e", last), 2)
        assert r is not None
        errors.append(moments[0, 0] - abs(r.Mz[0]))
    assert 0.0 < errors[1] < 2e-3 * moments[0, 0]
    assert abs(np.log2(errors[0] / errors[1]) - 2.0) < 0.15
