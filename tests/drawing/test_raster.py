"""Quick pictures of animations and windows against the stills of the same shapes, drawn in another way."""

import time
from itertools import pairwise

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from spacar_drawing.bodies import beam_lines
from spacar_drawing.drawn_shapes import Faces, Label, Line, Mark, convex_pieces, disc_outline, solid
from spacar_drawing.files import MovingFigure
from spacar_drawing.mechanism_picture import Extras, draw_steps, series
from spacar_drawing.paint import MOST_LABELS, _alike, paint, place_labels, thin
from spacar_drawing.scene import Pose
from spacar_drawing.sections import outline
from spacar_drawing.settings import SectionShape
from spacar_drawing.stage import Camera, new_figure

from .models import result_source

# Root mean square of the difference in grey levels, of that to an empty picture: edges are smoothed in another way; it
# shows most where everything is thin (0.09 for the zigzags of the springs of the lever).
ALIKE = 0.2


def grey(figure, drawn=False):
    canvas = figure.canvas if drawn else FigureCanvasAgg(figure)
    if not drawn:
        canvas.draw()
    return np.asarray(canvas.buffer_rgba())[:, :, :3].astype(float).mean(2)


def moving_pixels(bounds, camera, pictures):
    moving = MovingFigure.create(bounds, camera)
    FigureCanvasAgg(moving.figure)
    for shapes in pictures:
        moving.show(shapes, "a title")
        moving.draw()
    return grey(moving.figure, drawn=True)


def still_pixels(bounds, camera, shapes):
    figure, axes = new_figure(bounds, camera, "a title")
    paint(axes, camera, shapes)
    return grey(figure)


def difference(a, b):
    return float(np.sqrt(np.mean((a - b) ** 2)))


@pytest.mark.parametrize("name", [
    "crank", "leafguide", "plbeam5free",
    *(pytest.param(n, marks=pytest.mark.slow) for n in ("lever", "trike3v", "slider", "lateral4")),
])  # fmt: skip
def test_every_frame_is_the_still_of_its_step(name):
    """The frame before it leaves nothing behind."""
    source = result_source(name, 1, 0.02, 2)
    shown = series(source, Extras(), [1, 2, 3], [], False)
    first, last = (shown.pictures(k)[0] for k in (0, 2))
    quick = moving_pixels(shown.bounds, shown.camera, [first, last])
    still, empty = (still_pixels(shown.bounds, shown.camera, shapes) for shapes in (last, []))
    assert difference(quick, still) < ALIKE * difference(still, empty)
    assert difference(quick, moving_pixels(shown.bounds, shown.camera, [last])) == 0.0


def test_what_covers_what():
    """Ten rods of random colours and places, one mark, one line in front: the nearest is seen (1.5 grey levels)."""
    rng = np.random.default_rng(2)
    camera, shapes = Camera.towards(-50, 20), []
    for _ in range(10):
        a, b = rng.uniform(-0.7, 0.7, (2, 3))
        line = a + np.linspace(0, 1, 9)[:, None] * (b - a)
        u = np.cross(b - a, [0, 0, 1.0])
        u /= np.linalg.norm(u)
        v = np.cross((b - a) / np.linalg.norm(b - a), u)
        ones = np.ones((9, 1))
        shapes += solid(disc_outline(0.12), line, ones * u, ones * v, tuple(rng.random(3)))
    shapes += [Mark(np.zeros(3), 6.0), Line(np.array([[-0.7, 0, 0.7], [0.7, 0, -0.7]]), width=3.0, layer=6)]
    bounds = -np.ones(3), np.ones(3)
    assert difference(moving_pixels(bounds, camera, [shapes]), still_pixels(bounds, camera, shapes)) < 2.5


def test_planar_areas_of_opposite_turns_leave_no_hole():
    """Two squares that overlap, one clockwise: by the rule of winding numbers one path is empty where they do."""
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1.0, 0]])
    both = np.stack((square, square[::-1] + 0.5))
    bounds = np.array([-0.2, -0.2, 0]), np.array([1.7, 1.7, 0])
    shapes = [Faces(both, "#203040", light=False)]
    plane = Camera.plane()
    assert difference(moving_pixels(bounds, plane, [shapes]), still_pixels(bounds, plane, shapes)) < 0.5


def test_many_beams_at_once_are_the_beams_one_by_one():
    source = result_source("leafguide", 7)
    scene, x = source.scene, source.x(1)
    pose = Pose.of(scene, x)
    beams = [e for e in scene.elements if e.shape == "beam"]
    together = beam_lines(scene, pose, beams, 9)
    for i, e in enumerate(beams):
        for many, one in zip(together, beam_lines(scene, pose, [e], 9), strict=True):
            np.testing.assert_allclose(many[i], one[0], atol=1e-15)


@pytest.mark.parametrize("shape", [SectionShape("I", (0.1, 0.2, 0.01, 0.02)), SectionShape("RECT", (0.1, 0.3))])
def test_convex_pieces_fill_the_outline(shape):
    """Area by the shoelace formula, pieces against whole; no piece turns the other way round."""
    contour = outline(shape)

    def area(p):
        x, y = p.T
        return 0.5 * np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)

    areas = [area(contour[list(piece)]) for piece in convex_pieces(contour)]
    assert min(areas) > 0
    assert sum(areas) == pytest.approx(area(contour), rel=1e-12)


def test_an_outline_without_area_is_cut_into_nothing_worse():
    assert len(convex_pieces(np.array([[0, 0], [1, 0], [0.5, 1e-3], [0.5, 0.0], [0.2, 0.3]]))) >= 1


@pytest.mark.parametrize("planar", [pytest.param(True, marks=pytest.mark.slow), False])
def test_thousand_beams_move(planar):
    """A frame takes 12 and 23 ms of processor time here (benchmarks/pictures.py); asked for are 50, allowed 250."""
    from benchmarks.pictures import bent

    shown = series(bent(1000, planar), Extras(), [1, 2, 3], [], False)
    moving = shown.moving()
    FigureCanvasAgg(moving.figure)
    pictures = [shown.pictures(k) for k in range(3)]
    moving.show(*pictures[0])
    moving.draw()
    begun = time.process_time()
    for k in range(3):
        moving.show(*shown.pictures(k))
        moving.draw()
    assert (time.process_time() - begun) / 3 < 0.25


def test_a_still_of_the_same_beams():
    from benchmarks.pictures import bent

    source = bent(200, False)
    figure = draw_steps(source.scene, source.x(), source.settings, Extras(title=""))
    assert grey(figure).min() < 150


# Pictures of large models: labels are thinned out and found by neighbourhood, polygons are drawn in one piece.
def test_few_labels_all_stay():
    labels = [Label(np.zeros(3), str(i)) for i in range(MOST_LABELS)]
    assert thin(labels) == (labels, 1)


def test_many_labels_are_thinned_to_round_numbers_and_the_ends():
    labels = [Label(np.zeros(3), str(i)) for i in range(1, 1002)]
    shown, k = thin(labels)
    assert k == 20
    assert [s.text for s in shown] == ["1", *(str(i) for i in range(20, 1001, 20)), "1001"]


def test_polygons_of_different_corners_keep_their_outline():
    """Area by the shoelace formula: a repeated corner does not change it."""
    triangle, square = np.array([[[0, 0], [2, 0], [0, 2.0]]]), np.array([[[0, 0], [1, 0], [1, 1], [0, 1.0]]])
    both = _alike([triangle, square])
    x, y = both[..., 0], both[..., 1]
    area = 0.5 * np.sum(x * np.roll(y, -1, 1) - np.roll(x, -1, 1) * y, axis=1)
    np.testing.assert_allclose(area, [2.0, 1.0])


def test_thousand_numbered_beams():
    """Minutes as long as labels looked at everything; the limit is several times the need."""
    angle = np.linspace(0.0, 6.0, 1001)
    places = np.stack((np.cos(angle), np.sin(angle), 0 * angle), axis=1)
    shapes = [Line(np.linspace(a, b, 4)) for a, b in pairwise(places)]
    shapes += [Label(p, str(i)) for i, p in enumerate(places, 1)]
    shapes += [Label(0.5 * (a + b), str(i), boxed=True) for i, (a, b) in enumerate(pairwise(places))]
    camera = Camera.plane()
    _, axes = new_figure((-np.ones(3), np.ones(3)), camera)
    begun = time.process_time()
    paint(axes, camera, shapes)
    assert time.process_time() - begun < 5.0
    told = [t.get_text() for t in axes.texts]
    assert "every 20th number of nodes and every 20th number of elements" in told
    assert {"1", "20", "1001"} <= set(told)


def test_labels_do_not_cover_each_other():
    """Twenty labels of one place: every one finds a place of its own among the 24."""
    camera = Camera.plane()
    _, axes = new_figure((-np.ones(3), np.ones(3)), camera)
    texts = place_labels(axes, camera, [Label(np.zeros(3), str(i)) for i in range(8)], [])
    at = np.array([t.xyann for t in texts])
    gap = np.abs(at[:, None] - at[None]).max(-1) + 100 * np.eye(len(at))
    assert gap.min() > 4.0


def test_a_label_does_not_cover_the_long_part_of_a_line():
    """An ordinate up to the right, then a curve of many points elsewhere: not the first place, which is up right."""
    camera = Camera.plane()
    _, axes = new_figure((-np.ones(3), np.ones(3)), camera)
    curve = np.stack((np.linspace(0.9, -0.9, 300), np.full(300, 0.9), np.zeros(300)), axis=1)
    line = Line(np.concatenate((np.zeros((1, 3)), curve)), "k", 1.0, 1)
    (text,) = place_labels(axes, camera, [Label(np.zeros(3), "30.49")], [line])
    assert not (text.xyann[0] > 0.0 and text.xyann[1] > 0.0)


def test_faces_keep_their_colours_in_one_collection():
    square = np.array([[[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1.0, 0]]])
    camera = Camera.plane()
    _, axes = new_figure((-np.ones(3), np.ones(3)), camera)
    (collection,) = paint(axes, camera, [Faces(square, "#ff0000"), Faces(square[:, :3], "#0000ff", "#00ff00")])
    np.testing.assert_allclose(collection.get_facecolor(), [[1, 0, 0, 1], [0, 0, 1, 1]])
    np.testing.assert_allclose(collection.get_edgecolor(), [[1, 0, 0, 0], [0, 1, 0, 1]])
