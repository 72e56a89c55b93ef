"""Four meshes of one model: the estimate from two extrapolations; spectra of refined models keep the user's places."""

import numpy as np
import pytest
from models import cantilever

import spacar
from spacar.deck import parse_deck
from spacar.errors import AnalysisError
from spacar.studies.policies import mesh as mesh_accuracy
from spacar.studies.runs.mesh_ladder import MARGIN, extrapolate

BETA = np.array((1.8751040687119611, 4.694091132974175))  # cos b cosh b = -1


def levels(count):
    """u + c h^2 + d h^4 + f h^6 at h = 0.2, 0.1 ...; u (4, 3), and u."""
    u, c, d, f = np.random.default_rng(3).uniform(0.5, 1.5, size=(4, 4, 3))
    return [u + c * h**2 + d * h**4 + f * h**6 for h in 0.2 * 0.5 ** np.arange(count)], u


def test_an_order_seen_twice_is_trusted_further():
    """The estimate bounds the true error and is below what one extrapolation may claim."""
    meshes, u = levels(4)
    ones = np.ones(4)
    once, twice = extrapolate(meshes[1:], ones), extrapolate(meshes, ones)
    error = np.abs(twice.values - u).max(axis=1)
    assert (error <= twice.errors).all()
    assert (twice.errors <= 30.0 * error).all()
    assert (twice.errors < 0.2 * once.errors).all()


@pytest.mark.parametrize("small", [0.0, 1e-5, 1e-4, 1e-3])
@pytest.mark.parametrize("higher", [0.0, -0.3, -1.0])
def test_what_order_four_leaves_is_in_the_estimate(small, higher):
    """u + c h^2 + h^4 + e h^6: coarse meshes show order 4 with a small c, and c is what stays."""
    meshes = [np.array([[1.0 + small * h**2 + h**4 + higher * h**6]]) for h in (0.2, 0.1, 0.05)]
    found = extrapolate(meshes, np.ones(1))
    error = abs(found.values[0, 0] - 1.0)
    assert found.order == 4
    assert 0.99 * MARGIN * error - 1e-13 <= found.error <= 30.0 * error + 1e-13


def test_another_order_before_changes_nothing():
    meshes, u = levels(4)
    meshes[0] = u + 16.0 * (meshes[1] - u)
    once = extrapolate(meshes[1:], np.ones(4))
    np.testing.assert_array_equal(extrapolate(meshes, np.ones(4)).errors, once.errors)


def test_eigenvalues_keep_their_places():
    """102 freedoms become 204, of which only the lowest modes are computed: the lowest eigenvalue still is the last one
    of the list of the user's mesh, by its index too, and what was not computed is nan."""
    deck = parse_deck(cantilever(51, EI=1.0, length=1.0), mode=7)
    plain = spacar.run(7, deck)
    count = len(plain["eigval"][-1])
    result = spacar.run(7, deck, accuracy=1e-5, variables=[f"abs(eigval[{count}])"])
    values = result["eigval"][-1]
    assert values.shape == plain["eigval"][-1].shape == (204, 2)
    assert result["eigvre"].shape == plain["eigvre"].shape
    assert max(result.header["accuracy"].pieces.values()) == 2
    np.testing.assert_allclose(np.abs(values[[-2, -4], 1]), np.sort(BETA**2), rtol=1e-6)
    assert np.isnan(values[0]).all()


@pytest.mark.parametrize("beams", [1, 2])
def test_a_mesh_that_fails_leaves_the_last_answer(monkeypatch, beams):
    """What three meshes said is shown with its own estimate when the next one cannot be solved; of two beams each was
    divided by itself in between, which is not what is shown."""
    text = cantilever(beams, load="0. 3.", EI=1.0, length=1.0, dynamics=("ITERSTEP 10 3 1e-9",))
    deck = parse_deck(text, mode=7)
    compute = mesh_accuracy.MeshSearch.compute

    def limited(self, pieces, measure):
        if max(pieces.values()) > 4:
            raise AnalysisError("no more", "test")
        return compute(self, pieces, measure)

    monkeypatch.setattr(mesh_accuracy.MeshSearch, "compute", limited)
    found = spacar.run(7, deck, accuracy=1e-12).header["accuracy"]
    assert not found.met
    assert "meshes of 1, 2, 4" in found.way
    assert found.way.endswith("the mesh could not be refined further: no more")
    assert np.isfinite(found.estimate)
    assert found.pieces == dict.fromkeys(range(1, beams + 1), 4)
    assert found.runs == 3 + beams * (beams > 1)


@pytest.mark.slow
def test_the_guide_of_leaf_springs(deck):
    """Warping leaves the guide order 2; first frequency of its default mesh extrapolated from 4, 8, 16 by Romberg."""
    given = deck("leafguide", 7)
    count = len(spacar.run(7, given)["eigval"][-1])
    result = spacar.run(7, given, accuracy=1e-7, variables=[f"abs(eigval[{count}])", "x[7,1]", "x[7,2]"])
    assert result.header["accuracy"].met
    known = (87.0446759, 1.01806692e-2, 9.93759468e-2)
    found = (2 * np.pi * result.frequencies[-1][0], result.node(7, 1)[-1], result.node(7, 2)[-1])
    np.testing.assert_allclose(found, known, rtol=1e-7)
