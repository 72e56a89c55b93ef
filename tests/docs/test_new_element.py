"""The worked example of the developer guide: its texts, put into a copy of the program, give an element that works."""

import inspect
import os
import shutil
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from spacar_formats.log import LogSink
from spacar_formats.result_files import begin, result_sinks

import spacar
from spacar.compiled.library import unavailable
from spacar.frame import Frame
from spacar.kinematics.element_sweep import ElementSweep
from spacar.mechanism import build
from spacar.stationary.equilibrium import CompiledEquilibrium
from spacar.stationary.level_evaluator import ArrayEquilibrium, StaticEquilibrium
from spacar.studies.side_by_side import copies
from tests.elements.derivatives import check_stiffness, check_strain, group
from tests.studies.all_elements import MODELS

from .documents import blocks, environment, module_of

HOUSE = Path(__file__).resolve().parents[2]
TEXTS = {b.name: b.text for b in blocks(HOUSE / "docs" / "developer.md") if b.name}
FOLDERS = ("spacar", "formats/spacar_formats", "cli/spacar_cli", "cli/spacar_drawing")
# text of the guide -> file, line behind which a row is put
ROWS = {
    "table-row": ("spacar/deck/table_elements.py", "PLANAR = (\n"),
    "parts-row": ("cli/spacar_drawing/element_pictures.py", "PARTS: dict[str, DrawOne] = {\n"),
}
FUNCTIONS = {  # and before which a function is put
    "drawing": ("cli/spacar_drawing/element_pictures.py", "# Shape of an element type"),
}
DRIVEN = TEXTS["cam.dat"]
FREE = (
    DRIVEN.replace("INPUTX 1 1\n", "DYNX 1 1\n")
    .replace("INPUTX 1 1 0. 10.", "STARTDX 1 1 0. 10.")
    .replace("XM 2 0.5", "XM 1 1e-4\nXM 2 0.5\nERROR 1e-10 1e-10")
)


class House:
    """A copy of the program in which an edit is what a new owner would do."""

    def __init__(self, home: Path) -> None:
        self.home = home
        for folder in FOLDERS:
            shutil.copytree(HOUSE / folder, home / folder, ignore=shutil.ignore_patterns("__pycache__"))
        self.add("plcam.py")
        self.edit("table-row")
        (home / "cam.dat").write_text(DRIVEN)
        (home / "free.dat").write_text(FREE)

    def add(self, name: str) -> None:
        """A new module of the guide."""
        (self.home / "spacar/elements/planar" / name).write_text(TEXTS[name])

    def edit(self, name: str) -> None:
        """Put a text of the guide where the guide says."""
        place, mark = ROWS.get(name) or FUNCTIONS[name]
        path = self.home / place
        before, found, after = path.read_text().partition(mark)
        assert found, f"{place} has no line {mark}"
        new = found + TEXTS[name] if name in ROWS else f"{TEXTS[name]}\n\n{found}"
        path.write_text(before + new + after)

    def python(self, *words: str, status: int = 0) -> str:
        """What a Python of the copy prints."""
        paths = (*(self.home / Path(f).parent for f in FOLDERS), HOUSE)
        more = {"PYTHONPATH": os.pathsep.join(map(str, paths)), "XDG_CACHE_HOME": str(self.home)}
        done = subprocess.run(
            [sys.executable, *words], cwd=self.home, env=environment() | more, text=True, capture_output=True,
            timeout=300, check=False,
        )  # fmt: skip
        assert done.returncode == status, done.stdout + done.stderr
        return done.stdout + done.stderr

    def arrays(self, script: str) -> dict[str, np.ndarray]:
        """What a script stores with `keep(name=array, ...)`."""
        head = "import numpy as np, spacar\ndef keep(**arrays): np.savez('kept.npz', **arrays)\n"
        self.python("-c", head + script)
        with np.load(self.home / "kept.npz") as kept:
            return dict(kept)


@pytest.fixture(scope="module")
def house(tmp_path_factory):
    """Steps 1 and 2 of the guide."""
    return House(tmp_path_factory.mktemp("plain"))


@pytest.fixture
def drawn_house(tmp_path):
    """Without step 3, whose rows belong to an engine that has been built again."""
    house = House(tmp_path)
    for name in ("drawing", "parts-row"):
        house.edit(name)
    return house


def test_derivatives():
    module = ModuleType("spacar.elements.planar.plcam")
    exec(compile(TEXTS["plcam.py"], "plcam.py", "exec"), module.__dict__)
    rng = np.random.default_rng(5)
    x0, x, v = rng.normal(size=(3, 3, 4))
    family = module.PlanarCam(group("PLCAM", x0, geometry=rng.normal(size=(4, 3)), estiff=[[2.0]] * 4))
    check_strain(family, x, v, rng.normal(size=(1, 4)))
    check_stiffness(family)


def test_motion_force_and_torque(house):
    """Closed form of the guide. 1e-12: rounding of numbers of the size of the lift, the force and the torque."""
    got = house.arrays(
        "r = spacar.run(1, 'cam.dat')\n"
        "keep(t=r.t, y=r.node(2, 2), ydd=r.node(2, 2, 'xdd'), s=r.element(1, 1, 'sig'), M=r.node(1, 1, 'fxtot'))"
    )
    t, m, a, w = got["t"], 0.5, 0.01, 10.0
    y, yd, ydd = 0.1 + a * (1 - np.cos(w * t)), a * w * np.sin(w * t), a * w**2 * np.cos(w * t)
    for name, truth in (("y", y), ("ydd", ydd), ("s", -m * ydd), ("M", m * ydd * yd / w)):
        assert got[name] == pytest.approx(truth, abs=1e-12), name


def test_statements_and_mistakes(house):
    """ESTIFF and ESIG take one coefficient a mode; what is wrong is said with its line."""
    (house.home / "few.dat").write_text(DRIVEN.replace("  0. 1. ", "  0. "))
    (house.home / "law.dat").write_text(DRIVEN.replace("XM 2", "ESTIFF 1 100.\nEDAMP 1 1.\nESIG 1 2.\nXM 2"))
    (house.home / "much.dat").write_text(DRIVEN.replace("XM 2", "ESTIFF 1 100. 3.\nXM 2"))
    runs = "from spacar_cli.main import main\nprint([main(['1', name]) for name in ('few', 'much', 'law')])"
    said = house.python("-c", runs)
    assert "few.dat:1: PLCAM" in said
    assert "much.dat:7: ESTIFF" in said
    assert "[2, 2, 0]" in said
    assert "direction of the lift, x" in house.python("-m", "spacar.deck.reference")


SHAPES = """
from spacar_drawing.look import look_of
from spacar_drawing.element_pictures import element_shapes
from spacar_drawing.scene import Pose
from spacar_drawing.picture_source import source_of_result
r = spacar.run(1, 'cam.dat')
source = source_of_result(r)
look = look_of(source.scene, source.x(), source.settings)
shapes = [element_shapes(source.scene, Pose.of(source.scene, x), look) for x in source.x()]
r.draw('cam.png')
y = r.node(2, 2)
"""


def test_an_element_without_a_picture_is_a_mark(house):
    """At the follower, at every step."""
    got = house.arrays(f"{SHAPES}\nkeep(y=y, at=[s.at for [s] in shapes])")
    assert got["at"][:, 1] == pytest.approx(got["y"], abs=1e-15)
    assert (house.home / "cam.png").stat().st_size > 1000


def test_the_picture_of_the_guide(drawn_house):
    """The cam turns about a fixed point 0.1 m - h above the origin, and its contour passes through the follower.

    The radius about that point is h + h (1 - cos theta)/2 with the angle theta from the direction of the lift, turned
    clockwise by the cam angle. 1e-14: rounding of numbers below 0.2 m.
    """
    got = drawn_house.arrays(f"{SHAPES}\nkeep(y=y, t=r.t, lines=[s.points for [s] in shapes])")
    h, phi = 0.02, 10 * got["t"][:, None]
    d = got["lines"] - np.array([0.0, 0.1 - h, 0.0])
    clockwise = np.arctan2(d[..., 0], d[..., 1])
    assert np.hypot(d[..., 0], d[..., 1]) == pytest.approx(h + 0.5 * h * (1 - np.cos(clockwise + phi)), abs=1e-14)
    followers = np.stack((0 * got["y"], got["y"]), axis=-1)[:, None]
    assert np.abs(got["lines"][:, :, :2] - followers).max(-1).min(-1) == pytest.approx(0, abs=1e-14)
    assert (drawn_house.home / "cam.png").stat().st_size > 1000


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
def test_the_compiled_form(drawn_house):
    """All four steps. A cam that turns freely keeps its energy, and both paths give the same motion.

    Energy 5e-3 J with tolerances of 1e-10 on angle and rate: 1e-8 of it allows the errors of about a hundred steps.
    """
    pytest.importorskip("sympy")
    drawn_house.add("plcam_symbolic.py")
    shutil.copy(HOUSE / "hatch_build.py", drawn_house.home)
    assert "built the compiled engine" in drawn_house.python("hatch_build.py")
    got = drawn_house.arrays(
        "a, b = (spacar.run(1, 'free.dat', compiled=c) for c in (True, False))\n"
        "from spacar.compiled.numbers import without_form\n"
        "assert without_form(a.mechanism) == []\n"
        "keep(w=a.node(1, 1, 'xd'), v=a.node(2, 2, 'xd'), x=a.node(2, 2), y=b.node(2, 2))"
    )
    energy = 0.5e-4 * got["w"] ** 2 + 0.25 * got["v"] ** 2
    assert energy == pytest.approx(np.full(21, 5e-3), rel=1e-8)
    assert np.ptp(got["w"]) > 1.0  # it does slow down
    np.testing.assert_allclose(got["x"], got["y"], atol=1e-8)


# Claims of the developer guide that can be executed; `ELSEWHERE` says which tests execute others. Not executed: that
# comments say why, that tolerances have a reason, that formulas use the names of the theory, that a step that only
# moves code equals its parent (benchmarks/compare_revisions.py), and what speed asks for.
GUIDE = (HOUSE / "docs" / "developer.md").read_text("utf-8")
ELSEWHERE = {
    "Arrows point one way": "test_architecture.py",
    "works with complex x": "elements/derivatives.py",
    "An interrupted run\nhas written everything": "acceptance/test_runs.py",
    "An `Evaluator` is a `RightHandSide`": "dynamics/test_evaluators.py",
    "the Python\nmethod is the reference": "compiled/test_compiled_stepper.py",
    "Users never see a traceback": "robust/test_one_sentence.py",
    "No other module names an element": "deck/test_element_facts.py",
    "copy of the program and runs": "docs/test_new_element.py",
    "the order that each row claims": "integrators/test_orders.py",
    "spacar --help` needs no NumPy": "acceptance/test_runs.py",
    "means one thing in the whole program": "test_names.py",
}


def test_claims_that_other_tests_execute_are_made_and_tested():
    assert [claim for claim in ELSEWHERE if claim not in GUIDE] == []
    assert [path for path in ELSEWHERE.values() if not (HOUSE / "tests" / path).is_file()] == []


@pytest.mark.skipif(unavailable() is not None, reason="the walk is that of a run in C")
@pytest.mark.parametrize(("words", "most"), [("1 crank", 70), ("7 plbeam5", 80)])
def test_a_run_passes_through_few_files(words, most, tmp_path, monkeypatch):
    walk = module_of(HOUSE / "docs" / "walk.py")
    mode, name = words.split()
    shutil.copy(HOUSE / "data" / f"{name}.dat", tmp_path)
    monkeypatch.chdir(tmp_path)
    files = walk.files_of_a_run([mode, name, "--quiet"])
    assert (tmp_path / f"{name}.sbd").is_file()
    assert 40 < len(files) <= most
    if name == "crank":
        image = pytest.importorskip("PIL.Image")
        with image.open(HOUSE / "docs" / "pictures" / "walk.png") as picture:
            assert picture.text["Description"].splitlines() == files, "python docs/figures.py docs/pictures walk.png"


def lines_of_elements(deck: spacar.Deck) -> int:
    """How many lines of families are executed to evaluate all elements once."""
    m = build(deck, 1)
    sweep, v = ElementSweep(m), np.linspace(0.1, 1.0, m.numbering.nx)
    count = 0

    def trace(frame, event, _):
        nonlocal count
        if "elements" not in Path(frame.f_code.co_filename).parent.parts:
            return None
        count += event == "line"
        return trace

    before = sys.gettrace()  # of coverage
    sys.settrace(trace)
    try:
        sweep.strain(m.x0)
        sweep.mass()
        sweep.convective(v)
        sweep.inertia_force(v, v)
    finally:
        sys.settrace(before)
    return count


@pytest.mark.parametrize("name", MODELS)
def test_a_family_never_loops_over_elements(name):
    deck = spacar.Deck.build(*MODELS[name])
    assert lines_of_elements(copies([deck])) == lines_of_elements(copies([deck] * 5)) > 0


def test_a_sink_never_changes_a_frame(tmp_path):
    run = spacar.frames(4, HOUSE / "data" / "lever.dat", n_steps=3)
    with result_sinks(tmp_path / "lever", run.mode.files, False) as results:
        begin(results)
        sinks = [*results, LogSink(tmp_path / "lever.log", run.mode, tmp_path)]
        for sink in sinks:
            sink.start(run)
        for frame in run:
            stored = [getattr(frame, name) for name in Frame.__slots__]
            for value in (*stored, *frame.matrices.values(), *frame.state_space.values()):
                if isinstance(value, np.ndarray):
                    value.flags.writeable = False  # writing raises
            for sink in sinks:
                sink.frame(frame)
        for sink in sinks:
            sink.finish(None)


@pytest.mark.parametrize("kind", [ArrayEquilibrium, CompiledEquilibrium])
def test_both_kinds_of_static_equilibrium_have_what_the_protocol_asks_for(kind):
    for name, asked in vars(StaticEquilibrium).items():
        if inspect.isfunction(asked) and not name.startswith("_"):
            assert inspect.signature(getattr(kind, name)) == inspect.signature(asked), name
