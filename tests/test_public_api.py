"""The public names: no keyword argument is swallowed, a wrong value is one sentence, every parameter is described."""

import inspect
import re

import numpy as np
import pytest
import spacar_drawing

import spacar
from spacar.deck.table_solvers import INTEGRATORS as LISTED
from spacar.errors import InputError, UsageError
from spacar.integrators import METHODS
from tests.command_line import call
from tests.examples import DATA

CALLS = {"run": spacar.run, "frames": spacar.frames}
FUNCTIONS = ("run", "frames", "read_deck", "parse_deck", "flexure", "sensitivity", "sweep", "trade")
CLASSES = ("Deck", "Model", "Result", "Run", "Frame")


@pytest.mark.parametrize("name", CALLS)
@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"rtol": "1e-3"}, "the option rtol = '1e-3' must be a number, not str"),
        ({"atol": None, "rtol": 1j}, "the option rtol = 1j must be a number, not complex"),
        ({"rtol": [1e-3]}, r"the option rtol = \[0.001\] must be a number, not list"),
        ({"rtol": True}, "the option rtol = True must be a number, not bool"),
        ({"rtol": float("nan")}, "the option rtol = nan must be positive and finite"),
        ({"duration": float("inf")}, "the option duration = inf must be positive and finite"),
        ({"n_steps": 2.5}, "the option n_steps = 2.5 must be a whole number, not float"),
        ({"n_steps": 0}, "the option n_steps = 0 must be positive and finite"),
        ({"atol": float("inf")}, "the option atol = inf must be positive and finite"),
        ({"rtol": 1e300}, r"the option rtol = 1e\+300 is at most 1"),
        ({"duration": float("nan")}, "the option duration = nan must be positive and finite"),
        ({"n_steps": 2**63}, r"the option n_steps = 9223372036854775808 is at most 1e\+15"),
        ({"compiled": "no"}, "the option compiled = 'no' must be True or False, not str"),
        ({"integrator": "155"}, "the option integrator = '155' must be a whole number, not str"),
        ({"integrator": 7}, "integrator type 7 does not exist; the methods are -1, 0, 130"),
        ({"tolerances": 1e-3}, "there is no option 'tolerances'; the options are duration, n_steps"),
        ({"source_": "x"}, "there is no option 'source_'"),
    ],
)
def test_a_wrong_option_is_one_sentence(name, options, sentence):
    with pytest.raises(UsageError, match=f"^{sentence}"):
        CALLS[name](1, DATA / "crank.dat", **options)


def test_numbers_of_numpy_are_numbers():
    options = {"rtol": np.float32(1e-3), "n_steps": np.int64(2), "duration": np.float64(0.01)}
    assert len(spacar.run(1, DATA / "crank.dat", **options, integrator=np.int32(155)).frames) == 3


@pytest.mark.parametrize("name", ["read_deck", "parse_deck"])
def test_unknown_keyword_arguments_of_readers(name):
    with pytest.raises(TypeError, match="unexpected keyword argument 'colour'"):
        getattr(spacar, name)("x", colour=1)


def test_the_alias_of_225_is_the_same_everywhere():
    """INTEGRAT 255, the option and the command line: accepted with the same sentence."""
    sentence = "integrator type 255 is read as 225"
    text = (DATA / "crankfl.dat").read_text()
    short = {"duration": 0.001, "n_steps": 1}
    option = spacar.run(1, spacar.parse_deck(text), integrator=255, **short)
    assert option.mechanism.settings.integrator == 225
    assert f"warning: {sentence}" in option.report
    lines = text.replace("TIMESTEP", "INTEGRAT 255\nTIMESTEP", 1)
    deck = spacar.parse_deck(lines)
    assert any(sentence in str(m) for m in deck.messages)
    assert spacar.run(1, deck, **short).mechanism.settings.integrator == 225


def test_the_command_line_takes_the_alias(tmp_path):
    words = ("--output-dir", tmp_path, "--integrator", 255, "--time", 0.001, "--steps", 1)
    assert "integrator type 255 is read as 225" in call.done(1, DATA / "crankfl.dat", *words).err
    assert "integrator type 255 is read as 225" in (tmp_path / "crankfl.log").read_text()


def test_the_list_of_the_deck_is_the_table_of_methods():
    assert sorted(LISTED) == sorted(METHODS)


def described(thing, documentation):
    """Parameters of a callable whose names the text does not mention."""
    parameters = [p.name for p in inspect.signature(thing).parameters.values() if p.name not in ("self", "cls")]
    return [name for name in parameters if not re.search(rf"\b{name}\b", documentation)]


@pytest.mark.parametrize("name", FUNCTIONS)
def test_parameters_of_functions_are_described(name):
    function = getattr(spacar, name)
    assert not described(function, inspect.getdoc(function) or "")


@pytest.mark.parametrize("name", ["animate", "draw", "plot", "report", "stress", "flexure_page", "flexure_plot"])
def test_parameters_of_drawing_functions_are_described(name):
    """Those of `animate` that `draw` has too are said there."""
    text = inspect.getdoc(getattr(spacar_drawing, name)) or ""
    if "Arguments as `draw`" in text:
        text += inspect.getdoc(spacar_drawing.draw) or ""
    assert not [p for p in described(getattr(spacar_drawing, name), text) if p not in ("result", "path")]


def test_drawing_swallows_no_keyword_argument():
    result = spacar.run(1, DATA / "crank.dat", duration=0.01, n_steps=2)
    with pytest.raises(TypeError, match="unexpected keyword argument 'colour'"):
        result.plot("x.png", colour=1)
    for drawing in (result.draw, result.animate):  # which name the extras that there are
        with pytest.raises(UsageError, match="pictures have no option 'colour'"):
            drawing("x.png", colour=1)


@pytest.mark.parametrize("name", CLASSES)
def test_methods_and_fields_of_classes_are_described(name):
    """Methods in their own text or that of the class, fields in that of the class."""
    cls = getattr(spacar, name)
    missing = []
    text = inspect.getsource(cls)  # fields may be described by a comment beside them
    for member, value in vars(cls).items():
        function = value.__func__ if isinstance(value, classmethod | staticmethod) else value
        if member.startswith("_") or not inspect.isfunction(function):
            continue
        document = inspect.getdoc(function)
        missing += [f"{member}({p})" for p in described(function, document or "")]
        missing += [member] * (not document)
    assert not missing
    assert inspect.getdoc(cls)
    for field in getattr(cls, "__dataclass_fields__", {}):
        assert re.search(rf"\b{field}\b", text)


def test_input_errors_stay_input_errors():
    with pytest.raises(InputError):
        spacar.run(1, spacar.Deck.build([("PLTRUSS", 1, 1, 1)]), rtol=1e-3)
