"""Which method was chosen, from when and why: in the log and in --json."""

import json

import pytest

from spacar.compiled.library import why_off
from tests.examples import DATA

ENGINE = pytest.mark.skipif(why_off() is not None, reason="no engine")


def test_without_a_change(call, tmp_path):
    (tmp_path / "fingersim.dat").write_text((DATA / "fingersim.dat").read_text())
    summary = json.loads(call(1, "fingersim", "--json").out)
    assert summary["integrator"] == -1
    assert summary["integrator_note"].startswith("Adams predictor-corrector, or Radau IIA")
    assert not [line for line in summary["information"] if "INTEGRAT" in line]
    log = (tmp_path / "fingersim.log").read_text()
    assert "Integrator: INTEGRAT -1, Adams predictor-corrector, or Radau IIA" in log
    assert "It starts with INTEGRAT 0" in log
    summary = json.loads(call(1, "fingersim", "--json", "--integrator", "0").out)
    assert summary["integrator"] == 0
    assert "It starts" not in (tmp_path / "fingersim.log").read_text()


@ENGINE
def test_with_a_change(call, tmp_path):
    (tmp_path / "crankfl.dat").write_text((DATA / "crankfl.dat").read_text())
    options = ["--elements", "8", "--time", "0.08", "--steps", "5", "--atol", "1e-3", "--rtol", "1e-3"]
    summary = json.loads(call(1, "crankfl", "--json", *options).out)
    (line,) = [line for line in summary["information"] if "INTEGRAT" in line]
    assert line.startswith("from t = ")
    assert float(line.split()[3].rstrip(":")) < 0.01
    assert "INTEGRAT 595" in line
    assert "rad/s" in line
    assert line in (tmp_path / "crankfl.log").read_text()
