"""`accuracy`: the error asked for is kept against closed forms, its estimate is honest, what is not met is said."""

import json

import numpy as np
import pytest
from models import cantilever
from scipy.special import ellipj, ellipk

import spacar
from spacar.deck import parse_deck
from spacar.errors import AnalysisError, UsageError
from spacar.studies.policies import mesh as mesh_accuracy
from spacar.studies.runs.mesh_ladder import MARGIN, extrapolate

OSCILLATOR = """
PLTRUSS 1 1 2   X 2 1. 0.   FIX 1   FIX 2 2   DYNE 1 1   END HALT
XM 2 0.5   ESTIFF 1 200.   STARTDE 1 1 0.01 0.   TIMESTEP 3.1415926535897931 40   END END
"""
PENDULUM = """
PLRBEAM 1 1 2 3   X 3 0.1411200080598672 0.9899924966004454   FIX 1   DYNX 2 1   END HALT
EM 1 0.   XM 3 1.   GRAVITY 0. -9.81   TIMESTEP 4. 40   END END
"""
# two rods from the upright position: changes of the start grow e^(6 t) times, roughly
TUMBLING = """
PLRBEAM 1 1 4 2   PLRBEAM 2 2 5 3   X 2 0.1 1.   X 3 0.3 2.   FIX 1   DYNX 4 1   DYNX 5 1   END HALT
EM 1 1.   EM 2 1.   GRAVITY 0. -9.81   TIMESTEP {duration} 24   END END
"""


def oscillation(t):
    """x = 1 + 0.01 cos 20 t, omega = sqrt(200 / (1 * 0.5)): ten periods."""
    return 1.0 + 0.01 * np.cos(20.0 * t)


def swing(t):
    """Pendulum of 1 m released at rest 3 rad from below: sin(theta/2) = k cd(omega t, k), k = sin 1.5."""
    k = np.sin(1.5)
    sn = ellipj(np.sqrt(9.81) * t + ellipk(k * k), k * k)[0]
    return np.sin(2.0 * np.arcsin(k * sn))


CASES = {"oscillator": (OSCILLATOR, "x[2,1]", oscillation), "pendulum": (PENDULUM, "x[3,1]", swing)}


@pytest.mark.parametrize("target", [1e-3, 1e-5, 1e-7])
@pytest.mark.parametrize("name", CASES)
def test_the_error_asked_for_is_kept(name, target):
    """Against closed forms; and the true error is within twice the estimate that the run states."""
    text, variable, exact = CASES[name]
    result = spacar.run(1, parse_deck(text, mode=1), accuracy=target, variables=[variable])
    found = result.header["accuracy"]
    node = int(variable[2])
    error = np.abs(result.node(node, 1) - exact(result.t)).max() / np.ptp(exact(result.t))
    assert found.met
    assert found.estimate <= target
    assert error <= 2.0 * found.estimate + 1e-12
    assert error <= target
    assert len(found.attempts) <= 3
    bars = result.node(node, 1, "xerr")
    assert np.all(np.diff(bars) >= 0.0)
    assert bars[-1] / np.ptp(exact(result.t)) == pytest.approx(found.estimate, rel=1e-2)


def test_without_a_target_the_run_itself_is_measured():
    """Same numbers as the plain run, with the true error within a factor of two of the estimate."""
    deck = parse_deck(OSCILLATOR, mode=1)
    plain = spacar.run(1, deck)
    result = spacar.run(1, deck, accuracy=True)
    np.testing.assert_array_equal(result["x"], plain["x"])
    error = np.abs(result.node(2, 1) - oscillation(result.t)).max() / np.ptp(oscillation(result.t))
    found = result.header["accuracy"]
    assert found.target is None
    assert found.met is None
    assert error / 2 < found.estimate < 2 * error


def test_fixed_steps_are_measured():
    """Kutta's method has an error far above any tolerance: it is found."""
    deck = parse_deck(OSCILLATOR.replace("TIMESTEP", "INTEGRAT 140 0.02\nTIMESTEP"), mode=1)
    result = spacar.run(1, deck, accuracy=True)
    error = np.abs(result.node(2, 1) - oscillation(result.t)).max() / np.ptp(oscillation(result.t))
    assert error > 1e-4
    assert result.header["accuracy"].estimate == pytest.approx(error, rel=0.05)


def test_chaos_is_told():
    """Beyond some time no tolerance keeps the accuracy: what was reached is said, and until when it holds."""
    deck = parse_deck(TUMBLING.format(duration=9.0), mode=1)
    result = spacar.run(1, deck, accuracy=1e-10)
    found = result.header["accuracy"]
    assert not found.met
    assert found.estimate > 1e-10
    assert 0.0 < found.until < 9.0
    assert any(line.startswith("warning: accuracy 1e-10 is not met") for line in result.report)
    assert "chaos" in found.way or "rounding" in found.way


@pytest.mark.slow
def test_the_accuracy_of_a_stiff_model():
    """Runs that change to Radau against an explicit run that resolves every frequency; deflection up to 0.25."""
    dynamics = ("GRAVITY 0. -1.", "TIMESTEP 1.8 9")
    deck = parse_deck(cantilever(24, EI=1.0, length=1.0, dynamics=dynamics), mode=1)
    result = spacar.run(1, deck, accuracy=1e-3, variables=["x[49,2]"], mesh=False)
    exact = spacar.run(1, deck, integrator=853, rtol=1e-6, atol=1e-7).node(49, 2)
    assert any("INTEGRAT 595" in line for line in result.report)
    assert np.abs(result.node(49, 2) - exact).max() / np.ptp(exact) <= 1e-3


def test_nothing_to_integrate():
    """Prescribed motion has no error of integration."""
    text = OSCILLATOR.replace("DYNE 1 1", "INPUTE 1 1").replace("STARTDE 1 1 0.01 0.", "INPUTE 1 1 0. 0.01 0.")
    result = spacar.run(1, parse_deck(text, mode=1), accuracy=1e-6)
    assert result.header["accuracy"].estimate == 0.0


def test_mode_4_gets_it_too():
    result = spacar.run(4, parse_deck(OSCILLATOR, mode=4), accuracy=1e-6)
    assert result.header["accuracy"].met
    assert len(result["m0"]) == len(result["xerr"]) == 41
    assert result.mechanism.settings.integrator == result.header["accuracy"].attempts[-1].integrator


@pytest.mark.parametrize(
    ("mode", "options", "words"),
    [
        (0, {"accuracy": 1e-3}, "not of mode 0"),
        (1, {"accuracy": 2.0}, "between 0 and 1"),
        (1, {"accuracy": "fine"}, "between 0 and 1"),
        (1, {"variables": ["x[2,1]"]}, "give an accuracy"),
    ],
)
def test_what_is_refused(mode, options, words):
    with pytest.raises(UsageError, match=words):
        spacar.frames(mode, parse_deck(OSCILLATOR, mode=mode), **options)


def test_an_unknown_variable_is_named():
    with pytest.raises(UsageError, match="node 9"):
        spacar.run(1, parse_deck(OSCILLATOR, mode=1), accuracy=1e-3, variables=["x[9,1]"])


def test_on_the_command_line(tmp_path, monkeypatch, capsys):
    """Log, result file, JSON; a word that is no number is the file; the file's own settings are replaced."""
    from spacar_cli.main import main
    from spacar_formats.loadsbd import loadsbd

    monkeypatch.chdir(tmp_path)
    (tmp_path / "osc.dat").write_text(OSCILLATOR)
    assert main(["1", "osc", "--accuracy", "1e-5", "--variable", "x[2,1]", "--json"]) == 0
    report = json.loads(capsys.readouterr().out)["accuracy"]
    assert report["met"]
    assert report["estimate"] <= 1e-5
    assert report["cost"] > 1.0
    assert "accuracy 1e-05 is met" in (tmp_path / "osc.log").read_text()
    data = loadsbd("osc")
    assert data["accuracy"].ravel()[:2] == pytest.approx([report["estimate"], 1e-5])
    assert data["xerr"].shape == data["x"].shape
    assert main(["1", "--accuracy", "osc", "-q"]) == 0
    assert "estimated error of the result" in (tmp_path / "osc.log").read_text()
    assert main(["1", "osc", "--accuracy", "much", "-q"]) == 2
    assert "'much' is not a valid float" in capsys.readouterr().err
    assert main(["1", "osc", "--variable", "x[2,1]", "-q"]) == 2


@pytest.mark.parametrize("size", [1e-9, 1e-7, 1e-3])
def test_motions_of_any_size_keep_the_target(size: float) -> None:
    """A resonator of 1 Hz on a spring of 1 mm: e = size cos 2 pi t, whatever ERROR of the file is beside its size."""
    rows = [("PLTRUSS", 1, 1, 2), ("X", 2, 1e-2), ("FIX", 1), ("FIX", 2, 2), ("DYNE", 1, 1)]
    more = [("XM", 2, 1.0), ("ESTIFF", 1, 4e-2 * np.pi**2), ("STARTDE", 1, 1, size, 0.0), ("TIMESTEP", 2.3, 23)]
    for target in (1e-3, 1e-5):
        result = spacar.run(1, spacar.Deck.build(rows, more), accuracy=target)
        exact = size * np.cos(2.0 * np.pi * np.linspace(0.0, 2.3, 24))
        error = np.abs(result.element(1, 1, "e") - exact).max() / np.ptp(exact)
        found = result.header["accuracy"]
        assert found.met
        assert error <= target
        assert error <= 3.0 * found.estimate


# Four meshes of one model: the estimate from two extrapolations; spectra of refined models keep the user's places.
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
