"""What C calls in Python goes away with the model, at once: no circle of references keeps its arrays."""

import gc
import weakref

import pytest

import spacar
from spacar.compiled.library import why_off
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


def test_a_user_function_leaves_no_circle_behind(tmp_path):
    (tmp_path / "law.py").write_text(FUNCTION)
    (tmp_path / "model.dat").write_text(CANTILEVER)
    gc.collect()
    gc.disable()
    try:
        evaluator = chosen(spacar.frames(1, tmp_path / "model.dat"))
        evaluator.start()
        slots = weakref.ref(evaluator.solver.slots)
        assert slots().laws
        del evaluator
        assert slots() is None
    finally:
        gc.enable()


def test_the_file_of_a_user_function_keeps_no_deck(tmp_path):
    """The function and its module refer to each other; nothing large hangs on them."""
    (tmp_path / "law.py").write_text(FUNCTION)
    (tmp_path / "model.dat").write_text(CANTILEVER)
    gc.collect()
    gc.disable()
    try:
        mechanism = spacar.frames(1, tmp_path / "model.dat").mechanism
        mechanism.user_signal.anew()
        deck = weakref.ref(mechanism.deck)
        del mechanism
        assert deck() is None
    finally:
        gc.enable()
