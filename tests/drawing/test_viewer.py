"""The page of `spacar view`: its mesh against the pictures, what it holds, and what a real browser shows of it."""

import json
import re
import shutil
import subprocess
from base64 import b64decode, b64encode
from dataclasses import replace
from hashlib import sha256
from html import unescape

import numpy as np
import pytest
from spacar_drawing import view
from spacar_drawing.bodies import beam_lines
from spacar_drawing.drawn_shapes import Faces, cylinder
from spacar_drawing.element_pictures import PARTS
from spacar_drawing.look import look_of
from spacar_drawing.picture_source import source_of_result
from spacar_drawing.report_page import report_page
from spacar_drawing.scene import Pose
from spacar_drawing.stress_numbers import stress_results
from spacar_drawing.stresses import QUANTITIES
from spacar_drawing.viewer_mesh import ELEMENT, FRAME, PLACE, TriangleMesh, mesh_of, rigid_motion
from spacar_drawing.viewer_page import LAST, NONE, field_colours, view_page

import spacar
from spacar.errors import UsageError

from .conftest import call
from .models import result_source

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")


def corners(mesh, k):
    """Places of all corners in picture k: p + a X + b Y + c Z."""
    p, y, z = mesh.moving[:, k]
    i, place = mesh.corner[:, FRAME].astype(int), mesh.corner[:, PLACE]
    axes = np.stack((np.cross(y, z), y, z), axis=1)
    return p[i] + np.einsum("na,nax->nx", place, axes[i])


@pytest.mark.parametrize("name", [
    "trike3v", "cardan", "lever", "slider", pytest.param("screw", marks=pytest.mark.slow), "trike2",
])  # fmt: skip
def test_parts_of_the_mesh_are_the_faces_of_the_pictures(name):
    """At all pictures: every corner that an element's own drawing has is a corner of the mesh of that element."""
    source = result_source(name, 1, 0.02, 2)
    scene, xs = source.scene, source.x()
    look = look_of(scene, xs, source.settings)
    mesh = mesh_of(scene, xs, look)
    number = mesh.corner[:, ELEMENT]
    for k, x in enumerate(xs):
        found = corners(mesh, k)
        for e in scene.elements:
            if e.shape not in PARTS:
                continue
            for shape in PARTS[e.shape](scene, Pose.of(scene, x), look, e):
                if isinstance(shape, Faces):
                    own, wanted = found[number == e.number], shape.corners.reshape(-1, 3)
                    gap = np.linalg.norm(own[:, None] - wanted[None, ::7], axis=2).min(0)
                    assert gap.max() < 1e-6 * look.size / 0.022


def test_beams_of_the_mesh_follow_the_elastic_line():
    source = result_source("crankfl", 1, 0.02, 2)
    scene, xs = source.scene, source.x()
    look = look_of(scene, xs, source.settings)
    mesh = mesh_of(scene, xs, look)
    beams = [e for e in scene.elements if e.shape == "beam"]
    p = mesh.moving[0]
    for k, x in enumerate(xs):
        for e in beams:
            line = beam_lines(scene, Pose.of(scene, x), [e], look.points)[0][0]
            gap = np.linalg.norm(line[:, None] - p[k][None], axis=2).min(1)
            assert gap.max() < 1e-12


def test_rigid_motion_finds_the_rotation():
    rng = np.random.default_rng(4)
    R = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    R *= np.linalg.det(R)
    body = rng.normal(size=(7, 3))
    _, turn, rest = rigid_motion(np.stack((body, body @ R.T + [1.0, 2, 3])))
    np.testing.assert_allclose(turn[1], R, atol=1e-13)
    assert np.abs(rest).max() < 1e-13
    flat = body * [1, 1, 0]  # a plane has two solutions to the least squares, one of them a reflection
    _, turn, _ = rigid_motion(np.stack((flat, flat @ R.T)))
    np.testing.assert_allclose(np.linalg.det(turn), 1.0, atol=1e-12)


def test_what_changes_its_shape_keeps_its_corners():
    mesh = TriangleMesh(1.0, 2)
    (side, *_) = cylinder(np.zeros(3), np.array([0, 0, 1.0]), 0.1, "#ff0000")
    one = side.corners.reshape(-1, 3)
    both = np.stack((one, one * [1, 1, 2]))
    mesh.part(both, np.zeros_like(one), 3, np.arange(len(one)).reshape(-1, 3)[:1], 1.0)
    np.testing.assert_allclose(corners(mesh, 1), both[1])


def data_of(page):
    return json.loads(re.search(r'id="data">(.*?)</script>', page, re.S)[1])


def test_the_page_needs_nothing_else():
    """No address of anything, one script, and that is the one whose digest the policy names."""
    page = view_page(result_source("crank", 1, 0.02, 4))
    assert not re.findall(r"(?:src|href)\s*=|https?:|@import|url\(", page)
    script = re.findall(r"<script>(.*?)</script>", page, re.S)
    assert len(script) == 1
    assert b64encode(sha256(script[0].encode()).digest()).decode() in page
    assert "default-src 'none'" in page
    assert "innerHTML" not in page
    assert "eval(" not in page


def test_text_of_a_model_stays_text():
    source = result_source("crank", 1, 0.02, 1)
    evil = "</script><script>alert(1)</script>&<!--"
    page = view_page(replace(source, scene=replace(source.scene, title=evil)))
    assert page.count("<script") == 2
    assert "<script>alert" not in page
    assert "<!--" not in page


def test_nodes_of_the_page_are_the_coordinates():
    source = result_source("crank", 1, 0.02, 4)
    data = data_of(view_page(source))
    places = np.frombuffer(b64decode(data["arrays"]["nodes"]), "<f4").reshape(len(data["times"]), -1, 3)
    assert data["nodes"] == ["1 (2)", "3 (4,5)", "6 (7)"]
    assert data["times"] == ["t = 0 s", "t = 0.005 s", "t = 0.01 s", "t = 0.015 s", "t = 0.02 s"]
    pin = source.x()[:, source.scene.lnp[2, :2] - 1]
    np.testing.assert_allclose(places[:, 1, :2] + data["centre"][:2], pin, atol=1e-7)


def test_large_results_keep_fewer_pictures(monkeypatch):
    from spacar_drawing import viewer_page

    source = result_source("crank", 1, 0.02, 40)
    assert len(data_of(view_page(source))["times"]) == 41
    monkeypatch.setattr(viewer_page, "BUDGET", 2e4)
    few = data_of(view_page(source))["times"]
    assert 2 <= len(few) < 20
    assert few[-1] == "t = 0.02 s"


def test_command_and_call(results):
    done = call("view", results / "crank", "--frames", 5)
    assert done.status == 0
    page = (results / "crank_view.html").read_text()
    assert len(data_of(page)["times"]) == 5
    assert view(results / "crank", results / "again.html", frames=5) == page == (results / "again.html").read_text()
    for name in ("trike3v", "crank"):
        assert "--view upside" in call.refused("view", results / name, "--view", "upside")


def test_the_report_holds_the_page_in_a_frame():
    source = result_source("crank", 1, 0.02, 2)
    page = report_page(source, log_lines=0, viewer=True)
    frame = re.search(r'<iframe class="viewer" sandbox="allow-scripts" title="motion" srcdoc="([^"]*)"></iframe>', page)
    assert unescape(frame[1]) == view_page(source)
    assert "<script" not in page.replace(frame[1], "")
    assert "<iframe" not in report_page(source, log_lines=0)


def opened(path, wishes):
    """The attributes and the text of the page after its script has run in a browser; skips one without WebGL 2."""
    command = [
        CHROMIUM, "--headless", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader",
        "--enable-unsafe-swiftshader", "--window-size=900,700", "--dump-dom", f"{path.as_uri()}#{wishes}",
    ]  # fmt: skip
    page = subprocess.run(command, capture_output=True, text=True, timeout=240, check=False).stdout
    state = dict(re.findall(r'data-(\w+)="([^"]*)"', re.search(r"<body[^>]*>", page)[0]))
    if state.get("state") == "no-webgl":
        pytest.skip("this Chromium has no WebGL 2")
    return state, page


@pytest.mark.slow
@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium to open the page with")
def test_a_browser_shows_it_and_tells_the_numbers_of_a_node(tmp_path):
    source = result_source("crank", 1, 0.02, 4)
    path = tmp_path / "crank.html"
    path.write_text(view_page(source))
    state, page = opened(path, "step=3&node=3&ink=1")
    assert state["state"] == "ready"
    assert 0.002 < float(state["ink"]) < 0.3
    table = dict(re.findall(r"<tr><th>([^<]*)</th><td>([^<]*)</td></tr>", page))
    pin = source.x(4)[source.scene.lnp[2, :2] - 1]
    np.testing.assert_allclose([float(table["x (m)"]), float(table["y (m)"])], pin, atol=2e-7)
    assert "t = 0.015 s" in page


@pytest.mark.slow
@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium to open the page with")
def test_five_thousand_beams_in_a_browser(tmp_path):
    """What the page itself computes for a picture is short (5 ms here); the drawing depends on the graphics card."""
    from benchmarks.pictures import bent

    path = tmp_path / "many.html"
    path.write_text(view_page(bent(5000, False, 6)))
    state, _ = opened(path, "measure=6")
    assert state["state"] == "ready"
    assert float(state["script"]) < 100


def test_a_stationary_result_is_opened_at_its_last_state():
    for name, mode, shown in (("leafguide", 7, -1), ("crank", 1, 0)):
        data = data_of(view_page(result_source(name, mode)))
        assert len(data["times"]) > 1
        assert data["shown"] == shown % len(data["times"])


# Colours of `spacar view --stress` against the numbers of `spacar stress`, and what a browser shows of them.
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
    source = source_of_result(spacar.run(7, spacar.parse_deck(SPRINGS)))
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


@pytest.mark.slow
@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium to open the page with")
def test_a_browser_shows_the_colours(tmp_path):
    path = tmp_path / "hinge.html"
    path.write_text(view_page(result_source("crosshingew", 10), stress="mises"))
    state, page = opened(path, "step=10&ink=1")
    assert state["state"] == "ready"  # both shaders were compiled with the palette in them
    assert re.search(r'<label id="fields">', page)
