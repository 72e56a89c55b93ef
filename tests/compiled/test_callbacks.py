"""What C calls in Python goes away with the model, at once: no circle of references keeps its arrays."""

import gc
import subprocess
import sys
import weakref
from pathlib import Path

import pytest

import spacar
from spacar.compiled.library import engine, why_off
from spacar.forward.motion import chosen
from tests.examples import DATA

pytestmark = pytest.mark.skipif(why_off() is not None, reason=str(why_off()))

CANTILEVER = """PLBEAM 1 1 2 3 4   X 1 0 0   X 3 1 0   FIX 1   FIX 2   DYNE 1 2 3   END HALT
XM 3 1.   EM 1 1.   ESTIFF 1 0. 10. 0.   USERSIG law   TIMESTEP 0.1 2   END END
"""
FUNCTION = "def law(t, ne, le, e, ep, nx, lnp, x, xp):\n    return t, [[1, 2, 0.1]], []\n"


@pytest.fixture
def path(tmp_path):
    """A model with a user function; nobody looks for circles while it is used."""
    (tmp_path / "law.py").write_text(FUNCTION)
    (tmp_path / "model.dat").write_text(CANTILEVER)
    gc.collect()
    gc.disable()
    yield tmp_path / "model.dat"
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
