"""Outputs that are passed many in one call of C are those that come one by one, bit by bit, with the same sentences."""

import gc
import time
from collections import Counter
from dataclasses import fields

import numpy as np
import pytest

import spacar
from spacar.compiled import output_block
from spacar.compiled.compiled_evaluator import CompiledDynamics
from spacar.compiled.library import why_off
from spacar.deck import Deck, parse_deck
from spacar.forward.motion import chosen, motion
from spacar.frame import Frame, StoredFrames
from tests.examples import DATA

from .other_ways import CRANK, free_crank, pushed

pytestmark = pytest.mark.skipif(why_off() is not None, reason=str(why_off()))
CODES = (0, 135, 155, 853)

FREE, FAST = free_crank("1. 40"), free_crank("3. 3")
DRIVEN = CRANK.format(drive="INPUTX 2 1", start="INPUTX 2 1 0. 150. 0.", times="0.1 100")
R, L = 0.15, 0.35
UPRIGHT = float(np.sqrt(L**2 - R**2))
SLIDER = [
    ("PLRBEAM", 1, 1, 2, 3), ("PLRBEAM", 2, 3, 4, 5), ("X", 3, 0.0, R), ("X", 5, UPRIGHT, 0.0), ("FIX", 1),
    ("FIX", 5, 2), ("DYNX", 5, 1),
]  # fmt: skip
PARALLELOGRAM = [
    ("PLRBEAM", 1, 1, 2, 3), ("PLRBEAM", 2, 4, 5, 6), ("PLRBEAM", 3, 3, 7, 6),
    ("X", 3, 0.0, 1.0), ("X", 4, 2.0, 0.0), ("X", 6, 2.0, 1.0), ("FIX", 1), ("FIX", 4), ("INPUTX", 2),
]  # fmt: skip
AT_DEAD_POINTS = [("INPUTX", 2, 1, 0.0, 0.5 * np.pi, 0.0), ("TIMESTEP", 2.0, 16)]


def slider(duration: float, steps: int, *more: tuple) -> Deck:
    """It goes to its dead centre, 0.184 m away, with 0.1 m/s."""
    rows = [("XM", 5, 1.0), ("XM", 2, 0.1), ("STARTDX", 5, 1, UPRIGHT, 0.1), ("TIMESTEP", duration, steps)]
    return Deck.build(SLIDER, [*rows, *more], mode=1)


def trike(old: str, new: str) -> Deck:
    text = (DATA / "trike3v.dat").read_text()
    assert old in text
    return parse_deck(text.replace(old, new), mode=1)


def followed(source, standing: bool, **options):
    """All numbers of all frames, the report, and what ended the run."""
    run = spacar.frames(1, source, **options)
    frames, error = [], None
    with np.errstate(all="ignore"):
        try:
            for _, block in motion(run, own=standing):
                frames.extend([_bytes(getattr(frame, f.name)) for f in fields(Frame)] for frame in block)
        except Exception as raised:
            error = type(raised), str(raised)
    return frames, run.report.lines, error


def _bytes(value):
    return value.tobytes() if isinstance(value, np.ndarray) else value


def same(source, **options):
    """The two ways; the number of frames, the report, what ended it."""
    one_by_one, together = followed(source, True, **options), followed(source, False, **options)
    assert together == one_by_one
    return len(together[0]), together[1], together[2]


@pytest.fixture(params=["usual", "each", "little room"])
def calls(request, monkeypatch):
    """How many outputs a call of C takes at most: many, one, three."""
    if request.param == "each":
        monkeypatch.setattr(output_block, "LONGEST", 0.0)
    elif request.param == "little room":
        monkeypatch.setattr(output_block, "ROOM", 300)
    return request.param


@pytest.mark.parametrize("code", CODES)
@pytest.mark.parametrize("model", [FREE, FAST], ids=["outputs close together", "far apart"])
def test_a_crank(model, code, calls):
    frames, _, error = same(parse_deck(model, mode=1), integrator=code, atol=1e-6, rtol=1e-6)
    assert error is None
    assert frames in (4, 41)
    assert code or same(parse_deck(DRIVEN, mode=1)) == (101, [], None)


@pytest.mark.parametrize("code", [0, 155])
@pytest.mark.parametrize("name", ["robotsim", "cardan", "finger", "trike2", "crankfl"])
def test_examples(name, code):
    """Spatial ones, belts, wheels; with vibrations, where the method looks at its steps between outputs."""
    assert same(DATA / f"{name}.dat", integrator=code)[2] is None


def test_only_python_looks_where_somebody_needs_the_evaluator(monkeypatch):
    asked = []
    monkeypatch.setattr(CompiledDynamics, "output_block", lambda self, *a: asked.append(a))
    spacar.run(1, parse_deck(FREE.replace("END HALT", "OUTLEVEL 0 1 END HALT"), mode=1))
    assert not asked


# -- failures say the same, after the same frames ----------------------------------------------------------------------
def test_a_dead_point_at_an_output(calls):
    """Every fourth output falls on it."""
    frames, _, error = same(Deck.build(PARALLELOGRAM, AT_DEAD_POINTS, mode=1))
    assert frames == 8
    assert "singular position at t = 1" in error[1]


@pytest.mark.parametrize("tolerance", [1e-4, 1e-8])
def test_a_dead_point_between_outputs(tolerance, calls):
    frames, report, error = same(slider(3.0, 300, ("ERROR", tolerance, tolerance)))
    assert frames > 200
    assert any("singular position" in said for said in (*report, "" if error is None else error[1]))


@pytest.mark.parametrize(
    ("old", "new"), [("STARTDE 8 1 -0.5 0.0", "STARTDE 8 1 0.5 0.0"), ("STARTDE 2 1 0.0 10.0", "STARTDE 2 1 0.0 25.0")]
)
def test_a_wheel_that_leaves_the_ground(old, new):
    _, _, error = same(trike(old, new))
    assert "leaves the ground" in error[1]


BEAM = [("PLBEAM", 1, 1, 2, 3, 4), ("X", 3, 1.0), ("FIX", 1), ("FIX", 2)]


@pytest.mark.parametrize("rate", [0.93, 1.1], ids=["doubtful", "refused"])
def test_a_beam_that_is_bent_too_far(rate):
    """Its end rotates by asin(e3/l) to the chord: beyond 60 degrees that is said once, and the run ends later."""
    driven = [("INPUTE", 1, 3, 0.0, rate, 0.0), ("TIMESTEP", 1.0, 100)]
    frames, report, error = same(Deck.build([*BEAM, ("INPUTE", 1, 3)], driven, mode=1))
    assert frames > 60
    (said,) = [line for line in report if "element 1" in line]
    assert "to the line between its nodes" in said
    assert (error is not None) == (rate > 1.0)


@pytest.mark.parametrize("free", [False, True])
def test_an_element_that_vanishes_at_an_output(free):
    """1 m with -0.5 m/s: gone at t = 2."""
    motion = [("XM", 3, 1.0), ("STARTDE", 1, 1, 0.0, -0.5)] if free else [("INPUTE", 1, 1, 0.0, -0.5, 0.0)]
    rows = [*BEAM, ("DYNE" if free else "INPUTE", 1, 1)]
    frames, _, error = same(Deck.build(rows, [*motion, ("TIMESTEP", 4.0, 40)], mode=1))
    assert frames == 20
    assert "collapsed" in error[1]


@pytest.mark.parametrize("code", CODES)
def test_a_user_function(code, tmp_path):
    path = pushed(tmp_path, "return t, [], [[2, 1, 3.0 * (t > 0.3)]]")
    assert same(path, integrator=code)[2] is None


@pytest.mark.parametrize("code", [0, 853])
def test_a_user_function_that_fails(code, tmp_path):
    frames, _, error = same(pushed(tmp_path, "return t, [], [[2, 1, 1.0 / (t < 0.5)]]"), integrator=code)
    assert frames == 10
    assert "ZeroDivisionError" in error[1]


def test_sentences_of_a_user_function_come_with_their_frame(tmp_path):
    """From t = 0.5 on it gives a stress that cannot act: said once, with the first frame that has it."""
    path = pushed(tmp_path, "return t, [[1, 1, 5.0]] if t >= 0.499 else [], []")
    assert same(path)[2] is None
    run = spacar.frames(1, path)
    said = [(frame.t, len(run.report.lines)) for frame in run]
    assert [lines for _, lines in said] == [int(t > 0.499) for t, _ in said]


def test_an_interruption_comes_behind_the_frames_before_it(tmp_path):
    run = spacar.frames(1, pushed(tmp_path, "if t > 0.5: raise KeyboardInterrupt\n    return t, [], []"))
    times = []
    with pytest.raises(KeyboardInterrupt):
        times.extend(frame.t for frame in run)
    assert times == pytest.approx(np.linspace(0.0, 0.5, 11)[: len(times)])
    assert len(times) >= 8


# -- streams, memory -----------------------------------------------------------------------------------------------
def test_frames_are_handed_on_while_the_run_lasts(tmp_path):
    """An evaluation takes 3 ms: no frame waits longer than a call may last, and the step that it ends with."""
    path = pushed(tmp_path, "time.sleep(0.003)\n    return t, [], []")
    source = path.with_name("push.py")
    source.write_text("import time\n" + source.read_text())
    waits, last = [], time.perf_counter()
    for _ in spacar.frames(1, path):
        now = time.perf_counter()
        waits.append(now - last)
        last = now
    assert sum(waits) > 0.25  # s: several calls
    assert sum(wait > 0.01 for wait in waits) >= 3


def test_a_frame_keeps_few_others():
    """Rows of one array are bounded, however many outputs there are."""
    frames = iter(spacar.frames(1, parse_deck(DRIVEN.replace("0.1 100", "100. 100000"), mode=1)))
    some = [next(frames) for _ in range(3)]
    assert some[1].x.base is not None
    kept = some[1].x
    while kept.base is not None:
        kept = kept.base
    assert kept.nbytes <= 8 * output_block.ROOM


@pytest.mark.parametrize("model", [FREE, DRIVEN], ids=["free", "driven"])
def test_a_run_leaves_no_circles_behind(model):
    """Evaluators, states and records go away with the run, without the collector of circles. What an earlier test had
    held may end meanwhile: only more objects than before are a finding."""

    def count():
        return Counter(type(part).__module__ for part in gc.get_objects())

    for _ in range(2):
        spacar.run(1, parse_deck(model, mode=1))
    gc.collect()
    gc.disable()
    try:
        before = count()
        spacar.run(1, parse_deck(model, mode=1))
        left = count() - before
    finally:
        gc.enable()
    assert not [module for module in left if module.startswith("spacar")]


# -- the bound of the condition ----------------------------------------------------------------------------------------
@pytest.mark.parametrize("name", ["robotsim", "finger", "trike2", "crank", "screw"])
def test_the_bound_of_the_condition_never_lies_and_is_of_use(name):
    """Without the exact condition: above the true one nothing is called harmless; far below it everything is."""
    evaluator = chosen(spacar.frames(1, DATA / f"{name}.dat"))
    y = evaluator.start()
    evaluator.frame(0.0, y)
    exact = evaluator.position_matrix().rcond()
    for singular, harmless in ((exact * (1.0 + 1e-9), False), (exact * 1e-5, True)):
        many = evaluator.output_block(np.zeros(1), np.zeros(0, np.int64), singular)
        many.c.n_exact, many.c.guard = 0, -1.0
        (out,) = many.prescribed(y)
        assert isinstance(out.shown, StoredFrames) == (harmless and not many.c.foreign)
