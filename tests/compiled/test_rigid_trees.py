"""Chains and trees of rigid links, whose accelerations C takes from the reduced form or from the saddle-point form."""

import numpy as np
import pytest

import spacar
from spacar.compiled import CompiledDynamics
from spacar.compiled.library import unavailable
from spacar.deck import parse_deck
from spacar.dynamics import Dynamics

pytestmark = pytest.mark.skipif(unavailable() is not None, reason=str(unavailable()))


def spatial_links(n: int, branches: int) -> str:
    """n rods of 0.2 m with hinges of alternating axes, `branches` at the end of every one, numbered from the ground."""
    parent = [0, *((k - 2) // branches + 1 for k in range(2, n + 1))]
    place = [np.zeros(2)]
    for k in range(1, n + 1):
        angle = 0.4 * ((k - 2) % branches)
        place.append(place[parent[k - 1]] + 0.2 * np.array([np.cos(angle), np.sin(angle)]))
    before = [2 * n + 2, *(n + 1 + p for p in parent[1:])]
    rows = [f"RBEAM {k} {parent[k - 1] + 1} {n + 1 + k} {k + 1}" for k in range(1, n + 1)]
    rows += [f"HINGE {n + k} {before[k - 1]} {n + 1 + k} {('0 0 1', '0 1 0')[k % 2]}" for k in range(1, n + 1)]
    rows += [f"X {k + 1} {x!r} {y!r} 0." for k, (x, y) in enumerate(np.array(place).tolist())]
    rows += ["FIX 1", f"FIX {2 * n + 2}", *(f"DYNE {n + k} 1" for k in range(1, n + 1)), "END", "HALT"]
    rows += [f"EM {k} 1. 0.01 0.005 0.005" for k in range(1, n + 1)]
    return "\n".join([*rows, "GRAVITY 1. 2. -9.81", "TIMESTEP 1. 10", "END", "END", ""])


@pytest.mark.parametrize(("n", "branches"), [(3, 1), (12, 1), (12, 2), (45, 1)])
def test_links_in_both_forms(n, branches):
    """Accelerations, stresses and the reduced mass matrix are those of the general path."""
    mechanism = spacar.frames(1, parse_deck(spatial_links(n, branches), mode=1)).mechanism
    general, compiled = Dynamics(mechanism), CompiledDynamics(mechanism)
    y = general.start()
    compiled.start()
    compiled._in_general = None
    y += 0.05 * np.random.default_rng(n).standard_normal(len(y))
    for k in range(1, 3):
        a, b = general.frame(0.01 * k, k * y), compiled.frame(0.01 * k, k * y)
        for name in ("x", "xd", "xdd", "sig"):
            want, got = getattr(a, name), getattr(b, name)
            np.testing.assert_allclose(got, want, atol=1e-10 * max(1.0, np.abs(want).max()), rtol=0, err_msg=name)
    M = compiled.solver.reduced_mass()
    numpy_evaluator, rates = compiled.numpy_evaluator(), 2 * y[n:]
    numpy_evaluator.sweep.mass()
    energy = b.xd @ numpy_evaluator.sweep.mass_times(b.xd)  # kinetic energy, twice
    assert rates @ M[:, :, 0] @ rates == pytest.approx(energy, rel=1e-12)


SWING = """
{joint} X 1 0 0{z} X 4 1 0{z} FIX 1 FIX 2 DYNE 1 1 DRPINBOD 2 0.5 0{z} END HALT
ESTIFF 1 1. XM 4 1. STARTDE 1 1 0.1 0 TIMESTEP 1 4 ERROR 1e-9 1e-9 END END
"""
JOINTS = {
    "PLPINBOD": SWING.format(joint="PLTOR 1 2 3 PLPINBOD 2 1 3 4", z=""),
    "PLRBEAM": SWING.format(joint="PLTOR 1 2 3 PLRBEAM 2 1 3 4", z=""),
    "PINBODY": SWING.format(joint="HINGE 1 2 3 0 0 1 PINBODY 2 1 3 4", z=" 0"),
    "RBEAM": SWING.format(joint="HINGE 1 2 3 0 0 1 RBEAM 2 1 3 4", z=" 0"),
}


@pytest.mark.parametrize("body", JOINTS)
@pytest.mark.parametrize("compiled", [True, False])
def test_arm_of_drpinbod(body, compiled):
    """1 kg at 0.5 m on a spring of 1 N m/rad: 0.1 cos 2t, though the reference has 1 m."""
    result = spacar.run(1, parse_deck(JOINTS[body]), compiled=compiled)
    np.testing.assert_allclose(result.element(1, 1), 0.1 * np.cos(2.0 * result.t), atol=1e-8)
