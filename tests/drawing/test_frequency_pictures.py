"""Every curve of a Bode diagram has a name, however many there are; rounding is no cloud in a root locus."""

from types import SimpleNamespace

import numpy as np
import pytest
from spacar_drawing.frequency_pictures import bode_figure, margins, root_figure, unwrapped
from spacar_formats.signal_tables import signal_unit
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
    values = np.array([1e-13 + 1000j, 1e-13 - 1000j, -1e-9 + 500j, -1e-9 - 500j, 1e-2])
    clean = without_rounding(values)
    np.testing.assert_array_equal(clean, [1000j, -1000j, -1e-9 + 500j, -1e-9 - 500j, 1e-2])
    figure = root_figure([SimpleNamespace(values=values[:2])], np.array([0.0]), "step", "undamped")
    (dots,) = [np.asarray(c.get_offsets()) for c in figure.axes[1].collections]
    np.testing.assert_array_equal(dots[:, 0], 0.0)


def test_margins_of_three_lags():
    """10/(s + 1)^3: gain 10/8 at sqrt(3) rad/s; gain one at sqrt(10^(2/3) - 1), phase -3 arctan of that."""
    omega = np.geomspace(0.05, 50.0, 2000)
    h = 10 / (1j * omega + 1) ** 3
    assert unwrapped(h)[-1] == pytest.approx(-3 * np.degrees(np.arctan(50.0)), abs=1e-9)
    one = np.sqrt(10 ** (2 / 3) - 1)
    gain, at = 20 * np.log10(0.8), np.sqrt(3) / (2 * np.pi)
    phase, where = 180 - 3 * np.degrees(np.arctan(one)), one / (2 * np.pi)
    expected = f"gain margin {gain:.3g} dB at {at:.3g} Hz, phase margin {phase:.3g}\N{DEGREE SIGN} at {where:.3g} Hz"
    assert margins(omega / (2 * np.pi), 20 * np.log10(np.abs(h)), unwrapped(h)) == expected


def test_poles_without_damping_turn_back_and_zeros_forward():
    """(4 - w^2)/((1 - w^2)(9 - w^2)): half a turn at 1, back at 2, and again at 3; no margin at a peak."""
    omega = np.geomspace(0.1, 30.0, 501)
    h = ((4 - omega**2) / ((1 - omega**2) * (9 - omega**2))).astype(complex)
    at = [np.interp(w, omega, unwrapped(h)) for w in (0.5, 1.5, 2.5, 10.0)]
    assert at == pytest.approx([0.0, -180.0, 0.0, -180.0], abs=1e-9)
    assert margins(omega, 20 * np.log10(np.abs(h)), unwrapped(h)) == ""


@pytest.mark.parametrize("eps", [0.0, 1e-9, 1e-2])
def test_peaks_without_damping_are_cut_off_and_damped_ones_are_not(eps):
    omega = np.unique(np.concatenate((np.geomspace(0.1, 10.0, 200), 1 + eps * np.linspace(-5, 5, 21) + 1e-7)))
    system = SimpleNamespace(outputs=["OUTX node 3 x"], inputs=["INPUTF node 3 x"])
    h = 1 / (1 - omega**2 + 2j * eps * omega)
    figure = bode_figure(system, omega, h[:, None, None], [(0, 0)], "peak")
    top = figure.axes[0].get_ylim()[1]
    assert (top > 34.0) if eps > 1e-3 else (20.0 < top < 70.0)  # 1/(2 eps) = 34 dB
    assert figure.axes[0].get_ylabel() == "amplitude (dB, 0 is 1 m/N)"


def test_every_unit_has_panels_of_its_own():
    system = SimpleNamespace(outputs=["OUTX node 3 x", "OUTXP node 3 x", "OUTX node 5 y"], inputs=["INPUTF node 3 x"])
    omega = np.logspace(-1, 1, 20)
    h = np.tile((1 / (1 + 1j * omega))[:, None, None], (1, 3, 1))
    figure = bode_figure(system, omega, h, [(0, 0), (1, 0), (2, 0)], "units")
    assert [len(a.lines) for a in figure.axes] == [2, 2, 1, 1]


@pytest.mark.parametrize(
    ("name", "unit"),
    [("OUTXP node 8 x", {"m": 1, "s": -1}), ("OUTX node 4 phi", {"rad": 1}), ("OUTXDP node 4 lambda2", {"s": -2}),
     ("INPUTF node 4 phi", {"N": 1, "m": 1}), ("NOMF node 4 y", {"N": 1}), ("REFXS node 8 z", {"m": 1}),
     ("INPUTS element 1 (HINGE) e1 relative rotation", {"N": 1, "m": 1}), ("OUTS element 2 (PLBEAM) e1 x", {"N": 1}),
     ("REFEP element 1 (HINGE) e1 relative rotation", {"rad": 1, "s": -1}), ("INX node 2 y", {"m": 1}),
     ("INXDP node 2 y", {"m": 1, "s": -2}), ("OUTF node 2 y", {"N": 1}),
     *((name, None) for name in ("z1", "y3", "OUTX", "OUTE element 1 (NOSUCH) e1", "OUTE element 1 (HINGE) e9 x"))],
)  # fmt: skip
def test_units_of_signals(name, unit):
    found = signal_unit(name)
    assert found is None if unit is None else dict(found) == unit


def test_a_campbell_diagram_says_what_is_what():
    steps = [SimpleNamespace(values=np.array([1j, -1j]) * (10 + k)) for k in range(5)]
    left, right = root_figure(steps, np.arange(5.0), "xd[2,1] (rad/s)", "rotor").axes
    assert [t.get_text() for t in left.get_legend().get_texts()] == ["once a turn"]
    assert [t.get_text() for t in right.get_legend().get_texts()] == [f"xd[2,1] = {k}" for k in (0, 2, 4)]
