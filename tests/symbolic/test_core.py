"""The same arm in the numeric core (planar beam elements) and as fields; only these tests know both parts.

Reference numbers: symbolic.md, section 8.7 (two elements per link; fields with three
terms and foreshortening; no structural damping in either).
"""

from pathlib import Path

import numpy as np
import pytest

import spacar

DATA = Path(__file__).parents[2] / "data" / "symbolic"
# t, q1, q4, u1(L), u2(L) of two elements per link
ELEMENTS = np.array([
    [0.05, -0.45875333, 0.41844655, -5.169115e-3, -1.244804e-3],
    [0.2, -0.28323996, 0.18993413, -2.545821e-3, -6.590582e-4],
])  # fmt: skip


@pytest.fixture(scope="module")
def elements():
    """q1, q4, u1, u2 of the element model at 0.05 and 0.2 s (0.2 s of the .dat, 4 steps)."""
    text = (DATA / "manipulator_beams.dat").read_text().replace("TIMESTEP 3.0 3000", "TIMESTEP 0.2 4")
    result = spacar.run(1, spacar.parse_deck(text))
    x, y = ({n: result.node(n, i) for n in (5, 10)} for i in (1, 2))
    phi2, phi7 = result.node(2, 1), result.node(7, 1)
    u1 = -np.sin(phi2) * x[5] + np.cos(phi2) * y[5]
    u2 = -np.sin(phi7) * (x[10] - x[5]) + np.cos(phi7) * (y[10] - y[5])
    rows = np.column_stack([result.element(5, 1), result.element(6, 1), u1, u2])
    assert result.t == pytest.approx([0.0, 0.05, 0.1, 0.15, 0.2])
    return rows[[1, 4]]


@pytest.mark.slow
def test_beam_elements_of_the_core_give_the_reference(elements):
    assert np.max(np.abs(elements - ELEMENTS[:, 1:])) < 1e-6


@pytest.mark.slow
def test_fields_with_foreshortening_equal_the_elements(elements, arm):
    """From 0.2 s on the two models differ by 6e-8 rad and 2e-8 m; in the first 0.1 s by some 1e-6 (steps of torque)."""
    shortened = arm(gravity=False, foreshortening=True)
    program = shortened.program("recursive")
    values = shortened.values | {"gam": 0.0}
    times = np.array([0.0, 0.05, 0.2])
    run = program.simulate(
        values, {"q1": -0.5, "q4": 0.5}, t_end=0.2, at=times, rtol=1e-9, atol=1e-12, integrator="dop853"
    )
    field = np.column_stack([run[name][1:] for name in ("q1", "q4", "tip1", "tip2")])
    assert field[:, 0] == pytest.approx([-0.45875505, -0.28323995], abs=2e-8)
    assert field[:, 2] == pytest.approx([-5.167259e-3, -2.545834e-3], abs=2e-9)
    assert np.max(np.abs(field[1, :2] - elements[1, :2])) < 2e-7
    assert np.max(np.abs(field[1, 2:] - elements[1, 2:])) < 1e-7
