"""Cost follows the scene, shown by counters: what a model does not contain is not computed."""

import subprocess
import sys
from collections import Counter

import numpy as np
import pytest

import spacar
from spacar.deck import parse_deck
from spacar.dynamics import Dynamics
from spacar.mechanism import build
from tests.examples import DATA

METHODS = (
    "strain",
    "convective_strain",
    "mass",
    "inertia_force",
    "stiffness",
    "geometric_stiffness",
    "gradient_rate",
    "rate_gradient",
)


def counted(text: str, monkeypatch: pytest.MonkeyPatch) -> tuple[Dynamics, Counter[tuple[str, str]]]:
    """An evaluator whose families count their calls as (keyword, method), from after the start."""
    mechanism = build(parse_deck(text, mode=1), 1)
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
        for (keyword, method), count in calls.items():
            assert method not in ("stiffness", "geometric_stiffness", "gradient_rate", "rate_gradient") or not count, (
                name,
                keyword,
            )


def test_rigid_models_carry_no_stiffness():
    """The stress law of a model without active rows is empty: no stresses are computed."""
    dynamics = Dynamics(
        build(parse_deck(pendulum("EM 1 1.").replace("GRAVITY", "ESTIFF 1 1e9 1e9\nGRAVITY"), mode=1), 1)
    )
    assert dynamics.law.passive


def test_constant_matrices_are_evaluated_once(monkeypatch):
    """Trusses and rigid rods have a constant mass matrix: written at the start, never again."""
    text = "PLRBEAM 1 1 2 3\nPLTRUSS 2 3 4\nX 3 1. 0.\nX 4 1. 1.\nFIX 1\nFIX 4\nDYNX 2 1\nRLSE 2\nEND\nHALT\n"
    text += "EM 1 1.\nEM 2 1.\nXM 3 1.\nESTIFF 2 1.\nGRAVITY 0. -1.\nTIMESTEP 1. 1\nEND\nEND\n"
    dynamics, calls = counted(text, monkeypatch)
    assert not any(method in ("mass", "inertia_force") and count for (_, method), count in calls.items())
    assert not dynamics.sweep.moving


@pytest.mark.parametrize(("name", "forbidden"), [
    ("crankfl", "spatial"), *(pytest.param(n, "spatial", marks=pytest.mark.slow) for n in ("crank", "slider")),
])
def test_planar_models_never_import_spatial_elements(name, forbidden, tmp_path):
    spatial = (
        "beam",
        "beam_strain",
        "beam_inertia",
        "hinge",
        "rotation",
        "frames",
        "pinbody",
        "truss",
        "wheel",
        "screw",
        "tube",
        "node_inertia",
    )
    frames = f"spacar.frames(1, {str(DATA / name)!r} + '.dat')"
    code = f"import itertools, sys, spacar; list(itertools.islice({frames}, 3)); print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert not [m for m in loaded if m in {f"spacar.elements.{s}" for s in spatial}]
    assert not [
        m for m in loaded if m.startswith(("spacar.linear.", "spacar.stationary", "spacar.inverse", "scipy.integrate"))
    ]


def test_outputs_that_nobody_asked_for_are_not_computed():
    """Transfer functions and their tensors are absent without OUTLEVEL."""
    frame = spacar.run(1, parse_deck((DATA / "crank.dat").read_text(), mode=1)).frames[-1]
    assert frame.dx is frame.de is frame.d2x is frame.d2e is frame.bigd is None
    assert not frame.matrices


@pytest.mark.parametrize("spatial", [False, True], ids=["planar", "spatial"])
def test_entries_of_the_matrices_grow_linearly_with_a_chain(spatial):
    """Stored numbers, a counter of the work: per beam the same for 100 and 1000 beams, and the band does not widen."""
    from .test_large import cantilever

    sizes = {}
    for n in (100, 1000):
        dynamics = Dynamics(build(parse_deck(cantilever(n, spatial, ("TIMESTEP 1. 1",)), mode=1), 1))
        dynamics.rhs(0.0, dynamics.start())
        systems = (dynamics.kinematics.velocity_system, dynamics.saddle.system)
        assert [s.kind for s in systems] == ["banded", "banded"]
        sizes[n] = np.array([len(dynamics.sweep.entries), *(s.height * s.n for s in systems)])
    assert np.all(sizes[1000] <= 10.2 * sizes[100])
