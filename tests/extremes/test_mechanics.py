"""Extreme numbers in small mechanisms whose motion is known in closed form."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import spacar
from spacar.errors import AnalysisError
from tests.examples import DATA

from .units import Dimensions, System, back, convert


def run(mode: int, text: str, **options):
    return spacar.run(mode, spacar.parse_deck(text, mode=mode), **options)


def springs(k1: float, k2: float, m: float = 1.0, force: float = 1.0) -> str:
    """Two trusses of 1 m in a row, masses at their ends."""
    return f"""
PLTRUSS 1 1 2   PLTRUSS 2 2 3   X 2 1. 0.   X 3 2. 0.   FIX 1   FIX 2 2   FIX 3 2   DYNE 1   DYNE 2
END HALT
XM 2 {m!r}   XM 3 {m!r}   ESTIFF 1 {k1!r}   ESTIFF 2 {k2!r}   XF 3 {force!r} 0.
ITERSTEP 20 1 1e-12   END END
"""


@pytest.mark.parametrize("ratio", [1.0, 1e3, 1e6, 1e9, 1e12])
@pytest.mark.parametrize("soft_first", [True, False])
def test_stiffness_ratios_static(ratio, soft_first):
    """Springs in series: elongations F/k each. The mode 7 result is exact to rounding of the soft one."""
    k1, k2 = (1.0, ratio) if soft_first else (ratio, 1.0)
    result = run(7, springs(k1, k2, force=1e-3))
    e = result["e"][-1]
    rows = [result.mechanism.numbering.e_index(k, 1) for k in (1, 2)]
    assert e[rows[0]] == pytest.approx(1e-3 / k1, rel=1e-9)
    assert e[rows[1]] == pytest.approx(1e-3 / k2, rel=1e-9)


@pytest.mark.parametrize("mass", [1e-9, 1.0, 1e9])
@pytest.mark.parametrize("length", [1e-6, 1.0, 1e6])
def test_pendulum_of_any_size(mass, length):
    """Period of small swings 2 pi sqrt(l/g) (1 + a^2/16 + 11 a^4/3072): back at the start after one period."""
    g, a = 9.81, 0.1
    period = 2.0 * np.pi * np.sqrt(length / g) * (1.0 + a**2 / 16.0 + 11.0 * a**4 / 3072.0 + 173.0 * a**6 / 737280.0)
    text = f"""
PLRBEAM 1 1 2 3   X 3 0. {-length!r}   FIX 1   DYNX 2 1   END HALT
XM 3 {mass!r}   GRAVITY 0. {-g}   STARTDX 2 1 {a} 0.   TIMESTEP {float(period)!r} 4   END END
"""
    result = run(1, text, integrator=853, atol=1e-10, rtol=1e-10)
    assert result.node(2, 1)[-1] == pytest.approx(a, rel=1e-9)  # the velocity vanishes there: second order in the error
    pull = mass * g * (1.0 + 2.0 * (1.0 - np.cos(a)))  # support force at the lowest point
    quarter = np.hypot(*(result.node(1, k, "fxtot")[1] for k in (1, 2)))
    assert quarter == pytest.approx(pull, rel=1e-3)  # the quarter period is only nearly the lowest point


@pytest.mark.parametrize("speed", [1.0, 1e3, 1e5])
def test_centrifugal_force_of_a_fast_rotor(speed):
    """A mass at the end of a prescribed bar: force m omega^2 r on the bearing, at any angle."""
    text = f"""
PLRBEAM 1 1 2 3   X 3 0.2 0.   FIX 1   INPUTX 2 1   END HALT
XM 3 0.5   INPUTX 2 1 0. {speed!r}   TIMESTEP {100.0 / speed!r} 50   END END
"""
    result = run(1, text)
    force = np.hypot(result.node(1, 1, "fxtot"), result.node(1, 2, "fxtot"))
    assert force == pytest.approx(np.full(51, 0.5 * speed**2 * 0.2), rel=1e-12)


@pytest.mark.parametrize("spin", [1e2, 1e5])
def test_free_top_at_high_spin(spin):
    """A free symmetric top: H is constant and the body axis moves around it with the angle of the start. 2.5 rad: three
    Euler parameters describe an orientation up to half a turn."""
    text = f"""
PINBODY 1 1 2 3   X 3 0.1 0. 0.   FIX 1   DYNX 2   END HALT
XM 2 1. 0. 0. 1. 0. 2.
STARTDX 2 4 0. {0.5 * spin!r}   STARTDX 2 2 0. {0.05 * spin!r}   TIMESTEP {2.5 / spin!r} 10
END END
"""
    # ERROR is that of the most accurate level: rates of 1e5 rad/s and angles share one relative error
    result = run(1, text, integrator=853, atol=1e-10, rtol=1e-10)
    n = result.mechanism.numbering
    rows = n.lnp[1, :4] - 1
    L, Ld = result["x"][:, rows].T, result["xd"][:, rows].T
    l0, l = L[0], L[1:]
    omega = 2.0 * (l0 * Ld[1:] - Ld[0] * l + np.cross(l.T, Ld[1:].T).T)  # global components
    axis = np.array(
        [2.0 * (l[0] * l[2] + l0 * l[1]), 2.0 * (l[1] * l[2] - l0 * l[0]), 1.0 - 2.0 * (l[0] ** 2 + l[1] ** 2)]
    )
    H = omega + (2.0 - 1.0) * axis * (axis * omega).sum(0)  # J = I + (J3 - 1) axis axis
    size = np.linalg.norm(H[:, 0])
    assert np.abs(H - H[:, :1]).max() <= 1e-8 * size
    cosine = (axis * H).sum(0) / np.linalg.norm(H, axis=0)
    assert np.abs(cosine - cosine[0]).max() <= 1e-8
    assert np.abs((L**2).sum(0) - 1.0).max() <= 1e-12


@pytest.mark.parametrize("turns", [150, 1e5])
def test_revolutions_of_a_crank(turns):
    """The crank turns fifty times and more between two outputs; slider position in closed form.

    1e-9: rounding of the angle, 630,000 rad eps = 1.4e-10. Angles of the rod are followed, not found again.
    """

    text = (DATA / "crank.dat").read_text()
    omega = 150.0
    duration = turns * 2.0 * np.pi / omega
    text = text.replace("TIMESTEP 0.1 100", f"TIMESTEP {duration!r} 3")
    result = run(1, text)
    angle = omega * result.t
    slider = 0.15 * np.cos(angle) + np.sqrt(0.09 - (0.15 * np.sin(angle)) ** 2)
    assert result.node(6, 1) == pytest.approx(slider, abs=1e-9)
    assert result.node(2, 1)[-1] == pytest.approx(2.0 * np.pi * turns, rel=1e-14)


@pytest.mark.parametrize(("planar", "turns"), [
    (True, 600), (False, 100),
    pytest.param(True, 10_000, marks=pytest.mark.slow), pytest.param(False, 1000, marks=pytest.mark.slow),
])  # fmt: skip
def test_free_revolutions_are_counted(planar, turns):
    """A free rotor keeps its speed: the hinge angle is rate times time, not its remainder."""
    rate = 100.0
    duration = 2.0 * np.pi * turns / rate
    joint, inertia = ("PLTOR 1 1 2", "XM 2 3.") if planar else ("HINGE 1 1 2 0. 0. 1.", "XM 2 1. 0. 0. 1. 0. 3.")
    text = (
        f"{joint}\nFIX 1\nDYNE 1 1\nEND\nHALT\n{inertia}\nSTARTDE 1 1 0. {rate}\nTIMESTEP {duration!r} 200\nEND\nEND\n"
    )
    frames = spacar.frames(1, spacar.parse_deck(text, mode=1), atol=1e-11, rtol=1e-11)
    row = frames.mechanism.numbering.e_index(1, 1)
    last = None
    for last in frames:  # noqa: B007
        pass
    assert last.e[row] == pytest.approx(2.0 * np.pi * turns, rel=1e-10)
    assert last.ed[row] == pytest.approx(rate, rel=1e-12)


def rod(EI: float, beams: int = 1) -> str:
    """A beam that swings about a hinge, 1 m, 1 kg: rigid for EI to infinity."""
    n = beams
    lines = [f"PLBEAM {i + 1} {2 * i + 1} {2 * i + 2} {2 * i + 3} {2 * i + 4}" for i in range(n)]
    lines += [f"X {2 * i + 1} {i / n!r} 0." for i in range(1, n + 1)] + ["FIX 1", "DYNX 2 1"]
    lines += [f"DYNE {i + 1} 2 3" for i in range(n)] + ["END", "HALT"]
    lines += [f"EM {i + 1} 1." for i in range(n)] + [f"ESTIFF {i + 1} 0. {EI!r}" for i in range(n)]
    return "\n".join([*lines, "GRAVITY 0. -9.81", "TIMESTEP 0.5 5", "END", "END", ""])


@pytest.fixture(scope="module")
def rigid_rod():
    text = (
        "PLRBEAM 1 1 2 3\nX 3 1. 0.\nFIX 1\nDYNX 2 1\nEND\nHALT\nEM 1 1.\nGRAVITY 0. -9.81\nTIMESTEP 0.5 5\nEND\nEND\n"
    )
    result = run(1, text, integrator=853, atol=1e-11, rtol=1e-11)
    return np.array([result.node(3, 1), result.node(3, 2)])


@pytest.mark.parametrize(("code", "EI", "step", "tolerance"), [
    # elastic deflection of the order m g l^3 / (50 EI): 2e-4 for the first
    *(pytest.param(code, 1e3, None, 4e-4, marks=pytest.mark.slow) for code in (0, 853)),
    # implicit: order 3 with steps of 5 ms; the fast motion is damped away
    (430, 1e12, 0.005, 1e-6), (330, 1e8, 0.005, 1e-5),
    *(pytest.param(*case, marks=pytest.mark.slow) for case in ((430, 1e8, 0.005, 1e-6), (330, 1e12, 0.005, 1e-5))),
])  # fmt: skip
def test_stiff_beams_move_as_rigid_ones(code, EI, step, tolerance, rigid_rod):
    result = run(1, rod(EI), integrator=code, step=step, atol=1e-6, rtol=1e-6)
    tip = np.array([result.node(3, 1), result.node(3, 2)])
    assert np.abs(tip - rigid_rod).max() <= tolerance


@pytest.mark.parametrize("duration", [1e-12, 1e-6, 1e-3])
def test_very_short_simulations(duration):
    """Free fall: x = g t^2/2 with the relative accuracy of ERROR even when the whole way is 5e-24 m."""
    text = "PLTRUSS 1 1 2\nX 2 1. 0.\nFIX 1\nDYNX 2 2\nEND\nHALT\nXM 2 2.\nGRAVITY 0. -9.81\n"
    text += f"TIMESTEP {duration!r} 3\nEND\nEND\n"
    result = run(1, text, integrator=853)
    assert result.node(2, 2) == pytest.approx(-0.5 * 9.81 * result.t**2, rel=1e-6)
    assert result.node(2, 2, "xd") == pytest.approx(-9.81 * result.t, rel=1e-6)


def test_very_long_simulation_comes_to_rest():
    """A damped oscillator after 1e6 s (1e5 periods): the static position, with steps that grow when nothing moves."""
    text = springs(40.0, 1e3).replace("ITERSTEP 20 1 1e-12", "EDAMP 1 1.\nEDAMP 2 10.\nTIMESTEP 1e6 10")
    result = run(1, text, integrator=430, step=1e4, atol=1e-10)
    assert result.element(1, 1)[-1] == pytest.approx(1.0 / 40.0, rel=1e-9)
    assert result.element(2, 1)[-1] == pytest.approx(1e-3, rel=1e-9)


def test_undamped_oscillator_keeps_its_amplitude_for_twenty_periods():
    """x = a cos(w t); the phase error of ERROR 1e-9 over 20 periods is what remains."""
    text = "PLTRUSS 1 1 2\nX 2 1. 0.\nFIX 1\nFIX 2 2\nDYNE 1\nEND\nHALT\nXM 2 1.\nESTIFF 1 1.\n"
    text += f"STARTDE 1 1 0.01 0.\nTIMESTEP {40.0 * np.pi!r} 10\nEND\nEND\n"
    result = run(1, text, integrator=853, atol=1e-11, rtol=1e-9)
    assert result.element(1, 1) == pytest.approx(0.01 * np.cos(result.t), abs=1e-8)


# Mechanisms a thousand kilometres from the origin, change points with a flexible and a rigid link, and mm-t-s
# against SI in every mode.
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
    return spacar.parse_deck("\n".join([*rows[:end], *places, *rows[end:]]), mode=mode)


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
    result = spacar.run(1, spacar.parse_deck(text, mode=1))

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
        spacar.run(1, spacar.parse_deck(text, mode=1))
    assert any(f"node {k}" in str(found.value) or f"element {k}" in str(found.value) for k in (2, 3, 5, 7))
MM_T_S = System(kg=1e-3, m=1e3)


def same_in_mm(run, model, old, new, *variables):
    """Of these frames, to 1e-9: x and e of the largest of their kind (e of a coordinate at least), others of all."""
    kinds = dict(zip(("x", "e"), Dimensions(model).results(run.mechanism), strict=True))
    for a, b in zip(old, new, strict=True):
        values = back(b, run.mechanism, MM_T_S)
        for variable in variables:
            group, own = kinds["e" if variable in ("e", "sig") else "x"], getattr(a, variable)
            for kind in set(group):
                rows = [i for i, g in enumerate(group) if g == kind]
                size = np.abs(own[rows] if variable in ("x", "e") else own).max()
                size = max(size, np.abs(a.x).max()) if variable == "e" else size
                assert np.abs(values[variable][rows] - own[rows]).max() <= 1e-9 * size, variable


@pytest.mark.parametrize(
    ("name", "mode"),
    [("crank", 0), ("crank", 1), ("plbeam5", 7), ("lateral4", 8), ("lever", 9), ("plbeam5buck", 10), ("robotinv", 2),
     ("crankfl", 4)],
)  # fmt: skip
def test_millimetres_and_tonnes_in_every_mode(name, mode):
    model = spacar.read_deck(DATA / f"{name}.dat", mode)
    options = {"duration": 1e-3, "n_steps": 2, "rtol": 1e-11, "atol": 1e-13} if mode == 4 else {}
    finer = {"atol": 1e-10} if mode == 4 else {}
    run = spacar.frames(mode, convert(model, MM_T_S), **(options | finer))
    same_in_mm(run, model, spacar.frames(mode, model, **options), run, "x", "e", "sig")


@pytest.mark.parametrize("name", ["robotinv", "robotflexinv"])
def test_millimetres_and_tonnes_along_a_path(name):
    """Mode 3 after mode 2: the motion, and A of the state equations (eigenvalues have the unit 1/s)."""
    before = spacar.read_deck(DATA / f"{name}.dat", 2)
    model = spacar.read_deck(DATA / f"{name}lin.dat", 3)
    old = list(spacar.frames(3, model, nominal=spacar.run(2, before)))
    run = spacar.frames(3, convert(model, MM_T_S), nominal=spacar.run(2, convert(before, MM_T_S)))
    new = list(run)
    assert len(old) == len(new) > 100
    same_in_mm(run, model, old[::10], new[::10], "x", "xd", "xdd", "e", "sig", "fxtot")
    for a, b in zip(old[::10], new[::10], strict=True):
        rates, others = (np.linalg.eigvals(f.state_space["A"]) for f in (a, b))
        assert np.abs(np.abs(rates).max() - np.abs(others).max()) <= 1e-9 * np.abs(rates).max()
