"""Lets the tests import the modules of benchmarks/, whose models they share; results of two examples, to be read."""

import sys
from pathlib import Path

import pytest

from .examples import DATA

sys.path.insert(0, str(Path(__file__).parents[1] / "benchmarks"))


@pytest.fixture(scope="session")
def crank():
    import spacar

    return spacar.run(1, DATA / "crank.dat", duration=0.02, n_steps=4)


@pytest.fixture(scope="session")
def cantilever():
    import spacar

    return spacar.run(7, DATA / "plbeam5.dat")
