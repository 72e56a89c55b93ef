"""Colours of `spacar view --stress` against the numbers of `spacar stress`, and what a browser shows of them."""

import re

import numpy as np
import pytest
from spacar_cli.commands import visual
from spacar_drawing import view
from spacar_drawing.look import look_of
from spacar_drawing.stress_numbers import stress_results
from spacar_drawing.stresses import QUANTITIES
from spacar_drawing.viewer_colours import LAST, NONE, field_colours
from spacar_drawing.viewer_mesh import mesh_of

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


def test_a_page_with_stress_has_its_scale():
    source = result_source("crosshingew", 10)
    field = data_of(view_of(source, "mises"))["field"]
    assert field["name"] == "von Mises stress"
    assert field["low"] == 0.0
    assert len(field["palette"]) == 9
    largest = stress_results(source, list(range(1, source.steps + 1))).largest("mises").value
    assert field["high"] == pytest.approx(largest, rel=0.05)  # the pictures have fewer points along an element
    assert data_of(view_of(source, None))["field"] is None


def view_of(source, stress):
    from spacar_drawing.viewer_page import view_page

    return view_page(source, stress=stress)


def test_wrong_stress(results):
    with pytest.raises(UsageError, match="there is no stress 'size'; expected N, Qy"):
        view(results / "trike3v", stress="size")
    wrong = call("view", results / "trike3v", "--stress", "mises")
    assert wrong.status == 2
    assert "von Mises stress: no element has a cross-section" in wrong.err


def test_the_command_knows_every_quantity():
    assert set(visual.QUANTITIES) == set(QUANTITIES)


@pytest.mark.slow
@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium to open the page with")
def test_a_browser_shows_the_colours(tmp_path):
    path = tmp_path / "hinge.html"
    path.write_text(view_of(result_source("crosshingew", 10), "mises"))
    state, page = opened(path, "step=10&ink=1")
    if state.get("state") == "no-webgl":
        pytest.skip("this Chromium has no WebGL 2")
    assert state["state"] == "ready"  # both shaders were compiled with the palette in them
    assert re.search(r'<label id="fields">', page)
