"""UNITS mm: what is shown in mm is what the same numbers give when mm, N are simply taken as a consistent set.

Statics knows no mass, so the file without its UNITS line is the same model in these units: log, plots, key results and
compliances must show the same numbers.
"""

import re

import numpy as np
import pytest
import spacar_drawing
from spacar_formats.log.text_layout import ShownUnits

import spacar
from tests.command_line import call
from tests.examples import DATA

NUMBER = re.compile(r"[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?\Z")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """leafguide.dat in mm and without units, both run in mode 10 with the log level that prints transfer functions."""
    place = tmp_path_factory.mktemp("units")
    text = (DATA / "leafguide.dat").read_text()
    text = text.replace("BEAMSEC 2 bar aluminium", "BEAMSEC 2 bar spring").replace("bar aluminium", "bar spring")
    text = text.replace("spring 4", "spring 2").replace("27.", "27. 0. 3.\nESIG 1 0. 0. 0. 0. 0. 0.\nXF 8 0. 0. 20.")
    (place / "mm.dat").write_text(text)
    (place / "plain.dat").write_text(re.sub(r"UNITS mm.*", "", text))
    for name in ("mm", "plain"):
        call.done("10", place / name)
    return place


def part(text: str, first: str, last: str) -> list[str]:
    start = text.index(first)
    return text[start : text.index(last, start)].split()


@pytest.mark.parametrize(
    ("first", "last"),
    [
        ("\n  section  material", "Elements: numbers"), ("ESTIFF: stiffness", "DELXF: "), ("XF: ", "DELXF: "),
        ("  node  coordinate  class", "Eigenvalues"),
        ("  node  coordinate       compliance", "The reduced mass matrix"), ("SOLUTION 5, LOAD STEP 4", "Eigenvalues"),
    ],
)  # fmt: skip
def test_the_log_shows_the_numbers_of_the_file(folder, first, last):
    """Solutions are equal to the tolerance of the iteration; what is zero in both is rounding in both."""
    ours, theirs = (part((folder / f"{n}.log").read_text(), first, last) for n in ("mm", "plain"))
    values = [[float(word) for word in words if NUMBER.match(word)] for words in (ours, theirs)]
    assert len(values[0]) == len(values[1]) > 3
    assert np.count_nonzero(values[0]) > 1
    size = max(map(abs, values[1]))
    assert values[0] == pytest.approx(values[1], rel=1e-5, abs=1e-9 * size)


def test_the_log_says_which_units(folder):
    text = (folder / "mm.log").read_text()
    for words in ("shown in mm, N, N mm, kg, s", "A (mm^2)", "E (N/mm^2)", "Coordinates in mm;", "elongation [mm]"):
        assert words in text
    assert "Coordinates; total force" in (folder / "plain.log").read_text()


def test_curves(folder):
    """Figures of both files have the same numbers; csv stays in SI."""
    figures = [
        spacar_drawing.plot(folder / n, "x[7,1]", "fxtot[1,2]", "sig[1,4]", "x[8,4]", against="x[7,2]")
        for n in ("mm", "plain")
    ]
    assert "(mm)" in figures[0].axes[0].get_ylabel()
    for ours, theirs in zip(*(f.axes for f in figures), strict=True):
        for a, b in zip(ours.lines, theirs.lines, strict=True):
            assert a.get_xdata() == pytest.approx(b.get_xdata(), rel=1e-6)
            assert a.get_ydata() == pytest.approx(b.get_ydata(), rel=1e-5, abs=1e-6 * np.abs(b.get_ydata()).max())
    head, *lines = call("plot", folder / "mm", "x[7,1]", "--csv", "-").out.splitlines()
    assert head == 't,"x[7,1] (m)"'
    assert float(lines[-1].split(",")[1]) == pytest.approx(figures[0].axes[0].lines[0].get_ydata()[-1] / 1e3)


@pytest.mark.slow  # two pages with all their pictures
def test_key_results(folder):
    pages = [spacar_drawing.report(folder / n, ["x[7,1]"], log_lines=0) for n in ("mm", "plain")]
    rows = [re.search(r"<tr><th>x\[7,1\] \(m?m\)</th>(.*?)</tr>", page) for page in pages]
    assert rows[0] is not None
    assert rows[1] is not None
    assert rows[0][1] == rows[1][1]


def test_compliances(folder):
    tables = [call("compliance", folder / name, "7").out for name in ("mm", "plain")]
    assert "in mm and rad by N and N mm" in tables[0]
    ours, theirs = ([float(w) for w in t.split() if NUMBER.match(w) and "e" in w] for t in tables)
    assert ours == pytest.approx(theirs, rel=1e-6, abs=1e-12)


def test_powers_of_the_metre():
    """Work and energy are N m in SI, N mm in mm: the product of dual numbers is a thousand times as large."""
    n = spacar.run(0, DATA / "crosshingew.dat").mechanism.numbering
    shown = ShownUnits.of(n, 1e-3)
    rng = np.random.default_rng(1)
    x, f, e, s = (rng.standard_normal(k) for k in (n.nx, n.nx, n.ne, n.ne))
    assert shown.coordinates * x * shown.forces * f == pytest.approx(1e3 * x * f)
    assert shown.deformations * e * shown.stresses * s == pytest.approx(1e3 * e * s)
    assert shown.compliances * x * shown.forces * f == pytest.approx(shown.coordinates * x * f)
