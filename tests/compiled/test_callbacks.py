"""What C calls in Python goes away with the model, at once: no circle of references keeps its arrays."""

import gc
import weakref

import pytest

import spacar
from spacar.compiled.library import engine, why_off
from spacar.forward.motion import chosen

pytestmark = pytest.mark.skipif(why_off() is not None, reason=str(why_off()))

CANTILEVER = """PLBEAM 1 1 2 3 4
X 1 0 0
X 3 1 0
FIX 1
FIX 2
DYNE 1 2 3
END
HALT
XM 3 1.
EM 1 1.
ESTIFF 1 0. 10. 0.
USERSIG law
TIMESTEP 0.1 2
END
END
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
