"""Pictures are the same bytes whatever a matplotlibrc in the current folder says; LaTeX is never started."""

import shutil
import subprocess
import sys

import pytest

from tests.examples import DATA

HOSTILE = """text.usetex: True
font.family: fantasy
font.size: 40
figure.dpi: 30
figure.facecolor: red
savefig.bbox: tight
savefig.dpi: 20
axes.facecolor: black
axes.grid: True
axes.titlesize: 40
lines.linewidth: 9
path.sketch: 5, 50, 2
svg.fonttype: path
legend.fontsize: 30
xtick.direction: in
axes.formatter.use_locale: True
image.cmap: flag
no such line
"""
COMMANDS = (
    ("draw", "crank", "-o", "draw.png"), ("plot", "crank", "x[6,1]", "-o", "plot.svg"),
    ("visual", "lateral4", "-o", "visual.png"), ("eigen", "lateral4", "-o", "eigen.png"),
    ("stress", "lateral4", "-e", "1", "-o", "stress.png"), ("report", "crank", "--plot", "x[6,1]", "-o", "report.html"),
)  # fmt: skip
RUN = """
import sys
from spacar_cli.main import main
for words in {commands!r}:
    assert main(list(words)) == 0, words
import spacar
spacar.run(1, "crank.dat", n_steps=3).draw("called.png")
import matplotlib
print(matplotlib.rcParams["font.size"])
"""


@pytest.mark.slow
def test_a_matplotlibrc_changes_no_picture(tmp_path):
    """From the command line and from Python, whose own settings stay as they are."""
    found = {}
    for name, text in (("plain", ""), ("hostile", HOSTILE)):
        folder = tmp_path / name
        folder.mkdir()
        for model in ("crank", "lateral4"):
            shutil.copy(DATA / f"{model}.dat", folder)
        (folder / "matplotlibrc").write_text(text)
        first = (("1", "crank", "--steps", "5"), ("7", "lateral4"))
        words = [sys.executable, "-c", RUN.format(commands=(*first, *COMMANDS))]
        done = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr[-2000:]
        assert float(done.stdout.split()[-1]) == (40.0 if text else 10.0)
        pictures = (*(words[-1] for words in COMMANDS if words[0] != "report"), "called.png")
        found[name] = {picture: (folder / picture).read_bytes() for picture in pictures}
        page = (folder / "report.html").read_text()
        found[name]["svg"] = [part.split("</svg>")[0] for part in page.split("<svg")[1:]]
    assert [key for key in found["plain"] if found["plain"][key] != found["hostile"][key]] == []
