"""Stresses over one section against closed forms, and against the largest that `stress` gives."""

import numpy as np
import pytest
from spacar_drawing.mechanism_picture import Extras
from spacar_drawing.stress_numbers import stress_results
from spacar_drawing.stress_picture import section_figure, section_stress, stress_still

from spacar.errors import UsageError

from .conftest import call
from .models import result_source


def test_a_cantilever_under_a_tip_load():
    """lateral4: 1 N at 1 m from the clamp of a strip of 10 by 100 mm: M z/I, M/W = 6/(0.01 0.1^2) = 60 kPa."""
    source = result_source("lateral4", 8)
    at_clamp = section_stress(source, source.steps, 1, 0.0)
    z = np.linspace(-0.05, 0.05, 5)
    stress = at_clamp.at("normal", np.zeros(5), z)
    np.testing.assert_allclose(np.abs(stress), 6e4 * np.abs(z) / 0.05, atol=10.0)  # bent a little: second order
    assert stress[0] * stress[-1] < 0
    half = section_stress(source, source.steps, 2, 1.0).at("normal", np.zeros(1), z[:1])
    assert np.abs(half[0]) == pytest.approx(3e4, rel=1e-3)
    assert np.isnan(at_clamp.at("normal", np.array([0.02]), np.zeros(1))[0])


@pytest.mark.parametrize("quantity", ["normal", "shear", "mises"])
def test_the_largest_of_the_section_is_the_one_of_the_table(quantity):
    source = result_source("leafguide", 7)
    found = stress_results(source, [source.steps], [1], 2)
    y, z = found.places[quantity][0, 0, 1]
    one = section_stress(source, source.steps, 1, 1.0)
    assert one.at(quantity, np.array([y]), np.array([z]))[0] == pytest.approx(found[quantity][0, 0, 1], rel=1e-12)


def test_figure_says_what_it_shows():
    source = result_source("leafguide", 7)
    figure = section_figure(section_stress(source, source.steps, 1, 0.0), "normal", source.scene.metre, "a title")
    left, right, bar = figure.axes
    assert left.get_xlabel() == "y' (mm)"
    assert bar.get_ylabel() == "normal stress (N/mm\N{SUPERSCRIPT TWO})"
    assert next(t.get_text() for t in right.get_legend().get_texts()).startswith("over the height")


@pytest.mark.parametrize(("name", "mode"), [("leafguide", 7), ("lateral4", 8)])
def test_surface_colours_hold_the_largest_stress(name, mode):
    """The colour scale ends where the largest stress of the outline is: within the step of the points along it."""
    source = result_source(name, mode)
    k = source.steps
    figure = stress_still(source, k, Extras(), "normal", surface=True)
    largest = abs(stress_results(source, [k]).largest("normal").value) * (1e-6 if name == "leafguide" else 1.0)
    top = figure.axes[1].get_ylim()[1]
    assert 0.85 * largest < top <= largest * (1 + 1e-9)


def test_wrong_wishes(results):
    source = result_source("crank", 1, 0.01, 1)
    for step, element, place, text in (
        (9, 1, 0, "step 9"), (1, 8, 0, "element 8"), (1, 1, 2, "place 2"), (1, 1, 0, "no cr")
    ):
        with pytest.raises(UsageError, match=text):
            section_stress(source, step, element, place)
    for words in (("-e", 1, "-e", 2), ()):
        assert "one element" in call("stress", results / "lateral4", *words, "-o", results / "a.png").err
    for words in (("--place", 0.5), ("--of", "shear", "-o", results / "a.npz")):
        assert "is for a picture: give -o FILE.png" in call("stress", results / "lateral4", *words).err
    wrong = call("visual", results / "lateral4", "--over-section")
    assert (wrong.status, "--stress mises, normal or shear" in wrong.err) == (2, True)
    none = call("visual", results / "plbeam5", "--over-section", "--stress", "normal")
    assert (none.status, "no element has a cross-section" in none.err) == (2, True)


def test_commands(results):
    call.done("stress", results / "lateral4", "-e", 1, "--place", 0.5, "-o", results / "a.png", "--of", "shear")
    over = ("--over-section", "--stress")
    call.done("visual", results / "lateral4", *over, "mises", "-o", results / "b.png")
    call.done("visual", results / "plbeam5", *over, "normal", "--section", "RECT 0.6 0.2", "-o", results / "c.png")
    assert all((results / f"{n}.png").stat().st_size > 5000 for n in "abc")
