"""Angles that count whole turns: belts of nearly equal radii, hinges and screws, in both engines, lanes and statics.

Truth: (15) of theory-planar.md with the angle theta of an arm, e1 = -rho theta for pulleys that do not turn; released
hinges and screws follow what they are driven by.
"""

import numpy as np
import pytest

import spacar
from spacar.kinematics.kinematics import Kinematics

ENGINES = pytest.mark.parametrize("compiled", [True, False])
RADII = [(0.05, 0.0499), (0.0499, 0.05), (0.05, 0.05 - 1e-9), (0.2, 0.05), (0.1, -0.1), (0.1, 0.1)]


def arm(rp: float, rq: float, of_arm: str) -> list[tuple]:
    """A pulley carried around another one; both keep their orientations, the belt stretches."""
    return [
        ("PLBELT", 1, 1, 2, 3, 4, rp, rq), ("PLRBEAM", 2, 1, 5, 3), ("X", 3, 1.0), ("FIX", 1), ("FIX", 2), ("FIX", 4),
        (of_arm, 5), ("RLSE", 1),
    ]  # fmt: skip


@ENGINES
@pytest.mark.parametrize(("rp", "rq"), RADII)
def test_belt_around_an_arm_that_is_driven(rp: float, rq: float, compiled: bool) -> None:
    dynamics = [("ESTIFF", 1, 1000.0), ("INPUTX", 5, 1, 0.0, 2 * np.pi, 0.0), ("TIMESTEP", 7.0, 140)]
    r = spacar.run(1, spacar.Deck.build(arm(rp, rq, "INPUTX"), dynamics), compiled=compiled)
    np.testing.assert_allclose(r.element(1, 1), -(rp - rq) * r.node(5, 1), rtol=0, atol=1e-14)


@ENGINES
@pytest.mark.parametrize("mode", [1, 4])
def test_belt_around_an_arm_that_is_free(mode: int, compiled: bool) -> None:
    dynamics = [("ESTIFF", 1, 1000.0), ("XM", 5, 0.1), ("STARTDX", 5, 1, 0.0, 30.0), ("TIMESTEP", 1.0, 10)]
    r = spacar.run(mode, spacar.Deck.build(arm(0.05, 0.0499, "DYNX"), dynamics), compiled=compiled)
    assert r.node(5, 1)[-1] > 29.0
    np.testing.assert_allclose(r.element(1, 1), -1e-4 * r.node(5, 1), rtol=0, atol=1e-15)


@ENGINES
@pytest.mark.parametrize("rq", [0.0499, 0.2])
def test_belt_around_an_arm_in_load_steps(rq: float, compiled: bool) -> None:
    dynamics = [("ESTIFF", 1, 1000.0), ("INPUTX", 5, 1), ("DELINPX", 5, 1, 20.0), ("ITERSTEP", 20, 41, 1e-7, 1, 2)]
    r = spacar.run(7, spacar.Deck.build(arm(0.05, rq, "INPUTX"), dynamics), compiled=compiled)
    assert r.node(5, 1)[-1] == 20.0
    np.testing.assert_allclose(r.element(1, 1), (rq - 0.05) * r.node(5, 1), rtol=0, atol=1e-13)


@ENGINES
@pytest.mark.parametrize("rq", [0.05, 0.0499999, 0.0499, 0.049])
def test_belt_that_starts_with_a_turned_pulley(rq: float, compiled: bool) -> None:
    """phi = phi0 cos w t, w^2 = r_q^2 EA/(l J); e1 = -r_q phi."""
    rows = [("PLBELT", 1, 1, 2, 3, 4, 0.05, rq), ("X", 3, 0.5), ("FIX", 1), ("FIX", 2), ("FIX", 3), ("DYNX", 4), ("RLSE", 1)]  # noqa: E501
    dynamics = [("ESTIFF", 1, 1000.0), ("XM", 4, 0.01), ("STARTDX", 4, 1, 0.2, 0.0), ("TIMESTEP", 0.3, 6)]
    r = spacar.run(1, spacar.Deck.build(rows, dynamics), compiled=compiled, rtol=1e-10, atol=1e-12)
    stiffness = 1000.0 / np.sqrt(0.25 - (0.05 - rq) ** 2)
    w = rq * np.sqrt(stiffness / 0.01)
    assert r.element(1, 1, "sig")[0] == pytest.approx(-stiffness * rq * 0.2, rel=1e-13)
    np.testing.assert_allclose(r.node(4, 1), 0.2 * np.cos(w * r.t), rtol=0, atol=1e-8)
    np.testing.assert_allclose(r.element(1, 1), -rq * r.node(4, 1), rtol=0, atol=1e-15)


def test_belts_in_lanes() -> None:
    dynamics = [("ESTIFF", 1, 1000.0), ("XM", 5, 0.1), ("STARTDX", 5, 1, 0.0, 30.0), ("TIMESTEP", 1.0, 4)]
    deck = spacar.Deck.build(arm(0.05, 0.0499, "DYNX"), dynamics)
    results = ["phi: x[5,1]@end", "e: e[1,1]@end"]
    rows = spacar.sweep(deck, {"XM.5": list(np.linspace(0.05, 0.5, 9))}, results, jobs=1)
    for row in rows:
        assert row["phi"] > 29.0
        assert row["e"] == pytest.approx(-1e-4 * row["phi"], rel=0, abs=1e-15)


@ENGINES
@pytest.mark.parametrize("turns", [3.0, -40.0])
def test_released_hinge_and_screw(turns: float, compiled: bool) -> None:
    """A screw beside a driven hinge: the nut moves by the pitch times the angle, whole turns included."""
    angle = 2 * np.pi * turns
    dynamics = [("INPUTE", 1, 1, 0.0, angle, 0.0), ("TIMESTEP", 1.0, 8)]
    r = spacar.run(1, spacar.Deck.build(DRIVEN["screw"], dynamics), compiled=compiled)
    np.testing.assert_allclose(r.element(2, 1), angle * r.t, rtol=0, atol=1e-12 * abs(angle))
    moved = np.hypot(r.node(3, 2) - 0.3, r.node(3, 3) - 0.4)
    np.testing.assert_allclose(moved, 0.01 * abs(angle) * r.t, rtol=0, atol=1e-13 * abs(angle))


def geared(ratio: float) -> list[tuple]:
    """A belt that turns `ratio` times as far drives a slider-crank."""
    return [
        ("PLBELT", 1, 1, 2, 3, 4, 0.1 * ratio, 0.1), ("X", 3, 1.0), ("PLRBEAM", 2, 3, 4, 5), ("X", 5, 1.15),
        ("PLBEAM", 3, 5, 6, 7, 8), ("X", 7, 1.6), ("FIX", 1), ("FIX", 3), ("FIX", 7, 2), ("INPUTX", 2),
    ]  # fmt: skip


DRIVEN = {
    "four-bar": [("PLBEAM", 1, 1, 2, 3, 4), ("PLBEAM", 2, 3, 5, 6, 7), ("PLBEAM", 3, 6, 8, 9, 10), ("X", 3, 0.0, 0.1),
                 ("X", 6, 0.4, 0.3), ("X", 9, 0.35, 0.0), ("FIX", 1), ("FIX", 9), ("INPUTX", 2)],
    "belt of three turns": geared(1.0 / 3.0),
    "belt without a period": geared(np.sqrt(0.5)),
    "belt around a moving centre": arm(0.2, 0.1, "INPUTX"),
    "screw": [("HINGE", 1, 2, 4, 0.0, 0.6, 0.8), ("SCREW", 2, 1, 2, 3, 4, 0.0, 0.6, 0.8, 0.01), ("FIX", 1), ("FIX", 2),
              ("X", 3, 0.0, 0.3, 0.4), ("INPUTE", 1, 1), ("RLSE", 2, 1, 5, 6)],
    "hinge": [("HINGE", 1, 1, 2, 0.0, 0.0, 1.0), ("RBEAM", 2, 3, 2, 4), ("FIX", 1), ("FIX", 3), ("INPUTE", 1, 1),
              ("X", 3, 0.0, 0.0, 0.0), ("X", 4, 1.0, 0.2, 0.3)],
}  # fmt: skip


@ENGINES
@pytest.mark.parametrize("name", DRIVEN)
def test_outputs_that_are_many_turns_apart(name: str, compiled: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """They are those of a run with twelve outputs a turn, to the rounding of 200 rad; only a period is followed."""
    keyword, number = next(row[:2] for row in DRIVEN[name] if row[0].startswith("INPUT"))
    positions, newton = [], Kinematics._newton

    def counted(self: Kinematics, *arguments: object) -> object:
        positions.append(1)
        return newton(self, *arguments)

    monkeypatch.setattr(Kinematics, "_newton", counted)

    def outputs(n: int, turns: float = 30.3) -> spacar.Result:
        motion = [(keyword, number, 1, 0.0, -2 * np.pi, 0.0), ("TIMESTEP", turns, n)]
        return spacar.run(1, spacar.Deck.build(DRIVEN[name], motion), compiled=compiled)

    fine = outputs(363)
    positions.clear()
    far = outputs(3)
    for variable in ("x", "e", "xdd"):
        of_fine = np.array(fine[variable])[::121]
        np.testing.assert_allclose(far[variable], of_fine, rtol=0, atol=1e-11 * max(1.0, np.abs(of_fine).max()))
    if "without" not in name:
        positions.clear()
        assert np.isfinite(outputs(3, 1e5 + 0.3)["x"][-1]).all()
        assert len(positions) <= 150
