"""Extreme numbers in small mechanisms whose motion is known in closed form."""

import numpy as np
import pytest

import spacar
from spacar.deck import parse_deck
from tests.examples import DATA


def run(mode: int, text: str, **options):
    return spacar.run(mode, parse_deck(text, mode=mode), **options)


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


@pytest.mark.parametrize("ratio", [1e3, 1e6, 1e9, 1e12])
@pytest.mark.parametrize("soft_first", [True, False])
def test_stiffness_ratios_frequencies(ratio, soft_first):
    """Eigenvalues of [k1 + k2, -k2; -k2, k2] with unit masses, from the roots of the quadratic without cancellation.

    A backward stable method knows the lowest eigenvalue to eps times the ratio only: 2e-4 for 1e12. Asked is 1e-6.
    """
    k1, k2 = (1.0, ratio) if soft_first else (ratio, 1.0)
    found = run(7, springs(k1, k2, force=0.0))["eigval"][-1]
    frequencies = np.unique(np.round(np.abs(found[:, 1]), 300))
    trace = k1 + 2.0 * k2
    high = 0.5 * (trace + np.sqrt(k1**2 + 4.0 * k2**2))
    low = k1 * k2 / high
    assert frequencies.max() == pytest.approx(np.sqrt(high), rel=1e-9)
    assert frequencies.min() == pytest.approx(np.sqrt(low), rel=max(1e-9, 1e-18 * ratio))


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
    frames = spacar.frames(1, parse_deck(text, mode=1), atol=1e-11, rtol=1e-11)
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
