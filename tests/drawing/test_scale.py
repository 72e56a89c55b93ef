"""Pictures of large models: labels are thinned out and found by neighbourhood, polygons are drawn in one piece."""

import time
from itertools import pairwise

import numpy as np
from spacar_drawing.drawn_shapes import Faces, Label, Line
from spacar_drawing.paint import MOST_LABELS, _alike, paint, place_labels, thin
from spacar_drawing.stage import Camera, new_figure


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
