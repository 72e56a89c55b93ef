"""Mode shapes and constraints: values of the theory reference, the core's own analysis, and closed forms."""

import numpy as np
import pytest
from spacar_drawing.mode_picture import period, swing
from spacar_drawing.mode_shapes import (
    ModeShape,
    buckling_modes,
    dynamic_columns,
    redundancy,
    suitable_factor,
    vibration_modes,
)
from spacar_drawing.picture_source import source_of_result

import spacar
from tests.examples import DATA

from .models import result_source


class Matrices:
    """A `.sbm` file in memory."""

    path = "model.sbm"

    def __init__(self, result):
        self.frames = result.frames

    def has(self, name):
        return name in self.frames[0].matrices

    def get(self, name, step):
        from spacar.errors import UsageError

        value = self.frames[step - 1].matrices.get(name)
        if value is None:
            raise UsageError(f"ID not found: {name}")
        return value

    array = get


def modes_of(name, mode, kind):
    result = spacar.run(mode, DATA / f"{name}.dat")
    source = source_of_result(result)
    return source, (vibration_modes if kind == "vibration" else buckling_modes)(source, Matrices(result), 1)


def test_frequencies_of_the_cantilever_and_one_entry_per_pair():
    """theory-planar.md section 9: 0.3551305, 2.2265953, 6.2519760 rad/s (7 digits)."""
    _, modes = modes_of("plbeam5free", 7, "vibration")
    assert len(modes) == 10
    np.testing.assert_allclose([m.value.imag for m in modes[:3]], [0.3551305, 2.2265953, 6.2519760], rtol=2e-7)
    assert all(np.isclose(np.linalg.norm(m.vector), 1.0) for m in modes)
    assert not modes[0].is_complex
    assert "f = 0.056521 Hz" in modes[0].label


def test_motion_is_the_transfer_function_times_the_vector():
    """Moving the degrees of freedom by a small amount along the vector moves x by the same amount along the motion:
    checked by the orthogonality of the modes with respect to the mass, which only holds for the right columns."""
    source, modes = modes_of("shear2", 7, "vibration")
    dx = source.get("dx", 1)[:, dynamic_columns(source.header)]
    for m in modes:
        np.testing.assert_allclose(m.motion, dx @ m.vector, atol=1e-14)
    result = spacar.run(7, DATA / "shear2.dat")
    M = result.frames[0].matrices["m0"]
    gram = np.array([[abs(np.vdot(a.vector, M @ b.vector)) for b in modes] for a in modes])
    np.testing.assert_allclose(gram - np.diag(np.diag(gram)), 0, atol=1e-9)


def test_unstable_mode_comes_first():
    """finger.dat asks for VIBRATIONMODE 1, in the manual (bibliography.md) the unstable one: 2 pi 6.3191 1/s."""
    _, modes = modes_of("finger", 7, "vibration")
    assert [m.number for m in modes] == [1, 2]
    assert np.isclose(modes[0].value.real, 2 * np.pi * 6.3191, rtol=1e-5)
    assert not modes[0].oscillates
    assert "unstable" in modes[0].label
    assert modes[1].value == 0
    assert "frequency zero" in modes[1].label
    # the zero mode keeps the distal phalanx parallel: e1 of the hinge = -2.5 times the motor angle (theory-planar.md 9)
    ratio = modes[1].vector[1] / modes[1].vector[0]
    assert np.isclose(ratio.real, -2.5, atol=1e-6)


def test_wheels_have_configuration_modes():
    """trike3v: -30.91, -5.826 and zeros (theory-planar.md: the planar twin has the same)."""
    _, modes = modes_of("trike3v", 7, "vibration")
    decaying = sorted(m.value.real for m in modes if m.value.real < -1)
    np.testing.assert_allclose(decaying, [-30.9114, -5.8262], rtol=1e-5)


def test_modes_from_matrices_where_the_analysis_stores_none():
    """Mode 9 stores no eigenvalues: they follow from its matrices, as those of mode 7."""
    source, nine = modes_of("lever", 9, "vibration")
    result = spacar.run(7, DATA / "lever.dat")
    seven = vibration_modes(source_of_result(result), Matrices(result), 1)
    np.testing.assert_allclose([m.value for m in nine], [m.value for m in seven], rtol=1e-9)
    assert "damping ratio" in nine[0].label
    assert source.scene.mode == 9


def test_buckling_of_the_guided_column():
    """theory-planar.md: 9.94384680, 40.0, 128.722820."""
    _, modes = modes_of("column2", 8, "buckling")
    np.testing.assert_allclose([m.value.real for m in modes], [9.94384680, 40.0, 128.722820], rtol=1e-8)
    assert modes[0].label.endswith("load multiplier 9.94385")


def test_displacement_and_automatic_factor():
    source, modes = modes_of("plbeam5free", 7, "vibration")
    x, mode = source.x(1), modes[0]
    factor = suitable_factor(source.scene, mode.motion, 10.0)
    moved = swing(mode, x, factor, 0.0)
    tip = source.scene.lnp[10, 1] - 1
    assert np.isclose(abs(moved[tip] - x[tip]), 1.2)  # 12 % of 10 m, the tip moves most
    np.testing.assert_allclose(swing(mode, x, factor, np.pi) - x, x - moved, atol=1e-12)
    still = ModeShape(1, "vibration", 1.0 + 0j, mode.vector, mode.motion)
    ends = [swing(still, x, factor, p) for p in (0.0, np.pi)]
    np.testing.assert_allclose(ends, [x, moved], atol=1e-12)  # to one side and back
    assert period(mode, x, factor, 8).shape == (8, len(x))


@pytest.mark.parametrize("name", ["crank", "trike3v", "fourbar", "robotinv", "screw"])
def test_sound_examples_have_no_over_or_under_constraints(name):
    source = result_source(name, 0)
    found = redundancy(source.scene, source.get("bigd", 1), 1.0)
    assert len(found.over) == len(found.under) == 0


def test_constraints_agree_with_the_core():
    """A square with both diagonals is over-constrained once, all six bars take part; without two bars it can move."""
    corners = [("X", 2, 1.0, 0.0), ("X", 3, 1.0, 1.0), ("X", 4, 0.0, 1.0)]
    sides = [("PLTRUSS", i + 1, a, b) for i, (a, b) in enumerate(((1, 2), (2, 3), (3, 4), (4, 1), (1, 3), (2, 4)))]
    support = [("FIX", 1), ("FIX", 2, 2)]
    source = source_of_result(spacar.run(0, spacar.Deck.build([*sides, *corners, *support])))
    found = redundancy(source.scene, source.get("bigd", 1), 1.0)
    assert (len(found.over), len(found.under)) == (1, 0)
    # self stress of a square with diagonals: sides 1, diagonals -sqrt 2, so the squares are 1:2
    share = found.over[0]
    np.testing.assert_allclose(share, [0.125] * 4 + [0.25] * 2, atol=1e-12)

    loose = source_of_result(spacar.run(0, spacar.Deck.build([*sides[:4], *corners, *support])))
    found = redundancy(loose.scene, loose.get("bigd", 1), 1.0)
    assert (len(found.over), len(found.under)) == (0, 1)
    motion = found.under[0]
    x3, x4 = (motion[loose.scene.lnp[n - 1, :2] - 1] for n in (3, 4))
    np.testing.assert_allclose(abs(x3), abs(x4), atol=1e-12)  # the upper side moves as a whole, along x
    assert abs(x3[1]) < 1e-12
