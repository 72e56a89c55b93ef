"""User functions: a stress that cannot act is said, and a place that does not exist is never read."""

from pathlib import Path

import numpy as np
import pytest

import spacar
from spacar.errors import AnalysisError
from spacar.mechanism.placed_vectors import placed

BEAM = """PLBEAM 1 1 2 3 4   PLBEAM 2 3 4 5 6   X 3 1. 0.   X 5 2. 0.
FIX 1   FIX 2   DYNE 1 2 3   INPUTE 2 2   END HALT
XM 3 1.   XM 5 1.   ESTIFF 1 0. 1.   USERSIG law   TIMESTEP 0.1 2   END END
"""
RETURN = "def law(t, ne, le, e, ep, nx, lnp, x, xp):\n    return t, {rows}, []\n"


def model(folder: Path, function: str) -> Path:
    (folder / "law.py").write_text(function)
    path = folder / "model.dat"
    path.write_text(BEAM)
    return path


@pytest.mark.parametrize("mode", [1, 7])
def test_a_stress_on_a_fixed_or_prescribed_mode_is_reported(tmp_path: Path, mode: int) -> None:
    rows = "[[1, 1, 5.0], [2, 2, 3.0], [2, 3, 0.0], [1, 2, 0.5]]"
    lines = spacar.run(mode, model(tmp_path, RETURN.format(rows=rows))).report
    lost = [line for line in lines if "has no effect" in line]
    assert len(lost) == 2, lines  # once each, however often the function is called; a zero stress loses nothing
    assert all(line.startswith("warning: law at t = 0") for line in lost)
    assert "element 1 (PLBEAM) e1 elongation" in lost[0]
    assert "fixed" in lost[0]
    assert "element 2 (PLBEAM) e2 bending at p" in lost[1]
    assert "prescribed" in lost[1]


@pytest.mark.parametrize(
    ("vector", "place"),
    [("e", "le[0, 5]"), ("ep", "le[1, 3]"), ("x", "lnp[1, 1]"), ("xp", "lnp[0]"), ("x", "[lnp[1, 1]]")],
)
def test_what_does_not_exist_is_not_read(tmp_path: Path, vector: str, place: str) -> None:
    """Before, -1 read the last deformation or coordinate: a wrong number without a word."""
    rows = f"[[1, 2, float(__import__('numpy').sum({vector}[{place}]))]]"
    with pytest.raises(AnalysisError) as caught:
        spacar.run(1, model(tmp_path, RETURN.format(rows=rows)))
    assert f"a place in {vector} is negative" in str(caught.value)
    assert "-1" in str(caught.value)


def test_guarded_vectors_are_vectors_otherwise() -> None:
    v = placed(np.arange(4.0), "e")
    assert type(v[1:]) is np.ndarray
    assert type(2.0 * v) is np.ndarray
    assert (v + v)[-1] == 6.0
    assert v[1:][-1] == 3.0
    assert v[[0, 2]].tolist() == [0.0, 2.0]
    assert v[v > 1.0].tolist() == [2.0, 3.0]
    assert np.linalg.norm(v) == pytest.approx(14.0**0.5, rel=1e-15)
    assert v @ v == 14.0
    assert np.sum(v) == 6.0
    assert len(v) == 4
    with pytest.raises(IndexError, match="negative"):
        v[np.int64(-1)]
