"""`accuracy` where beams are flexible: the error of the mesh against closed forms, on the nodes of the user."""

import json
from dataclasses import replace
from pathlib import Path

import models
import numpy as np
import pytest

import spacar
from spacar.deck import parse_deck
from spacar.deck.rewrite.refine import divisible_beams, refine
from spacar.errors import UsageError
from spacar.studies.runs.user_nodes import UserNodes

# Tip of an inextensible cantilever, L = 10, EI = 102, dead transverse load 14 (elliptic integrals; reference test S5).
ELASTICA = np.array((3.810897752359167, 8.404448390735478))
BETA = np.array((1.8751040687119611, 4.694091132974175, 7.854757438237613))  # cos b cosh b = -1
LATERAL = 5.6746723  # 4.0126 sqrt(EIz GIt)/l^2 of the narrow cantilever, from J(-1/4)(b/2) = 0


def cantilever(n=2, length=10.0, load="XF {tip} 0. 14.", stiffness=102.0, more=""):
    """PLBEAMs 1 ... n along x, clamped at node 1, tip node 2 n + 1; inextensible."""
    return models.cantilever(n, length=length, EI=stiffness, dynamics=(load.format(tip=2 * n + 1), more))


def tip_error(result, n):
    tip = np.array([result.node(2 * n + 1, c)[-1] for c in (1, 2)])
    return np.abs(tip - ELASTICA).max() / ELASTICA[1]


@pytest.mark.parametrize("target", [1e-2, 1e-4, 1e-6])
def test_the_elastica_of_two_beams(target):
    """The tip is as accurate as asked for; reactions are load and load times arm; the model stays that of the user."""
    deck = parse_deck(cantilever(2), mode=7)
    variables = ["x[5,1]", "x[5,2]"]
    result = spacar.run(7, deck, accuracy=target, variables=variables)
    found = result.header["accuracy"]
    assert found.met
    assert tip_error(result, 2) <= target
    assert found.estimate <= target
    assert tip_error(result, 2) <= found.estimate
    assert result["x"].shape[1] == spacar.run(7, deck)["x"].shape[1]
    assert result.node(1, 2, "fxtot")[-1] == pytest.approx(-14.0, rel=1e-7)
    assert result.node(2, 1, "fxtot")[-1] == pytest.approx(-14.0 * ELASTICA[0], rel=10 * target)
    assert np.isfinite(result["xerr"]).all()


def test_generalized_stresses_are_end_moments():
    """sigma2 l0 of the first beam is the moment at the clamp (angle measure), whatever stands in its place."""
    result = spacar.run(7, parse_deck(cantilever(2), mode=7), accuracy=1e-5)
    moment = 14.0 * ELASTICA[0]
    assert 5.0 * abs(result.element(1, 2, "sig")[-1]) == pytest.approx(moment, rel=1e-4)


def test_deformations_are_those_of_the_users_elements():
    """e = D(x) of the nodes that the user sees: the same as an analysis of these positions gives."""
    result = spacar.run(7, parse_deck(cantilever(2), mode=7), accuracy=1e-5)
    x, phi = result["x"][-1], {k: result.node(k, 1)[-1] for k in (2, 4)}
    p, q = (np.array([result.node(k, c)[-1] for c in (1, 2)]) for k in (1, 3))
    chord = np.arctan2(*(q - p)[::-1])
    assert result.element(1, 2)[-1] == pytest.approx(5.0 * (phi[2] - chord), rel=1e-9)
    assert result.element(1, 3)[-1] == pytest.approx(-5.0 * (phi[4] - chord), rel=1e-9)
    assert len(x) == 9


def test_frequencies_of_a_cantilever():
    """omega = beta^2 sqrt(EI/(m L^4)); two modes of a single element, which has 0.5 % and 58 % of error."""
    deck = parse_deck(cantilever(1, 1.0, "", 1.0), mode=7)
    result = spacar.run(7, deck, accuracy=1e-6)
    omega = 2 * np.pi * result.frequencies[-1]
    np.testing.assert_allclose(omega, BETA[:2] ** 2, rtol=1e-6)
    assert result.header["accuracy"].met
    assert result["eigvre"].shape == spacar.run(7, deck)["eigvre"].shape
    plain = 2 * np.pi * spacar.run(7, deck).frequencies[-1]
    measured = spacar.run(7, deck, accuracy=True)
    np.testing.assert_array_equal(2 * np.pi * measured.frequencies[-1], plain)
    worst = np.abs(plain / BETA[:2] ** 2 - 1).max()
    assert measured.header["accuracy"].estimate == pytest.approx(worst, rel=1e-2)


def test_shapes_of_vibration_are_those_of_the_nodes():
    """First mode of a single element: tip displacement over tip slope (times L) of the clamped-free beam, 0.72640."""
    result = spacar.run(7, parse_deck(cantilever(1, 1.0, "", 1.0), mode=7), accuracy=1e-5)
    shape = result["eigvre"][-1][:2, -1]
    # w = -e_q ... of a cubic: tip deflection (e2 + ... ): from e2 = -w, e3 = w - theta (l = 1, small)
    w, theta = -shape[0], -shape[1] - shape[0]
    sigma = (np.sinh(BETA[0]) - np.sin(BETA[0])) / (np.cosh(BETA[0]) + np.cos(BETA[0]))
    exact_w = np.cosh(BETA[0]) - np.cos(BETA[0]) - sigma * (np.sinh(BETA[0]) - np.sin(BETA[0]))
    exact_theta = BETA[0] * (np.sinh(BETA[0]) + np.sin(BETA[0]) - sigma * (np.cosh(BETA[0]) - np.cos(BETA[0])))
    assert w / theta == pytest.approx(exact_w / exact_theta, rel=1e-3)


@pytest.mark.parametrize("target", [1e-3, 1e-6])
def test_buckling_of_a_column(target, deck):
    """Clamped column whose end is guided: pi^2 EI/L^2."""
    result = spacar.run(8, deck("column2", 8), accuracy=target)
    assert result["lmult"][-1].min() == pytest.approx(np.pi**2, rel=target)
    assert result.header["accuracy"].met


@pytest.mark.parametrize("target", [1e-3, 1e-5])
def test_lateral_buckling(target, deck):
    """The twist gradient of the angle measure makes it order 4."""
    result = spacar.run(8, deck("lateral4", 8), accuracy=target, variables=["abs(lmult[1])"])
    assert np.abs(result["lmult"][-1]).min() == pytest.approx(LATERAL, rel=target)
    assert result.header["accuracy"].met


def test_only_beams_that_need_it_are_refined():
    """A soft and long beam carries the load on a stiff one that hardly bends."""
    text = cantilever(2).replace("ESTIFF 1 0. 102.0", "ESTIFF 1 0. 1e5").replace("X 3 5.0", "X 3 0.5")
    result = spacar.run(7, parse_deck(text, mode=7), accuracy=1e-6, variables=["x[5,1]", "x[5,2]"])
    found = result.header["accuracy"]
    assert found.met
    assert set(found.pieces) == {2}
    fine = spacar.run(7, refine(parse_deck(text, mode=7), 32), beams="angle")
    assert np.abs(result["x"][-1] - fine["x"][-1][_common(result, fine)]).max() < 1e-5


def _common(result, fine):
    n, m = result.mechanism.numbering, fine.mechanism.numbering
    return [m.x_index(*n.x_owner(i)) for i in range(n.nx)]


def test_the_weight_of_the_parts_is_carried():
    """Clamp of a cantilever under gravity: m g L and, nearly straight, m g L^2 / 2."""
    deck = parse_deck(cantilever(1, 1.0, "GRAVITY 0. -1.", 1e4), mode=7)
    result = spacar.run(7, deck, accuracy=1e-6)
    reaction = [(result[k]) for k in ("fxtot", "fx", "fxgrav")]
    force = reaction[0] - reaction[1] - reaction[2]
    n = result.mechanism.numbering
    assert force[-1, n.x_index(1, 2)] == pytest.approx(1.0, rel=1e-6)
    assert force[-1, n.x_index(2, 1)] == pytest.approx(0.5, rel=1e-6)


def test_the_state_space_is_that_of_the_user():
    """Mode 9: degrees of freedom, inputs and outputs stay; the error of the poles is told."""
    text = cantilever(1, 1.0, "", 1.0).replace("END\nEND", "END\nHALT\nINPUTF 1 3 2\nOUTX 1 3 2\nEND\nEND")
    deck = parse_deck(text, mode=9)
    plain, result = spacar.run(9, deck), spacar.run(9, deck, accuracy=1e-3)
    np.testing.assert_array_equal(plain["A"], result["A"])
    found = result.header["accuracy"]
    assert not found.met
    assert found.estimate == pytest.approx(34.8069 / BETA[1] ** 2 - 1, rel=1e-2)
    assert any("is not met" in line for line in result.report)


def test_a_model_without_beams_has_no_error_of_the_mesh():
    text = "PLTRUSS 1 1 2\nX 2 1. 0.\nFIX 1\nFIX 2 2\nDYNE 1 1\nEND HALT\nXM 2 1.\nESTIFF 1 1.\nEND END\n"
    found = spacar.run(7, parse_deck(text, mode=7), accuracy=1e-6).header["accuracy"]
    assert found.estimate == 0.0
    assert "no flexible beams" in found.way


def test_what_cannot_be_divided_is_said():
    """A joint in the beam: no estimate, no promise."""
    text = cantilever(1, 1.0, "", 1.0)
    text = text.replace("DYNE 1 2 3", "DYNE 1 2\nRLSE 1 3\nFIX 4").replace("ESTIFF 1 0. 1.0", "ESTIFF 1 0. 0.")
    result = spacar.run(7, parse_deck(text, mode=7), accuracy=1e-3)
    found = result.header["accuracy"]
    assert np.isnan(found.estimate)
    assert found.record()["estimate"] is None
    assert not found.met
    assert any("cannot be divided" in line for line in result.report)


def test_fixed_mesh_is_for_motions():
    with pytest.raises(UsageError, match="mesh"):
        spacar.frames(7, parse_deck(cantilever(1), mode=7), accuracy=1e-3, mesh=False)


def test_on_the_command_line(tmp_path, monkeypatch, capsys):
    from spacar_cli.main import main
    from spacar_formats.loadsbd import loadsbd

    monkeypatch.chdir(tmp_path)
    (tmp_path / "arm.dat").write_text(cantilever(2))
    assert main(["7", "arm", "--accuracy", "1e-5", "--variable", "x[5,1]", "--json"]) == 0
    report = json.loads(capsys.readouterr().out)["accuracy"]
    assert report["met"]
    assert report["pieces"]
    data = loadsbd("arm")
    assert data["lnp"].shape[0] == 6
    assert data["xerr"].shape == data["x"].shape
    assert abs(data["x"].ravel()[data["lnp"][4, 0] - 1] - ELASTICA[0]) < 1e-5 * ELASTICA[1]
    assert "accuracy 1e-05 is met" in (tmp_path / "arm.log").read_text()
    assert main(["7", "--accuracy", "arm", "-q"]) == 0
    assert "the mesh of the model against" in (tmp_path / "arm.log").read_text()


MOVING = cantilever(2, 1.0, "GRAVITY 0. -1.", 1.0, "TIMESTEP 0.9 9")


@pytest.fixture(scope="module")
def released():
    """Tip of 16 beams in the angle measure."""
    deck = refine(parse_deck(MOVING, mode=1), 8)
    return spacar.run(1, deck, beams="angle", integrator=595, rtol=1e-6, atol=1e-7).node(5, 2)


@pytest.mark.slow
def test_a_released_cantilever(released):
    """Mode 1: the tip under its weight, against 16 beams in the angle measure integrated to 1e-8."""
    deck = parse_deck(MOVING, mode=1)
    result = spacar.run(1, deck, accuracy=1e-3, variables=["x[5,2]"])
    found = result.header["accuracy"]
    assert found.met
    assert np.abs(result.node(5, 2) - released).max() / np.ptp(released) <= 1e-3
    assert result["x"].shape == (10, 9)
    assert "beams in the place of" in found.way


@pytest.mark.slow
def test_the_mesh_of_a_motion_is_measured(released):
    """The run of the file stays as it is; its error against the same fine run is what is told, within a factor of 2."""
    deck = parse_deck(MOVING, mode=1)
    plain = spacar.run(1, deck)
    result = spacar.run(1, deck, accuracy=True, variables=["x[5,2]"])
    np.testing.assert_array_equal(plain["x"], result["x"])
    error = np.abs(plain.node(5, 2) - released).max() / np.ptp(released)
    assert error / 2 < result.header["accuracy"].estimate < 2 * error
    fixed = spacar.run(1, deck, accuracy=True, variables=["x[5,2]"], mesh=False)
    assert fixed.header["accuracy"].estimate < 0.1 * error


def test_meshes_without_stress_have_infinite_multipliers():
    """Where large meshes are computed sparse and nothing is stressed, as many infinite multipliers as the user has."""
    text = cantilever(3, load="")
    text = text.replace("END END", "ITERSTEP 10 1 1e-9\nEND END")
    result = spacar.run(10, parse_deck(text, mode=10), accuracy=True)
    assert len(result["lmult"][-1]) == 6
    assert np.isinf(result["lmult"][-1]).all()
    assert np.isfinite(result["eigval"][-1]).all()
    given = spacar.run(10, parse_deck(text, mode=10))
    found = UserNodes(given.mechanism, given.mechanism, {}, given.frames)
    fine = replace(given.frames[-1], matrices=dict(given.frames[-1].matrices))
    fine.matrices |= {"lmult": np.zeros(0), "bmode": np.zeros((6, 0))}
    view = found.frame(fine, -1)
    assert view.matrices["lmult"].tolist() == [np.inf] * 6
    assert view.matrices["bmode"].shape == (6, 6)


# `--elements N`: the run of the divided model, in which nodes and elements of the file keep their numbers.
def test_the_same_as_the_divided_model(deck):
    """plbeam5 with two beams for each, by the option and by hand; the tip is nearer to 3.8109 of the elastica."""
    given = deck("plbeam5", 7)
    by_option, by_hand = spacar.run(7, given, elements=2), spacar.run(7, refine(given, 2))
    np.testing.assert_array_equal(by_option["x"], by_hand["x"])
    exact = 3.810897752359167
    assert abs(by_option.node(11, 1)[-1] - exact) < 0.3 * abs(spacar.run(7, given).node(11, 1)[-1] - exact)


def test_the_command(call):
    """The log repeats the option, the json counts the divided model's freedoms, the results have its nodes."""
    done = call.done("7", "plbeam5", "--elements", "3", "--json")
    report = json.loads(done.out)
    assert report["nddof"] == 3 * 10
    text = Path("plbeam5.log").read_text(encoding="utf-8")
    assert "--elements" in text
    assert spacar.read_deck("plbeam5.dat").sha256 in text


def test_units_and_sections_stay(deck):
    given = deck("leafguide", 7)
    finer = refine(given, 2)
    assert finer.metre == given.metre == 1e-3
    assert finer.visualization == given.visualization
    assert [len(s.parts) for s in finer.sections] == [8, 1, 1, 8]


def test_beams_that_cannot_be_divided_are_said(deck):
    """A flexible tube stays; without any beam to divide it is refused."""
    rows = "PLBEAM 1 1 2 3 4\nPLTUBE 2 3 4 5 6\nX 3 1. 0.\nX 5 2. 0.\nFIX 1\nFIX 2\nDYNE 1 2 3\nDYNE 2 2 3\nEND HALT\n"
    rows += "EM 1 1.\nEM 2 1.\nESTIFF 1 0. 1.\nESTIFF 2 0. 1.\nEND END\n"
    model = parse_deck(rows, mode=7)
    assert divisible_beams(model) == ((1,), {2: "a tube is not divided; write more of them"})
    run = spacar.frames(7, model, elements=2)
    assert run.mechanism.numbering.nddof == 3 * 2
    assert any("beam 2 is not divided into 2: a tube" in line for line in run.report.lines)
    with pytest.raises(UsageError, match=r"no beam that can be divided \(none is flexible\)"):
        spacar.frames(1, deck("crank", 1), elements=2)
    for wrong in (0, 1.5, "2", False):
        with pytest.raises(UsageError, match=r"elements = .* must be a whole number from 1"):
            spacar.frames(7, model, elements=wrong)
