"""`spacar flexure` on the command line, and its files."""

import csv
import io
import json
import re
import shutil

import numpy as np
import pytest

import spacar
from tests import command_line
from tests.examples import DATA

from . import stroke_models as models
from .stroke_models import EA, EI, LENGTH


@pytest.fixture
def call(tmp_path, monkeypatch):
    """`call("flexure", "leafguide", ...)` in a folder with the models: status, output, errors."""
    shutil.copy(DATA / "leafguide.dat", tmp_path)
    (tmp_path / "planar.dat").write_text(models.two_leaves(models.GUIDE, 2))
    monkeypatch.chdir(tmp_path)
    return command_line.CommandLine("flexure")


def test_tables_are_in_the_unit_of_the_file_and_files_in_metres(call, tmp_path):
    """UNITS mm: 7x=5 are 5 mm; the table says mm, N/mm and N/mm^2; csv, npz and JSON are in SI and agree."""
    words = ("leafguide", "--move", "7x=5", "--steps", "2")
    status, out, err = call(*words, "--csv", "a.csv", "-o", "a.npz")
    assert (status, err) == (0, "")
    assert "stroke (mm)  force (N)  drive stiffness (N/mm)" in out
    assert re.search(r"^ +5 +13\.15 +2\.64", out, re.MULTILINE)
    assert "mises (N/mm^2)" in out
    rows = list(csv.DictReader((tmp_path / "a.csv").open()))
    arrays = np.load(tmp_path / "a.npz")
    found = json.loads(call(*words, "--json")[1])
    assert float(rows[-1]["stroke"]) == arrays["stroke"][-1] == found["columns"]["stroke"][-1] == pytest.approx(0.005)
    assert found["units"]["mises"] == "N/m^2"
    assert found["columns"]["k_x"][0] is None  # infinite
    assert arrays["compliance"].shape == (3, 6, 6)
    assert arrays["compliance"][:, 1, 1] == pytest.approx(1.0 / arrays["k_y"])
    study = spacar.flexure(tmp_path / "leafguide.dat", move="7x=5", steps=2)
    assert study.table()["f_1"] == pytest.approx(arrays["f_1"])
    assert next(csv.reader(io.StringIO(call(*words, "--csv", "-")[1]))) == list(study.table())


def test_the_same_model_in_metres(tmp_path):
    """What the units of the file are does not matter."""
    deck = spacar.read_deck(DATA / "leafguide.dat", 10)
    plain = spacar.parse_deck(deck.to_text(), mode=10)
    ours = spacar.flexure(deck, move="7x=4", steps=1).table()
    theirs = spacar.flexure(plain, move="7x=0.004", steps=1).table()
    for name, values in ours.items():
        if not name.startswith(("rotation", "line_z", "line_x")):  # rounding
            assert theirs[name] == pytest.approx(values, rel=1e-6, abs=1e-12, nan_ok=True), name


def test_the_page_holds_everything(call, tmp_path):
    out = call.done("planar", "--move", "9x=+-0.01", "--steps", "2", "-o", "page.html").out
    assert out.startswith("page.html\n")
    page = (tmp_path / "page.html").read_text()
    assert "http" not in page.replace("http-equiv", "")
    assert "<script" not in page
    assert page.count("data:image/png;base64,") >= 5
    for text in ("Key results", "Range of motion", "Support stiffness of node 9", "Energy balance", "locked 1"):
        assert text in page
    assert "nan" not in re.sub(r'src="[^"]*"', "", page)


def test_what_the_file_moves_is_the_drive(call):
    """leafguide.dat has one DELXF: 27 N along x at node 7."""
    status, out, _ = call("leafguide", "--steps", "2", "--json")
    found = json.loads(out)
    assert (status, found["drive"]) == (0, "7x")
    assert found["columns"]["force"] == pytest.approx([0.0, 13.5, 27.0])
    assert found["columns"]["stroke"][-1] == pytest.approx(0.0102, abs=1e-4)


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (("--move", "7q=3"), "--move 7q=3: '7q' names no coordinate"),
        (("--move", "99x=3"), "--move 99x=3: there is no node 99"),
        (("--move", "8x=3"), "--move 8x=3: node 8 is a node for orientations"),
        (("--move", "8r=3"), "--move 8r=3: say about which axis node 8 turns"),
        (("--move", "1x=3"), "1x is fixed: it cannot be moved"),
        (("--move", "x[8,1]=3"), "x[8,1]: lambda0 follows from the other three"),
        (("--move", "x[6,1]=3"), "x[6,1]: a twist rate is no range of motion"),
        (("--move", "e[2,1]=1"), "e[2,1] is rigid: it cannot be moved"),
        (("--move", "e[1,9]=1"), "there is no e[1,9] in the model"),
        (("--force", "e[1,3]=1"), "e[1,3]: a force acts on a node"),
        (("--move", "7x"), "--move 7x: expected NODEx=VALUE"),
        (("--move", "7x=1:2:3"), "--move 7x=1:2:3: '1:2:3' is no finite range"),
        (("--move", "7x=+-a"), "--move 7x=+-a: '+-a' is no number"),
        (("--move", "7x=0"), "--move 7x=0: the range is empty"),
        (("--move", "8rz=4"), "--move 8rz=4: a spatial rotation is at most 3 rad"),
        (("--move", "7x=1", "--force", "7x=1"), "give either a move or a force"),
        (("--move", "7x=1", "--load", "7y=1:2"), "--load 7y=1:2: one force, not a range"),
        (("--move", "7x=1", "--node", "99"), "there is no position or orientation node 99"),
        (("--move", "7x=1", "--pivot", "a"), "--pivot a: expected numbers x,y or x,y,z"),
        (("--move", "7x=1", "--pivot", "1"), "the pivot has 3 coordinates, not 1"),
    ],
)
def test_wrong_questions_are_one_sentence(call, words, sentence):
    status, out, err = call("leafguide", *words)
    assert (status, out) == (2, "")
    assert err.startswith(f"error: {sentence}"), err
    assert err.count("\n") == 1


def test_a_model_without_a_drive_asks_for_one(call):
    assert "planar.dat moves no single coordinate (DELINPX, DELINPE, DELXF)" in call.refused("planar")


@pytest.mark.slow
def test_a_stroke_that_is_too_long_fails_without_files(call, tmp_path):
    err = call.refused("planar", "--move", "9x=1", "--steps", "1", "--csv", "a.csv", "-o", "a.html", status=1)
    assert err.startswith("error: ")
    assert "; the range of 9x, 1 m, exceeds the size of the model" in err
    assert not (tmp_path / "a.csv").exists()
    assert not (tmp_path / "a.html").exists()


@pytest.mark.parametrize(("stroke", "told"), [("2x=250", True), ("2x=90", False)])
def test_a_stroke_beyond_the_model_is_told_in_its_unit(call, tmp_path, stroke, told):
    """A spring of 100 mm, 8 N/mm: 250 mm is computed, and doubted."""
    spring = "UNITS mm\nPLTRUSS 1 1 2\nX 2 100. 0.\nFIX 1\nFIX 2 2\nDYNE 1\nEND HALT\nXM 2 1.\nESTIFF 1 800.\nEND END\n"
    (tmp_path / "spring.dat").write_text(spring)
    status, out, err = call("spring", "--move", stroke, "--steps", "1")
    text = "the range of 2x, 250 mm, exceeds the size of the model, 100 mm; lengths are in mm, the unit of the input"
    assert (status, err) == (0, f"warning: {text} file (UNITS)\n" if told else ""), err
    assert re.search(rf"^ +{stroke[3:]} +{8 * float(stroke[3:]):g}", out, re.MULTILINE), out


def test_a_work_integral_that_misses_energy_is_told(tmp_path):
    """A strip that buckles sideways within the first step: the force is far from a cubic there."""
    text = """BEAM 1 1 2 3 4  0. 1. 0.   BEAM 2 3 4 5 6  0. 1. 0.   X 3 0.5 0. 0.   X 5 1. 0. 0.
FIX 1   FIX 2   DYNE 1 2 3 4 5 6   DYNE 2 2 3 4 5 6   END HALT
ESTIFF 1 0. 2. 1000. 1.   ESTIFF 2 0. 2. 1000. 1.   EM 1 1. 0.003   EM 2 1. 0.003   XF 5 0. 0.01 0.
END END
"""
    coarse = spacar.flexure(spacar.parse_deck(text), move="5z=-0.03", steps=1)
    assert coarse.imbalance > 0.01
    assert any("take more steps" in line for line in coarse.warnings)


def test_a_model_without_mass_has_no_frequencies():
    text = re.sub(r"^(EM|XM) .*\n", "", models.two_leaves(models.GUIDE, 2), flags=re.MULTILINE)
    study = spacar.flexure(spacar.parse_deck(text), move="9x=0.001", steps=1)
    assert np.isnan(study.frequencies).all()
    assert any(line.startswith("no frequencies") for line in study.warnings)
    assert study.drive_stiffness == pytest.approx(2625.0, rel=1e-3)


def test_loads_on_one_node_add_up(tmp_path):
    """Two --load on a node, and one on a node that the file loads: the sum, not a second statement."""
    loaded = models.two_leaves(models.GUIDE, 3, dynamics=("XF 9 0 -10",))
    plain = models.two_leaves(models.GUIDE, 3)
    one, two, three = (
        spacar.flexure(spacar.parse_deck(text), move="9x=0.002", steps=1, loads=loads).table()
        for text, loads in ((plain, ["9y=-25"]), (plain, ["9y=-10", "9y=-15"]), (loaded, ["9y=-15"]))
    )
    for name, values in one.items():
        assert two[name] == pytest.approx(values, rel=1e-9, abs=1e-12, nan_ok=True), name
        assert three[name] == pytest.approx(values, rel=1e-6, abs=1e-9, nan_ok=True), name


def test_a_singular_mass_matrix_is_told(capsys):
    """Of three translations one mass gives six frequencies no value: rounding is no frequency."""
    lines = ["BEAM 1 1 2 3 4 0 0 1", "BEAM 2 3 4 5 6 0 0 1", "X 1 0 0 0", "X 3 0 0.1 0", "X 5 0 0.2 0"]
    lines += ["FIX 1", "FIX 2", "DYNE 1", "DYNE 2", "END", "HALT", "XM 5 1"]
    lines += [f"ESTIFF {k} 1e6 1 1 10 0 0" for k in (1, 2)]
    study = spacar.flexure(spacar.parse_deck("\n".join([*lines, "END", "END"])), force="6rz=0.05", steps=1)
    assert any("no frequencies" in line for line in study.warnings)
    assert np.isnan(study.frequencies).all()


def test_an_over_constrained_flexure_runs_with_the_releases(call, tmp_path):
    """Two leaves, each of two beams: the lines are told, and the stiffness is that of two guided leaves, 24 EI/L^3."""
    leaves = "".join(f"PLBEAM {k} {p} {p + 1} 7 8\nBEAMSEC {k} s m 2\nDYNE {k}\n" for k, p in ((4, 1), (5, 5)))
    text = "SECTION s RECT 0.0005 0.04\nMATERIAL m 210e9 0.3 7800\n" + leaves
    text += "X 1 0 0\nX 7 0 0.1\nX 5 0 0.2\nFIX 1\nFIX 2\nFIX 5\nFIX 6\nEND HALT\nXM 7 0.18\nXM 8 1e-5\nEND END\n"
    (tmp_path / "over.dat").write_text(text)
    words = ("over", "--move", "7x=0.00001", "--steps", "1", "--json")
    status, _, err = call(*words)
    assert (status, "--release solves it" in err) == (1, True)
    status, out, err = call(*words, "--release")
    assert (status, err) == (0, "information: % in place of DYNE 4 (line 5):\ninformation: RLSE 4\n")
    EI = 210e9 * 0.04 * 0.0005**3 / 12
    # shear and the tension of the displaced leaves: some (t/L)^2 = 2.5e-5
    assert json.loads(out)["columns"]["drive_stiffness"][0] == pytest.approx(24 * EI / 0.1**3, rel=1e-4)
    assert call(*words, "--release")[1] == out


# A parallel guide over its stroke against closed forms, and against finite differences and integrals of itself.
BEAMS = 8
PUBLISHED = DATA / "published" / "leafspring_guide.dat"


@pytest.fixture(scope="module")
def published():
    """SPACAR Light's guide, 0.5 mm, 20 mm to both sides as its file says."""
    return spacar.flexure(PUBLISHED, steps=5)


@pytest.fixture(scope="module")
def small():
    """Planar, 4 mm to both sides, where the closed forms hold; the coordinate was calculable in the file."""
    return spacar.flexure(spacar.parse_deck(models.two_leaves(models.GUIDE, BEAMS)), move="9x=+-0.004", steps=4)


def test_the_published_numbers(published):
    """99.06, 177.13, 258.32 Hz and 654 MPa at 20 mm, in the compressed leaf at its clamp; the file is its own drive.
    The published program leaves shear out of the second order terms, which is 0.3 % here; finer meshes tend to 75.7,
    158.8, 260.5 Hz in both measures."""
    assert published.stroke == pytest.approx(np.linspace(-0.02, 0.02, 11), abs=1e-15)
    found, theirs, fine = published.frequencies, np.array([99.06, 177.13, 258.32]), np.array([75.7, 158.8, 260.5])
    assert found[-1, :3] == pytest.approx(theirs, rel=3e-3)
    assert np.all(np.abs(found[-1, :3] - fine) <= np.abs(theirs - fine) + 6e-3)
    assert found[:, :3] == pytest.approx(found[::-1, :3], rel=1e-8)  # equilibria are known to 1e-8 of the loads
    assert not any("fewer digits" in line for line in published.result.report)
    stress, element, place = published.largest_stress
    assert stress[-1] == pytest.approx(654e6, abs=0.5e6)
    assert (element[-1], place[-1]) == (1, 0.0)


def test_the_parasitic_motion(published):
    """An elastic rod, clamped and guided, comes down by 3/5 p^2 + 36/175 p^4 where it moves by p, both over its length;
    an element turns by up to 0.1 rad, 0.1^2/6."""
    p = published.stroke / LENGTH
    expected = -LENGTH * (0.6 * p**2 + 36.0 / 175.0 * p**4)
    assert published.errors.line_error[:, 1] == pytest.approx(expected, rel=2e-3, abs=1e-12)
    assert published.errors.line_error[:, [0, 2]] == pytest.approx(np.zeros((11, 2)), abs=1e-12)
    assert not published.errors.turning


def test_work_is_strain_energy(published, small):
    """Hermite's rule has an error of fourth order: 4 mm steps leave 2.4e-7, 1 mm steps 1/256 of it."""
    for study, limit in ((published, 1e-6), (small, 4e-9)):
        assert np.abs(study.missing_energy).max() < limit * study.energy.max()
        assert study.energy.max() > 0.0


def test_the_drive_stiffness_is_the_derivative_of_the_force(published, small):
    """Simpson's rule over two steps gives the difference of the forces; its error is of fifth order in the step."""
    for study in (published, small):
        h = np.diff(study.stroke)[0]
        k, F = study.drive_stiffness, study.force
        integral = h / 3.0 * (k[:-2:2] + 4.0 * k[1:-1:2] + k[2::2])
        assert integral == pytest.approx(F[2::2] - F[:-2:2], rel=2e-6)


def test_closed_forms_of_the_undeflected_guide(small):
    """Two leaves: 24 EI/L^3 along the drive, 2 EA/L across."""
    zero = small.zero
    assert small.drive_stiffness[zero] == pytest.approx(24.0 * EI / LENGTH**3, rel=1e-4)  # the body turns by 1e-5
    k = small.stiffness()[zero]
    assert k[1] == pytest.approx(2.0 * EA / LENGTH, rel=1e-6)
    assert k[0] == np.inf
    assert small.stiffness(locked=False)[zero, 0] == pytest.approx(24.0 * EI / LENGTH**3, rel=1e-4)
    assert small.support == [1, 2]


def test_the_support_stiffness_over_the_stroke(small):
    """Awtar: L/EA + L x^2/(700 EI) for a leaf, clamped and guided: half of the stiffness is left at 4 mm; four
    beams a leaf are 2 % off there, eight 0.1 %."""
    expected = 2.0 / (LENGTH / EA + LENGTH * small.stroke**2 / (700.0 * EI))
    assert small.stiffness()[:, 1] == pytest.approx(expected, rel=2e-3)
    assert small.remaining()[-1, 1] == pytest.approx(expected[-1] / expected[small.zero], rel=2e-3)
    assert small.remaining()[-1, 1] < 0.5


def test_first_unwanted_frequency_and_that_of_the_drive(small):
    """Locking one coordinate separates the frequencies (Cauchy); the drive has sqrt(24 EI/L^3/m), m with 26/35 of the
    leaves, so little that 1 % is enough."""
    locked, free = small.frequencies, small.free_frequencies
    known = np.isfinite(locked[0]) & np.isfinite(free[0])
    n = int(known.sum()) - 1
    assert (free[:, :n] <= locked[:, :n] * (1 + 1e-9)).all()
    assert (locked[:, :n] <= free[:, 1 : n + 1] * (1 + 1e-9)).all()
    leaves = 2 * models.RHO * models.WIDTH * models.THICKNESS * LENGTH
    expected = np.sqrt(24.0 * EI / LENGTH**3 / (models.BODY + 13 / 35 * leaves)) / (2 * np.pi)
    assert small.of("drive_hertz") == pytest.approx(expected, rel=0.01)
    assert small.of("unwanted_free") == pytest.approx(free[:, 1])


def test_a_drive_that_the_file_prescribes_gives_the_same(small):
    """Whether the coordinate was prescribed, dynamic or calculable in the file does not matter."""
    inputs = spacar.flexure(
        spacar.parse_deck(models.two_leaves(models.GUIDE, BEAMS, ("INPUTX 9 1",))), move="x[9,1]=-0.004:0.004", steps=4
    )
    ours, theirs = small.table(), inputs.table()
    names = ("force", "drive_stiffness", "energy", "line_y", "k_y", "k_r", "f_1", "ffree_1", "margin", "margin_free")
    for name in names:
        assert theirs[name] == pytest.approx(ours[name], rel=1e-6, abs=1e-9), name


def test_a_force_reaches_the_same_states(small):
    """A force instead of a displacement: the same stroke, stiffness, frequencies."""
    pushed = spacar.flexure(
        spacar.parse_deck(models.two_leaves(models.GUIDE, BEAMS)), force=f"9x={float(small.force[-1])!r}", steps=4
    )
    assert pushed.stroke[-1] == pytest.approx(0.004, rel=1e-6)
    assert pushed.force == pytest.approx(np.linspace(0.0, small.force[-1], 5))
    for name in ("drive_stiffness", "energy", "line_y", "k_y", "f_1", "margin", "work"):
        assert pushed.table()[name][-1] == pytest.approx(small.table()[name][-1], rel=1e-5), name


def test_the_buckling_margin_of_a_payload():
    """A load along the leaves: 4 pi^2 EI/L^2 a leaf with the drive locked, pi^2 EI/L^2 with it free."""
    load = 100.0
    deck = spacar.parse_deck(models.two_leaves(models.GUIDE, BEAMS))
    study = spacar.flexure(deck, move="9x=0.0001", steps=1, loads=[f"9y={-load}"], beams="angle")
    euler = 2.0 * np.pi**2 * EI / LENGTH**2 / load
    assert study.of("margin_free")[0] == pytest.approx(euler, rel=0.01)
    assert study.of("margin")[0] == pytest.approx(4.0 * euler, rel=0.02)


def test_a_payload_works_too():
    """The strain energy is the work of drive and payload."""
    deck = spacar.parse_deck(models.two_leaves(models.GUIDE, BEAMS))
    study = spacar.flexure(deck, move="9x=0.01", steps=4, loads=["9y=-20"])
    assert study.load_work[-1] == pytest.approx(20.0 * 0.6 * 0.01**2 / LENGTH, rel=0.02)
    assert np.abs(study.missing_energy).max() < 1e-6 * study.energy.max()


def test_another_node_and_axes_of_the_body(small):
    """Node 7 of the same body: the same frequencies, another support stiffness; body axes turn with the body."""
    other = spacar.flexure(
        spacar.parse_deck(models.two_leaves(models.GUIDE, BEAMS)), move="9x=0.004", steps=1, node=7, orientation=6
    )
    assert other.frequencies[-1] == pytest.approx(small.frequencies[-1], rel=1e-6)
    assert other.support == [0, 1, 2]
    trace = [np.trace(other.compliance(body=body)[-1][:2, :2]) for body in (False, True)]
    assert trace[0] == pytest.approx(trace[1], rel=1e-9)
