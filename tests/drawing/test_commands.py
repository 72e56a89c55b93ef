"""The commands draw, visual, plot and report as a user sees them: files, messages, exit status."""

import shlex
import shutil
import subprocess
import sys

import numpy as np
import pytest
from PIL import Image
from spacar_cli import progress
from spacar_drawing import animate, draw, report

import spacar
from tests.examples import DATA

from .conftest import call

PNG, PDF = b"\x89PNG", b"%PDF"
COARSE = ("--dpi", 30)  # where it is not the picture that is looked at


def picture_size(path):
    with Image.open(path) as image:
        return image.size, getattr(image, "n_frames", 1)


def test_draw_writes_beside_the_result_and_says_so(results):
    done = call("draw", results / "crank")
    assert (done.status, done.err) == (0, "")
    assert done.out.strip() == str(results / "crank.png")
    assert (results / "crank.png").read_bytes().startswith(PNG)


def test_draw_in_all_still_formats_is_reproducible(results):
    files = [results / f"p.{kind}" for kind in ("png", "svg", "pdf")]
    outputs = [w for f in files for w in ("-o", f)]
    arguments = ["draw", results / "crank", "--strobe", 4, "--numbers", "--trace", 6, *outputs]
    assert call(*arguments).status == 0
    first = [f.read_bytes() for f in files]
    assert first[0].startswith(PNG)
    assert b"<svg" in first[1]
    assert first[2].startswith(PDF)
    call(*arguments)
    assert [f.read_bytes() for f in files] == first


@pytest.mark.parametrize(
    "words",
    [
        "crank", "crank.sbd", "crank.dat", "crank --at end", "crank --at 1:3", "crank --at all --no-supports",
        "crank --strobe 3 --initial", "crank --no-trace", "crank --node-numbers",
        "crank --element-numbers --title 'a crank'", "crank --section 'RECT 0.01 0.01' --opacity 0.4",
        "crank --section 'CIRC 2 0.02' --hide 1", "crank --dpi 40", "trike3v --view xz",
        "trike3v --view -120,35 --no-light", "trike3v --section 'CIRCHOL 0.1 0.08'",
    ],
)  # fmt: skip
def test_names_and_options_of_draw(results, words):
    name, *options = shlex.split(words)
    done = call("draw", results / name, "-o", results / "p.png", *COARSE, *options)
    assert (done.status, done.err) == (0, "")


@pytest.mark.parametrize(
    ("arguments", "part"),
    [
        (["draw", "nothing"], "nothing.sbd not found"),
        (["draw", "crank", "--at", "999"], "step 999 does not exist"),
        (["draw", "crank", "--at", "first"], "is no step"),
        (["draw", "crank", "--at", "1", "--strobe", "3"], "exclude each other"),
        (["draw", "crank", "--trace", "99"], "--trace: position node 99 does not exist; the model has 1, 3, 6"),
        (["draw", "crank", "--trace", "2"], "position node 2"),
        (["draw", "crank", "--hide", "9"], "element 9 does not exist"),
        (["draw", "crank", "-o", "p.bmp"], "ends in .png"),
        (["draw", "crank", "-o", "no/p.png"], "does not exist"),
        (["draw", "crank", "--section", "RECT 1"], "--section"),
        (["draw", "trike3v", "--view", "front"], "--view front"),
        (["draw", "crank", "--view", "front"], "--view front"),
        (["visual", "plbeam5free", "--list", "-o", "p.png"], "--list prints modes"),
        (["visual", "crank"], "use spacar draw"),
        (["visual", "crank", "7"], "for pictures of mode 7 run: spacar 7 crank"),
        (["visual", "plbeam5free", "8"], "spacar 8 plbeam5free"),
        (["visual", "plbeam5free", "--mode-number", "11"], "does not exist"),
        (["visual", "plbeam5free", "--mode-number", "all", "-o", "/"], "/: a picture file ends in"),
        (["visual", "fourbar"], "OUTLEVEL 0 1"),
        (["visual", "plbeam5", "--stress", "mises"], "cross-section"),
        (["visual", "trike2", "--diagram", "N"], "no beams or trusses"),
        (["visual", "trike2", "-o", "c.gif"], "ends in .png, .svg, .pdf"),
        (["visual", "plbeam5", "--at", "7"], "step 7 does not exist"),
        (["plot", "crank", "x[99,1]"], "node 99 does not exist"),
        (["plot", "crank", "dxx"], "not a variable"),
        (["plot", "crank"], "EXPR"),
        (["report", "crank", "--plot", "x[1"], "no expression"),
    ],
    ids=lambda v: " ".join(v) if isinstance(v, list) else "",
)
def test_wrong_use_is_explained(results, monkeypatch, arguments, part):
    monkeypatch.chdir(results)
    done = call.refused(*arguments)
    assert part in done
    assert not list(results.glob("*.bmp")) + list(results.glob("p.*"))


@pytest.mark.parametrize(
    "command",
    [["draw"], ["visual", "--diagram", "Mz"], ["plot", "t"], pytest.param(["report"], marks=pytest.mark.slow)],
    ids=lambda c: c[0],
)
def test_stale_results_are_refused(results, command):
    """The digest of the input decides, not the date."""
    word, *rest = command
    target = results / "crank"
    with open(results / "crank.dat", "a") as file:
        file.write("% changed\n")
    arguments = [word, target, *rest]
    done = call.refused(*arguments)
    assert "has changed since" in done
    assert "--stale-ok" in done
    assert call(*arguments, "--stale-ok").status == 0


def test_matrices_of_another_run_are_refused(results):
    shutil.copy(results / "lateral4.sbm", results / "plbeam5free.sbm")
    assert "different runs" in call.refused("visual", results / "plbeam5free")


def test_gif_has_the_frames_and_loops(results):
    assert call("draw", results / "crank", "-o", results / "c.gif", "--frames", 5, "--dpi", 40).status == 0
    (width, height), frames = picture_size(results / "c.gif")
    assert (frames, width % 2, height % 2) == (5, 0, 0)
    with Image.open(results / "c.gif") as image:
        assert image.info["loop"] == 0
        shots = []
        for k in (0, 2):
            image.seek(k)
            shots.append(np.asarray(image.convert("L"), float))
    assert np.abs(shots[1] - shots[0]).max() > 50  # it moves
    assert not list(results.glob(".*part*"))


@pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="ffmpeg is not installed")
def test_mp4(results):
    assert call("draw", results / "crank", "-o", results / "c.mp4", "--frames", 3, "--dpi", 40).status == 0
    assert b"ftyp" in (results / "c.mp4").read_bytes()[:16]


def test_mp4_without_ffmpeg_is_refused_before_anything_is_drawn(results, monkeypatch):
    monkeypatch.setattr(shutil, "which", lambda name: None)
    assert "needs the program ffmpeg" in call.refused("draw", results / "crank", "-o", results / "c.mp4")


def test_animation_bar_on_terminals_only(results, monkeypatch):
    monkeypatch.setattr(progress, "PATIENCE", 0.0)  # a bar waits for half a second
    arguments = ["draw", results / "crank", "-o", results / "c.gif", "--frames", 20, "--dpi", 20]
    assert call(*arguments).err == ""
    seen = call(*arguments, terminal=True)
    assert seen.status == 0
    assert "c.gif" in seen.err
    assert "/20" in seen.err


@pytest.mark.parametrize(
    ("arguments", "file"),
    [
        (["visual", "plbeam5free"], "plbeam5free_vibration1.png"),
        (["visual", "plbeam5free", "7", "--factor", "3", "--mode-number", "2"], "plbeam5free_vibration2.png"),
        (["visual", "lateral4"], "lateral4_buckling1.png"),
        (["visual", "trike2"], "trike2_constraints.png"),
        (["visual", "plbeam5", "--diagram", "Mz"], "plbeam5_Mz.png"),
        (["visual", "plbeam5", "--stress", "N"], "plbeam5_N.png"),
        (["visual", "plbeam5", "--stress", "mises", "--section", "CIRC 0.2"], "plbeam5_mises.png"),
        (["visual", "lateral4", "--stress", "MISES"], "lateral4_mises.png"),
        (["visual", "fourbar", "--diagram", "N"], "fourbar_N.png"),
        (["plot", "crank", "x[6,1]", "sig[1,1]"], "crank_plot.png"),
    ],
    ids=lambda v: " ".join(v) if isinstance(v, list) else "",
)
def test_default_names(results, monkeypatch, arguments, file):
    monkeypatch.chdir(results)
    done = call(*arguments, *COARSE)
    assert (done.status, done.err, done.out.strip()) == (0, "", file)
    assert (results / file).read_bytes().startswith(PNG)


def test_several_modes_get_names_of_their_own(results):
    done = call("visual", results / "plbeam5free", "--mode-number", "1:3", "-o", results / "m.svg")
    assert done.out.split() == [str(results / f"m_vibration{k}.svg") for k in (1, 2, 3)]


def test_mode_as_gif_and_list(results):
    assert call("visual", results / "plbeam5free", "-o", results / "m.gif", "--dpi", 30).status == 0
    assert picture_size(results / "m.gif")[1] == 48
    lines = call("visual", results / "plbeam5free", "--list").out.splitlines()
    assert len(lines) == 10
    assert lines[0].startswith("vibration mode 1   f = 0.056521 Hz")


def test_plot_csv_to_a_file_and_to_the_output(results):
    done = call("plot", results / "crank", "x[6,1]", "--csv", "-")
    assert done.out.splitlines()[0] == 't (s),"x[6,1] (m)"'
    assert len(done.out.splitlines()) == 102
    call("plot", results / "crank", "x[6,1]", "--csv", results / "c.csv", "-x", "x[2,1]")
    assert (results / "c.csv").read_text("utf-8").startswith('"x[2,1] (rad)","x[6,1] (m)"\n')
    assert not (results / "crank_plot.png").exists()


def test_only_the_step_that_is_drawn_is_read(made, monkeypatch):
    """10 000 steps: the checksums of all other blocks stay unread (they are verified on reading)."""
    from spacar_drawing.mechanism_picture import chosen_steps, configurations
    from spacar_drawing.picture_source import open_source
    from spacar_formats.sbf import SbfFile

    asked = []
    inside = SbfFile.check_steps
    monkeypatch.setattr(SbfFile, "check_steps", lambda self, chosen: (asked.append(list(chosen)), inside(self, chosen)))
    source = open_source(made / "crank")
    configurations(source, chosen_steps(source, "77", None, False))
    source.time(77)
    assert asked == [[76], [76]]


def long_result(folder, steps=10_000):
    """A `.sbd` of the crank with many steps."""
    from spacar_formats.sbf import SbfFile, SbfWriter

    with SbfFile(folder / "crank.sbd") as old:
        header = {k: v for k, v in old.header.items() if k not in ("SOURCE", "SHA256")}
        shapes = {k: (r.rows, r.cols) for k, r in old.step_records.items()}
        values = {k: old.get(k, 30) for k in shapes}
    with SbfWriter(folder / "long.sbd", "sbd", header, shapes) as writer:
        for k in range(steps):
            writer.append(values | {"T": np.array([[float(k)]])})


@pytest.mark.slow
def test_one_frame_of_ten_thousand_costs_little_more_than_one_of_sixty(results):
    """A whole process. Processor time is compared, which a busy machine does not lengthen."""
    import resource

    long_result(results)
    times = [0.0]
    for name, at in (("crank", "30"), ("long", "9000")):
        subprocess.run([sys.executable, "-m", "spacar_cli.main", "draw", results / name, "--at", at], check=True)
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        times.append(used.ru_utime + used.ru_stime - sum(times))
    assert (results / "long.png").exists()
    assert times[2] < 1.5 * times[1]  # 1.0; reading all steps takes several times as long


def test_no_window_toolkit_is_loaded_for_files(results):
    code = (
        "import sys; from spacar_cli.main import main; s = main(sys.argv[1:]); "
        "print(s, [m for m in sys.modules if m in ('matplotlib.pyplot', 'tkinter', 'pandas')])"
    )
    done = subprocess.run([sys.executable, "-c", code, "draw", results / "trike3v"], capture_output=True, text=True)
    assert done.stdout.splitlines()[-1] == "0 []"


def test_incomplete_results_can_be_drawn(results):
    shutil.move(results / "crank.sbd", results / "crank.sbd.part")
    done = call.refused("draw", results / "crank")
    assert "crank.sbd.part" in done
    assert call("draw", results / "crank.sbd.part").status == 0


# The public functions of spacar_drawing, from a Result in memory and from a file.
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
