"""Every element type, moments, MEE and prescribed motions in lanes: cases with other lengths and masses are their
single runs, and their numbers, made for all cases at once, are those of decks of their own."""

import numpy as np
import pytest

import spacar
from spacar.compiled.library import why_off
from spacar.compiled.numbers import of_one
from spacar.compiled.numbers_of_cases import same
from spacar.deck import ELEMENT_TYPES
from spacar.dynamics.loaded_mechanism import LoadedMechanism
from spacar.mechanism import build
from spacar.studies.affine_cases import FEWEST, affine_cases
from spacar.studies.assignments import change, setting
from spacar.studies.ensemble import why_not
from tests.ensembles import ensemble, followed

from .all_elements import MODELS, deck_of

pytestmark = pytest.mark.skipif(why_off() is not None, reason=str(why_off()))
TOLERANCE = 1e-9


def test_every_type_is_there():
    used = {row[0] for kinematics, _ in MODELS.values() for row in kinematics}
    assert set(ELEMENT_TYPES) - {"PLBEAR"} <= used  # which has no equations


def varied(name):
    """Settings of a position and a mass, and values of FEWEST cases in no order."""
    deck = deck_of(name)
    x = next(s for s in deck.of("X", block=1) if s.values[0] == 3)
    mass = deck.of("XM", block=2)[0]
    axis = 0 if "WHEEL" not in name or name.startswith("PL") else 1
    settings = setting(f"X.3[{axis + 2}]"), setting(f"XM.{mass.values[0]}[2]")
    random = np.random.default_rng(3).random((FEWEST, 2))
    place = x.values[1 + axis] + 0.1 * (random[:, 0] if axis == 0 else 0.0 * random[:, 0])
    return deck, settings, np.column_stack((place, mass.values[1] * (1.0 + random[:, 1]))).tolist()


@pytest.mark.parametrize("name", MODELS)
def test_numbers_of_all_cases_are_those_of_their_decks(name):
    deck, settings, values = varied(name)
    cases = affine_cases(deck, settings, values)
    assert cases is not None
    assert list(cases.chosen) == list(range(FEWEST))
    for k in range(0, FEWEST, 3):
        own = of_one(LoadedMechanism.of(build(change(deck, settings, values[k]), 1)))
        assert same(own, cases.numbers.take(np.array([k]))), k


@pytest.mark.parametrize("name", MODELS)
def test_every_case_is_its_single_run(name):
    deck, settings, values = varied(name)
    options = {"rtol": TOLERANCE, "atol": TOLERANCE}
    assert not why_not(deck, **options)
    cases = affine_cases(deck, settings, values, **options)
    results = followed(cases, **options)
    decks = [change(deck, settings, v) for v in values]
    of_decks = ensemble(decks[:3], **options)
    for k in (0, 1, FEWEST - 1):
        single = spacar.run(1, decks[k], **options)
        for found in (results[k], *of_decks[k : k + 1]):
            assert found is not None
            for variable in ("x", "xd", "e", "sig", "fxtot"):
                want = single[variable]
                size = max(1.0, np.abs(want).max())
                np.testing.assert_allclose(found[variable], want, atol=100 * TOLERANCE * size, rtol=0, err_msg=variable)
