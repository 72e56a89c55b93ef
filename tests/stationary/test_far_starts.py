"""Statics and steady motion from starts far from the solution, and solutions that only a preload makes possible."""

from math import acos, cos, inf, pi, remainder, sin, sqrt, tau

import numpy as np
import pytest
from scipy.optimize import brentq

import spacar
from spacar import run
from spacar.deck import Deck, parse_deck, read_deck
from spacar.errors import AnalysisError
from spacar.linear_systems.reciprocal_condition import entry_rounding, lost
from spacar.stationary import continuation
from spacar.stationary.arc_length import LimitPoint

G = 9.81
PENDULUM = """
PLRBEAM 1 1 2 3   X 3 0 -{l!r}   FIX 1   DYNX 2   END HALT   XM 3 2.   GRAVITY 0 -9.81
STARTDX 2 1 {start!r}   ITERSTEP 20 {steps} 1e-9   END END
"""
CONICAL = """
HINGE 1 1 2 0 0 1   HINGE 2 2 3 0 1 0   RBEAM 3 4 3 5 0 1 0   X 4 0 0 0   X 5 {x!r} 0. {z!r}
FIX 1   FIX 4   INPUTE 1 1   DYNE 2 1   END HALT
XM 5 0.4   INPUTE 1 1 0 {speed!r} 0   GRAVITY 0 0 -9.81   {more}   ITERSTEP 30 {steps} 1e-10
END END
"""


@pytest.mark.parametrize("general", ["", "1"])
@pytest.mark.parametrize("start", [0.3, 0.8, -1.1, 1.5, 1.7, 2.5, -3.0])
def test_a_pendulum_finds_its_rest(start, general, monkeypatch):
    """w^2 = g/l about the hanging position, whatever the number of steps. Above the pivot the start is not stable,
    and the way down may add a turn."""
    monkeypatch.setenv("SPACAR_GENERAL", general)
    for steps in (1, 4, 10):
        r = spacar.run(7, parse_deck(PENDULUM.format(l=0.5, start=start, steps=steps), mode=7))
        assert remainder(r.node(2, 1)[-1], tau if abs(start) > 1.6 else inf) == pytest.approx(0.0, abs=1e-9)
        assert r["eigval"][0][0] == pytest.approx((0.0, sqrt(G / 0.5)), abs=1e-7)
        assert not any("warning" in line for line in r.report)


def test_a_path_back_that_does_not_come_to_the_load_leaves_the_unstable_state(monkeypatch):
    """Upright, as without that path."""
    asked = []

    def turned(*words):
        asked.append(words)
        raise LimitPoint(0.5, None, followed=True)

    monkeypatch.setattr(continuation, "follow", turned)
    r = spacar.run(7, parse_deck(PENDULUM.format(l=0.5, start=2.5, steps=1), mode=7))
    assert asked
    assert abs(remainder(r.node(2, 1)[-1], tau)) == pytest.approx(pi, abs=1e-9)


@pytest.mark.parametrize("off", [0.0, 5.0, -5.0, 15.0])
@pytest.mark.parametrize(("speed", "l"), [(7.0, 0.5), (20.0, 0.3), (5.0, 0.6), (4.45, 0.5)])
def test_a_conical_pendulum(speed, l, off):
    """cos a = g/(W^2 l); it swings about that with W sin a. The hanging position, which it is close to where the bar
    is slow, is not stable."""
    a = acos(G / (speed**2 * l))
    start = max(a - off * pi / 180.0, 0.4 * a)
    for steps in (1, 4):
        text = CONICAL.format(x=l * sin(start), z=-l * cos(start), speed=speed, steps=steps, more="")
        r = spacar.run(7, parse_deck(text, mode=7))
        assert r.node(5, 3)[-1] == pytest.approx(-l * cos(a), rel=1e-9)
        assert r["eigval"][0][0] == pytest.approx((0.0, speed * sin(a)), abs=1e-7)


@pytest.mark.parametrize(("l", "speed", "c", "a0"), [(0.5, 9.0, 1.5, 0.9), (0.5, 15.0, 0.2, 0.3), (2.0, 9.0, 1.5, 0.3)])
@pytest.mark.parametrize("steps", [1, 4, 50])
def test_a_governor_with_a_spring(l, speed, c, a0, steps):
    """A spring c at the hinge, unstrained where the bar begins: c (a - a0) = m W^2 l^2 sin a cos a - m g l sin a. One
    step, and four, ended at the unstable solution near the hanging position."""

    def moment(a: float) -> float:
        return c * (a - a0) - 0.4 * (speed * l) ** 2 * sin(a) * cos(a) + 0.4 * G * l * sin(a)

    a = brentq(moment, 0.5, 1.5, xtol=1e-14)
    text = CONICAL.format(x=l * sin(a0), z=-l * cos(a0), speed=speed, steps=steps, more=f"ESTIFF 2 {c}")
    r = spacar.run(7, parse_deck(text, mode=7))
    assert r.node(5, 3)[-1] == pytest.approx(-l * cos(a), rel=1e-8)


@pytest.mark.parametrize("stretch", [0.3, 0.9, 2.5])
def test_a_spring_that_starts_stretched(stretch):
    text = "PLTRUSS 1 1 2\nX 2 1 0\nFIX 1\nFIX 2 2\nDYNE 1\nEND HALT\nXM 2 1\nESTIFF 1 2\n"
    r = spacar.run(7, parse_deck(f"{text}STARTDE 1 1 {stretch}\nEND END\n", mode=7))
    assert r.element(1, 1)[-1] == pytest.approx(0.0, abs=1e-12)
    assert r["eigval"][0][0] == pytest.approx((0.0, sqrt(2.0)))


STRING = """
PLTRUSS 1 1 2   PLTRUSS 2 2 3   X 1 0. 0.   X 2 1. 0.   X 3 2. 0.
FIX 1   FIX 3   DYNX 2 1 2   RLSE 1 1   RLSE 2 1   END HALT
XM 2 1.   ESTIFF 1 1.   ESTIFF 2 1.   ESIG 1 {preload}   ESIG 2 {preload}   XF 2 0. {force}
END END
"""


HALVES = """X 3 0.6 0   FIX 1   FIX 2   PLBEAM 1 1 2 3 4   RLSE 1   DYNX 3   DYNX 4
SECTION bar CUSTOM 0.8 0.11 0.13 0.24   MATERIAL stuff 100. 50. 0.5   BEAMSEC 1 bar stuff 2
END HALT
XM 3 1.   XM 4 0.3   STARTDX 3 1 {x}   STARTDX 3 2 {y}   STARTDX 4 1 {phi}   END END
"""


@pytest.mark.parametrize("x", [0.54, 0.59, 0.65])
@pytest.mark.parametrize(("y", "phi"), [(0.02, 0.03), (0.05, -0.1), (-0.05, 0.03)])
def test_a_path_of_fading_forces_that_turns_is_left(x, y, phi):
    """A beam of two halves without loads is straight wherever its end starts. The forces that held the start went
    through limit points, to a state in which the halves were folded: refused for their range."""
    r = spacar.run(10, parse_deck(HALVES.format(x=x, y=y, phi=phi), mode=10))
    assert r.node(3)[-1] == pytest.approx((0.6, 0.0), abs=1e-12)
    assert not any("unstable" in line for line in r.report)


@pytest.mark.parametrize("general", ["", "1"])
@pytest.mark.parametrize("mode", [7, 8, 10])
@pytest.mark.parametrize(("preload", "force"), [(0.01, 1e-4), (0.01, 0.02), (0.3, 0.1), (1e-3, 1e-5)])
def test_a_preload_comes_before_the_load_that_needs_it(mode, preload, force, general, monkeypatch):
    """2 (s0 + l - 1) y/l = F, l^2 = 1 + y^2; 0.00499383547 for the first."""
    monkeypatch.setenv("SPACAR_GENERAL", general)
    y = brentq(lambda y: 2 * (preload + sqrt(1 + y * y) - 1) * y / sqrt(1 + y * y) - force, 0.0, 1.0, xtol=1e-15)
    r = spacar.run(mode, parse_deck(STRING.format(preload=preload, force=force), mode=mode))
    assert r.node(2, 2)[-1] == pytest.approx(y, rel=1e-7)


def test_loads_of_the_user_take_part_in_load_steps(tmp_path):
    """A dead tip force by USERSIG bends a cantilever as XF does, whatever the steps."""
    lines = ["FIX 1", "FIX 2"]
    for k in range(4):
        a = 2 * k + 1
        lines += [f"PLBEAM {k + 1} {a} {a + 1} {a + 2} {a + 3}", f"X {a + 2} {0.25 * (k + 1)} 0", f"DYNE {k + 1} 2 3"]
    lines += ["END HALT", *(f"EM {k + 1} 1.\nESTIFF {k + 1} 0 1." for k in range(4))]
    (tmp_path / "push.py").write_text("def push(t, ne, le, e, ep, nx, lnp, x, xp):\n    return t, [], [[9, 2, 6.0]]\n")
    found = []
    for load, steps in (("XF 9 0 6.0", 20), ("USERSIG push", 4), ("USERSIG push", 1), ("USERSIG push\nXF 9 1e-9", 10)):
        (tmp_path / "model.dat").write_text("\n".join([*lines, load, f"ITERSTEP 20 {steps} 1e-10", "END END\n"]))
        found.append(spacar.run(7, read_deck(tmp_path / "model.dat", 7)).node(9)[-1])
    assert np.allclose(found, found[0], rtol=0.0, atol=1e-8)


# Wheels: released beams with stiffness bear load in the stationary solution (they had no stress).
TEXT = """X 1 0.1 0.2 0.5   X 3 0.1 0.2 0.0   DYNX 2 2 3 4   KINX 1 1 2   TWHEEL 1 1 2 3 0.5 0.1 0.0 1.0 0.0
X 4 1.035 -0.452 -0.38   FIX 4   FIX 5   BEAM 2 4 5 1 2 0.015 1. 0.3   RLSE 2 1 2 3 4 5 6   END HALT
XM 1 5.014   XM 2 0.39 0. 0. 0.334 0. 0.316   ESTIFF 2 76.189 10.747 10.804 14.127   ESIG 2 0.3
XF 2 0.1 0.2 -0.1 0.05   GRAVITY 0.02 0.03 -1.0   ITERSTEP 60 2 1e-12 1 0   END END
"""


@pytest.mark.parametrize("compiled", [True, False])
def test_released_beams_have_the_stress_of_their_law(tmp_path, compiled):
    """sigma_1 = E A e_1 / l + preload, sigma_2 = G I_t e_2 / l^3: closed forms; the end's force is that of sigma_1."""
    path = tmp_path / "wheel.dat"
    path.write_text(TEXT)
    r = run(7, path, compiled=compiled)
    places = np.asarray(r["le"])[1] - 1
    e, sigma = r["e"][0][places], r["sig"][0][places]
    length = np.linalg.norm([0.935, -0.652, -0.88])
    assert sigma[0] == pytest.approx(76.189 * e[0] / length + 0.3, rel=1e-9)
    assert sigma[1] == pytest.approx(10.747 * e[1] / length**3, rel=1e-9)
    assert abs(sigma[0]) > 0.1


def test_a_linear_convergence_is_followed_to_its_end():
    """Slips let the iteration converge linearly: what is left is that of a geometric series, not of a square."""
    text = TEXT.replace("KINX 1 1 2", "KINX 1 1\nDYNX 1 2").replace("RLSE 2 1", "RLSE 1 6\nDYNE 1 1\nRLSE 2 1")
    text = text.replace("ESTIFF 2", "ESTIFF 1 60.4 73.9 62.1 75.7 65.3 86.3\nESTIFF 2")
    exact, ordinary = (run(7, parse_deck(text), tolerance=tolerance)["x"][-1] for tolerance in (1e-15, 1.0))
    assert np.abs(ordinary - exact).max() <= 2e-11 * 1.5  # of two runs; size of the model


# Displacements under forces of the size of the stiffness are large where a model is soft in one way, stiff in
# another and finely divided; that is no singularity as long as rounding of the entries leaves digits.
N = 60


def cantilever(EA, *more):
    beams = [("PLBEAM", i + 1, 2 * i + 1, 2 * i + 2, 2 * i + 3, 2 * i + 4) for i in range(N)]
    places = [("X", 2 * i + 1, i / N, 0.0) for i in range(1, N + 1)]
    held = [("FIX", 1), ("FIX", 2), *(("DYNE", i + 1, 1, 2, 3) for i in range(N))]
    rows = [("ESTIFF", i + 1, EA, 1.0) for i in range(N)] + [("EM", i + 1, 1.0) for i in range(N)]
    return Deck.build(beams + places + held, [*rows, *more], mode=7)


@pytest.mark.parametrize("EA", [1e4, 1e12, 1e15])
def test_a_soft_cantilever_that_hardly_stretches(EA):
    """Tip under a transverse load: P L^3/(3 EI), less 4/35 P^2 of it (next term of the elastica's series at small P);
    frequencies from cos b cosh b = -1; both whatever the axial stiffness is."""
    P = 1e-3
    result = spacar.run(7, cantilever(EA, ("XF", 2 * N + 1, 0.0, P), ("ITERSTEP", 10, 1, 1e-9)), beams="angle")
    assert result.node(2 * N + 1, 2)[-1] == pytest.approx(P / 3.0, rel=P**2 + 1e-8)
    lowest = 2.0 * np.pi * result.frequencies[-1][:2]
    np.testing.assert_allclose(lowest, (1.8751040687119611**2, 4.694091132974175**2), rtol=2e-6)


def test_a_motion_without_stiffness_is_still_refused():
    """The same beam with its clamp turned into a pin: nothing resists the load."""
    beams = cantilever(1e15, ("XF", 2 * N + 1, 0.0, 1.0))
    rows = [(s.keyword, *s.values) for s in beams.statements if s.block == 1 and (s.keyword, *s.values) != ("FIX", 2)]
    loads = [(s.keyword, *s.values) for s in beams.statements if s.block == 2]
    with pytest.raises(AnalysisError, match=r"without stiffness|singular"):
        spacar.run(7, Deck.build([*rows, ("DYNX", 2)], loads, mode=7))


def test_lost_digits_tell_a_singular_matrix_from_a_soft_one():
    """diag(1, 1e-20) keeps all digits of every solution, [[1, 1], [1, 1 + eps]] none."""

    def of(A):
        rows, columns = map(np.ravel, np.indices(A.shape))
        z = np.linalg.solve(A, np.array([1.0, 1.5]))
        return lost(lambda b: np.linalg.solve(A, b), entry_rounding(2, rows, columns, A.ravel(), z), z, 2)

    assert of(np.diag([1.0, 1e-20])) < 1e-15
    assert of(np.array([[1.0, 1.0], [1.0, 1.0 + 2**-52]])) > 0.1
