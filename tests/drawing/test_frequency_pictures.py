"""Every curve of a Bode diagram has a name, however many there are; rounding is no cloud in a root locus."""

from types import SimpleNamespace

import numpy as np
from spacar_drawing.frequency_pictures import bode_figure, root_figure
from spacar_formats.vibration import without_rounding


def diagram(n_out, n_in):
    system = SimpleNamespace(outputs=[f"y{i} node" for i in range(n_out)], inputs=[f"u{j}" for j in range(n_in)])
    omega = np.logspace(-1, 1, 20)
    response = np.tile((1 / (1 + 1j * omega))[:, None, None], (1, n_out, n_in))
    return bode_figure(system, omega, response, [(i, j) for i in range(n_out) for j in range(n_in)], "many")


def test_few_curves_share_a_panel():
    figure = diagram(2, 2)
    assert len(figure.axes) == 2
    texts = [t.get_text() for t in figure.axes[0].get_legend().get_texts()]
    assert texts == ["y0 node / u0", "y0 node / u1", "y1 node / u0", "y1 node / u1"]


def test_many_curves_have_a_column_an_input_and_one_legend():
    figure = diagram(15, 3)
    assert len(figure.axes) == 6
    assert [a.get_title() for a in figure.axes[:3]] == ["from u0", "from u1", "from u2"]
    assert [t.get_text() for t in figure.legends[0].get_texts()] == [f"y{i} node" for i in range(15)]
    looks = {(line.get_color(), line.get_linestyle()) for line in figure.axes[0].lines}
    assert len(looks) == 15  # no two outputs look the same


def test_rounding_is_zero_and_light_damping_is_not():
    values = np.array([1e-13 + 1000j, 1e-13 - 1000j, -1e-9 + 500j, -1e-9 - 500j])
    clean = without_rounding(values)
    np.testing.assert_array_equal(clean, [1000j, -1000j, -1e-9 + 500j, -1e-9 - 500j])
    figure = root_figure([SimpleNamespace(values=values[:2])], np.array([0.0]), "step", "undamped")
    (dots,) = [np.asarray(c.get_offsets()) for c in figure.axes[1].collections]
    np.testing.assert_array_equal(dots[:, 0], 0.0)
