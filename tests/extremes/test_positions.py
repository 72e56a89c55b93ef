"""Singular positions, redundant constraints, far starts, critical loads, impossible numbers: the right answer, or a
message that says what and where."""

import numpy as np
import pytest

from spacar.errors import AnalysisError, SpacarError

from .test_mechanics import run


def crank(rod: float, omega: float, duration: float, steps: int) -> str:
    return f"""
PLBEAM 1 1 2 3 4   PLBEAM 2 3 5 6 7   X 3 0.15 0.   X 6 {0.15 + rod!r} 0.
FIX 1   FIX 6 2   INPUTX 2 1   END HALT
XM 6 0.03   EM 2 0.2   INPUTX 2 1 0. {omega!r}   TIMESTEP {duration!r} {steps}   END END
"""


def test_outer_dead_centre_of_the_slider_is_passed():
    """slider.dat: a bar of 2 m passes the vertical, x = -sqrt(3) + t, y = sqrt(4 - x^2)."""
    text = "PLTRUSS 1 1 2\nX 1 0. 0.\nX 2 1.7321 1.\nFIX 1 2\nFIX 2 1\nINPUTX 1 1\nEND\nHALT\n"
    text += "INPUTX 1 1 0. 1.\nTIMESTEP 3.4641 10\nEND\nEND\n"
    result = run(1, text)
    l2 = 1.7321**2 + 1.0
    assert result.node(2, 2) == pytest.approx(np.sqrt(l2 - (1.7321 - result.t) ** 2), abs=1e-12)


def test_dead_centres_of_a_driven_slider_crank_are_passed():
    """The rod is a little longer than the crank: at 90 degrees it is nearly vertical. Closed form to rounding times the
    condition 1/cos(rod angle) = 17."""
    result = run(1, crank(0.15 * 1.0017, 1.0, 2.0 * np.pi, 200))
    a = result.t
    slider = 0.15 * (np.cos(a) + np.sqrt(1.0017**2 - np.sin(a) ** 2))
    assert result.node(6, 1) == pytest.approx(slider, abs=1e-11)


@pytest.mark.parametrize("steps", [4, 8, 100])
def test_folded_slider_crank_stops_and_says_where(steps):
    """Equal crank and rod: at 90 degrees the slider is on the crank bearing and its motion is undetermined."""
    with pytest.raises(AnalysisError) as caught:
        run(1, crank(0.15, 1.0, 2.0 * np.pi, steps))
    text = str(caught.value)
    assert "t = " in text
    assert any(f"node {k}" in text or f"element {k}" in text for k in (1, 2, 3, 5, 6, 7))


def test_driving_the_slider_through_the_dead_centre_stops_and_says_where():
    """The slider cannot pull the crank beyond its outer dead centre at x = 0.45 m, reached after 0.05 s."""
    text = """
PLBEAM 1 1 2 3 4   PLBEAM 2 3 5 6 7   X 3 0.09 0.12   X 6 0.3649545345 0.
FIX 1   FIX 6 2   INPUTX 6 1   END HALT
XM 6 0.03   INPUTX 6 1 0.3649545345 1.   TIMESTEP 0.2 40   END END
"""
    with pytest.raises(AnalysisError) as caught:
        run(1, text)
    words = str(caught.value).split("t = ")
    assert len(words) > 1
    time = float(words[1].split()[0].rstrip(",;:"))
    assert 0.08 <= time <= 0.095  # 0.45 - 0.36495 = 0.08505 at 1 m/s; outputs are 5 ms apart


@pytest.mark.parametrize("gap", [1.0, 1e-3, 1e-6])
def test_nearly_redundant_supports(gap):
    """A bar held by two parallel links that are `gap` apart: reactions F a/gap, exact to the condition of the
    position."""
    text = f"""
PLRBEAM 1 1 2 3   PLRBEAM 2 1 2 4   PLTRUSS 3 1 5   PLTRUSS 4 3 6   PLTRUSS 5 1 7
X 1 0. 0.   X 3 {gap!r} 0.   X 4 1. 0.   X 5 0. -1.   X 6 {gap!r} -1.   X 7 -1. 0.
FIX 5   FIX 6   FIX 7   END HALT
XF 4 0. -1.   END END
"""
    result = run(1, text)
    n = result.mechanism.numbering
    sigma = result["sig"][-1]
    # moments about node 1: the link at the distance gap carries 1/gap in compression, the other the rest
    assert sigma[n.e_index(4, 1)] == pytest.approx(-1.0 / gap, rel=1e-9)
    assert sigma[n.e_index(3, 1)] == pytest.approx(1.0 / gap - 1.0, rel=1e-9, abs=1e-9)


def test_redundant_support_is_named():
    """Two links at the same place: one too many, and the diagnosis names them."""
    text = """
PLRBEAM 1 1 2 3   PLTRUSS 2 1 4   PLTRUSS 3 1 5   PLTRUSS 4 3 6   PLTRUSS 5 3 7
X 3 1. 0.   X 4 0. -1.   X 5 -1. 0.   X 6 1. -1.   X 7 1. 1.   FIX 4   FIX 5   FIX 6   FIX 7
END HALT
TIMESTEP 1. 1   END END
"""
    with pytest.raises(AnalysisError, match=r"over-constrained.*element [45]"):
        run(1, text)


@pytest.mark.parametrize("angle", [3.0, -3.0, 31.0])
def test_start_values_far_from_the_reference(angle):
    """The crank starts up to five turns away from the drawing: the position is that of the closed form."""
    text = crank(0.30, 0.0, 0.1, 1).replace("INPUTX 2 1 0. 0.0", f"INPUTX 2 1 {angle}")
    result = run(1, text)
    assert result.node(6, 1)[0] == pytest.approx(
        0.15 * np.cos(angle) + np.sqrt(0.09 - (0.15 * np.sin(angle)) ** 2), abs=1e-12
    )


def test_start_that_cannot_be_reached_is_refused():
    """A rod shorter than the crank: 90 degrees does not exist."""
    text = crank(0.10, 0.0, 0.1, 1).replace("INPUTX 2 1 0. 0.0", "INPUTX 2 1 1.5707963")
    with pytest.raises(AnalysisError, match=r"element|node"):
        run(1, text)


COLUMN = """
PLBEAM 1 1 2 3 4   PLBEAM 2 3 4 5 6   X 3 0.5 0.   X 5 1. 0.
FIX 1   FIX 2   DYNE 1 2 3   DYNE 2 2 3   END HALT
EM 1 1.   EM 2 1.   ESTIFF 1 0. 1.   ESTIFF 2 0. 1.   XF 5 {force!r} 0.
ITERSTEP 20 4 1e-12   END END
"""


@pytest.fixture(scope="module")
def critical():
    """Critical load of the two-element column: about pi^2/4."""
    load = np.min(run(8, COLUMN.format(force=-1.0))["lmult"][-1])
    assert load == pytest.approx(np.pi**2 / 4.0, rel=1e-3)
    return float(load)


@pytest.mark.parametrize("part", [0.0, 0.5, 0.9, 0.99, 0.9999, 0.999999])
def test_frequency_of_a_loaded_column(part, critical):
    """The square of the lowest frequency falls to zero at the critical load; between it is nearly linear (a few
    percent), and its slope at the end is that of the linear law of the buckling mode: within a factor 1.1."""
    free = np.abs(run(7, COLUMN.format(force=0.0))["eigval"][-1][:, 1]).min()
    found = run(7, COLUMN.format(force=-part * critical))["eigval"][-1]
    assert np.abs(found[:, 0]).max() <= 1e-4
    squared = (np.abs(found[:, 1]).min() / free) ** 2
    assert squared == pytest.approx(1.0 - part, rel=0.1, abs=1e-9)


def test_beyond_the_critical_load_the_straight_column_diverges(critical):
    """A real positive eigenvalue, not an error and not a frequency."""
    found = run(7, COLUMN.format(force=-1.1 * critical))["eigval"][-1]
    assert found[:, 0].max() > 0.1


def test_load_multipliers_of_an_overloaded_column(critical):
    """Mode 8 at twice the critical load: the multiplier is one half, whatever the load."""
    for factor in (0.5, 0.999999, 2.0, 1e6):
        multipliers = run(8, COLUMN.format(force=-factor * critical))["lmult"][-1]
        assert np.min(np.abs(multipliers)) == pytest.approx(1.0 / factor, rel=1e-6)


@pytest.mark.parametrize("mass", [5e-324, 1e-310, 1e-300, 1e300])
def test_masses_at_the_end_of_the_numbers(mass):
    """Free fall does not depend on the mass. A denormal one has lost its digits, so it may be refused, never be
    wrong."""
    text = f"PLTRUSS 1 1 2\nX 2 1. 0.\nFIX 1\nDYNX 2 2\nEND\nHALT\nXM 2 {mass!r}\nGRAVITY 0. -1.\n"
    text += "TIMESTEP 0.001 1\nEND\nEND\n"
    try:
        result = run(1, text)
    except SpacarError as error:
        refused = str(error)
    else:
        refused = ""
    if refused:
        assert any(word in refused for word in ("mass", "not finite", "equations of motion"))
    else:
        assert result.node(2, 2)[-1] == pytest.approx(-0.5e-6, rel=1e-4)


@pytest.mark.parametrize("statement", ["XM 2 0.", "EM 1 0.", ""])
def test_no_mass_is_refused_with_its_name(statement):
    text = (
        f"PLTRUSS 1 1 2\nX 2 1. 0.\nFIX 1\nDYNX 2 2\nEND\nHALT\n{statement}\nGRAVITY 0. -1.\nTIMESTEP 1. 1\nEND\nEND\n"
    )
    with pytest.raises(SpacarError, match="mass"):
        run(1, text)


@pytest.mark.parametrize("stiffness", [0.0, 5e-324, 1e300])
def test_stiffness_at_the_end_of_the_numbers(stiffness):
    """Static elongation F/k: nothing for 1e300; no stiffness to speak of is a message."""
    text = f"PLTRUSS 1 1 2\nX 2 1. 0.\nFIX 1\nFIX 2 2\nDYNE 1\nEND\nHALT\nXM 2 1.\nESTIFF 1 {stiffness!r}\n"
    text += "XF 2 1. 0.\nEND\nEND\n"
    if stiffness < 1.0:
        with pytest.raises(SpacarError):
            run(7, text)
    else:
        assert abs(run(7, text).element(1, 1)[-1]) <= 1e-290


def test_huge_loads_do_not_give_silent_nonsense():
    """1e300 N on a soft beam: the elongation cannot be represented by the element, which must be said."""
    with pytest.raises(SpacarError):
        run(7, COLUMN.format(force=-1e300).replace("XF 5 -1e+300 0.", "XF 5 0. 1e300"))
