"""plot and sweep read one language: the same numbers and messages in both; the documentation has every function."""

from pathlib import Path

import numpy as np
import pytest

import spacar
from spacar.errors import UsageError
from spacar.expressions import FUNCTIONS, listed, parse
from spacar.expressions.grammar import INDICES
from spacar.studies.runs.quantities import quantity
from tests.examples import DATA

DOCS = Path(__file__).resolve().parents[2] / "docs"


@pytest.fixture(scope="module")
def drawn(crank):
    from spacar_drawing.picture_source import source_of_result

    return source_of_result(crank)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_function_is_the_same_in_plot_and_sweep(crank, drawn, name):
    from spacar_drawing.curves import evaluate

    angle = {"hypot": "x[6,1], x[3,1]", "atan2": "x[3,2], x[3,1]", "sqrt": "x[6,1]**2"}.get(name, "x[2,1]/x[2,1]@end")
    text = f"{name}({angle})"
    values = evaluate(drawn, text).values
    study = quantity(text).series(crank)
    assert np.array_equal(values, np.broadcast_to(study, values.shape), equal_nan=True)


def test_reductions_and_steps_can_be_plotted_with_their_units(drawn):
    from spacar_drawing.curves import evaluate

    from spacar.expressions import unit_text

    x = evaluate(drawn, "x[6,1]")
    for text, value in {
        "max(x[6,1])": x.values.max(),
        "x[6,1]@end": x.values[-1],
        "x[6,1]@2": x.values[1],
        "rms(x[6,1])": np.sqrt(np.mean(x.values**2)),
        "span(x[6,1])": np.ptp(x.values),
    }.items():
        curve = evaluate(drawn, text)
        assert unit_text(curve.unit) == "m"
        assert np.array_equal(curve.values, np.full(len(x.values), value)), text
    departure = evaluate(drawn, "x[6,1] - (x[6,1]@start)").values
    assert np.array_equal(departure, x.values - x.values[0])


def test_studies_know_the_functions_of_plot(crank):
    # the crank pin stays at 0.15 m from its bearing, within the tolerance of the position iteration
    assert quantity("max(hypot(x[3,1], x[3,2]))").number(crank) == pytest.approx(0.15, abs=1e-9)
    assert quantity("deg(x[2,1]@end)").number(crank) == pytest.approx(np.degrees(crank.node(2, 1)[-1]), rel=1e-15)
    # a study computes with bare numbers: metres and radians may be added
    assert quantity("x[6,1]@end + x[2,1]@end").number(crank) == crank.node(6, 1)[-1] + crank.node(2, 1)[-1]


@pytest.mark.parametrize("text", ["x[99,1]", "x[6]", "y[1,1]", "max(t, t)", "x.real", "spam", "x[6,1", "t@7.5"])
def test_the_same_sentence_in_both(crank, drawn, text):
    from spacar_drawing.curves import evaluate

    with pytest.raises(UsageError) as plot:
        evaluate(drawn, text)
    with pytest.raises(UsageError) as study:
        quantity(text).number(crank)
    assert str(plot.value) == str(study.value)


def test_a_complex_value_asks_for_a_part(drawn):
    from spacar_drawing.curves import evaluate

    cantilever = spacar.run(7, DATA / "plbeam5.dat")
    from spacar_drawing.picture_source import source_of_result

    with pytest.raises(UsageError, match=r"takes real numbers; write abs\(\)"):
        quantity("hypot(eigval[1], 1)").number(cantilever)
    with pytest.raises(UsageError, match=r"does not contain|complex"):
        evaluate(source_of_result(cantilever), "eigval[1]")


def test_lists_are_short():
    assert listed([1, 2, 3, 5, 7, 8]) == "1 to 3, 5, 7 to 8"
    assert listed(range(1, 99, 2)) == "1, 3, 5, 7, 9, ..., 97"
    assert listed([]) == ""


def test_the_documentation_has_every_variable_and_function():
    page = (DOCS / "expressions.md").read_text(encoding="utf-8")
    missing = [
        n for n in (*INDICES, *FUNCTIONS) if f"`{n}`" not in page and f"`{n}[" not in page and f"`{n}(" not in page
    ]
    assert not missing


def test_a_deep_text_is_refused_in_one_sentence():
    with pytest.raises(UsageError, match=r"characters|no expression"):
        parse("(" * 600 + "t" + ")" * 600)
    parse("-" * 499 + "t")
