"""Cost follows the scene, shown by counters: what a model does not contain is not computed."""

import os
import subprocess
import sys
import tracemalloc
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

import spacar
from spacar.dynamics import Dynamics
from spacar.mechanism import build
from tests.examples import DATA
from tests.stationary.walk import walked

LINEARIZED = ("stiffness", "geometric_stiffness", "gradient_rate", "rate_gradient")
METHODS = ("strain", "convective_strain", "mass", "inertia_force", *LINEARIZED)


def counted(text: str, monkeypatch: pytest.MonkeyPatch) -> tuple[Dynamics, Counter[tuple[str, str]]]:
    """An evaluator whose families count their calls as (keyword, method), from after the start."""
    mechanism = build(spacar.parse_deck(text, mode=1), 1)
    calls: Counter[tuple[str, str]] = Counter()
    for batch in mechanism.batches:
        for name in METHODS:
            original = getattr(batch.family, name)

            def call(*arguments, original=original, key=(batch.family.keyword, name)):
                calls[key] += 1
                return original(*arguments)

            monkeypatch.setattr(batch.family, name, call, raising=False)
    dynamics = Dynamics(mechanism)
    y = dynamics.start()
    calls.clear()
    for k in range(10):
        dynamics.rhs(1e-4 * k, y)
    return dynamics, calls


def pendulum(mass: str) -> str:
    return (
        f"PLBEAM 1 1 2 3 4\nX 3 1. 0.\nFIX 1\nDYNX 2 1\nEND\nHALT\n{mass}\nGRAVITY 0. -9.81\nTIMESTEP 1. 1\nEND\nEND\n"
    )


def test_massless_links_do_no_mass_work(monkeypatch):
    _, calls = counted(pendulum("XM 3 1."), monkeypatch)
    assert not calls["PLBEAM", "mass"]
    assert not calls["PLBEAM", "inertia_force"]
    _, calls = counted(pendulum("EM 1 1."), monkeypatch)
    assert calls["PLBEAM", "mass"] == calls["PLBEAM", "inertia_force"] == 10


def test_one_mass_and_one_convective_evaluation_per_right_hand_side(monkeypatch):
    """A right-hand side costs one M, one h, one H(v,v), and few strains: Newton's iteration from a good guess."""
    _, calls = counted((DATA / "crankfl.dat").read_text(), monkeypatch)
    assert calls["PLBEAM", "mass"] == calls["PLBEAM", "inertia_force"] == calls["PLBEAM", "convective_strain"] == 10
    assert calls["PLBEAM", "strain"] <= 40


def test_no_stiffness_or_third_derivatives_in_a_right_hand_side(monkeypatch):
    """S is assembled once per model; the derivatives of linearization are not touched."""
    for name in ("crank", "crankfl", "robotsim", "trike2"):
        _, calls = counted((DATA / f"{name}.dat").read_text(), monkeypatch)
        assert not [key for key, count in calls.items() if key[1] in LINEARIZED and count], name


def test_rigid_models_carry_no_stiffness():
    """The stress law of a model without active rows is empty: no stresses are computed."""
    deck = spacar.parse_deck(pendulum("EM 1 1.\nESTIFF 1 1e9 1e9"), mode=1)
    assert Dynamics(build(deck, 1)).law.passive


def test_constant_matrices_are_evaluated_once(monkeypatch):
    """Trusses and rigid rods have a constant mass matrix: written at the start, never again."""
    text = "PLRBEAM 1 1 2 3\nPLTRUSS 2 3 4\nX 3 1. 0.\nX 4 1. 1.\nFIX 1\nFIX 4\nDYNX 2 1\nRLSE 2\nEND\nHALT\n"
    text += "EM 1 1.\nEM 2 1.\nXM 3 1.\nESTIFF 2 1.\nGRAVITY 0. -1.\nTIMESTEP 1. 1\nEND\nEND\n"
    dynamics, calls = counted(text, monkeypatch)
    assert not any(method in ("mass", "inertia_force") and count for (_, method), count in calls.items())
    assert not dynamics.sweep.moving


@pytest.mark.parametrize("name", ["crankfl", *(pytest.param(n, marks=pytest.mark.slow) for n in ("crank", "slider"))])
def test_planar_models_never_import_spatial_elements(name):
    frames = f"spacar.frames(1, {str(DATA / name)!r} + '.dat')"
    code = f"import itertools, sys, spacar; list(itertools.islice({frames}, 3)); print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    needless = ("spacar.linear.", "spacar.stationary", "spacar.inverse", "scipy.integrate")
    assert not [m for m in loaded if m.startswith(("spacar.elements.spatial.", *needless))]


def test_outputs_that_nobody_asked_for_are_not_computed():
    """Transfer functions and their tensors are absent without OUTLEVEL."""
    frame = spacar.run(1, spacar.parse_deck((DATA / "crank.dat").read_text(), mode=1)).frames[-1]
    assert frame.dx is frame.de is frame.d2x is frame.d2e is frame.bigd is None
    assert not frame.matrices


@pytest.mark.parametrize("spatial", [False, True], ids=["planar", "spatial"])
def test_entries_of_the_matrices_grow_linearly_with_a_chain(spatial):
    """Stored numbers, a counter of the work: per beam the same for 100 and 1000 beams, and the band does not widen."""
    sizes = {}
    for n in (100, 1000):
        dynamics = Dynamics(build(spacar.parse_deck(cantilever(n, spatial, ("TIMESTEP 1. 1",)), mode=1), 1))
        dynamics.rhs(0.0, dynamics.start())
        systems = (dynamics.kinematics.velocity_system, dynamics.saddle.system)
        assert [s.kind for s in systems] == ["banded", "banded"]
        sizes[n] = np.array([len(dynamics.sweep.entries), *(s.height * s.n for s in systems)])
    assert np.all(sizes[1000] <= 10.2 * sizes[100])


# Chains of a thousand elements and many output steps.
CRANK = (DATA / "crank.dat").read_text()


def cantilever(n: int, spatial: bool, rows: tuple[str, ...] = (), load: str = "", EI: float = 1.0) -> str:
    """n equal beams, 1 m and 1 kg together; clamped at the origin, inextensible."""
    kind, zero, modes = ("BEAM", " 0. 0.", "2 3 4 5 6") if spatial else ("PLBEAM", " 0.", "2 3")
    y = " 0. 1. 0." if spatial else ""
    lines = [f"{kind} {i + 1} {2 * i + 1} {2 * i + 2} {2 * i + 3} {2 * i + 4}{y}" for i in range(n)]
    lines += [f"X {2 * i + 1} {i / n!r}{zero}" for i in range(1, n + 1)]
    lines += ["FIX 1", "FIX 2", *(f"DYNE {i + 1} {modes}" for i in range(n)), "END", "HALT"]
    lines += [f"EM {i + 1} 1. 1e-4 5e-5 5e-5" if spatial else f"EM {i + 1} 1." for i in range(n)]
    lines += [f"ESTIFF {i + 1} 0. {EI}{f' {EI} {EI}' if spatial else ''}" for i in range(n)]
    if load:
        lines.append(f"XF {2 * n + 1} {load}")
    return "\n".join([*lines, *rows, "END", "END", ""])


@pytest.mark.parametrize("spatial", [False, True], ids=["planar", "spatial"])
def test_statics_of_a_thousand_beams(spatial):
    """Small tip load F: deflection F l^3/3, exact for cubic beams in the linear range; 1e-6 from F^2 = (1e-4)^2
    terms and the condition of a thousand beams (n^3 eps = 2e-7)."""
    load = "0. 0. 1e-4" if spatial else "0. 1e-4"
    solver = walked(cantilever(1000, spatial, ("ITERSTEP 20 1 1e-9",), load))
    tip = solver.dynamics.kinematics.x[solver.mechanism.numbering.x_index(2001, 3 if spatial else 2)]
    assert tip == pytest.approx(1e-4 / 3.0, rel=1e-6)


@pytest.mark.parametrize("spatial", [False, True], ids=["planar", "spatial"])
def test_accelerations_of_a_thousand_beams(spatial):
    """Released under gravity: all inertia forces together are the weight and the support force (Newton), to rounding
    times the stiffness of a thousand constraints, and the tip falls freely, since no wave has reached it."""
    rows = ("GRAVITY 0. 0. -1.",) if spatial else ("GRAVITY 0. -1.",)
    deck = spacar.parse_deck(cantilever(1000, spatial, rows), mode=1)
    dynamics = Dynamics(build(deck, 1))
    y = dynamics.start()
    frame = dynamics.frame(0.0, y)
    n, c = dynamics.numbering, 3 if spatial else 2
    tip = frame.xdd[n.x_index(2001, c)]
    assert tip == pytest.approx(-1.0, rel=1e-3)
    vertical = np.zeros(n.nx)
    vertical[[n.x_index(2 * i + 1, c) for i in range(1001)]] = 1.0
    inertia = vertical @ dynamics.sweep.mass_times(frame.xdd)
    support = frame.fxtot[n.x_index(1, c)] - frame.fxgrav[n.x_index(1, c)]
    gravity = vertical @ frame.fxgrav
    assert inertia == pytest.approx(gravity + support, abs=1e-8)


@pytest.mark.parametrize("spatial", [False, pytest.param(True, marks=pytest.mark.slow)], ids=["planar", "spatial"])
def test_short_motion_of_a_thousand_beams(spatial):
    """An explicit method below its stability limit (w_max = 70 n^2 sqrt(EI) = 7e4 rad/s): the tip falls by g t^2/2."""
    rows = ("GRAVITY 0. 0. -1." if spatial else "GRAVITY 0. -1.", "TIMESTEP 4e-5 2")
    deck = spacar.parse_deck(cantilever(1000, spatial, rows, EI=1e-6), mode=1)
    result = spacar.run(1, deck, integrator=140, step=1e-5)
    fallen = result.node(2001, 3 if spatial else 2)[-1]
    assert fallen == pytest.approx(-0.5 * 4e-5**2, rel=1e-3)


def test_output_steps_take_no_memory():
    """The stream of frames keeps nothing: the traced memory does not grow with the number of steps."""
    text = CRANK.replace("TIMESTEP 0.1 100", "TIMESTEP 0.4 400")
    stream = iter(spacar.frames(1, spacar.parse_deck(text, mode=1)))
    for _ in range(100):
        next(stream)
    tracemalloc.start()
    try:
        for _ in range(100):
            next(stream)
        first = tracemalloc.get_traced_memory()[0]
        for _ in stream:
            pass
        last = tracemalloc.get_traced_memory()[0]
    finally:
        tracemalloc.stop()
    assert last - first <= 20_000  # bytes; 200 steps of two kilobytes each would be 0.4 MB


def peak_memory(folder: Path, steps: int) -> float:
    """Largest resident memory of `spacar 1 crank` [MB], by the process itself."""
    (folder / "crank.dat").write_text(CRANK.replace("TIMESTEP 0.1 100", f"TIMESTEP {steps / 1000.0} {steps}"))
    code = (
        "import resource, sys\nfrom spacar_cli.main import main\ntry:\n    main(['1', 'crank', '--quiet'])\n"
        "except SystemExit:\n    pass\n"
        "print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024, file=sys.stderr)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=folder, capture_output=True, text=True, check=True,
        env={**os.environ, "OMP_NUM_THREADS": "1"},
    )  # fmt: skip
    assert (folder / "crank.sbd").exists(), done.stderr
    return float(done.stderr.split()[-1])


@pytest.mark.slow  # test_output_steps_take_no_memory is the fast one
@pytest.mark.parametrize(("steps", "most"), [(5_000, 3.0), (1_000_000, 30.0)])
def test_memory_of_the_program_does_not_grow_with_the_steps(steps, most, tmp_path):
    """From 1,000 output steps on, all of them written: by 3 MB beside 3 MB of results, by 30 MB beside 700 MB."""
    short = peak_memory(tmp_path, 1_000)
    assert peak_memory(tmp_path, steps) - short <= most
    assert (tmp_path / "crank.sbd").stat().st_size > 500 * steps
