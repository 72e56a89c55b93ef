"""The right-hand side compiled for this machine, called from Python."""

from pathlib import Path

import numpy as np
import pytest

from spacar.symbolic.compiled_program import CompiledFunction, compiler
from spacar.symbolic.model_reader import read_model
from tests.examples import DATA

MODEL = DATA / "symbolic" / "manipulator.toml"


@pytest.mark.skipif(not compiler(), reason="no C compiler")
def test_a_call_of_the_compiled_right_hand_side_takes_what_python_takes(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Lists, tuples, slices with steps; the same numbers with and without the headers of Python; errors in words."""
    text = MODEL.read_text().replace('field = ["x**2/L**4", "x**3/L**4", "x**4/L**4"]', 'field = ["x**2/L**4"]')
    assert text.count('field = ["x**2/L**4"]') == 2
    (tmp_path / "manipulator.toml").write_text(text)
    model = read_model(tmp_path / "manipulator.toml")
    program = model.system.derive().program(model.outputs)
    direct = CompiledFunction(program, model.values)
    monkeypatch.setattr("spacar.symbolic.compiled_program.compiler_options", lambda: None)
    by_ctypes = CompiledFunction(program, model.values)
    y = np.random.default_rng(3).uniform(-0.1, 0.1, len(program.state))
    expected = program.function(model.values)(0.2, y.tolist())
    spread = np.zeros(2 * len(y))
    spread[::2] = y
    for given in (y, y.tolist(), tuple(y), spread[::2], y.astype(np.float32).astype(float)[...]):
        for function in (direct, by_ctypes):
            rates = function(0.2, given)
            assert rates.shape == y.shape
            assert rates.dtype == float
        np.testing.assert_array_equal(direct(0.2, given), by_ctypes(0.2, given))
    np.testing.assert_allclose(direct(0.2, y), expected, rtol=1e-9)
    first = direct(0.2, y)
    direct(0.3, 2 * y)
    np.testing.assert_array_equal(first, direct(0.2, y))  # every call gives an array of its own
    with pytest.raises(ValueError, match="y has 3 numbers, the system has"):
        direct(0.0, [1.0, 2.0, 3.0])
