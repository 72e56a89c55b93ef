"""The manual's slider-crank with a flexible rod from its model file: closed, driven, against mode 1 of crankfl.dat."""

import numpy as np
import pytest

import spacar
from spacar.symbolic.compiled_program import CompiledFunction, compiler
from spacar.symbolic.model_reader import read_model
from tests.examples import DATA


def simulate(model, program, start, **options):
    function = CompiledFunction(program, model.values) if compiler() else None
    settings = {"guess": model.settings["guess"], "integrator": "dop853", "function": function} | options
    return program.simulate(model.values, start, **settings)


@pytest.fixture(scope="module")
def driven():
    model = read_model(DATA / "symbolic" / "slider_crank.toml")
    system = model.system
    rod = system.beams[0]
    middle = system.section(rod, rod.length / 2)
    eq = system.derive("recursive")
    program = eq.program(
        model.outputs | {"middle_x": middle.position & system.N[1], "middle_y": middle.position & system.N[2]}
    )
    return model, eq, simulate(model, program, model.start, t_end=0.1, steps=100, rtol=1e-9)


@pytest.mark.slow
def test_the_model_is_right_and_closed(driven):
    _, eq, run = driven
    check = eq.check()
    assert check.energy_error < 1e-28
    assert check.constraint_error < 1e-28
    assert np.max(np.abs(run["gap"])) < 1e-15
    assert run["a"] == pytest.approx(150.0 * run.time, abs=1e-13)


def refined(number):
    """crankfl.dat with `number` elements in the rod, node 6 in the middle."""
    places = [3, *(20 + k for k in range(1, number)), 8]
    places[number // 2] = 6
    turns = [5, *(40 + k for k in range(1, number + 1))]
    lines = ["PLBEAM 1 1 2 3 4"]
    lines += [f"PLBEAM {k + 2} {places[k]} {turns[k]} {places[k + 1]} {turns[k + 1]}" for k in range(number)]
    lines += ["X 1 0.0 0.0", *(f"X {p} {0.15 + 0.3 * k / number} 0.0" for k, p in enumerate(places))]
    lines += ["FIX 1", "FIX 8 2", "INPUTX 2 1", *(f"DYNE {k + 2} 2 3" for k in range(number)), "END", "HALT"]
    lines += ["XM 8 0.033375", *(f"EM {k + 2} 0.2225" for k in range(number))]
    lines += [f"ESTIFF {k + 2} 0.0 13.359623" for k in range(number)]
    lines += ["INPUTX 2 1 0.0 150.0 0.0", "TIMESTEP 0.1 100"]
    lines += [f"STARTDE {k + 2} {d} 0.0 0.0" for k in range(number) for d in (2, 3)]
    return "\n".join([*lines, "END", "END", ""])


@pytest.mark.slow
def test_against_beam_elements_of_the_core(driven):
    """Nodes 6 (middle of the rod) and 8 (block) of mode 1.

    Two cubic elements give the first frequency of the pinned rod, 850 rad/s, 0.4 % high: 0.34 rad of phase after 0.1 s
    on an oscillation of 5 mm, 1.7 mm. The error of the elements falls with the fourth power of their length; three
    shapes are 3e-4 high in the first frequency, 0.03 rad, 0.13 mm.
    """
    _, _, run = driven
    manual = spacar.run(1, spacar.parse_deck((DATA / "crankfl.dat").read_text()))
    errors = {2: manual, 4: spacar.run(1, spacar.parse_deck(refined(4)))}
    middle, block = (
        {n: np.max(np.abs(run[name] - r.node(node, i))) for n, r in errors.items()}
        for name, node, i in (("middle_y", 6, 2), ("x", 8, 1))
    )
    assert middle[2] < 0.34 * 5e-3
    assert middle[4] < 2e-4
    assert block[4] < 2e-5


@pytest.mark.slow  # test_closed.py::test_check_sees_energy_and_constraints is the fast one
def test_free_crank_keeps_its_energy(tmp_path):
    """Without the drive, with an inertia on the crank: the loop closes and energy is kept to 1e-9."""
    text = (DATA / "symbolic" / "slider_crank.toml").read_text()
    start = text.index('[[constraint]]\nname = "drive"')
    text = text[:start] + text[text.index("[simulate]") :]
    text = text.replace('motor = "drive_force"\n', "").replace("pinned 3", "pinned 2")
    text = text.replace('a = { speed = "w" }', 'a = { speed = "w", start = 0.3, speed_start = 150.0 }')
    text += '\n[[body]]\nname = "crank"\nat = "O"\nmass = 0\nframe = "A"\ninertia = [0, 0, 1e-3]\n'
    path = tmp_path / "free.toml"
    path.write_text(text)
    model = read_model(path)
    eq = model.system.derive("recursive")
    program = eq.program(model.outputs | {"E": sum(eq.energy())})
    run = simulate(model, program, model.start, t_end=0.05, steps=50, rtol=1e-11)
    assert np.ptp(run["E"]) < 1e-9 * np.max(np.abs(run["E"]))
    assert np.max(np.abs(run["gap"])) < 1e-15
