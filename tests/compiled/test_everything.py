"""Both engines give the same for every example and for what Python answers in the compiled one: to rounding.

A state is known to 1e-11 of the size of the mechanism where the general path stops (frames in C are exact to
rounding), and stiffness turns that into forces: 1e-8 of the largest value of each kind (of 1 m, 1 N ... where the
mechanism is at rest), forces compared with stresses and deformations with coordinates, as in test_everything.py.
"""

from pathlib import Path

import numpy as np
import pytest
from models import cantilever

import spacar
from spacar.compiled import CompiledDynamics
from spacar.compiled.library import unavailable
from spacar.compiled.numbers import without_form
from spacar.dynamics import Dynamics
from spacar.elements.spatial.angle_measure import rotation_factor
from spacar.errors import AnalysisError, SpacarError
from spacar.kinematics.kinematics import CONVERGED
from spacar.mechanism import build
from tests.examples import DATA
from tests.studies.all_elements import MODELS, deck_of

from .other_ways import pushed, started

pytestmark = pytest.mark.skipif(unavailable() is not None, reason=str(unavailable()))

LIKE = {"e": "x", "ed": "xd", "edd": "xdd", "fx": "sig", "fxgrav": "sig", "fxtot": "sig"}


def in_mode_1() -> list[str]:
    found = []
    for path in sorted(DATA.glob("*.dat")):
        try:
            spacar.frames(1, path)
        except SpacarError:
            continue
        found.append(path.stem)
    return found


def same(mechanism: spacar.Result, moved: float = 1e-2) -> CompiledDynamics:
    """Frames and derivatives at the start and at two states near it; C did all, but for very stiff models, whose
    reduced mass matrix is lost in rounding."""
    general, compiled = Dynamics(mechanism), CompiledDynamics(mechanism)
    y, rng = general.start(), np.random.default_rng(4)
    np.testing.assert_array_equal(compiled.start(), y)
    if moved > 1e-3:
        compiled._in_general = None
    n = general.n_positions
    for k in range(3):
        state = y + (k > 0) * np.r_[moved * rng.standard_normal(n), rng.standard_normal(len(y) - n)]
        a, b = general.frame(1e-3 * k, state), compiled.frame(1e-3 * k, state)
        for name in ("x", "xd", "xdd", "e", "ed", "edd", "sig", "fx", "fxgrav", "fxtot"):
            want, got = getattr(a, name), getattr(b, name)
            size = max(np.abs(getattr(a, n)).max(initial=1.0) for n in (name, LIKE.get(name, name)))
            np.testing.assert_allclose(got, want, atol=1e-8 * size, rtol=0, err_msg=name)
        if len(y):
            want, got = (evaluator.rhs(1e-3 * k, state, 1e-15) for evaluator in (general, compiled))
            np.testing.assert_allclose(got, want, atol=1e-8 * max(np.abs(want).max(), np.abs(a.xdd).max(), 1.0))
    return compiled


@pytest.mark.parametrize("name", in_mode_1())
def test_every_example(name: str) -> None:
    stiff = name in ("crosshingew", "leafguide")  # short leaf springs cannot be bent by a hundredth
    same(spacar.frames(1, DATA / f"{name}.dat").mechanism, 1e-4 if stiff else 1e-2)


def mechanism(rows: list[tuple], dynamics: list[tuple]) -> spacar.Result:
    return spacar.frames(1, spacar.Deck.build(rows, [*dynamics, ("TIMESTEP", 0.1, 2)])).mechanism


@pytest.mark.parametrize("name", MODELS)
def test_every_element_moment_and_coupling(name: str) -> None:
    """Both measures, moments whose dual forces follow the orientation, MEE, slips, prescribed motions."""
    whole = build(deck_of(name), 1)
    assert without_form(whole) == []
    same(whole)


@pytest.mark.parametrize("angle", [False, True])
@pytest.mark.parametrize("end", [0, 1, 2, 3])
@pytest.mark.parametrize("tube", ["PLTUBE", "TUBE", "ORTUBE"], ids=["planar", "spatial", "curved"])
def test_tubes_with_flow(tube: str, end: int, angle: bool) -> None:
    rows, law = MODELS[tube]
    law = [(*r[:6], end, *r[7:]) if r[0] == "EM" else r for r in law]
    whole = mechanism([*rows, *[("ADEFORM",)] * angle], law)
    assert without_form(whole) == []
    same(whole, 3e-2)


def test_screws_and_belts_count_turns() -> None:
    """In steps of 0.7 rad to more than two turns: a nut on its screw, and a planet around a wheel that stands still."""
    screw = [("SCREW", 1, 1, 2, 3, 4, 1.0, 0.0, 0.0, 0.05), ("FIX", 1), ("FIX", 2), ("DYNE", 1, 1)]
    belt = [("PLBELT", 1, 1, 2, 3, 4, 0.3, -0.1), ("PLRBEAM", 2, 1, 5, 3), ("X", 3, 0.5), ("FIX", 1), ("FIX", 2)]
    nut, wheel = [("XM", 3, 1.0), ("XM", 4, 0.1, 0, 0, 0.1, 0, 0.1)], [("XM", 3, 1.0), ("XM", 4, 0.1)]
    models = [(mechanism(screw, nut), 3, 0.05), (mechanism([*belt, ("DYNX", 5, 1)], wheel), 4, (0.3 + 0.1) / 0.1)]
    for model, node, ratio in models:
        general, compiled, _ = started(model)
        compiled._in_general = None
        place = model.numbering.lnp[node - 1, 0] - 1
        for k in range(22):
            y = np.array([0.7 * k, 1.0])
            a, b = general.frame(0.1 * k, y), compiled.frame(0.1 * k, y)
            for name in ("x", "e", "edd", "sig"):
                np.testing.assert_allclose(getattr(b, name), getattr(a, name), atol=1e-11)
            assert b.x[place] == pytest.approx(ratio * y[0], abs=1e-12)


PENDULUM = """PLBEAM 1 1 2 3 4   X 3 1. 0.   FIX 1   {klass}   END HALT
XM 3 2.   {more}   TIMESTEP 1. 10   END END
"""


def test_user_functions_are_called_for_their_share(tmp_path: Path) -> None:
    law = "return t, [[1, 2, 3*e[le[0][1]] + ep[le[0][1]]]], [[3, 2, -5.0 * t]]"
    path = pushed(tmp_path, law, PENDULUM.format(klass="DYNX 2 1\nDYNE 1 2", more="XM 4 0.1\nEM 1 0.5"))
    same(spacar.frames(1, path).mechanism)
    runs = [spacar.run(1, path, rtol=1e-8, atol=1e-8, compiled=c) for c in (True, False)]
    np.testing.assert_allclose(runs[0]["x"], runs[1]["x"], atol=1e-7)


def test_a_user_function_that_fails_says_so_as_in_the_general_path(tmp_path: Path) -> None:
    path = pushed(tmp_path, "if t > 0.5: raise RuntimeError('too late')\n    return t, [], [[3, 2, -5.0]]")
    said = []
    for compiled in (True, False):
        with pytest.raises(AnalysisError) as found:
            spacar.run(1, path, compiled=compiled)
        said.append((found.value.code, str(found.value).split(" at t = ")[0]))
    assert said[0] == said[1] == ("user-function.failed", "the user function push failed")


def test_prescribed_motion_of_a_user_function(tmp_path: Path) -> None:
    """phi = sin 3t: values, rates and accelerations; stages of a step ask for it too."""
    function = "import math\ndef push(t, step):\n  s, c = math.sin(3*t), math.cos(3*t)\n"
    function += "  return t, [], [[2, 1, s, 3*c, -9*s]]\n"
    klass, more = "INPUTX 2 1\nDYNE 1 2", "INPUTX 2 1\nESTIFF 1 0. 40.\nXM 4 0.1\nUSERINP push"
    (tmp_path / "push.py").write_text(function)
    path = tmp_path / "model.dat"
    path.write_text(PENDULUM.format(klass=klass, more=more))
    compiled = same(spacar.frames(1, path).mechanism)
    assert not compiled.solver.slots.polynomial
    runs = [spacar.run(1, path, rtol=1e-8, atol=1e-8, integrator=853, compiled=c) for c in (True, False)]
    np.testing.assert_allclose(runs[0]["x"], runs[1]["x"], atol=1e-7)


def test_a_pivot_order_that_loses_digits_is_chosen_again() -> None:
    """Accelerations of cardan in millionths of a metre had eight digits less when multipliers could grow to 1000."""
    a, b = (list(spacar.frames(1, DATA / "cardan.dat", compiled=c)) for c in (True, False))
    for one, other in zip(a, b, strict=True):
        np.testing.assert_allclose(one.xdd, other.xdd, atol=1e-11 * max(np.abs(other.xdd).max(), 1e-12))


# The compiled right-hand side gives the numbers of the general path, and says so when it cannot be used.
@pytest.mark.parametrize("angle", [0.0, 0.5, 1.0, 3.0])
def test_the_start_is_that_of_the_general_path(angle):
    """Near starts, and those of a tree, are placed in C, others in the general path; they differ by rounding only.
    Deformations of the general path are those before its last correction, which is below CONVERGED."""
    text = (DATA / "robotsim.dat").read_text().split("HALT")
    rows = f"STARTDE 1 1 {angle} 1.\nSTARTDE 2 1 {angle} 0.\nEND\nEND"
    mechanism = build(spacar.parse_deck(f"{text[0]}HALT{text[1].replace('END', rows)}", mode=1), 1)
    general, compiled, y = started(mechanism)
    np.testing.assert_array_equal(compiled.start(), y)
    for x in (compiled.state.x[:, 0], compiled.numpy_evaluator().kinematics.x):
        np.testing.assert_allclose(x, general.kinematics.x, atol=1e-14)
    np.testing.assert_allclose(compiled.state.e[:, 0], general.sweep.e, atol=CONVERGED)
    np.testing.assert_allclose(compiled.placement().xd, general.xd, atol=1e-13)
    assert compiled.condition() == pytest.approx(general.condition(), rel=1e-12)


def test_a_motion_without_mass_is_named_as_in_the_general_path():
    """The factorization in C fails there, and the general path explains."""
    text = (DATA / "robotsim.dat").read_text().replace("XM ", "% XM ").replace("EM ", "% EM ")
    with pytest.raises(AnalysisError, match="no inertia on the motion of") as found:
        list(spacar.frames(1, spacar.parse_deck(text, mode=1), compiled=True))
    assert found.value.code == "dynamics.singular-mass"


@pytest.mark.parametrize(("code", "asked", "x"), [(-1, 1e-9, 1e-8), (430, None, 1e-7)], ids=["explicit", "implicit"])
def test_a_simulation_is_the_same(code, asked, x):
    """The step sequences agree up to rounding, the results to the tolerance; ERROR's default 1e-5 ends Newton's
    iteration of the stages of an implicit method, which needs the exact Jacobian of the same state."""
    given = {} if asked is None else {"atol": asked, "rtol": asked}
    options = {"integrator": code, "duration": 0.005 if asked else 0.002, "n_steps": 5 if asked else 2, **given}
    a, b = (spacar.run(1, DATA / "crankfl.dat", compiled=c, **options) for c in (False, True))
    np.testing.assert_allclose(b["x"], a["x"], atol=x)
    if asked:
        np.testing.assert_allclose(b["sig"], a["sig"], atol=1e-5 * np.abs(a["sig"]).max())


def test_checks_see_the_state_that_c_evaluated():
    """Determinant and condition from the factors in C are those of the matrix of the general path at the same state."""
    general, compiled, y = started(spacar.frames(1, DATA / "robotsim.dat").mechanism)
    for evaluator in (general, compiled):
        evaluator.rhs(0.0, y + 0.1)
    expected, found = general.position_matrix(), compiled.position_matrix()
    # the position is known to 1e-11 (CONVERGED), the matrix and what depends on it to a hundred times that
    assert found.rcond() == pytest.approx(expected.rcond(), rel=1e-9)
    assert found.determinant() == pytest.approx(expected.determinant(), rel=1e-9)
    numpy_evaluator = compiled.numpy_evaluator()
    np.testing.assert_allclose(numpy_evaluator.kinematics.x, general.kinematics.x, atol=1e-10)  # ten times CONVERGED
    matrices = (d.kinematics.velocity_system.A for d in (numpy_evaluator, general))
    np.testing.assert_allclose(*matrices, atol=1e-9)


def test_a_far_state_is_reached_in_pieces(monkeypatch):
    """1.5 rad on are more than a jump (0.8): C goes there in pieces, and the general path is not asked."""
    general, compiled, y = started(spacar.frames(1, DATA / "robotsim.dat").mechanism)
    monkeypatch.setattr(compiled, "_in_general", None)
    y[:3] += 1.5
    expected = general.frame(0.1, y)
    found = compiled.frame(0.1, y)
    np.testing.assert_allclose(found.x, expected.x, atol=1e-10)  # ten times CONVERGED


def test_checks_see_the_state_that_c_could_not_do(monkeypatch):
    """Then the general path has evaluated it, and its matrix counts: the factors in C are of another state."""
    general, compiled, y = started(spacar.frames(1, DATA / "robotsim.dat").mechanism)
    compiled.rhs(0.0, y)
    general.rhs(0.1, y + 0.1)
    monkeypatch.setattr(type(compiled.solver), "rhs", lambda *arguments: -1)
    compiled.rhs(0.1, y + 0.1)
    expected, found = general.position_matrix(), compiled.position_matrix()
    assert found.determinant() == pytest.approx(expected.determinant(), rel=1e-9)
    assert found.rcond() == pytest.approx(expected.rcond(), rel=1e-9)


@pytest.mark.parametrize(("angle", "sure"), [(0.1, True), (0.7, True), (0.8, False), (1.4, False)])
def test_guards_know_which_elements_are_surely_in_range(angle, sure):
    """Bending of 45 degrees (0.785) is what they let pass; beyond, the elements are asked themselves."""
    text = "PLBEAM 1 1 2 3 4\nX 3 1. 0.\nFIX 1\nFIX 2\nDYNE 1 2 3\nEND\nHALT\nEM 1 1.\nESTIFF 1 0. 1.\nEND\nEND\n"
    compiled = CompiledDynamics(spacar.frames(1, spacar.deck.parse_deck(text, mode=1)).mechanism)
    y = compiled.start()
    y[:2] = 0.0, np.sin(angle)  # e3 is the sine of the end rotation, times the length
    for part in np.linspace(0.0, 1.0, 11):
        compiled.frame(part, part * y)
    assert compiled.in_range() is sure


@pytest.mark.parametrize("n", [3, 150])
def test_chains_of_any_length_have_a_compiled_form(n):
    """The sparse factors of the saddle-point form know no limit of size. Bound as in test_everything.py."""
    text = cantilever(n, EI=1.0, length=1.0, dynamics=("GRAVITY 0. -9.81", "TIMESTEP 0.01 1"))
    general, compiled, y = started(spacar.frames(1, spacar.deck.parse_deck(text, mode=1)).mechanism)
    rng = np.random.default_rng(1)
    state = y + 1e-3 / n * rng.standard_normal(len(y))
    expected = general.rhs(0.0, state)
    np.testing.assert_allclose(compiled.rhs(0.0, state), expected, atol=1e-8 * np.abs(expected).max())


def test_the_order_of_the_pivots_follows_the_position():
    """Two revolutions of crank.dat: entries that were pivots vanish on the way, and another order takes over.

    Reactions are compared with those of the general path, which chooses its pivots anew at every step.
    """
    options = {"duration": 0.0837758040957278, "n_steps": 200}  # 4 pi at 150 rad/s
    a = spacar.run(1, DATA / "crank.dat", **options)
    b = spacar.run(1, DATA / "crank.dat", compiled=True, **options)
    for name in ("x", "xdd", "sig", "fxtot"):
        np.testing.assert_allclose(b[name], a[name], atol=1e-9 * np.abs(a[name]).max(), rtol=0)


def test_rotation_factor_in_c_far_from_one():
    """A beam twisted by 2.2 rad: the closed form of G in C."""
    rows = [("BEAM", 1, 1, 2, 3, 4, 0.0, 1.0, 0.0), ("X", 3, 1.0, 0.0, 0.0), ("FIX", 1), ("FIX", 2), ("DYNE", 1, 2)]
    dynamics = [("ESTIFF", 1, 0.0, 2.0), ("EM", 1, 1.0, 0.5), ("STARTDE", 1, 2, 2.2, 0.0), ("TIMESTEP", 0.5, 2)]
    deck = spacar.Deck.build([*rows, ("ADEFORM",)], [*dynamics, ("ERROR", 1e-11, 1e-11)])
    result = spacar.run(1, deck, compiled=True)
    phi = 2 * np.arctan2(result.node(4, 2), result.node(4, 1))
    omega = np.sqrt(2.0 / 0.25)  # GIt/l0 over the half of the inertia that is at the end
    np.testing.assert_allclose(phi, 2.2 * np.cos(omega * np.array([0.0, 0.25, 0.5])), atol=1e-8)
    assert rotation_factor(np.array([np.cos(1.1)]))[0, 0] == pytest.approx(2.2 / np.sin(1.1))
