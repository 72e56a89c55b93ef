"""The unit of many deformations, which comes from few rows of the transfer function, against all of its columns."""

import models
import numpy as np
import pytest
import sizes

import spacar
from spacar.dynamics.array_evaluator import Dynamics
from spacar.forward import displaced
from spacar.mechanism import build

LATER = ["TIMESTEP 1e-9 1", "END", "END", ""]


def comb(n: int, m: int) -> str:
    """A back of n beams, at each of its nodes a tooth of m beams."""
    beams: list[str] = []
    nodes = {1: (0.0, 0.0)}

    def beam(p: int, x: float, y: float) -> int:
        q = 2 * len(beams) + 3
        beams.append(f"PLBEAM {len(beams) + 1} {p} {p + 1} {q} {q + 1}")
        nodes[q] = (x, y)
        return q

    back = 1
    for i in range(n):
        back = tip = beam(back, i + 1.0, 0.0)
        for j in range(m):
            tip = beam(tip, i + 1.0, 0.3 * (j + 1))
    return _with_masses(beams, nodes, [f"DYNE {k + 1} 2 3" for k in range(len(beams))])


def guide(n: int) -> str:
    """Two bowed leaf springs of n beams each with a rigid coupler: a closed loop, three deformations follow."""
    beams, nodes, ends = [], {}, []
    for side in (0, 1):
        p = 1000 * side + 1
        nodes[p] = (0.0, float(side))
        for k in range(1, n + 1):
            beams.append(f"PLBEAM {len(beams) + 1} {p} {p + 1} {p + 2} {p + 3}")
            p += 2
            nodes[p] = (k / n, side + 0.3 * float(np.sin(np.pi * k / n)))
        ends.append(p)
    a, b = ends
    coupler = f"PLBEAM {2 * n + 1} {a} {a + 1} {b} {b + 1}"
    follow = {n + 1: (2, 3), n + n // 2: (2, 3), 2 * n: (3, 2)}
    classes = [f"DYNE {k} {follow[k][1] if k in follow else '2 3'}" for k in range(1, 2 * n + 1)]
    classes += [f"RLSE {k} {released}" for k, (released, _) in follow.items()] + ["FIX 1001", "FIX 1002"]
    return _with_masses([*beams, coupler], nodes, classes, 2 * n)


def _with_masses(elements: list[str], nodes: dict, classes: list[str], count: int | None = None) -> str:
    masses = [f"EM {k + 1} 1.\nESTIFF {k + 1} 0. 1." for k in range(count or len(elements))]
    places = [f"X {k} {x!r} {y!r}" for k, (x, y) in nodes.items()]
    return "\n".join([*elements, *places, "FIX 1", "FIX 2", *classes, "END", "HALT", *masses, *LATER])


def both(text: str, monkeypatch: pytest.MonkeyPatch) -> tuple[np.ndarray, np.ndarray, int]:
    """g by few rows, by all columns, and how many solutions the first took."""
    evaluator = Dynamics(build(spacar.parse_deck(text, mode=1), 1))
    evaluator.place(0.0, evaluator.start())
    monkeypatch.setattr(displaced, "BLOCK", 10**9)
    exact = displaced.displaced(evaluator)
    assert exact is not None
    system, columns = evaluator.kinematics.velocity_system, []
    solve, solve_transposed = system.solve, system.solve_transposed
    monkeypatch.setattr(system, "solve", lambda b: columns.append(b.shape[1]) or solve(b))
    monkeypatch.setattr(system, "solve_transposed", lambda b: columns.append(b.shape[1]) or solve_transposed(b))
    monkeypatch.setattr(displaced, "BLOCK", 16)
    found = displaced.displaced(evaluator)
    assert found is not None
    return found, exact, sum(columns)


@pytest.mark.parametrize("text", [sizes.planar(60), sizes.spatial(30)])
def test_arms_are_exact(text, monkeypatch):
    found, exact, count = both(text, monkeypatch)
    np.testing.assert_allclose(found, exact, rtol=1e-9)
    assert count < 100


@pytest.mark.parametrize("text", [comb(20, 10), comb(60, 2), comb(150, 1), guide(60)])
def test_many_arms_and_loops_are_right_up_to_a_factor(text, monkeypatch):
    found, exact, count = both(text, monkeypatch)
    assert (found >= 0.5 * exact).all()
    assert (found <= displaced.SHORT * 1.5 * exact).all()
    assert count < displaced.PROBES + 4 * displaced.SAMPLE * (displaced.ROUNDS + 1)


# The absolute error of deformations is that of the displacement they cause: it keeps its meaning on fine meshes.
def cantilever(n, unit=1.0, more="TIMESTEP 0.2 4"):
    """Released under its weight; 1 m, EI = 1 N m^2, 1 kg/m. `unit`: of length, in m."""
    dynamics = (f"GRAVITY 0. {-1.0 / unit!r}", more)
    return models.cantilever(n, mass=unit, EI=1.0 / unit**2, length=1.0 / unit, dynamics=dynamics)


@pytest.mark.parametrize("unit", [1.0, 1e-3])
@pytest.mark.parametrize("n", [1, 4, 16])
def test_the_displacement_that_a_deformation_causes(n, unit):
    """e_p of element i turns the rest of the straight beam by e_p/l: the tip moves by (L - x_p)/l; e_q likewise."""
    evaluator = Dynamics(build(spacar.parse_deck(cantilever(n, unit), mode=1)))
    evaluator.rhs(0.0, evaluator.start())
    g = displaced.displaced(evaluator)
    behind = np.array([[n - i, n - i - 1] for i in range(n)], float)
    if n == 1:
        assert g is None
    else:
        np.testing.assert_allclose(g, np.tile(np.maximum(behind, 1.0).ravel(), 2), rtol=1e-9)


def test_rotations_and_rigid_models_keep_their_unit():
    text = "PLRBEAM 1 1 2 3\nX 3 5. 0.\nFIX 1\nDYNX 2 1\nEND HALT\nEM 1 1.\nTIMESTEP 1. 1\nEND END\n"
    evaluator = Dynamics(build(spacar.parse_deck(text, mode=1)))
    evaluator.rhs(0.0, evaluator.start())
    assert displaced.displaced(evaluator) is None


@pytest.mark.parametrize("code", [553, 595])
def test_error_keeps_its_meaning_on_fine_meshes(code):
    """Error over ERROR of the coordinates with 2 and with 8 elements; the same unit for all made it grow 8 and 16
    times."""
    ratios = []
    for n in (2, 8):
        deck = spacar.parse_deck(cantilever(n), mode=1)
        exact = spacar.run(1, deck, integrator=853, rtol=1e-6, atol=1e-7)["x"]
        x = spacar.run(1, deck, integrator=code, rtol=1e-14, atol=1e-2)["x"]
        ratios.append(np.abs(x - exact).max() / 1e-2)
    assert ratios[1] < 4.5 * ratios[0]
    assert ratios[1] < 1.0
