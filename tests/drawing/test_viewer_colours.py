"""Colours of `spacar view --stress` against the numbers of `spacar stress`, and what a browser shows of them."""

import re

import numpy as np
import pytest
from spacar_cli.commands import visual
from spacar_drawing import view
from spacar_drawing.look import look_of
from spacar_drawing.picture_source import source_of_result
from spacar_drawing.stress_numbers import stress_results
from spacar_drawing.stresses import QUANTITIES
from spacar_drawing.viewer_mesh import mesh_of
from spacar_drawing.viewer_page import LAST, NONE, field_colours, view_page

import spacar
from spacar.deck import parse_deck
from spacar.errors import UsageError

from .conftest import call
from .models import result_source
from .test_viewer import CHROMIUM, data_of, opened


def colours(name, mode, quantity):
    source = result_source(name, mode)
    chosen = [1, source.steps]
    xs = np.stack([source.x(k) for k in chosen])
    mesh = mesh_of(source.scene, xs, look_of(source.scene, xs, source.settings))
    return source, mesh, field_colours(source, mesh, chosen, quantity)


@pytest.mark.parametrize("quantity", ["Mz", "N"])
def test_resultants_along_a_loaded_cantilever(quantity):
    """Planar: the moment is linear between the ends of an element, and the frames lie evenly on it."""
    source, mesh, found = colours("plbeam5", 7, quantity)
    (first, elements, n), = mesh.lines
    value = found.low + found.numbers[-1].astype(float) / LAST * (found.high - found.low)
    table = stress_results(source, [source.steps], points=n)
    want = np.asarray(table[quantity]).reshape(len(elements), n)
    # 65534 levels over twice the largest value
    assert np.allclose(value[first : first + len(elements) * n].reshape(-1, n), want, rtol=0.0, atol=found.high / 6e4)
    assert found.low == -found.high
    assert found.unit == QUANTITIES[quantity][1]


def test_what_has_no_stress_keeps_its_colour():
    _, mesh, found = colours("crankfl", 1, "Mz")
    on_lines = np.zeros(mesh.frames, bool)
    for first, elements, n in mesh.lines:
        on_lines[first : first + len(elements) * n] = True
    assert np.all(found.numbers[:, ~on_lines] == NONE)
    assert np.any(found.numbers[:, on_lines] != NONE)


SPRINGS = """
PLTRUSS 1 1 2\nPLTRUSS 2 2 3\nPLTRUSS 3 1 3
X 1 0 0\nX 2 1 0\nX 3 0.5 1\nFIX 1\nFIX 2 2\nDYNE 1 1\nDYNE 2 1\nDYNE 3 1\nEND\nHALT
ESTIFF 1 1000\nESTIFF 2 1000\nESTIFF 3 1000\nXM 2 1\nXM 3 1\nXF 3 5 -10\nEND\nEND
"""


def test_springs_have_the_colour_of_their_force():
    """They have no elastic line; without any line a quantity that no element has is refused too."""
    source = source_of_result(spacar.run(7, parse_deck(SPRINGS)))
    xs = source.x(1)[None]
    mesh = mesh_of(source.scene, xs, look_of(source.scene, xs, source.settings))
    assert not mesh.lines
    found = field_colours(source, mesh, [1], "N")
    owner = mesh.owner
    for number, force in zip((1, 2, 3), stress_results(source, [1], points=2)["N"][0, :, 0], strict=True):
        shown = found.low + found.numbers[0, owner == number] / LAST * (found.high - found.low)
        assert np.allclose(shown, force, rtol=0.0, atol=found.high / 6e4)
        assert len(shown)
    assert np.all(found.numbers[0, owner == 0] == NONE)
    with pytest.raises(UsageError, match="von Mises stress: no element has a cross-section"):
        field_colours(source, mesh, [1], "mises")


@pytest.mark.filterwarnings("ignore:invalid value")
@pytest.mark.parametrize("wrong", [np.nan, np.inf])
def test_what_is_not_finite_has_no_colour_and_no_part_in_the_scale(wrong, monkeypatch):
    source, mesh, sound = colours("crankfl", 1, "N")
    first, elements, n = mesh.lines[0]
    row = int(source.scene.le[elements[0] - 1, 0]) - 1
    stored = type(source).get

    def get(self, name, step):
        value = np.array(stored(self, name, step), float)
        if name == "sig":
            value.flat[row] = wrong
        return value

    monkeypatch.setattr(type(source), "get", get)
    found = field_colours(source, mesh, [1, source.steps], "N")
    assert np.all(found.numbers[:, first : first + n] == NONE)
    assert np.any(found.numbers != NONE)
    assert 0.0 < found.high <= sound.high


def test_a_page_with_stress_has_its_scale():
    source = result_source("crosshingew", 10)
    field = data_of(view_page(source, stress="mises"))["field"]
    assert field["name"] == "von Mises stress"
    assert field["low"] == 0.0
    assert len(field["palette"]) == 9
    largest = stress_results(source, list(range(1, source.steps + 1))).largest("mises").value
    assert field["high"] <= largest * (1.0 + 1e-12)
    assert field["high"] == pytest.approx(largest, rel=0.05)  # the pictures have fewer points along an element
    assert data_of(view_page(source))["field"] is None


def test_wrong_stress(results):
    with pytest.raises(UsageError, match="there is no stress 'size'; expected N, Qy"):
        view(results / "trike3v", stress="size")
    wrong = call.refused("view", results / "trike3v", "--stress", "mises")
    assert "von Mises stress: no element has a cross-section" in wrong


def test_the_command_knows_every_quantity():
    assert set(visual.QUANTITIES) == set(QUANTITIES)


@pytest.mark.slow
@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium to open the page with")
def test_a_browser_shows_the_colours(tmp_path):
    path = tmp_path / "hinge.html"
    path.write_text(view_page(result_source("crosshingew", 10), stress="mises"))
    state, page = opened(path, "step=10&ink=1")
    assert state["state"] == "ready"  # both shaders were compiled with the palette in them
    assert re.search(r'<label id="fields">', page)
