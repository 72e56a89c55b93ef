"""Claims of the developer guide that can be executed; `ELSEWHERE` says which tests execute others.

Not executed: that comments say why, that tolerances have a reason, that formulas use the names of the theory, that
a step that only moves code equals its parent (benchmarks/compare_revisions.py), and what speed asks for.
"""

import inspect
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest
from spacar_formats.log import LogSink
from spacar_formats.sinks import begin, result_sinks

import spacar
from spacar.compiled.library import unavailable
from spacar.frame import Frame
from spacar.kinematics.element_sweep import ElementSweep
from spacar.mechanism import build
from spacar.stationary.equilibrium import CompiledEquilibrium
from spacar.stationary.level_evaluator import ArrayEquilibrium, StaticEquilibrium
from spacar.studies.side_by_side import copies
from tests.studies.all_elements import MODELS

from .documents import module_of

HOUSE = Path(__file__).resolve().parents[2]
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
    "spacar --help` needs no NumPy": "acceptance/test_cost.py",
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

    sys.settrace(trace)
    try:
        sweep.strain(m.x0)
        sweep.mass()
        sweep.convective(v)
        sweep.inertia_force(v, v)
    finally:
        sys.settrace(None)
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
