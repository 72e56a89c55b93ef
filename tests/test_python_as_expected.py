"""What users of Python try first: a model in memory goes wherever a file goes, answers print short, draw themselves and
become tables, and what is wrong is said by an error of ours."""

import importlib.util
import json
import subprocess
import sys

import numpy as np
import pytest
import spacar_drawing
from spacar_formats.compliance import node_compliance

import spacar
from spacar.calls import deck_of
from spacar.errors import SpacarError
from spacar.simulation import Diagram, Spasim, closed_loop, simulate
from tests.examples import DATA


@pytest.fixture(scope="module")
def model():
    """A steel strip, clamped at one end, with a force at the other."""
    m = spacar.Model("cantilever")
    a, b = m.node(1, (0.0, 0.0)), m.node(3, (0.5, 0.0))
    beam = m.plbeam(1, (a, 2), (b, 4), section="strip", material="steel", parts=4)
    m.section("strip", "RECT", 0.001, 0.02)
    m.fix(a)
    m.fix(2)
    m.dyne(beam, 2, 3)
    m.xf(b, Fy=-0.1)
    return m


def test_a_model_a_deck_and_a_file_are_one_thing(model, tmp_path):
    """The same numbers, whichever way they come."""
    path = model.save(tmp_path / "strip")
    deck = spacar.read_deck(path)
    for source in (model, deck, path, str(path)):
        assert spacar.run(7, source).node(3, 2)[-1] == model.run(7).node(3, 2)[-1]
        assert spacar.flexure(source, force="3y=-0.1", steps=1).force[0] == -0.1
        slope = spacar.sensitivity(source, ["SECTION.strip[t]"], "x[3,2]@end")
        assert slope.derivatives[0, 0] == pytest.approx(0.594256, rel=1e-5)
        assert deck_of(source, 7).mode == 7
    assert deck.run(7).node(3, 2)[-1] == model.run(7).node(3, 2)[-1]


def test_pictures_and_stresses_of_a_model(model):
    assert spacar_drawing.stress(model)["Mz"].shape == (1, 4, 9)
    by_force = model.sensitivity("XF.3[force Fy]", "x[3,2]@end").derivatives[0, 0]
    assert node_compliance(model, 3)[0].fixed[1, 1] == pytest.approx(by_force, rel=1e-9)
    for figure in (spacar_drawing.draw(model), model.run(7).plot("x[3,2]"), spacar_drawing.draw(model.run(7), steps=1)):
        assert figure._repr_png_().startswith(b"\x89PNG")


def test_a_mechanism_of_a_model_is_a_block():
    deck = spacar.read_deck(DATA / "robotsim.dat", "simulation")
    plants = [Spasim(source) for source in (DATA / "robotsim.dat", deck, spacar.Model.from_deck(deck))]
    assert all(np.array_equal(p.start(), plants[0].start()) for p in plants)


def drive():
    """A simulation of 0.01 s without moments."""
    return closed_loop(Spasim(DATA / "robotsim.dat"), lambda t, y: np.zeros(3), [0.0, 0.01], feedback="1-3")


def test_answers_print_short_draw_themselves_and_become_tables(model):
    rows = model.sweep({"XF.3[force Fy]": [-0.1, -0.2]}, "tip: x[3,2]@end")  # mode 7: there is no TIMESTEP
    assert rows[0]["tip"] == model.run(7).node(3, 2)[-1]
    slope = model.sensitivity(["SECTION.strip[t]"], ["x[3,2]@end", "frequency[1]"])
    response = drive()
    for answer in (rows, slope, response, spacar_drawing.stress(model), spacar.frames(7, model)):
        assert 2 <= len(repr(answer).splitlines()) <= 10
        assert len(repr(answer)) < 900
    for figure in (rows.plot(), slope.plot(), response.plot(), response.plot("plant:1-3", "control")):
        assert figure._repr_png_().startswith(b"\x89PNG")
    pytest.importorskip("pandas")
    assert rows.to_pandas()["tip"].tolist() == [row["tip"] for row in rows]
    assert slope.to_pandas()["derivative"].tolist() == slope.derivatives.ravel().tolist()
    table = response.to_pandas()
    assert table[table.columns[0]].tolist() == response["plant:1"][:, 0].tolist()


def test_a_result_says_how_accurate_it_is():
    result = spacar.run(1, DATA / "crank.dat", accuracy=True, duration=0.02, n_steps=4)
    assert "accuracy    " in repr(result)


WRONG = {
    "model": lambda m, r: spacar.run(1, 5),
    "text of a deck": lambda m, r: spacar.Model("PLTRUSS 1 1 2\nEND"),
    "mode": lambda m, r: spacar.run("x", m),
    "no file": lambda m, r: spacar.run(1, "nofile"),
    "option": lambda m, r: m.run(7, foo=1),
    "steps": lambda m, r: m.flexure(move="3y=0.01", steps="a"),
    "target": lambda m, r: m.trade("a"),
    "changes": lambda m, r: m.sweep(["a"], "x"),
    "node": lambda m, r: r.node("a"),
    "variable": lambda m, r: r["q q"],
    "picture": lambda m, r: r.plot("x[3,2]", path="/nonexist/a.png"),
    "step": lambda m, r: r.draw(steps=3),
    "option of a picture": lambda m, r: r.draw(step=1),
    "trace of no node": lambda m, r: r.draw(traces=[99]),
    "trace of an orientation": lambda m, r: r.animate(traces=2),
    "no film": lambda m, r: r.animate("a.png"),
    "no frames": lambda m, r: r.animate(frames=0),
    "number of a variable": lambda m, r: r[7],
    "number for an expression": lambda m, r: r.plot(7),
    "number for a result": lambda m, r: m.sweep({"XF.3[force Fy]": [1.0]}, 7),
    "number for a parameter": lambda m, r: m.sensitivity(7, ["x[3,2]@end"]),
    "mode of a sensitivity": lambda m, r: m.sensitivity(["XF.3[force Fy]"], ["x[3,2]@end"], mode=7),
    "number for a variable": lambda m, r: m.run(7, accuracy=0.1, variables=7),
    "repeats": lambda m, r: m.trade(0.1, repeats=0),
    "budget": lambda m, r: m.trade(0.1, budget=None),
    "move": lambda m, r: m.flexure(move=3),
    "places": lambda m, r: r.stress(points="a"),
    "elements": lambda m, r: r.stress(elements=["a"]),
    "nominal": lambda m, r: spacar.run(3, m, nominal=3),
    "times": lambda m, r: simulate(Diagram(), "a"),
    "diagram": lambda m, r: simulate(None, [0.0, 1.0]),
    "number for a path": lambda m, r: spacar.read_deck(5),
    "number for a deck": lambda m, r: spacar.parse_deck(5),
    "number for a name": lambda m, r: spacar.Model(5),
    "list of accuracies": lambda m, r: m.run(7, accuracy=[1]),
    "number for a film": lambda m, r: r.animate(5),
    "number for a picture": lambda m, r: r.draw(5),
    "number for a result file": lambda m, r: r.save(5),
    "number for a column": lambda m, r: r.to_pandas(5),
    "signal": lambda m, r: drive().plot("plant:99"),
}


@pytest.mark.parametrize("what", WRONG)
def test_what_is_wrong_is_said_by_an_error_of_ours(model, what):
    with pytest.raises(SpacarError):
        WRONG[what](model, model.run(7))


def test_a_mode_may_be_a_number_of_numpy(model):
    assert [model.run(mode).mode for mode in np.array([7, -8])] == [7, 8]


NOTEBOOK = """import spacar
result = spacar.run(1, r"DATA/crank.dat", duration=0.02, n_steps=4)
result
--
result.plot("x[6,1]")
--
result.draw(strobe=3)
--
result.to_pandas("x[6,1]")
--
result.animate(frames=3)"""


@pytest.mark.slow
@pytest.mark.skipif(not importlib.util.find_spec("nbconvert"), reason="nbconvert is not installed")
def test_a_notebook_with_nothing_but_import_spacar_shows_everything(tmp_path):
    cells = [
        {"cell_type": "code", "execution_count": None, "id": f"c{k}", "metadata": {}, "outputs": [], "source": source}
        for k, source in enumerate(NOTEBOOK.replace("DATA", str(DATA)).split("\n--\n"))
    ]
    book = {"cells": cells, "metadata": {}, "nbformat": 4, "nbformat_minor": 5}
    path = tmp_path / "first.ipynb"
    path.write_text(json.dumps(book))
    words = [sys.executable, "-m", "nbconvert", "--to", "notebook", "--execute", "--output", "done.ipynb", str(path)]
    subprocess.run(words, check=True, capture_output=True, timeout=240)
    made = json.loads((tmp_path / "done.ipynb").read_text())["cells"]
    kinds = [{kind for output in cell["outputs"] for kind in output.get("data", ())} for cell in made]
    assert ["text/html" in k or "image/png" in k for k in kinds] == [True] * 5, kinds
    assert all("image/png" in k for k in kinds[1:3])
