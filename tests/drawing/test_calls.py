"""The public functions of spacar_drawing, from a Result in memory and from a file."""

import numpy as np
import pytest
from PIL import Image
from spacar_drawing import animate, draw, report

import spacar
from spacar.errors import UsageError
from tests.examples import DATA

from .conftest import call


@pytest.fixture(scope="module")
def result() -> spacar.Result:
    return spacar.run(1, DATA / "crank.dat", n_steps=7)


def test_a_result_draws_itself_into_a_file(result, tmp_path):
    figure = result.draw(tmp_path / "crank.png", steps="1,4", node_numbers=True)
    pixels = np.asarray(Image.open(tmp_path / "crank.png").convert("L"))
    assert pixels.min() < 100 < pixels.max()  # something dark on something light
    assert len(figure.axes) == 1


def test_an_animation_has_the_frames_that_were_asked_for(result, tmp_path):
    path = result.animate(tmp_path / "crank.gif", frames=4)
    assert Image.open(path).n_frames == 4


def test_results_in_files(tmp_path):
    (tmp_path / "crank.dat").write_text((DATA / "crank.dat").read_text())
    assert call("1", str(tmp_path / "crank"), "--steps", "7").status == 0
    draw(tmp_path / "crank", tmp_path / "few.svg", strobe=3)
    assert (tmp_path / "few.svg").stat().st_size > 1000
    animate(tmp_path / "crank", tmp_path / "crank.gif", frames=2)
    assert "x[6,1]" in report(tmp_path / "crank", ["x[6,1]"])


def test_what_does_not_exist_is_said(result, tmp_path):
    with pytest.raises(UsageError, match="step 9 does not exist"):
        result.draw(steps="9")
    with pytest.raises(UsageError, match="ends in"):
        result.draw(tmp_path / "crank.txt")


def test_several_load_steps_are_no_times(result):
    bent = spacar.run(7, DATA / "plbeam5.dat")
    assert "t = " not in bent.draw(steps="all").axes[0].get_title(loc="left")
    assert "t = 0 to" in result.draw(steps="all").axes[0].get_title(loc="left")


def test_postscript_is_the_same_every_time(tmp_path) -> None:
    """There is no date in an .eps."""
    result = spacar.run(1, DATA / "crank.dat")
    for name in ("a.eps", "b.eps"):
        result.plot("x[6,1]", path=tmp_path / name)
    text = (tmp_path / "a.eps").read_bytes()
    assert text.startswith(b"%!PS-Adobe-3.0 EPSF")
    assert text.count(b"CreationDate") == 0
    assert (tmp_path / "b.eps").read_bytes().split(b"%%EndComments")[1] == text.split(b"%%EndComments")[1]
