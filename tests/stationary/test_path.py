"""The equilibrium path: against exact rods, independent of load steps and releases, limit points, critical states."""

import numpy as np
import pytest
from spacar_drawing.picture_source import source_of_result
from spacar_drawing.stresses import resultants

import spacar
from spacar.errors import AnalysisError
from spacar.stationary import continuation
from spacar.stationary.level_evaluator import ArrayEquilibrium

from . import planar_models as models
from . import rods
from .test_stability import run
from .walk import levels, walked

CROSS_BODY, GUIDE_BODY = (0.1, 0.1), (0.0, 0.1)


def force(model: tuple[str, int], coordinate: int = 1, node: int = 0) -> np.ndarray:
    """External force of all stored steps at the node of a model."""
    forces = []
    for solver, level in levels(model[0], 8):
        if level.store:
            forces.append(solver.dynamics.sweep.rate_transposed(solver.solution.sigma))
    return np.array(forces)[:, solver.mechanism.numbering.x_index(node or model[1], coordinate)]


def falls_quadratically(values: list[float], exact: float) -> None:
    """Two meshes n, 2n: the error falls by four. Order within 0.15: the next term is of order h^4, 5 % at these n."""
    coarse, fine = (abs(v - exact) for v in values)
    assert abs(np.log2(coarse / fine) - 2.0) < 0.15
    assert fine < 2e-3 * abs(exact)


@pytest.mark.parametrize("d", [-0.01, pytest.param(0.01, marks=pytest.mark.slow)])
def test_cross_hinge_against_exact_rods(d):
    EA, EI = models.section(2e-4)
    exact = rods.two_leaves(models.CROSS, CROSS_BODY, EA, EI, 0.1 + d * np.linspace(0.1, 1.0, 10), False)
    falls_quadratically([force(models.cross_hinge(n, d))[-1] for n in (6, 12)], exact)


def test_turned_cross_hinge_against_exact_rods():
    EA, EI = models.section(2e-4)
    angles = 0.25 * np.pi * np.linspace(0.05, 1.0, 20)
    exact = rods.two_leaves(models.CROSS, CROSS_BODY, EA, EI, angles, True)
    moments = [force(models.turned_hinge(n, 0.25 * np.pi), node=7)[-1] for n in (6, 12)]
    falls_quadratically(moments, exact)


@pytest.mark.parametrize("t", [2e-4, pytest.param(1e-3, marks=pytest.mark.slow)])
def test_parallel_guide_against_exact_rods(t):
    EA, EI = models.section(t)
    exact = rods.two_leaves(models.GUIDE, GUIDE_BODY, EA, EI, np.linspace(0.002, 0.02, 10), False)
    falls_quadratically([force(models.guide(n, t, 0.02))[-1] for n in (6, 12)], exact)


BUILDS = {"hinge": lambda **k: models.cross_hinge(3, 0.01, **k), "guide": lambda **k: models.guide(4, 2e-4, 0.02, **k)}


@pytest.mark.parametrize("model", BUILDS.values(), ids=BUILDS)
def test_path_does_not_depend_on_steps_and_releases(model):
    """Equilibrium forces to 1e-8: the accepted forces are accurate to 1e-9 of the largest."""
    reference = force(model())[-1]
    for steps in (1, 3, 40):
        assert force(model(steps=steps))[-1] == pytest.approx(reference, rel=1e-8)
    for release in models.RELEASES:
        assert force(model(release=release))[-1] == pytest.approx(reference, rel=1e-8)


def test_lee_frame_before_the_limit_load():
    """Exact rods at P = 1.5, v = 25.84100; error of order h^2."""
    errors = []
    for n in (10, 20):
        text, p = models.lee(1.5, 5, n)
        result = run(text)
        x = result.frames[-1]
        base = [-x.fxtot[result.mechanism.numbering.x_index(1, c)] for c in (1, 2)]
        angle = 0.5 * np.pi + x.x[result.mechanism.numbering.x_index(2, 1)]
        exact = rods.lee(1.5, np.array([*base, angle]))
        assert 120.0 - exact[1] == pytest.approx(25.84100, abs=1e-5)
        errors.append(abs(result.node(p, 2)[-1] - exact[1]))
    assert abs(np.log2(errors[0] / errors[1]) - 2.0) < 0.15


def test_prescribed_load_stops_at_the_limit_point():
    """Limit load of the frame 1.8556 (exact rods); that of the mesh is below it with an error of order h^2."""
    errors = []
    for n in (10, 20):
        with pytest.raises(AnalysisError) as caught:
            run(models.lee(2.5, 10, n)[0])
        assert caught.value.code == "statics.limit-point"
        assert caught.value.exit_status == 1
        assert "ITERSTEP position 7" in str(caught.value)
        errors.append(1.8556 - 2.5 * caught.value.data["level"].initial)
    assert 3.3 < errors[0] / errors[1] < 4.7  # the limit is known to four digits, the coarse error is 0.028
    assert errors[1] < 0.01


@pytest.mark.parametrize("steps", [5, *(pytest.param(n, marks=pytest.mark.slow) for n in (1, 25))])
def test_path_beyond_the_limit_point_when_asked(steps):
    """P = 2.5 after the snap-through: v = 93.21722 by exact rods; 10 elements a bar are 0.073 away, 40 a sixteenth."""
    text, p = models.lee(2.5, steps, 10, follow=1)
    result = run(text)
    v = 120.0 - result.node(p, 2)[-1]
    x, n = result.frames[-1], result.mechanism.numbering
    base = [-x.fxtot[n.x_index(1, c)] for c in (1, 2)]
    exact = rods.lee(2.5, np.array([*base, 0.5 * np.pi + x.x[n.x_index(2, 1)]]))
    assert 120.0 - exact[1] == pytest.approx(93.21722, abs=1e-5)
    assert v == pytest.approx(93.21722, abs=0.1)
    assert any("limit points" in line for line in result.report)


def test_stored_levels_before_the_limit_point_are_kept():
    """The stream gives every stored step up to the limit, then the error."""
    text = models.lee(1.0, 10, 10)[0].replace("1 0 0 0", "1 2 1 0").replace("ITERSTEP", "DELXF 5 0. -1.5\nITERSTEP")
    stored = []

    with pytest.raises(AnalysisError, match="limit point"):
        stored.extend(spacar.frames(8, spacar.parse_deck(text, mode=8)))
    assert len(stored) == 6  # 1.0, 1.15, ..., 1.75; the limit of this mesh is 1.828


def test_clamped_beam_pushed_through_stays_symmetric():
    """The path from +h to -h is its own mirror image: the forces change their signs; 4 and 10 steps agree."""
    ends = []
    for steps in (4, 10):
        f = force(models.buckled(steps), coordinate=2)
        assert f[-1] == pytest.approx(-f[0], rel=1e-6)  # of the path; each force is accurate to 1e-9
        ends.append(f[-1])
    assert ends[0] == pytest.approx(ends[1], rel=1e-8)
    assert abs(ends[0]) > 30.0  # the antisymmetric branch has 12 N or 57 N with another sign


STRIP = """
{beams}   FIX 1   FIX 2   INPUTX {tip} 3   {classes}   END HALT
{stiff}   XF {tip} 0. 1e-3 0.   DELINPX {tip} 3 -0.01   ITERSTEP 20 {steps} 1e-8 1 2   END END
"""


def strip(steps: int, released: int, n: int = 6) -> spacar.Result:
    """Cantilever strip 100 x 20 x 0.2 mm on edge, a millinewton across, its tip pressed down by 10 mm."""
    E, G, h, t, l = 210e9, 80e9, 0.02, 2e-4, 0.1
    beams = [f"BEAM {k} {2 * k - 1} {2 * k} {2 * k + 1} {2 * k + 2} 0. 1. 0." for k in range(1, n + 1)]
    beams += [f"X {2 * k + 1} {l * k / n!r} 0. 0." for k in range(1, n + 1)]
    classes = [f"DYNE {k} " + ("2 3 4 5 6" if k != released else "1 2 4 5 6") for k in range(1, n + 1)]
    classes += [f"DYNE {k} 1" for k in range(1, n + 1) if k != released] + [f"RLSE {released} 3"]
    S = f"{E * h * t!r} {G * h * t**3 / 3!r} {E * h**3 * t / 12!r} {E * h * t**3 / 12!r}"
    stiff = [f"ESTIFF {k} {S}" for k in range(1, n + 1)] + [f"EM {k} 0.03" for k in range(1, n + 1)]
    text = STRIP.format(
        beams="\n".join(beams), classes="\n".join(classes), stiff="\n".join(stiff), tip=2 * n + 1, steps=steps
    )
    return run(text)


def test_imperfect_strip_takes_the_stable_branch():
    """Lateral buckling at 4.013 sqrt(EI GJ)/l^2 = 1.39 N: beyond it the force hardly grows, the strip gives way
    sideways; the flat branch has 800 N."""
    forces = []
    for steps, released in ((5, 6), (10, 6), (10, 1)):
        result = strip(steps, released)
        n = result.mechanism.numbering
        forces.append(result.frames[-1].fxtot[n.x_index(13, 3)])
        assert not any("unstable" in line for line in result.report)
    assert -1.8 < forces[0] < -1.39
    assert np.allclose(forces, forces[0], rtol=1e-7, atol=0.0)


SNAP = """
PLTRUSS 1 1 2   PLTRUSS 2 2 3   X 1 -1. 0.   X 2 0. 0.1   X 3 1. 0.   FIX 1   FIX 3   {classes}
END HALT
ESTIFF 1 1000.   ESTIFF 2 1000.   XM 2 1.   XF 2 0. {load}   ITERSTEP {settings}   END END
"""
SHALLOW = "FIX 2 1\nDYNX 2 2\nRLSE 1\nRLSE 2"


def test_failure_says_where_and_what_to_do():
    """One iteration is too few to follow the snap-through."""
    text = SNAP.format(classes=SHALLOW, load=-1.0, settings="1 4 5e-7 1 0 0 1")
    with pytest.raises(AnalysisError) as caught:
        run(text)
    assert caught.value.code == "statics.no-convergence"
    for part in ("of 4 (", "residual", "ITERSTEP", "cut to", "last solution", "0 negative eigenvalues"):
        assert part in str(caught.value)


def resisting(y: np.ndarray | float) -> np.ndarray:
    """Downward force of both bars on the node at the height y, 0.1 at rest: linear strain (l - l0) EA/l0."""
    l0, l = np.hypot(1.0, 0.1), np.hypot(1.0, y)
    return 2e3 * (l0 - l) / l0 * y / l


@pytest.mark.parametrize("classes", [SHALLOW, "DYNE 1 1\nDYNE 2 1"])
@pytest.mark.parametrize("steps", [1, 2, 3, 4, 5, 8, 12, 16, 40])
def test_a_shallow_truss_does_not_snap_through_without_a_word(steps: int, classes: str) -> None:
    """Its limit load is 0.3811 N; at 1 N only the state that hangs through is left, stable, but not on the path."""
    highest = resisting(np.linspace(0.0, 0.1, 200_001)).max()
    with pytest.raises(AnalysisError, match=r"limit point at 0[.]381") as caught:
        run(SNAP.format(classes=classes, load=-1.0, settings=f"20 {steps} 1e-10"), mode=7)
    assert caught.value.data["level"].initial == pytest.approx(highest, rel=1e-8)
    if classes == SHALLOW:
        assert "node 2 y" in str(caught.value)


def test_snap_through_of_a_shallow_truss_when_asked():
    end = run(SNAP.format(classes=SHALLOW, load=-1.0, settings="10 4 1e-10 1 0 0 1")).node(2, 2)[-1]
    assert end < -0.1
    assert resisting(end) == pytest.approx(1.0, rel=1e-9)


@pytest.mark.parametrize("steps", [1, 3, 20])
def test_a_shallow_truss_below_its_limit_load(steps: int) -> None:
    y = run(SNAP.format(classes="DYNE 1 1\nDYNE 2 1", load=-0.35, settings=f"20 {steps} 1e-10"), mode=7).node(2, 2)[-1]
    assert resisting(y) == pytest.approx(0.35, rel=1e-8)  # FORCES of newton.py: 1e-9, twice the work


# More unknowns than are counted at every level: the determinant of the factorization tells where to count.
def report_of_column(n: int, load: float, steps: int) -> list[str]:
    """A straight column of length 1 with EI = 1, clamped at its foot, in n beams, loaded in equal steps."""
    rows: list[tuple] = [("PLBEAM", k + 1, 2 * k + 1, 2 * k + 2, 2 * k + 3, 2 * k + 4) for k in range(n)]
    rows += [("X", 2 * k + 1, k / n, 0.0) for k in range(1, n + 1)] + [("FIX", 1), ("FIX", 2)]
    rows += [("DYNE", k + 1, 1, 2, 3) for k in range(n)]
    dynamics: list[tuple] = [("ESTIFF", k + 1, 1e4, 1.0) for k in range(n)]
    loads = ("XF", 2 * n + 1, -load), ("ITERSTEP", 20, steps, 1e-8)
    return walked(spacar.Deck.build(rows, [*dynamics, *loads])).report.lines


@pytest.mark.parametrize("n", [20, 120])
def test_a_critical_load_between_stored_levels_is_said_where_it_is(n: int) -> None:
    """pi^2/4 = 2.467 of the load 4 is 0.617: the path loses its stability in step 7 of 10, nothing else is stored."""
    report = report_of_column(n, 4.0, 10)
    passed = [line for line in report if "critical state is passed" in line]
    assert len(passed) == 1
    assert "load step 7 of 10" in passed[0]
    assert "1 negative eigenvalue more" in passed[0]
    assert any("unstable equilibrium" in line for line in report)


def test_levels_between_stored_ones_cost_no_count(monkeypatch: pytest.MonkeyPatch) -> None:
    """Below the critical load: one count at the start, one at the stored level."""
    counts, counted = [], ArrayEquilibrium.stability
    monkeypatch.setattr(ArrayEquilibrium, "stability", lambda *a: counts.append(counted(*a)) or counts[-1])
    report_of_column(120, 2.0, 10)
    assert [c.negative for c in counts] == [0, 0]
    assert continuation.LARGE < 3 * 120 * 2


def test_the_moment_at_the_clamp_converges_to_that_of_the_rod():
    """Of a leaf of the published guide (SPACAR Light, 20 mm): the error, 2 % of three beams, falls by four with every
    halving."""
    EA, EI = models.section(5e-4)
    exact = abs(rods.clamps(models.GUIDE, GUIDE_BODY, EA, EI, 0.02 * np.linspace(0.1, 1.0, 10))[0, 2])
    errors = []
    for n in (6, 12):
        text, _ = models.guide(n, 5e-4, 0.02)
        source = source_of_result(spacar.run(8, spacar.parse_deck(text, mode=8)))
        last, e = len(source.x()), source.scene.elements[0]
        r = resultants(source.scene, e, source.get("sig", last), source.get("e", last), 2)
        assert r is not None
        errors.append(exact - abs(r.Mz[0]))
    assert 0.0 < errors[1] < 2e-3 * exact
    assert abs(np.log2(errors[0] / errors[1]) - 2.0) < 0.15
