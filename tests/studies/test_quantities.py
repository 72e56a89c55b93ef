"""Quantities: values against the arrays of the result, and everything that is refused."""

import contextlib
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from spacar_drawing.curves import evaluate
from spacar_drawing.picture_source import source_of_result

from spacar.errors import UsageError
from spacar.expressions import FUNCTIONS, listed, parse, unit_text
from spacar.expressions.grammar import INDICES
from spacar.studies.runs.quantities import quantity


def test_numbers_of_a_result(crank):
    x, t = crank.node(6, 1), crank.t
    truth = {
        "x[6,1]@end": x[-1],
        "x[6,1]@start": x[0],
        "x[6, 1]@2": x[1],
        "x[6,1]@0.015": x[3],
        "max(sig[2,1])": crank.element(2, 1, "sig").max(),
        "min(x[6,1]) - 1": x.min() - 1,
        "span(x[6,1])": np.ptp(x),
        "rms(xd[6,1])": np.sqrt(np.mean(crank.node(6, 1, "xd") ** 2)),
        "-2*pi*mean(abs(x[6,1]))**2": -2 * np.pi * np.mean(np.abs(x)) ** 2,
        "last(t)": t[-1],
        "max(x[6,1] + 3*xd[6,1])": np.max(x + 3 * crank.node(6, 1, "xd")),
    }
    for text, value in truth.items():
        assert quantity(text).number(crank) == pytest.approx(value, rel=1e-15), text


def test_series_and_name(crank):
    q = quantity("slider: x[6,1]")
    assert (q.name, q.text) == ("slider", "x[6,1]")
    assert np.array_equal(q.series(crank), crank.node(6, 1))


def test_eigenvalues_are_complex(cantilever):
    value = quantity("eigval[1]").number(cantilever)
    assert isinstance(value, complex)
    assert quantity("abs(eigval[1])/(2*pi)").number(cantilever) == pytest.approx(abs(value) / (2 * np.pi))
    assert quantity("k0[1,2]@end").number(cantilever) == cantilever["k0"][-1, 0, 1]
    with pytest.raises(UsageError, match="20 values"):  # beyond the matrix
        quantity("eigval[21]").number(cantilever)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("__import__('os')", "functions are"),
        ("x.real", "Attribute is not allowed"),
        ("(lambda: 1)()", "cannot read"),
        ("(1)(t)", "functions are"),
        ("[t for t in t]", "ListComp"),
        ("'a'", "not a number"),
        ("True", "not a number"),
        ("x[6]", "takes 2 indices, not 1"),
        ("x", r"write x\[i, j\]"),
        ("y[1,1]", "variables with indices"),
        ("x[0,1]", "whole numbers from 1"),
        ("x[1.5,1]", "whole numbers from 1"),
        ("x[t,1]", "whole numbers from 1"),
        ("x[1:2,1]", "cannot read"),
        ("max(t, t)", "takes 1 argument"),
        ("t @ t", "after @"),
        ("x[6,1]@end@", "cannot read"),
        ("t // 2", "BinOp is not allowed"),
        ("not t", "UnaryOp is not allowed"),
        ("", "no name|cannot read"),
        (": t", "no name"),
        ("1+" * 300 + "1", "characters"),
    ],
)
def test_what_is_refused_at_once(text, why):
    with pytest.raises(UsageError, match=why):
        quantity(text)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("x[6,1]", "5 steps; add @end"),
        ("x[99,1]@end", "node 99 does not exist; nodes are 1 to 7"),
        ("sig[9,1]@end", "element 9 does not exist; elements are 1 to 2"),
        ("eigval[1]@end", "was not computed"),
        ("x[6,1]@6", "there are 5 steps"),
        ("x[6,1]@0.0151", "the nearest is 0.015"),
        ("max(t)@end", "behind a series"),
        ("1/min(t)", "is inf"),
        ("log(-1)", "is nan"),
        ("10.0**400", "is inf"),
        ("9**9**9**9", "is inf"),
    ],
)
def test_what_a_result_does_not_have(crank, text, why):
    with pytest.raises(UsageError, match=why):
        quantity(text).number(crank)


@settings(max_examples=200, deadline=None)
@given(st.text("xt[]()@,.*+-/ 0123456789maxsigend:'\"\\\n", max_size=30))
def test_any_text_is_read_or_refused(text):
    """No text brings anything but a quantity or a UsageError."""
    with contextlib.suppress(UsageError):
        quantity(text)


@pytest.mark.parametrize("text", [
    "x[1,1]@end", "max(x[1,2])", "rms(x[1,1]) + mean(e[1,1])", "span(x[1,2]) * t@end", "last(abs(x[1,1]))", "pi",
    "x[1,1]@0.5 - x[1,1]@start", "sqrt(x[1,1])@end", "max(t)", "min(hypot(x[1,1], x[1,2]))", "max(x[1,1]@end)",
])  # fmt: skip
def test_the_numbers_of_many_cases_are_those_of_each(text):
    rng, cases = np.random.default_rng(3), 3
    values = {"x": rng.standard_normal((5, 2, cases)), "e": rng.standard_normal((5, 1, cases))}
    t = np.linspace(0.0, 1.0, 5)
    tables = {"lnp": np.array([[1, 2]]), "le": np.array([[1]])}

    def variables(of):
        class Read(SimpleNamespace):
            def __getitem__(self, name):
                return t if name == "t" else of(values[name])

        return Read(**tables)

    asked = quantity(text)
    together = asked.numbers(variables(lambda v: v), cases)
    for case, found in enumerate(together):
        one = variables(lambda v, case=case: v[..., case])
        if found is None:
            with pytest.raises(UsageError):
                asked.number(one)
        else:
            assert found == pytest.approx(asked.number(one), rel=1e-14)


def test_a_series_has_no_number_for_many_cases():
    class Read(SimpleNamespace):
        def __getitem__(self, name):
            return np.zeros(4) if name == "t" else np.zeros((4, 2, 3))

    assert quantity("x[1,1]").numbers(Read(lnp=np.array([[1, 2]]), le=np.zeros((0, 0))), 3) is None


# plot and sweep read one language: the same numbers and messages in both; the documentation has every function.
DOCS = Path(__file__).resolve().parents[2] / "docs"


@pytest.fixture(scope="module")
def drawn(crank):
    return source_of_result(crank)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_function_is_the_same_in_plot_and_sweep(crank, drawn, name):
    angle = {"hypot": "x[6,1], x[3,1]", "atan2": "x[3,2], x[3,1]", "sqrt": "x[6,1]**2"}.get(name, "x[2,1]/x[2,1]@end")
    text = f"{name}({angle})"
    values = evaluate(drawn, text).values
    study = quantity(text).series(crank)
    assert np.array_equal(values, np.broadcast_to(study, values.shape), equal_nan=True)


def test_reductions_and_steps_can_be_plotted_with_their_units(drawn):
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
    with pytest.raises(UsageError) as plot:
        evaluate(drawn, text)
    with pytest.raises(UsageError) as study:
        quantity(text).number(crank)
    assert str(plot.value) == str(study.value)


def test_a_complex_value_asks_for_a_part(cantilever):
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
