"""C asks the user function of a single case itself: what it takes is what Python reads, what is raised is kept, and
nothing stays behind."""

import gc
import signal
import subprocess
import sys
import threading
import weakref
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import spacar
from spacar.compiled import python_callbacks
from spacar.compiled.compiled_evaluator import CompiledDynamics
from spacar.compiled.library import engine, why_off
from spacar.errors import AnalysisError
from spacar.forward.motion import chosen
from spacar.mechanism import build
from tests.examples import DATA

pytestmark = pytest.mark.skipif(why_off() is not None, reason=str(why_off()))

ARM = """PLBEAM 1 1 2 3 4   X 1 0. 0.   X 3 1. 0.   FIX 1   FIX 2   DYNE 1 1   DYNE 1 2 3   END HALT
XM 3 1.   EM 1 1.   ESTIFF 1 100. 100.   USERSIG law   TIMESTEP 0.1 5   END END
"""
HEAD = "import json, numpy as np\ndef law(t, ne, le, e, ep, nx, lnp, x, xp):\n"
USUAL = "    return t, [[1, 1, -0.3 * ep[0]], (1, 2, 0.1)], [[3, 1, 0.5 + t]]\n"


def model(folder: Path, body: str, text: str = ARM) -> Path:
    (folder / "law.py").write_text(HEAD + (body or "    pass\n"))
    (folder / "model.dat").write_text(text)
    return folder / "model.dat"


def evaluator(path: Path) -> CompiledDynamics:
    made = CompiledDynamics(build(spacar.read_deck(path, 1), 1))
    made.start()
    return made


def tip(path: Path) -> Any:
    return spacar.run(1, path).node(3, 2)


def asked(path: Path, times: int = 8) -> list[Any]:
    """Derivatives at some times, or what was raised instead."""
    made = evaluator(path)
    y, found = np.zeros(made.n_positions + made.numbering.nddof), []
    for k in range(times):
        try:
            status = made._derivative(0.01 * k, y, 1e-11)
            found.append((status, made._out.tolist(), dict(made.solver.slots.lost[0])))
        except (AnalysisError, KeyboardInterrupt, SystemExit) as error:
            found.append((type(error), str(error), type(error.__cause__), str(error.__cause__)))
    return found


BODIES = {
    "usual": USUAL,
    "no force": "    return t, [[1, 1, 0.1]], []\n",
    "nothing": "    return t, None, None\n",
    "list": "    return [t, [[1, 1, 0.1]], []]\n",
    "whole": "    return t, [[1, 1, 2], [1, 2, np.float64(0.25)]], []\n",
    "minus one": "    return t, [[1, 1, -1.0], [1, 2, -1]], []\n",
    "large": "    return t, [[1, 1, 10**400 if t > 0.03 else 2]], []\n",
    "not finite": "    return t, [[1, 1, np.nan if t > 0.03 else 2.0]], []\n",
    "other rows": "    return (t, [[1, 1, 0.1]], []) if t < 0.03 else (t, [[1, 2, 0.2], [1, 3, 0.1]], [[3, 2, 1.0]])\n",
    "array": "    return t, np.array([[1.0, 1.0, 0.1]]), np.zeros((0, 3))\n",
    "equal numbers": "    return t, [[1.0, True, 0.1]], []\n",
    "several rows on a place": "    return t, [[1, 1, 0.1], [1, 1, 0.1]], []\n",
    "short": "    return t, [[1, 1, 0.1]]\n",
    "number": "    return 3.0\n",
    "text": "    return t, [[1, 1, 'a' if t > 0.03 else 2.0]], []\n",
    "raised": "    return t, [[1, 1, 1.0 if t < 0.03 else [][0]]], []\n",
    "raised at first": "    raise RuntimeError('two\\nlines')\n",
    "raised once": "    if round(t, 9) == 0.03: raise ValueError\n" + USUAL,
    "no such place": "    return t, [[1, 1, 1.0], [9, 1, 0.0]][: 1 + (t > 0.03)], []\n",
    "end of the program": "    if round(t, 9) == 0.03: raise SystemExit(3)\n" + USUAL,
    "Ctrl-C": "    if round(t, 9) == 0.03: raise KeyboardInterrupt('here')\n" + USUAL,
    "json": "    return t, json.loads('[[1, 1, 0.5], [1, 2, 1e-3]]'), []\n",
}


def outcomes(path: Path) -> Any:
    try:
        return asked(path)
    except AnalysisError as error:
        return str(error), error.code


@pytest.mark.parametrize("which", BODIES)
def test_answers_are_those_that_are_called_back(tmp_path: Path, which: str, monkeypatch: pytest.MonkeyPatch) -> None:
    path = model(tmp_path, BODIES[which])
    assert python_callbacks.python() is not None
    found = outcomes(path)
    assert isinstance(found, list) or found[1].startswith("user-function.")
    monkeypatch.setattr("spacar.compiled.python_callbacks.python", lambda: None)
    assert found == outcomes(path)


def test_python_reads_only_the_first_of_usual_answers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Else C would call Python for nothing."""
    times: list[float] = []
    read = python_callbacks.PythonCallbacks.read
    seen = lambda self, t, given: (times.append(t), read(self, t, given))[1]  # noqa: E731
    monkeypatch.setattr(python_callbacks.PythonCallbacks, "read", seen)
    spacar.run(1, model(tmp_path, USUAL))
    assert times == [0.0]


def test_sentences_come_and_go_as_when_called_back(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A stress on a fixed deformation at some outputs only: where it was, not where it was not."""
    body = "    return t, [[1, 1, 0.1 if 0.03 < t < 0.07 else 0.0], [1, 2, 0.1]], []\n"
    path = model(tmp_path, body, ARM.replace("DYNE 1 1 ", ""))

    def lost() -> tuple[list[list[Any]], list[str]]:
        blocks = list(spacar.frames(1, path).blocks())
        return [[dict(frame.lost) for frame in block] for block in blocks], spacar.run(1, path).report

    found, report = lost()
    sentences = [sentence for block in found for sentence in block]
    assert [bool(s) for s in sentences] == [False, False, True, True, False, False]
    assert sum("has no effect" in line for line in report) == 1
    monkeypatch.setattr("spacar.compiled.python_callbacks.python", lambda: None)
    assert (found, report) == lost()


def test_nobody_is_asked_after_ctrl_c_until_it_was_raised(tmp_path: Path) -> None:
    body = "    law.times.append(t)\n    if t == 0.5: raise KeyboardInterrupt\n" + USUAL + "law.times = []\n"
    made = evaluator(model(tmp_path, body))
    solver, y = made.solver, np.zeros(made.n_positions + made.numbering.nddof)
    times = made.model.mechanism.user_signal.function.function.times
    del times[:]
    evaluate = [made.state.address, *made._addresses]

    def rates(t: float) -> int:
        return int(solver.engine.rhs(solver.handle, evaluate[0], t, evaluate[1], evaluate[2], 1e-11, 1e9))

    made._y[:] = y
    assert [rates(t) < 0 for t in (0.1, 0.5, 0.6)] == [False, True, True]
    assert times == [0.1, 0.5]
    with pytest.raises(KeyboardInterrupt):
        solver.slots.interrupted()
    assert rates(0.6) >= 0
    assert times[-1] == 0.6


INTERRUPTED = """
import signal, sys, time
import scipy.linalg, scipy.sparse.linalg, spacar.linearization.state_jacobian  # not within an import: another matter
import spacar
from spacar.elements.planar.pltruss import PlanarTruss

signal.signal(signal.SIGALRM, signal.default_int_handler)  # a clock that presses Ctrl-C
kind, path = sys.argv[1:]
if kind == "element":
    PlanarTruss.definition = ""

def go(**options):
    if kind == "lanes":
        spacar.sweep(path, {"EM.1": [1.0, 1.1]}, "x[3,1]@end", jobs=1, batch=True, **options)
    else:
        spacar.run(1, path, **options)

go(duration=1e-3)  # other modules are there too
for k in range(8):
    begin = time.monotonic()
    signal.setitimer(signal.ITIMER_REAL, 0.1 + 0.007 * k, 8.0)  # the second one ends what did not hear the first
    try:
        go()
        print("ended")
    except KeyboardInterrupt:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        print("late" if time.monotonic() > begin + 7.0 else "interrupted")
"""
CHAIN = "".join([
    *(f"PLBEAM {k} {2 * k - 1} {2 * k} {2 * k + 1} {2 * k + 2}\nX {2 * k + 1} {k}. 0.\n" for k in range(1, 9)),
    *(f"DYNE {k} 2 3\n" for k in range(1, 9)),
    "PLTRUSS 99 1 17\nRLSE 99 1\nX 1 0. 0.\nFIX 1\n%s\nEND HALT\n%s\n",
    *(f"EM {k} 1.\nESTIFF {k} 0. 100.\n" for k in range(1, 9)),
    "XF 17 0. 1.\nESTIFF 99 1.\nTIMESTEP 1e5 10\nEND END\n",
])  # fmt: skip
SINE = "    return t, [], [[2, 1, 0.01 * np.sin(t), 0.01 * np.cos(t), -0.01 * np.sin(t)]]\n"
QUESTIONS = {  # where nothing is asked but this: the model, the body of its function
    "one case": (ARM.replace("TIMESTEP 0.1 5", "TIMESTEP 1e4 10"), "    return t, [[1, 1, np.sin(1e4 * t)]], []\n"),
    "motion": (CHAIN % ("INPUTX 2 1", "INPUTX 2 1\nUSERINP law"), SINE),
    "lanes": (CHAIN % ("FIX 2", "USERSIG law"), "    return t, [[1, 2, np.sin(50.0 * t)]], []\n"),
    "element": (CHAIN % ("FIX 2", ""), ""),
}


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="no clock that interrupts")
@pytest.mark.parametrize("kind", QUESTIONS)
def test_ctrl_c_between_the_questions_is_heard(tmp_path: Path, kind: str) -> None:
    """Python notices it where what C calls begins: a callback of ctypes writes 'Exception ignored' then and goes on."""
    text, body = QUESTIONS[kind]
    path = model(tmp_path, body, text)
    if kind == "motion":
        (tmp_path / "law.py").write_text("import numpy as np\ndef law(t, step):\n" + body)
    command = [sys.executable, "-c", INTERRUPTED, kind, str(path)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)
    assert (done.stdout, done.stderr) == (8 * "interrupted\n", "")


def test_the_traceback_shows_the_function(tmp_path: Path) -> None:
    with pytest.raises(AnalysisError) as caught:
        spacar.run(1, model(tmp_path, "    return 1 / 0\n"))
    cause = caught.value.__cause__
    assert isinstance(cause, ZeroDivisionError)
    trace = cause.__traceback__
    while trace is not None and trace.tb_frame.f_code.co_name != "law":
        trace = trace.tb_next
    assert trace is not None


def test_questions_leave_nothing_behind(tmp_path: Path) -> None:
    """Blocks of memory and references after many questions: taken, read in Python, and raised."""
    for body in (
        USUAL,
        "    return t, np.array([[1.0, 1.0, 0.1]]), []\n",
        "    law.n = getattr(law, 'n', 0) + 1\n    if law.n > 5: raise ValueError(le)\n" + USUAL,
    ):
        made = evaluator(model(tmp_path, body))
        solver, slots = made.solver, made.solver.slots
        arguments = slots.asking.law.arguments
        made._y[:] = 0.0

        def many(n: int, made: CompiledDynamics = made) -> None:
            for k in range(n):
                solver = made.solver
                solver.engine.rhs(solver.handle, made.state.address, k / n, *made._addresses, 1e-11, 1e9)
                solver.slots.interrupted()

        many(500)
        gc.collect()
        counts, blocks = [sys.getrefcount(o) for o in (*arguments, float, list, tuple)], sys.getallocatedblocks()
        many(20_000)
        gc.collect()
        after = [sys.getrefcount(o) for o in (*arguments, float, list, tuple)]
        assert max(abs(a - b) for a, b in zip(after, counts, strict=True)) < 50, body
        assert abs(sys.getallocatedblocks() - blocks) < 500, body
        assert slots is solver.slots


def test_threads_ask_each_their_own(tmp_path: Path) -> None:
    """ctypes lets go of the interpreter during a run, so that questions of several runs mix."""
    paths = []
    for k in range(4):
        (tmp_path / str(k)).mkdir()
        paths.append(model(tmp_path / str(k), USUAL.replace("0.5 + t", f"{k}.0 + t")))
    alone = [tip(path) for path in paths]
    begun = threading.Barrier(4)

    def run(path: Path) -> list[Any]:
        begun.wait()
        return [tip(path) for _ in range(5)]

    with ThreadPoolExecutor(4) as pool:
        for expected, found in zip(alone, pool.map(run, paths), strict=True):
            for x in found:
                np.testing.assert_array_equal(x, expected)


def test_a_python_that_lacks_a_function(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(python_callbacks, "FUNCTIONS", (*python_callbacks.FUNCTIONS, "PyNothing_OfTheKind"))
    python_callbacks.python.cache_clear()
    assert python_callbacks.python() is None
    python_callbacks.python.cache_clear()


# What C calls in Python goes away with the model, at once: no circle of references keeps its arrays.
@pytest.fixture
def path(tmp_path):
    """A model with a user function; nobody looks for circles while it is used."""
    gc.collect()
    gc.disable()
    yield model(tmp_path, USUAL)
    gc.enable()


def test_a_user_function_leaves_no_circle_behind(path):
    evaluator = chosen(spacar.frames(1, path))
    evaluator.start()
    slots = weakref.ref(evaluator.solver.slots)
    assert slots().laws
    del evaluator
    assert slots() is None


def test_the_file_of_a_user_function_keeps_no_deck(path):
    """The function and its module refer to each other; nothing large hangs on them."""
    mechanism = spacar.frames(1, path).mechanism
    mechanism.user_signal.anew()
    deck = weakref.ref(mechanism.deck)
    del mechanism
    assert deck() is None


def test_a_model_ends_without_capsules_too(path, monkeypatch):
    """As in a Python that has none: once, with its last reference."""
    c, ended = engine(1), []
    end = c.end
    monkeypatch.setattr(c, "_new", None)
    monkeypatch.setattr(c, "end", lambda model: (ended.append(model), end(model)))
    evaluator = chosen(spacar.frames(1, path))
    evaluator.start()
    model = evaluator.solver.handle
    assert not ended
    del evaluator
    assert ended == [model]


PAGES = """
import sys, spacar
mode, path = sys.argv[1:]
deck = spacar.read_deck(path, int(mode))
for k in range(10_000):
    spacar.run(int(mode), deck, **({"duration": 1e-3, "n_steps": 2} if mode == "1" else {}))
    if k in (999, 9_999):
        print(open("/proc/self/statm").read().split()[1])
"""


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="no /proc")
@pytest.mark.parametrize(("mode", "name"), [("1", "crank"), ("7", "lateral4")])
def test_ten_thousand_runs_leak_nothing(mode, name):
    """Memory of C too. A run allocates more than 10 kB; one byte in forty of that would be found."""
    path = DATA / f"{name}.dat"
    words = [sys.executable, "-c", PAGES, mode, str(path)]
    first, last = map(int, subprocess.run(words, capture_output=True, text=True, check=True).stdout.split())
    assert (last - first) * 4096 < 9_000 * 256
