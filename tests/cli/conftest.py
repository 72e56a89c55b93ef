"""The command line inside the test process: streams that remember, terminals or not."""

import shutil

import pytest

from tests import command_line
from tests.examples import DATA


@pytest.fixture
def call(tmp_path, monkeypatch):
    """`call("1", "crank", terminal=True, NO_COLOR="1")` in an empty folder that has crank.dat."""
    shutil.copy(DATA / "crank.dat", tmp_path)
    monkeypatch.chdir(tmp_path)
    return command_line.call
