"""States at rest in C (`spacar.stationary.equilibrium`) against the general path and against dense linear algebra."""

import numpy as np
import pytest
from statics import cantilever

from spacar.compiled.compiled_elements import with_compiled_elements
from spacar.compiled.library import why_off
from spacar.deck import parse_deck, read_deck
from spacar.errors import AnalysisError, Report
from spacar.mechanism import build
from spacar.stationary import LoadLevel, LoadProgram, StationarySolver, equilibrium
from spacar.stationary.equilibrium import CompiledEquilibrium, level_equilibrium
from spacar.stationary.level_evaluator import LevelEvaluator
from spacar.stationary.newton import Demand, newton
from spacar.stationary.resting_tangent import RestingTangent
from spacar.stationary.stationary_equations import Astray
from tests.examples import DATA

pytestmark = pytest.mark.skipif(why_off() is not None, reason=str(why_off()))

PRESCRIBED = """PLBEAM 1 1 2 3 4   PLBEAM 2 3 4 5 6   PLTRUSS 3 1 5   X 3 1. 0.   X 5 2. 0.1
FIX 1   FIX 2   INPUTX 5 2   DYNE 1 1 2 3   DYNE 2 1 2   RLSE 2 3   RLSE 3 1   END HALT
EM 1 1.   ESTIFF 1 1000. 3.   ESTIFF 2 1000. 2.   ESIG 1 0.3 0.01 0.02   INPUTX 5 2 0.15 0. 0.
XF 3 0.4 -0.2   DELXF 3 0. 0.5   DELINPX 5 2 0.05   ITERSTEP 20 4 1e-10 2 1   END END
"""
SPATIAL = """BEAM 1 1 2 3 4 0. 1. 0.   BEAM 2 3 4 5 6 0. 1. 0.   X 3 1. 0. 0.   X 5 2. 0. 0.3
FIX 1   FIX 2   DYNE 1 1 2 3 4 5 6   DYNE 2 1 2 3 4 5 6   END HALT
EM 1 2.   EM 2 2.   ESTIFF 1 5e4 20. 30. 40. 0. 0.   ESTIFF 2 5e4 20. 30. 40. 0. 0.
GRAVITY 0. 0. -9.81   XF 5 3. 2. 1.   ITERSTEP 20 3 1e-10   END END
"""
TEXTS = {"cantilever": cantilever(6), "long": cantilever(90), "prescribed": PRESCRIBED, "spatial": SPATIAL}


def evaluator(text: str) -> CompiledEquilibrium:
    return CompiledEquilibrium(LevelEvaluator(with_compiled_elements(build(parse_deck(text, mode=7), 7))))


def near_start(e: CompiledEquilibrium) -> tuple[np.ndarray, np.ndarray]:
    """A state that is no equilibrium."""
    rng, n = np.random.default_rng(3), e.mechanism.numbering
    x, sigma = e.mechanism.x0.copy(), np.where(e.levels._equations.passive, 0.0, rng.normal(size=n.ne))
    F = e.levels._equations.F
    x[F] += 0.02 * e.levels.scale[F] * rng.normal(size=len(F))
    return x, sigma


@pytest.mark.parametrize("name", TEXTS)
def test_the_residual_and_the_size_of_its_terms_are_those_of_the_general_path(name):
    e = evaluator(TEXTS[name])
    n = e.mechanism.numbering
    held = 1e-3 * np.random.default_rng(5).normal(size=n.nx + n.ne)
    for level in (LoadLevel(0.0, 0.0), LoadLevel(0.4, 0.0), LoadLevel(1.0, 0.7)):
        e.levels.set_fading_force(held, until=0.9)
        e.load(level)
        x, sigma = near_start(e)
        found = e.point(x, sigma)
        p = e.levels.equations.point(x, sigma, e.levels.given)  # puts loads and elements in place
        size = np.abs(p.rounding) / np.finfo(float).eps
        np.testing.assert_allclose(found.right, p.right, rtol=0.0, atol=1e-13 * max(1.0, size.max()))
        np.testing.assert_allclose(found.rounding, p.rounding, rtol=1e-12, atol=1e-30)
        for number in ("force", "work", "work_size", "gap"):
            assert getattr(found, number) == pytest.approx(getattr(p, number), rel=1e-10), number
        assert found.quiet == p.quiet
        np.testing.assert_array_equal(found.x, x)
        np.testing.assert_array_equal(found.sigma, p.sigma)


@pytest.mark.parametrize("name", TEXTS)
def test_iterations_are_those_of_the_general_path(name):
    e = evaluator(TEXTS[name])
    x, sigma = e.mechanism.x0.copy(), np.zeros(e.mechanism.numbering.ne)
    branch = e.levels.branch.copy()
    for stored in (False, True):
        e.load(LoadLevel(0.1, 0.0))
        e.levels.branch[:] = branch
        demand = Demand.of(20, 1e-8, stored)
        found = e.newton(x, sigma, demand)
        turns = e.levels.branch.copy()
        e.levels.branch[:] = branch
        general = newton(e.levels.equations, e.levels.tangent, x, sigma, e.levels.given, demand)
        assert found.iterations == general.iterations > 0
        assert found.regular == general.regular
        np.testing.assert_allclose(found.point.x, general.point.x, rtol=0.0, atol=1e-12)
        np.testing.assert_allclose(found.point.sigma, general.point.sigma, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(turns, e.levels.branch, rtol=0.0, atol=1e-12)
        assert found.noise == pytest.approx(general.noise, rel=0.5)


@pytest.mark.parametrize(("part", "limit"), [(1.0, 2), (30.0, 20), (1e6, 20), (np.nan, 20)])
def test_an_iteration_that_goes_astray_says_the_same(part, limit):
    e = evaluator(TEXTS["cantilever"].replace("ITERSTEP 20", f"ITERSTEP {limit}"))
    x, sigma = e.mechanism.x0.copy(), np.zeros(e.mechanism.numbering.ne)
    demand = Demand.of(limit, 1e-10, True)
    e.load(LoadLevel(part, 0.0))
    with pytest.raises(Astray) as ours:
        e.newton(x, sigma, demand)
    e.levels.branch[:] = 0.0
    with pytest.raises(Astray) as general:
        newton(e.levels.equations, e.levels.tangent, x, sigma, e.levels.given, demand)
    assert str(ours.value) == str(general.value)


@pytest.mark.parametrize("name", TEXTS)
def test_the_sign_of_the_determinant(name):
    e = evaluator(TEXTS[name])
    e.load(LoadLevel(0.3, 0.0))
    p = e.point(*near_start(e))
    sign = e.factored_sign(p)
    assert isinstance(e.levels.tangent, RestingTangent)
    e.levels.tangent.factor(p)
    assert sign == e.last_sign() == e.levels.tangent.sign()
    assert sign == np.sign(np.linalg.slogdet(e.levels.tangent.dense())[0]) * (-1.0) ** e.levels.tangent.t.ne


@pytest.mark.parametrize("name", TEXTS)
@pytest.mark.parametrize("pressed", [0.0, 1.0, 30.0])
def test_the_proof_of_stability_is_that_of_the_general_path(name, pressed):
    e = evaluator(TEXTS[name])
    e.load(LoadLevel(0.3, 0.0))
    x, sigma = near_start(e)
    p = e.point(x, -pressed * np.abs(sigma))
    proved = e.is_definite(p)
    assert isinstance(e.levels.tangent, RestingTangent)
    assert proved == e.levels.tangent.is_definite(p)
    if proved:
        assert e.levels.tangent.inertia(p)[0] == e.levels.tangent.t.ne


def test_a_singular_matrix_is_left_to_python():
    """A free rotation: the motion of minimum norm is that of the general path."""
    text = "PLTRUSS 1 1 2\nX 2 1. 0.\nFIX 1\nDYNE 1 1\nDYNX 2 2\nEND\nHALT\nESTIFF 1 100.\nXF 2 3. 0.\nEND\nEND\n"
    e = evaluator(text)
    e.load(LoadLevel(1.0, 0.0))
    n = e.mechanism.numbering
    assert e.tried(e.mechanism.x0.copy(), np.zeros(n.ne), Demand.of(20, 1e-8, True)) is None
    found = e.newton(e.mechanism.x0.copy(), np.zeros(n.ne), Demand.of(20, 1e-8, True))
    assert found.point.x == pytest.approx([0.0, 0.0, 1.03, 0.0], abs=1e-12)
    assert found.point.sigma == pytest.approx([3.0])


def test_a_stiffness_that_is_singular_to_working_precision_is_left_to_python():
    """Bending of which the second mode repeats the first: to a thousandth, to the last digit, wholly."""
    text = TEXTS["cantilever"]
    m = with_compiled_elements(build(parse_deck(text, mode=7), 7))
    family = next(b.family for b in m.batches if b.family.n_deformations == 3)
    S, damping = (part.copy() for part in family.stiffness())
    for part, taken in ((1e-3, True), (1e-15, False), (0.0, False)):
        S[1, 2] = S[2, 1] = S[1, 1] = 1.0
        S[2, 2] = 1.0 + part
        family.general.__dict__["constitutive"] = S, damping
        assert isinstance(level_equilibrium(m), CompiledEquilibrium) == taken
    with pytest.raises(AnalysisError, match="singular to working precision"):
        _ = LevelEvaluator(m).equations


def test_what_has_no_form_in_c_is_left_to_python(monkeypatch):
    def taken(text: str) -> bool:
        m = with_compiled_elements(build(parse_deck(text, mode=7), 7))
        return isinstance(level_equilibrium(m), CompiledEquilibrium)

    spatial = TEXTS["spatial"]
    assert taken(spatial)
    assert not taken(spatial.replace("XF 5 3. 2. 1.", "XF 6 0.1 0.2 0.3"))  # a moment follows the orientation
    assert not taken(TEXTS["prescribed"].replace("INPUTX 5 2 0.15 0. 0.", "INPUTX 5 2 0.15 1. 0."))  # motion
    assert taken(TEXTS["long"])
    monkeypatch.setattr(equilibrium, "widest_band", lambda n, mixed: 20.0)
    assert not taken(TEXTS["long"])
    assert taken(TEXTS["cantilever"])  # dense in Python


@pytest.mark.parametrize("name", ["lateral4", "robotsim", "plbeam5", "massspring", "crankfl", "cardan", "finger"])
def test_models_end_where_the_general_path_does(name):
    states, reports = [], []
    for compiled in (False, True):
        m = build(read_deck(DATA / f"{name}.dat", 8), 8)
        solver = StationarySolver(with_compiled_elements(m) if compiled else m, Report())
        for level in LoadProgram(m.settings):
            solver.solve(level)
            if not level.store:
                continue
            states.append((solver.dynamics.kinematics.x.copy(), solver.solution.sigma, solver.iterations))
        reports.append(len(solver.report.lines))
    half = len(states) // 2
    for (x, sigma, iterations), (x_c, sigma_c, iterations_c) in zip(states[:half], states[half:], strict=True):
        np.testing.assert_allclose(x_c, x, rtol=0.0, atol=1e-11 * np.abs(x).max())
        np.testing.assert_allclose(sigma_c, sigma, rtol=0.0, atol=1e-10 * max(np.abs(sigma).max(), 1e-3))
        assert iterations == iterations_c
    assert reports[0] == reports[1]
