"""Limit points do not depend on the number of load steps, nor on the engine."""

import re
from math import hypot
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar

import spacar
from spacar.errors import AnalysisError
from spacar.stationary import arc_length

from . import planar_models as models

# Williams' toggle, left half, beams rigid against shear: F. W. Williams, Q. J. Mech. Appl. Math. 17 (1964) 451-469.
L, H, EA, EI = 12.943, 0.386, 1.885e6, 9.27e3


def toggle(n: int, apex: str, settings: str) -> str:
    lines = ["FIX 1 1 2", "FIX 2 1", f"FIX {2 * n + 1} 1", f"FIX {2 * n + 2} 1"]
    for k in range(n):
        a = 2 * k + 1
        lines += [f"PLBEAM {k + 1} {a} {a + 1} {a + 2} {a + 3}", f"X {a + 2} {L * (k + 1) / n!r} {H * (k + 1) / n!r}"]
        lines += [f"RLSE {k + 1}"] + ([f"DYNX {a + 2} 1 2", f"DYNX {a + 3} 1"] if k < n - 1 else [])
    lines += [f"INPUTX {2 * n + 1} 2" if "INPUTX" in apex else f"DYNX {2 * n + 1} 2", "END HALT"]
    lines += [f"ESTIFF {k + 1} {EA} {EI}\nEM {k + 1} 1e-4" for k in range(n)]
    return "\n".join([*lines, apex, f"ITERSTEP {settings}", "END END\n"])


def limit_of(model: str | Path) -> float:
    with pytest.raises(AnalysisError) as caught:
        spacar.run(7, spacar.parse_deck(model, mode=7) if isinstance(model, str) else model)
    assert caught.value.code == "statics.limit-point", str(caught.value)
    return float(caught.value.data["level"].initial)


@pytest.fixture(scope="module")
def limit_load() -> float:
    """The largest force of the toggle under prescribed displacement [N]: at a distance of 1e-6, so to its square."""

    def force(v: float) -> float:
        v = float(v)
        r = spacar.run(7, spacar.parse_deck(toggle(4, f"INPUTX 9 2 {H - v!r}", "30 10 1e-10"), mode=7))
        return -float(r.frames[-1].fxtot[r.mechanism.numbering.x_index(9, 2)])

    found = minimize_scalar(lambda v: -force(v), bounds=(0.1, 0.3), method="bounded", options={"xatol": 1e-6})
    return -float(found.fun)


@pytest.mark.parametrize("general", ["", "1"])
def test_the_toggle_for_many_numbers_of_steps(limit_load, monkeypatch, general):
    monkeypatch.setenv("SPACAR_GENERAL", general)
    for steps in (100,) if general else (1, 7, 60, 100, 150):
        found = 20.0 * limit_of(toggle(4, "XF 9 0 -20", f"30 {steps} 1e-6"))
        assert found == pytest.approx(limit_load, rel=1e-8)
        r = spacar.run(7, spacar.parse_deck(toggle(4, "XF 9 0 -20", f"30 {steps} 1e-6 1 0 0 1"), mode=7))
        said = re.search(r"limit points at ([0-9.]+), ([0-9.]+) of", "\n".join(r.report))
        assert said
        assert 20.0 * float(said[1]) == pytest.approx(limit_load, rel=1e-7)
        assert r.node(9, 2)[-1] < -0.1


@pytest.mark.parametrize("height", [0.02, 0.1, 0.4])
@pytest.mark.parametrize("steps", [1, 60, 150])
def test_a_truss_of_von_mises(height, steps, tmp_path):
    """P(y) = 2 k (l0 - l) y/l, k = EA/l0: the limit is its maximum over 0 < y < h."""
    l0 = hypot(1.0, height)
    at = minimize_scalar(lambda y: -(l0 - hypot(1.0, y)) * y / hypot(1.0, y), bounds=(0, height), method="bounded",
                         options={"xatol": 1e-10}).x  # fmt: skip
    at = float(at)
    limit = 2e5 / l0 * (l0 - hypot(1.0, at)) * at / hypot(1.0, at)
    text = f"PLTRUSS 1 1 2\nPLTRUSS 2 2 3\nX 1 -1 0\nX 2 0 {height}\nX 3 1 0\nFIX 1\nFIX 3\nFIX 2 1\nDYNX 2 2\n"
    text += f"RLSE 1\nRLSE 2\nEND HALT\nESTIFF 1 1e5\nESTIFF 2 1e5\nXM 2 1\nITERSTEP 20 {steps} 1e-8\n"
    push = f"def push(t, ne, le, e, ep, nx, lnp, x, xp):\n    return t, [], [[2, 2, {-1.07 * limit!r}]]\n"
    (tmp_path / "push.py").write_text(push)
    for load in (f"XF 2 0 {-1.07 * limit!r}", "USERSIG push"):  # the second one followed the path beyond the limit
        (tmp_path / "truss.dat").write_text(f"{text}{load}\nEND END\n")
        assert 1.07 * limit_of(tmp_path / "truss.dat") == pytest.approx(1.0, abs=1e-7)


@pytest.mark.parametrize("general", ["", "1"])
@pytest.mark.parametrize("steps", [1, 2, 7])
def test_a_displaced_start_does_not_jump_over_a_limit_point(steps, general, monkeypatch):
    """1.2 times the limit load, from bars that begin a little too long: the first of few steps snapped through, as
    nothing was asked about a state that was reached while the force that holds the start fades."""
    monkeypatch.setenv("SPACAR_GENERAL", general)
    text = "PLTRUSS 1 1 2\nPLTRUSS 2 2 3\nX 2 1 0.5\nX 3 2 0\nFIX 1\nFIX 3\nDYNE 1\nDYNE 2\nEND HALT\nXM 2 1\n"
    text += f"ESTIFF 1 1\nESTIFF 2 1\nSTARTDE 1 1 0.02\nSTARTDE 2 1 0.03\nITERSTEP 60 {steps}\nXF 2 0 %r\nEND END\n"

    def force(y: float) -> float:
        return float(2 * y * (1 / hypot(1, 0.5) - 1 / hypot(1, y)))

    least = minimize_scalar(force, bounds=(0, 0.5), method="bounded")
    limit_of(text % (1.2 * float(least.fun)))
    height = brentq(lambda y: force(y) - 0.9 * least.fun, least.x, 0.5, xtol=1e-15)
    r = spacar.run(7, spacar.parse_deck(text % (0.9 * float(least.fun)), mode=7))
    assert r.node(2)[-1] == pytest.approx((1.0, height), abs=1e-9)


def test_thousands_of_steps_leave_fixed_nodes_where_they_are():
    """Predictions of fixed coordinates were extrapolated, and rounding grew with the number of levels: 6e-7 m."""
    r = spacar.run(7, spacar.parse_deck(toggle(4, "XF 9 0 -16", "30 2000 1e-6"), mode=7))
    n = r.mechanism.numbering
    assert np.array_equal(r.frames[-1].x[n.x_class["fixed"]], r.mechanism.x0[n.x_class["fixed"]])


def test_lee_frame_for_many_numbers_of_steps():
    limits = [2.5 * limit_of(models.lee(2.5, steps, 10)[0]) for steps in (3, 10, 77)]
    assert np.ptp(limits) < 1e-7


def test_the_limit_of_a_column_pushed_off_its_axis():
    """A rigid bar of length 1, 0.1 rad off the vertical, under P, held by a long spring k at its tip: about
    P = k cos a (sin a - sin a0)/sin a, whose largest value is found by differences."""
    a0, k = 0.1, 10.0
    x0, y0 = float(np.sin(a0)), float(np.cos(a0))
    text = f"""
PLRBEAM 1 1 2 3   PLTRUSS 2 3 4   X 3 {x0!r} {y0!r}   X 4 {x0 - 50.0!r} {y0!r}
FIX 1   FIX 4 1   INPUTX 4 2   DYNX 2   RLSE 2   END HALT
ESTIFF 2 {k * 50.0}   XM 3 1   XF 3 0 -10   ITERSTEP 20 40 1e-8   END END
"""

    def load(a: float) -> float:  # the long truss stays where its end is fixed: force k (l - l0) along it
        dx, dy = np.sin(a) - np.sin(a0) + 50.0, np.cos(a) - np.cos(a0)
        length = hypot(dx, dy)
        pull = k * (length - 50.0)
        fx, fy = -pull * dx / length, -pull * dy / length
        return float((-fx * np.cos(a) + fy * np.sin(a)) / np.sin(a))

    def slope(a: float) -> float:
        return (load(a + 1e-5) - load(a - 1e-5)) / 2e-5

    at = brentq(slope, 0.2, 1.2)
    assert 10.0 * limit_of(text) == pytest.approx(load(at), rel=1e-8)


@pytest.mark.slow
def test_the_toggle_for_all_numbers_of_steps(limit_load):
    for steps in [*range(1, 200), 333, 1000]:
        found = 20.0 * limit_of(toggle(4, "XF 9 0 -20", f"30 {steps} 1e-6"))
        assert found == pytest.approx(limit_load, rel=1e-8)


PYRAMID = """
X 1 0.794 -0.479 -0.124   FIX 1   FIX 2   X 3 0.733 -0.063 0.281
BEAM 1 1 2 3 4 -0.355 -0.5078 0.4889 0.029   DYNE 1 1   DYNE 1 2   DYNE 1 3   DYNE 1 4
X 5 1.273 -0.888 0.184   SCREW 2 1 2 5 6 0.4775 -0.564 0.7407 -0.1277
DYNE 2 1   DYNE 2 3   DYNE 2 4   DYNE 2 5   DYNE 2 6
X 7 1.377 0.022 0.241   X 8 1.787 -0.462 -0.039   FIX 8   X 9 0.705 -0.435 0.459   FIX 9
TRUSS 3 5 7   DYNE 3 1   TRUSS 4 7 8   TRUSS 5 7 9   END HALT
ESTIFF 1 64.495 13.356 13.394 11.042 0.03 0.025   XM 3 1.816
XM 4 0.326 0.042 0.0357 0.317 0.0202 0.298   ESTIFF 2 9.174 10.753 14.286 14.286 8.18 8.18
XM 5 0.829   XM 6 0.307 0.0301 -0.0164 0.226 0.0268 0.21   ESTIFF 3 31.673   XM 7 0.889   EM 1 0.374
EM 3 0.514   EM 4 0.512   EM 5 0.55   XF 3 0.3147 0.335 0.1773   GRAVITY 0.3836 -0.2661 -0.3006
ITERSTEP 60 {steps} 1e-12 1 0   END END
"""


@pytest.mark.parametrize("general", ["", "1"])
def test_a_pyramid_of_trusses_does_not_snap_through(general, monkeypatch):
    """One, two or three load steps went to the other side of the plane of three nodes, which the way back did not
    tell, as it failed; more steps named the limit point."""
    monkeypatch.setenv("SPACAR_GENERAL", general)
    for steps in (1, 2, 3, 10):
        assert limit_of(PYRAMID.format(steps=steps)) == pytest.approx(0.0065196133, rel=1e-6)


def test_a_path_beyond_the_limit_that_does_not_come_to_the_load(limit_load, monkeypatch):
    """Such as a closed curve, of which arcs have no end; here so few that the toggle is still falling."""
    monkeypatch.setattr(arc_length, "MOST_ARCS", 5)
    text = toggle(4, "XF 9 0 -20", "30 7 1e-6 1 0 0 1")
    assert 20.0 * limit_of(text) == pytest.approx(limit_load, rel=1e-8)
    with pytest.raises(AnalysisError, match="followed by arc length and was not seen to come to this loading"):
        spacar.run(7, spacar.parse_deck(text, mode=7))


# A wheel whose axle carries chains of bars that gravity pulls tight.
WHEEL_WITH_CHAINS = """
X 1 0.1 0.2   X 3 0.5 0.3   X 5 0.515 -0.559   X 8 0.346 -0.649   X 9 0.919 -0.356   X 10 1.329 0.093
X 12 -0.31 -0.963   X 13 -0.519 -1.823   FIX 5   FIX 6   FIX 7   FIX 10   FIX 13
DYNX 2   DYNX 4   KINX 1 1 2   PLRBEAM 1 1 2 3   PLWHEEL 2 3 2 4 0.336 0.0 1.0
PLBEAM 3 5 6 1 2   RLSE 3 1 2 3   PLTOR 4 7 4   RLSE 4 1   PLPINBOD 5 1 2 8   ORPINBOD 1 -0.6753 -0.8971
PLTRUSS 6 8 9   PLTRUSS 7 9 10   DYNE 7 1   DYNX 11 1   PLTOR 8 2 11   RLSE 8 1
PLTRUSS 9 8 12   PLTRUSS 10 12 13   DYNE 10 1   END HALT
XM 1 1.743   XM 3 1.658   XM 8 1.962   XM 9 1.839   XM 12 1.835   EM 6 0.369   EM 7 0.43   EM 9 0.549   EM 10 0.388
ESTIFF 3 88.957 12.911 0.017   ESTIFF 4 12.08   ESTIFF 5 12.377 11.114   ESTIFF 7 31.699   ESTIFF 8 10.369
ESTIFF 10 46.293   STARTDX 2 1 0.0421   STARTDX 4 1 0.0481   XF 9 -0.42 -0.1717   GRAVITY -0.4067 0.3765
ITERSTEP 60 2 1e-12 1 0 0 1   END HALT END END
"""


def test_an_arc_does_not_end_on_another_path():
    """The path is closed; an arc of it once ended on another one, which comes to the load. The limit point lies between
    the last part of the load step that converged and the next."""
    assert 0.159667 < limit_of(WHEEL_WITH_CHAINS) < 0.160157
