"""A user's file is run from its text as it stands: an edit counts at once, and nothing is written beside the model."""

import sys

import pytest

import spacar
from spacar.errors import AnalysisError

MODEL = """PLBEAM 1 1 2 3 4   X 1 0. 0.   X 3 1. 0.   FIX 1   DYNX 2 1   END HALT
EM 1 1.0   XM 3 1.0   USERSIG push   TIMESTEP 0.1 2   END END
"""


def test_an_edit_in_the_same_moment_with_the_same_length_counts(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    (tmp_path / "beam.dat").write_text(MODEL)
    forces = []
    for force in ("1.0", "2.0"):
        (tmp_path / "push.py").write_text(
            f"def push(t, ne, le, e, ep, nx, lnp, x, xp):\n    return t, [], [[3, 2, {force}]]\n"
        )
        forces.append(spacar.run(1, tmp_path / "beam.dat").node(3, 2, "fx")[0])
    assert forces == [1.0, 2.0]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["beam.dat", "push.py"]


def test_the_place_of_a_failure_is_that_in_the_file(tmp_path):
    (tmp_path / "beam.dat").write_text(MODEL)
    path = tmp_path / "push.py"
    path.write_text(
        "def push(t, ne, le, e, ep, nx, lnp, x, xp):\n    assert __file__.endswith('push.py')\n    return 1 / 0\n"
    )
    with pytest.raises(AnalysisError, match="ZeroDivisionError") as raised:
        spacar.run(1, tmp_path / "beam.dat")
    failure: BaseException = raised.value
    while failure.__cause__ is not None:
        failure = failure.__cause__
    trace, places = failure.__traceback__, []
    while trace is not None:
        places.append((trace.tb_frame.f_code.co_filename, trace.tb_lineno))
        trace = trace.tb_next
    assert places[-1] == (str(path), 3)


@pytest.mark.parametrize(
    ("row", "sentence"),
    [
        ("[3, 2, True]", None), ("(3.0, 2, 1)", None), ("[3, 2, 1.0], [3, 2, 1.0]", None),
        ("[3, 2, '1']", None), ("[3, 2, float('nan')]", "not finite"), ("[3, 9, 1.0]", "does not exist"),
        ("[3.5, 2, 1.0]", "does not exist"), ("{3, 2, 1.0}", "not an array"), ("[3, 2, 1.0, 0.0]", "shape"),
        ("[3, 2, [1.0]]", "not an array"),
    ],
)  # fmt: skip
def test_every_answer_is_checked_also_behind_good_ones(row, sentence, tmp_path):
    """The first answers are plain, so that all places are known; the last one is like the first or is refused."""
    (tmp_path / "beam.dat").write_text(MODEL)
    (tmp_path / "push.py").write_text(
        f"def push(t, ne, le, e, ep, nx, lnp, x, xp):\n    return t, [], [[3, 2, 1.0]] if t < 0.05 else [{row}]\n"
    )
    if sentence is None:
        force = spacar.run(1, tmp_path / "beam.dat").node(3, 2, "fx")
        assert force[0] == 1.0
        assert force[-1] == 1.0 + (row.count("[") > 1)
        return
    with pytest.raises(AnalysisError, match=sentence):
        spacar.run(1, tmp_path / "beam.dat")
