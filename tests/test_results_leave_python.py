"""Results on their way out of Python: files as the command writes them, tables of pandas and xarray, notebooks."""

import re
import sys

import numpy as np
import pytest

import spacar
from spacar.errors import AnalysisError, UsageError
from tests.command_line import call
from tests.examples import DATA

CASES = {1: "crank", 4: "massspring", 7: "plbeam5", 9: "lever", 2: "robotinv"}


def without_times(log: str) -> str:
    log = re.sub(r"\d{4}-\d\d-\d\d \d\d:\d\d:\d\d.*|[\d.]+ s of wall time", "", log)
    return re.sub(r"Input file: .*", "Input file", log)


@pytest.mark.parametrize("mode", [*(m for m in CASES if m != 2), pytest.param(2, marks=pytest.mark.slow)])
def test_files_are_those_of_the_command(mode, tmp_path):
    """Byte for byte, of a result in memory and of a stream; the logs but for date, path and wall time."""
    name = CASES[mode]
    assert call(mode, DATA / f"{name}.dat", "--output-dir", tmp_path)[0] == 0
    stored = spacar.run(mode, DATA / f"{name}.dat").save(tmp_path / "stored.sbd")
    streamed = spacar.frames(mode, DATA / f"{name}.dat").save(tmp_path / "streamed")
    assert stored[0] == tmp_path / "stored.log"
    for made in (stored, streamed):
        for path in made:
            wanted = tmp_path / f"{name}{path.suffix}"
            if path.suffix == ".log":
                assert without_times(path.read_text()) == without_times(wanted.read_text())
            else:
                assert path.read_bytes() == wanted.read_bytes()
    assert len(stored) == len(streamed) == 1 + len(list(tmp_path.glob(f"{name}.[sl][bt][dmv]")))


def test_an_earlier_result_is_kept(tmp_path):
    result = spacar.run(1, DATA / "crank.dat", duration=0.01, n_steps=2)
    result.save(tmp_path / "a")
    result.save(tmp_path / "a")
    assert {p.name for p in tmp_path.iterdir()} == {"a.log", "a.sbd", "a.log.bak", "a.sbd.bak"}
    with pytest.raises(UsageError, match="cannot write"):
        result.save(tmp_path / "nowhere" / "a")


def test_a_run_that_fails_says_so_and_keeps_its_frames(tmp_path):
    deck = spacar.Deck.build(
        [("PLTRUSS", 1, 1, 2), ("X", 2, 1.0, 0.0), ("FIX", 1), ("FIX", 2, 2), ("INPUTE", 1, 1)],
        [("XM", 2, 1.0), ("INPUTE", 1, 1, 0.0, -1.0), ("TIMESTEP", 2.0, 20)],
    )
    with pytest.raises(AnalysisError, match="collapsed"):
        spacar.frames(1, deck).save(tmp_path / "a")
    assert {p.name for p in tmp_path.iterdir()} == {"a.log", "a.sbd.part"}
    assert "The analysis failed." in (tmp_path / "a.log").read_text()


def test_a_data_frame():
    pytest.importorskip("pandas")
    result = spacar.run(1, DATA / "crank.dat", duration=0.01, n_steps=4)
    table = result.to_pandas()
    assert table.index.name == "t"
    assert np.array_equal(table["x[6,1]"], result.node(6, 1))
    assert np.array_equal(table["sig[1,1]"], result.element(1, 1, "sig"))
    assert table.attrs["units"]["xdd[6,1]"] == "m/s²"
    assert table.shape == (5, 6 * 10 + 4 * 6)
    some = result.to_pandas("x[6,1]", "hypot(x[3,1], x[3,2])")
    assert list(some.columns) == ["x[6,1]", "hypot(x[3,1], x[3,2])"]
    assert np.allclose(some.iloc[:, 1], 0.15, rtol=1e-12)
    with pytest.raises(UsageError, match="node 99 does not exist; nodes are 1 to 7"):
        result.to_pandas("x[99,1]")


def test_a_data_set():
    pytest.importorskip("xarray")
    result = spacar.run(7, DATA / "plbeam5.dat")
    data = result.to_xarray()
    assert float(data["x"].sel(coordinate="11,2")[-1]) == result.node(11, 2)[-1]
    assert float(data["sig"].sel(deformation="1,1")[-1]) == result.element(1, 1, "sig")[-1]
    assert data["m0"].shape == (1, 10, 10)
    assert np.array_equal(data["frequency"], result.frequencies)


@pytest.mark.parametrize("package", ["pandas", "xarray"])
def test_without_the_extra_one_sentence(package, monkeypatch):
    result = spacar.run(0, DATA / "crank.dat")
    monkeypatch.setitem(sys.modules, package, None)  # an import of it raises
    with pytest.raises(UsageError, match=rf"to_{package} needs {package}: pip install 'spacar\[tables\]'"):
        getattr(result, f"to_{package}")()


def test_an_animation_in_a_notebook():
    result = spacar.run(1, DATA / "crank.dat", duration=0.01, n_steps=3)
    shown = result.animate(dpi=30.0)
    assert shown._repr_html_().startswith('<img alt="animation" src="data:image/gif;base64,R0lGOD')
    assert len(repr(shown)) < 100
