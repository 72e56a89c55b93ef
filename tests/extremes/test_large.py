"""Chains of a thousand elements and many output steps."""

import os
import subprocess
import sys
import tracemalloc
from pathlib import Path

import numpy as np
import pytest

import spacar
from spacar.deck import parse_deck
from spacar.dynamics import Dynamics
from spacar.errors import Report
from spacar.mechanism import build
from spacar.stationary import LoadProgram, StationarySolver
from tests.examples import DATA

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
    mechanism = build(parse_deck(cantilever(1000, spatial, ("ITERSTEP 20 1 1e-9",), load), mode=7), 7)
    solver = StationarySolver(mechanism, Report())
    for level in LoadProgram(mechanism.settings):
        solver.solve(level)
    tip = solver.dynamics.kinematics.x[mechanism.numbering.x_index(2001, 3 if spatial else 2)]
    assert tip == pytest.approx(1e-4 / 3.0, rel=1e-6)


@pytest.mark.parametrize("spatial", [False, True], ids=["planar", "spatial"])
def test_accelerations_of_a_thousand_beams(spatial):
    """Released under gravity: all inertia forces together are the weight and the support force (Newton), to rounding
    times the stiffness of a thousand constraints, and the tip falls freely, since no wave has reached it."""
    rows = ("GRAVITY 0. 0. -1.",) if spatial else ("GRAVITY 0. -1.",)
    deck = parse_deck(cantilever(1000, spatial, rows), mode=1)
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
    deck = parse_deck(cantilever(1000, spatial, rows, EI=1e-6), mode=1)
    result = spacar.run(1, deck, integrator=140, step=1e-5)
    fallen = result.node(2001, 3 if spatial else 2)[-1]
    assert fallen == pytest.approx(-0.5 * 4e-5**2, rel=1e-3)


def test_output_steps_take_no_memory():
    """The stream of frames keeps nothing: the traced memory does not grow with the number of steps."""
    text = CRANK.replace("TIMESTEP 0.1 100", "TIMESTEP 0.4 400")
    stream = iter(spacar.frames(1, parse_deck(text, mode=1)))
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
def test_memory_of_the_program_does_not_grow_with_the_steps(tmp_path):
    """From 1,000 to 5,000 output steps; the result file grows by 7 MB, the program may not by 3 MB."""
    assert peak_memory(tmp_path, 5_000) - peak_memory(tmp_path, 1_000) <= 3.0


@pytest.mark.slow
def test_a_million_output_steps(tmp_path):
    """1,000,000 output steps through the program, all written, in bounded memory: less than 30 MB above a short run."""
    short = peak_memory(tmp_path, 1_000)
    assert peak_memory(tmp_path, 1_000_000) - short <= 30.0
    assert (tmp_path / "crank.sbd").stat().st_size > 1e9 * 0.5
