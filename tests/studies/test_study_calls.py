"""`spacar.sweep` and `spacar.trade`: a study in one line."""

import numpy as np
import pytest

import spacar
from spacar.errors import UsageError


@pytest.fixture
def oscillator() -> spacar.Model:
    """0.5 kg on 200 N/m: 20 rad/s."""
    m = spacar.Model("oscillator")
    m.pltruss(1, 1, 2)
    m.node(2, (1.0, 0.0))
    m.fix(1)
    m.fix(2, 2)
    m.dyne(1, 1)
    m.xm(2, mass=0.5)
    m.estiff(1, EA=200.0)
    m.startde(1, 1, 0.01)
    m.timestep(0.4, 8)
    return m


def test_a_sweep(oscillator):
    """x = 1 + 0.01 cos(sqrt(k/m) t) at the end, for all combinations."""
    change = {"ESTIFF.1": [100.0, 200.0], "XM.2": "0.5:1.0:3"}
    rows = spacar.sweep(oscillator, change, "end: x[2,1]@end", rtol=1e-10, atol=1e-12)
    assert [(r["ESTIFF.1"], r["XM.2"]) for r in rows] == [(k, m) for k in (100.0, 200.0) for m in (0.5, 0.75, 1.0)]
    exact = [1 + 0.01 * np.cos(np.sqrt(r["ESTIFF.1"] / r["XM.2"]) * 0.4) for r in rows]
    assert np.abs([r["end"] for r in rows] - np.array(exact)).max() < 1e-9
    assert {r["status"] for r in rows} == {"done"}


def test_rows_are_kept(oscillator, tmp_path):
    """Cases that are there are not run again; rows of an earlier call are numbers too."""
    path = tmp_path / "rows.csv"
    first = spacar.sweep(oscillator, {"XM.2": [0.5, 1.0]}, "x[2,1]@end", output=path)
    again = spacar.sweep(oscillator, {"XM.2": [0.5, 1.0, 2.0]}, "x[2,1]@end", output=path)
    assert len(path.read_text().splitlines()) == 4
    assert [{k: v for k, v in r.items() if k != "reason"} for r in again[:2]] == [
        {k: v for k, v in r.items() if k != "reason"} for r in first
    ]


def test_together_and_failed_cases(oscillator):
    rows = spacar.sweep(oscillator, {"XM.2": [0.5, -1.0], "ESTIFF.1": [1.0, 2.0]}, ["x[2,1]@end"], together=True)
    assert [r["status"] for r in rows] == ["done", "failed"]
    assert "mass" in rows[1]["reason"]


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"rtol": 1e-3}, "trade chooses rtol itself"),
        ({"target": 2.0}, "the target is between 0 and 1"),
        ({"mode": 2}, "trade runs modes 1, 7"),
        ({"mode": 7}, "without flexible beams"),
        ({"colour": 1}, "there is no option 'colour'"),
    ],
)
def test_a_wrong_trade_is_one_sentence(oscillator, options, sentence):
    with pytest.raises(UsageError, match=sentence):
        spacar.trade(oscillator, **options)


@pytest.mark.parametrize(
    ("change", "results", "options", "sentence"),
    [
        ({}, "x[2,1]@end", {}, "nothing to vary"),
        ({"XM.2": [1.0]}, (), {}, "nothing to keep"),
        ({"XM.3": [1.0]}, "x[2,1]@end", {}, "there is no statement XM 3 to change"),
        ({"XM.2": ["heavy"]}, "x[2,1]@end", {}, r"the values of XM.2 are \['heavy'\]"),
        ({"XM.2": []}, "x[2,1]@end", {}, "XM.2 has no values"),
        ({"XM.2": [1.0]}, ["x[2,1]@end", "x[2,1]@end"], {}, "two columns would be called"),
        # not left out without a word: only motions run in batches
        ({"XM.2": [0.4, 0.5]}, "frequency[1]@end", {"mode": 7, "batch": True}, "batch: only mode 1 runs in batches"),
    ],
)
def test_a_wrong_sweep_is_one_sentence(oscillator, change, results, options, sentence):
    with pytest.raises(UsageError, match=sentence):
        spacar.sweep(oscillator, change, results, **options)
