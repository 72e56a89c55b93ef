"""Every public name has a docstring with an example that runs beside the example models."""

import doctest

import pytest

import spacar

from .citations import HOUSE


@pytest.mark.parametrize("name", spacar.__all__)
def test_the_example_of_a_public_name(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(HOUSE)
    text = getattr(spacar, name).__doc__
    test = doctest.DocTestParser().get_doctest(text, {}, name, None, 0)
    assert test.examples, f"{name} has no example"
    assert doctest.DocTestRunner().run(test).failed == 0
