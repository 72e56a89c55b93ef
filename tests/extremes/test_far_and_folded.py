"""Mechanisms a thousand kilometres from the origin, change points with a flexible and a rigid link, and mm-t-s against
SI in every mode."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import spacar
from spacar.deck import parse_deck
from spacar.errors import AnalysisError
from tests.examples import DATA

from .units import Dimensions, System, back, convert

FAR = 1e6  # m; positions are known to 1e-10 m there
ROUNDING = 2.0 * FAR * float(np.finfo(float).eps)


def moved(name, mode, shift):
    """A planar example whose beams all stand `shift` farther along x and y, prescribed positions at their start."""
    given = spacar.read_deck(DATA / f"{name}.dat", mode)
    at = {s.integer(0): s.reals(1, 2) for s in given.of("X", block=1)}
    ends = {s.integer(k) for s in given.of("PLBEAM", block=1) for k in (1, 3)}
    places = [f"X {node} {' '.join(repr(v + shift) for v in at.get(node, (0.0, 0.0)))}" for node in sorted(ends)]
    rows = [line for line in given.to_text().splitlines() if not line.startswith("X ")]
    end = next(i for i, line in enumerate(rows) if line.startswith("END"))
    return parse_deck("\n".join([*rows[:end], *places, *rows[end:]]), mode=mode)


def test_a_crank_far_away_is_the_crank():
    """Slider at 0.15 cos a + sqrt(0.3^2 - (0.15 sin a)^2); velocities, accelerations and forces as near the origin, all
    up to the rounding of the positions over the length of the crank."""
    near, far = (spacar.run(1, moved("crank", 1, s)) for s in (0.0, FAR))
    a = 150.0 * far.t
    slider = 0.15 * np.cos(a) + np.sqrt(0.3**2 - (0.15 * np.sin(a)) ** 2)
    assert np.abs(far.node(6, 1) - FAR - slider).max() < 3.0 * ROUNDING
    relative = 30.0 * ROUNDING / 0.15
    for variable in ("xd", "xdd", "fxtot"):
        a, b = near.node(6, 1, variable), far.node(6, 1, variable)
        assert np.abs(a - b).max() <= relative * max(np.abs(a).max(), 1.0)


def test_a_bent_cantilever_far_away():
    """plbeam5: tip, reactions and frequencies as near the origin, up to the rounding of the direction of a chord, 1e-10
    over 1.7 m, times what the tip moves with it."""
    near, far = (spacar.run(7, moved("plbeam5", 7, s)) for s in (0.0, FAR))
    for k in (1, 2):
        assert np.abs(far.node(11, k) - FAR - near.node(11, k)).max() < 1e3 * ROUNDING
    np.testing.assert_allclose(far.frequencies[-1][:3], near.frequencies[-1][:3], rtol=1e-6)
    assert far.node(2, 1, "fxtot")[-1] == pytest.approx(near.node(2, 1, "fxtot")[-1], rel=1e-6)


# A parallelogram, crank and follower 0.1 m, bearings 0.3 m apart: crank, coupler and follower are in one line at 0 and
# 180 degrees, where the follower of a rigid coupler may go either way. The crank turns with 10 rad/s.
CHANGE = """
PLBEAM 1 1 2 3 4   PLTRUSS 2 3 5   PLBEAM 3 6 7 5 8   X 3 0.1 0.   X 6 0.3 0.   X 5 0.4 0.
FIX 1   FIX 6   INPUTX 2 1   {free}   END HALT
XM 7 {inertia!r}   ESTIFF 2 {EA!r}
INPUTX 2 1 0. 10.   {start}   TIMESTEP 1.4 140   ERROR 1e-10 1e-10   INTEGRAT 853   END END
"""
INERTIA, EA = 2e-3, 3e3


def test_a_change_point_with_a_flexible_coupler_is_passed():
    """Twice in two turns and more; the follower by Newton's law of its angle alone: J b'' = -EA/l0 (l - l0) dl/db, its
    energy in a spring of stiffness EA/l0."""
    text = CHANGE.format(free="RLSE 2 1\nDYNX 7 1", inertia=INERTIA, EA=EA, start="STARTDX 7 1 0. 10.")
    result = spacar.run(1, parse_deck(text, mode=1))

    def rate(t, y):
        a, b = 10.0 * t, y[0]
        d = np.array((0.3 + 0.1 * (np.cos(b) - np.cos(a)), 0.1 * (np.sin(b) - np.sin(a))))
        length = np.linalg.norm(d)
        slope = d @ np.array((-0.1 * np.sin(b), 0.1 * np.cos(b))) / length
        return np.array((y[1], -EA / 0.3 * (length - 0.3) * slope / INERTIA))

    exact = solve_ivp(rate, (0.0, 1.4), (0.0, 10.0), "DOP853", result.t, rtol=1e-12, atol=1e-12).y[0]
    assert exact[-1] > 4.0 * np.pi
    assert np.abs(result.node(7, 1) - exact).max() < 1e-7


def test_a_change_point_with_a_rigid_coupler_is_not_passed_in_silence():
    """The start itself is the change point."""
    text = CHANGE.format(free="", inertia=INERTIA, EA=0.0, start="").replace("ESTIFF 2 0.0", "")
    with pytest.raises(AnalysisError) as found:
        spacar.run(1, parse_deck(text, mode=1))
    assert any(f"node {k}" in str(found.value) or f"element {k}" in str(found.value) for k in (2, 3, 5, 7))


MM_T_S = System(kg=1e-3, m=1e3)


@pytest.mark.parametrize(
    ("name", "mode"),
    [("crank", 0), ("crank", 1), ("plbeam5", 7), ("lateral4", 8), ("lever", 9), ("plbeam5buck", 10), ("robotinv", 2),
     ("crankfl", 4)],
)  # fmt: skip
def test_millimetres_and_tonnes_in_every_mode(name, mode):
    """Coordinates, deformations and stresses of every step to 1e-9 of the largest of their kind."""
    model = spacar.read_deck(DATA / f"{name}.dat", mode)
    options = {"duration": 1e-3, "n_steps": 2, "rtol": 1e-11, "atol": 1e-13} if mode == 4 else {}
    finer = {"atol": 1e-10} if mode == 4 else {}
    run = spacar.frames(mode, convert(model, MM_T_S), **(options | finer))
    old, new = list(spacar.frames(mode, model, **options)), list(run)
    assert len(old) == len(new)
    kinds = dict(zip(("x", "e"), Dimensions(model).results(run.mechanism), strict=True))
    for a, b in zip(old, new, strict=True):
        values = back(b, run.mechanism, MM_T_S)
        for variable, group in (("x", "x"), ("e", "e"), ("sig", "e")):
            for kind in set(kinds[group]):
                rows = [i for i, g in enumerate(kinds[group]) if g == kind]
                size = max(np.abs(getattr(a, variable)[rows]).max(), np.abs(a.x).max() if variable == "e" else 0.0)
                off = np.abs(values[variable][rows] - getattr(a, variable)[rows]).max()
                assert off <= 1e-9 * max(size, np.abs(a.sig).max() if variable == "sig" else size), variable


@pytest.mark.parametrize("name", ["robotinv", "robotflexinv"])
def test_millimetres_and_tonnes_along_a_path(name):
    """Mode 3 after mode 2, 1e-9 of the largest of their kind: the motion, and A of the state equations (eigenvalues
    have the unit 1/s)."""
    before = spacar.read_deck(DATA / f"{name}.dat", 2)
    model = spacar.read_deck(DATA / f"{name}lin.dat", 3)
    old = list(spacar.frames(3, model, nominal=spacar.run(2, before)))
    run = spacar.frames(3, convert(model, MM_T_S), nominal=spacar.run(2, convert(before, MM_T_S)))
    new = list(run)
    assert len(old) == len(new) > 100
    kinds = dict(zip(("x", "e"), Dimensions(model).results(run.mechanism), strict=True))
    for a, b in zip(old[::10], new[::10], strict=True):
        values = back(b, run.mechanism, MM_T_S)
        for variable, group in (("x", "x"), ("xd", "x"), ("xdd", "x"), ("e", "e"), ("sig", "e"), ("fxtot", "x")):
            for kind in set(kinds[group]):
                rows = [i for i, g in enumerate(kinds[group]) if g == kind]
                size = max(np.abs(getattr(a, variable)).max(), np.abs(a.x).max() if variable == "e" else 0.0)
                assert np.abs(values[variable][rows] - getattr(a, variable)[rows]).max() <= 1e-9 * size, variable
        rates, others = (np.linalg.eigvals(f.state_space["A"]) for f in (a, b))
        assert np.abs(np.abs(rates).max() - np.abs(others).max()) <= 1e-9 * np.abs(rates).max()
