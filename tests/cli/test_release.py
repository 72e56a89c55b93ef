"""`spacar 0 --release`: lines, file, JSON, exit status."""

import json
from pathlib import Path

import pytest

GUIDE = """PLBEAM 1 1 2 3 4   % leaf
PLBEAM 2 3 4 7 8
PLBEAM 3 5 6 7 8   % leaf
X 3 0. 0.1
X 5 0.05 0.
X 7 0.05 0.1
FIX 1
FIX 2
FIX 5
FIX 6
{classes}END HALT
XM 3 0.18
XM 4 1e-4
ESTIFF 1 5.25e6 0.109375
ESTIFF 3 5.25e6 0.109375
END END
"""


@pytest.fixture
def guide(tmp_path) -> Path:
    path = tmp_path / "guide.dat"
    path.write_text(GUIDE.format(classes="DYNE 1\nDYNE 3\n"))
    return path


def test_the_file_is_written_and_solved(call, guide):
    done = call.done("0", "guide", "--release", "solved.dat")
    assert "released 3 flexible deformations" in done.out
    assert "neither over- nor under-constrained" in done.out
    text = Path("solved.dat").read_text()
    assert "% leaf" in text
    assert call("0", "solved", "--json").status == 0
    again = json.loads(call("0", "solved", "--json").out)
    assert (again["constraints"]["over"], again["constraints"]["under"]) == (0, 0)
    assert guide.read_text() == GUIDE.format(classes="DYNE 1\nDYNE 3\n")


@pytest.mark.parametrize("words", ["guide --release", "--release guide", "--release guide.dat -v"])
def test_without_a_name_nothing_is_written(call, guide, words):
    before = set(Path().iterdir())
    done = call.done("0", *words.split())
    assert "RLSE" in done.out
    assert {p.suffix for p in set(Path().iterdir()) - before} == {".log", ".sbd"}


def test_json_has_element_mode_share(call, guide):
    record = json.loads(call("0", "guide", "--release", "--json").out)
    found = record["constraints"]
    assert found["over"] == 3
    assert sum(p["share"] for p in found["deformations"]) == pytest.approx(1.0, abs=1e-6)
    effects = {(p["element"], p["effect"]) for p in found["deformations"]}
    assert effects == {(1, "flexible"), (3, "flexible"), (2, "hinge")}
    assert {p["mode"] for p in found["deformations"]} <= {1, 2, 3}
    assert len(record["release"]["released"]) == 3
    assert record["release"]["left"] == 0
    assert any(line.startswith("RLSE") for line in record["release"]["lines"])


def test_an_input_file_is_never_overwritten(call, guide):
    for name in ("guide.dat", "crank.dat"):
        before = Path(name).read_text()
        assert name in call.refused("0", "guide", "--release", name)
        assert Path(name).read_text() == before


def test_rigid_over_constraints_are_left_and_said(call, guide):
    guide.write_text(GUIDE.format(classes=""))
    err = call.refused("0", "guide", "--release", "solved.dat", status=1)
    assert "over-constraints left that no flexible deformation takes away; by hand: RLSE" in err


def test_nothing_to_release_and_no_file(call):
    done = call.done("0", "crank", "--release", "same.dat")
    assert "no flexible deformation to release" in done.out
    assert Path("same.dat").read_text() == Path("crank.dat").read_text()
    assert "FILE" in call.refused("0")
