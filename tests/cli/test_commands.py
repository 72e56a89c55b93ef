"""The small commands: check, keywords, examples."""

import json

import pytest
from spacar_drawing.settings import RULES
from spacar_formats.sim_blocks import BLOCKS

from spacar.deck.keyword_table import KEYWORDS
from tests.examples import DATA


@pytest.mark.parametrize("name", sorted({name for name, _ in KEYWORDS}))
def test_every_keyword_is_explained(call, name):
    done = call.done("keywords", name.lower())
    for (keyword, block), row in KEYWORDS.items():
        if keyword == name:
            assert f"{name}: {row.help}" in done.out
            assert block.value in done.out
            for variant in row.variants:
                assert all(p.text in done.out for p in variant.parameters)


def test_keywords_lists_every_keyword(call):
    """An alias is explained under its name, and a block with its keys."""
    done = call.done("keywords")
    listed = {line.split()[0] for line in done.out.splitlines() if line.startswith("  ")}
    assert listed == {name for name, _ in KEYWORDS} | set(RULES) | {block.name for block in BLOCKS}
    assert call("keywords", "LEVELLOG").out.startswith("OUTLEVEL: ")
    assert "anti_windup" in call("keywords", "pid").out


def test_check_in_json(call, tmp_path):
    (tmp_path / "bad.dat").write_text("PLTRUSS 1 1 2\nFIX 1\nFIX 9\nFXI 2\nEND END\n")
    done = call("check", "bad", "--json")
    assert done.status == 2
    assert done.err == ""
    found = json.loads(done.out)["messages"]
    assert {(m["severity"], m["line"]) for m in found} >= {("error", 4), ("warning", 3)}


def test_check_writes_nothing_and_refuses_a_mode_that_does_not_exist(call, tmp_path):
    before = set(tmp_path.iterdir())
    call("check", "crank", "--mode", "1")
    assert "mode 5 does not exist" in call.refused("check", "crank", "--mode", "5")
    assert set(tmp_path.iterdir()) == before


def test_examples_are_listed_and_copied(call, tmp_path):
    listed = call("examples").out
    assert all(path.stem in listed for path in DATA.glob("*.dat"))
    assert call("examples", "slider", "fourbar.dat", "--output-dir", "models").status == 0
    assert (tmp_path / "models" / "slider.dat").read_bytes() == (DATA / "slider.dat").read_bytes()
    assert (tmp_path / "models" / "fourbar.dat").exists()


def test_examples_in_folders(call, tmp_path):
    """Listed with their folder, copied without it, with all their files; none of these is replaced."""
    assert "symbolic/manipulator " in call("examples").out
    assert call("examples", "symbolic/manipulator", "published/leafspring_guide.dat").status == 0
    assert {p.name for p in tmp_path.iterdir()} >= {"manipulator.toml", "manipulator.py", "leafspring_guide.dat"}
    (tmp_path / "manipulator.toml").unlink()
    (tmp_path / "manipulator.py").write_text("mine")
    done = call("examples", "symbolic/manipulator")
    assert (done.status, "manipulator.py exists" in done.err) == (2, True)
    assert (tmp_path / "manipulator.py").read_text() == "mine"


def test_examples_do_not_overwrite(call, tmp_path):
    (tmp_path / "slider.dat").write_text("mine")
    assert "--overwrite" in call.refused("examples", "slider")
    assert (tmp_path / "slider.dat").read_text() == "mine"
    assert call("examples", "slider", "--overwrite").status == 0
    assert (tmp_path / "slider.dat").read_text() != "mine"
