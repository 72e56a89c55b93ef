"""A user's file is run from its text as it stands: an edit counts at once, and nothing is written beside the model."""

import warnings
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import spacar
from spacar.errors import AnalysisError
from spacar.mechanism import build
from spacar.mechanism.mechanism import Mechanism
from spacar.mechanism.placed_vectors import placed
from spacar.mechanism.user_functions import UserLaw

MODEL = """PLBEAM 1 1 2 3 4   X 1 0. 0.   X 3 1. 0.   FIX 1   DYNX 2 1   END HALT
EM 1 1.0   XM 3 1.0   USERSIG push   TIMESTEP 0.1 2   END END
"""


def test_the_place_of_a_failure_is_that_in_the_file(tmp_path):
    (tmp_path / "beam.dat").write_text(MODEL)
    path = tmp_path / "push.py"
    path.write_text(
        "def push(t, ne, le, e, ep, nx, lnp, x, xp):\n    assert __file__.endswith('push.py')\n    return 1 / 0\n"
    )
    with pytest.raises(AnalysisError, match="ZeroDivisionError") as raised:
        spacar.run(1, tmp_path / "beam.dat")
    failure: BaseException = raised.value
    while failure.__cause__ is not None:
        failure = failure.__cause__
    trace, places = failure.__traceback__, []
    while trace is not None:
        places.append((trace.tb_frame.f_code.co_filename, trace.tb_lineno))
        trace = trace.tb_next
    assert places[-1] == (str(path), 3)


# Answers of a user function that have the form of earlier ones are written without being read anew: whatever comes
# after whatever, each is written, or refused with the same words, as by a law that has answered nothing before.
ARM = """
PLBEAM 1 1 2 3 4   X 1 0. 0.   X 3 1. 0.   FIX 1   DYNE 1 1   DYNE 1 2 3   END HALT
XM 3 1.   ESTIFF 1 100. 100.   END END
"""
MANY = [[1, 1, 0.1]] * 25  # more rows than are looked at one by one
ANSWERS: dict[str, tuple[Any, Any]] = {
    "usual": ([[1, 1, 1.5], [1, 2, -2.0]], [[3, 1, 0.5]]),
    "other values": ([[1, 1, 7], [1, 2, np.float64(3.0)]], [[3, 1, -0.25]]),
    "other order": ([[1, 2, 1.0], [1, 1, 2.0]], [[3, 1, 0.5]]),
    "equal numbers": ([[1.0, True, 1.0], [np.int64(1), 2, 4.0]], [[3, 1, 0.5]]),
    "tuples": ([(1, 1, 1.5), (1, 2, -2.0)], [(3, 1, 0.5)]), "nothing": ([], []), "no stresses": ([], [[3, 1, 0.5]]),
    "none": (None, None), "twice the same": ([[1, 1, 1.5], [1, 1, -2.0]], [[3, 1, 0.5], [3, 1, 0.5]]),
    "more rows": ([[1, 1, 1.5], [1, 2, -2.0], [1, 3, 1.0]], [[3, 1, 0.5]]), "many": (MANY, []),
    "stiffness": ([[1, 1, 1.5, 8.0, 0.4], [1, 2, -2.0, 0.0, 0.0]], [[3, 1, 0.5]]),
    "array": (np.array([[1.0, 1.0, 1.5], [1.0, 2.0, -2.0]]), np.array([[3.0, 1.0, 0.5]])),
    "array of one": ([[1, 1, np.array([1.5])], [1, 2, -2.0]], [[3, 1, 0.5]]),
    "array as number": ([[np.array(1), 1, 1.5], [1, 2, -2.0]], [[3, 1, 0.5]]),
    "small type": ([[1, 1, np.float32(1.5)], [1, 2, True]], [[3, 1, 0.5]]),
    "dict": ([{1: 0, 2: 0, 3: 0}, [1, 2, -2.0]], [[3, 1, 0.5]]), "text": ([[1, 1, "a"], [1, 2, -2.0]], [[3, 1, 0.5]]),
    "a number as text": ([[1, 1, "1"], [1, 2, -2.0]], [[3, 1, 0.5]]), "set": ([{1, 2, 3.5}, [1, 2, -2.0]], []),
    "two numbers": ([[1, 1], [1, 2, -2.0]], [[3, 1, 0.5]]), "list": ([[1, 1, [1.5]], [1, 2, -2.0]], [[3, 1, 0.5]]),
    "four numbers": ([[1, 1, 1.5, 8.0], [1, 2, -2.0, 0.0]], [[3, 1, 0.5]]),
    "not finite": ([[1, 1, 1.5], [1, 2, np.nan]], [[3, 1, 0.5]]),
    "infinite": ([[1, 1, np.inf], [1, 2, -np.inf]], [[3, 1, 0.5]]),
    "large": ([[1, 1, 10**400], [1, 2, -2.0]], [[3, 1, 0.5]]),
    "no such element": ([[1, 1, 1.5], [9, 2, -2.0]], [[3, 1, 0.5]]),
    "no such force": ([[1, 1, 1.5], [1, 2, -2.0]], [[3, 7, 0.5]]),
    "not whole": ([[1, 1, 1.5], [1, 2.5, -2.0]], [[3, 1, 0.5]]), "fixed": ([[1, 1, 1.5]], []),
    "fixed, nothing": ([[1, 1, 0.0], [1, 2, 2.0]], [[3, 1, 0.5]]),
}  # fmt: skip


@pytest.fixture(scope="module", params=["", "fixed "])
def mechanism(request: pytest.FixtureRequest) -> Mechanism:
    return build(spacar.parse_deck(ARM.replace("DYNE 1 1 ", "") if request.param else ARM, mode=1), 1)


class Asked:
    """A law with one function, asked through the vectors of the engine."""

    def __init__(self, mechanism: Mechanism) -> None:
        n = mechanism.numbering
        self.next: tuple[Any, Any] = [], []
        self.sigma, self.force = np.zeros(n.ne), np.zeros(n.nx)
        law = UserLaw(lambda t, *_: (t, *self.next), "law", n, n.le - 1, n.lnp - 1, False)
        told = tuple(placed(np.zeros(size), "x") for size in (n.ne, n.ne, n.nx, n.nx))
        self.answer = law.answering(told, self.sigma, self.force)

    def __call__(self, which: str) -> tuple[Any, ...]:
        self.next = ANSWERS[which]
        self.sigma[:] = self.force[:] = 0.0  # as C does
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            try:
                lost = self.answer(0.5)
            except AnalysisError as error:
                return str(error), error.code
        return self.sigma.tolist(), self.force.tolist(), lost


def test_every_answer_after_every_other(mechanism: Mechanism) -> None:
    alone = {which: Asked(mechanism)(which) for which in ANSWERS}
    assert sum(isinstance(found[0], str) for found in alone.values()) >= 8  # some are refused
    for first, second in product(ANSWERS, repeat=2):
        asked = Asked(mechanism)
        for which in (first, second, second, first):
            assert asked(which) == alone[which], (first, second, which)


def test_answers_are_those_of_the_general_path(mechanism: Mechanism) -> None:
    n = mechanism.numbering
    for which, given in ANSWERS.items():
        asked = Asked(mechanism)
        found = asked("usual"), asked(which)
        law = UserLaw(lambda t, *_, given=given: (t, *given), "law", n, n.le - 1, n.lnp - 1, False)
        at = 0.5, np.zeros(n.ne), np.zeros(n.ne), np.zeros(n.nx), np.zeros(n.nx)
        if isinstance(found[1][0], str):
            with pytest.raises(AnalysisError) as caught:
                law(*at)
            assert found[1] == (str(caught.value), caught.value.code)
            continue
        forces = law(*at)
        assert found[1] == (forces.sigma.tolist(), forces.force.tolist(), forces.lost), which


def test_entries_of_a_placed_vector() -> None:
    """One entry is a NumPy number as ever; of what has more axes an entry is an ordinary array."""
    x = placed(np.arange(6.0), "x")
    for place in (2, np.int64(2), np.int32(2), True):
        assert type(x[place]) is type(np.arange(6.0)[place])
        assert np.all(x[place] == np.arange(6.0)[place])
    assert type(x.reshape(2, 3)[1]) is np.ndarray
    assert x.reshape(2, 3)[1].tolist() == [3.0, 4.0, 5.0]
    for place in (-1, np.int64(-1), np.int32(-1)):
        with pytest.raises(IndexError, match="a place in x is negative"):
            x[place]
    with pytest.raises(IndexError, match="out of bounds"):
        x[6]


def test_a_placed_vector_can_be_printed_and_copied() -> None:
    x = placed(np.arange(3.0), "x")
    assert (str(x), repr(x), f"{x}") == ("[0. 1. 2.]", "array([0., 1., 2.])", "[0. 1. 2.]")
    with pytest.raises(IndexError, match="a place in x is negative"):
        x.copy()[-1]


# User functions: a stress that cannot act is said, and a place that does not exist is never read.
BEAM = """PLBEAM 1 1 2 3 4   PLBEAM 2 3 4 5 6   X 3 1. 0.   X 5 2. 0.
FIX 1   FIX 2   DYNE 1 2 3   INPUTE 2 2   END HALT
XM 3 1.   XM 5 1.   ESTIFF 1 0. 1.   USERSIG law   TIMESTEP 0.1 2   END END
"""
RETURN = "def law(t, ne, le, e, ep, nx, lnp, x, xp):\n    return t, {rows}, []\n"


def model(folder: Path, function: str) -> Path:
    (folder / "law.py").write_text(function)
    path = folder / "model.dat"
    path.write_text(BEAM)
    return path


@pytest.mark.parametrize("mode", [1, 7])
def test_a_stress_on_a_fixed_or_prescribed_mode_is_reported(tmp_path: Path, mode: int) -> None:
    rows = "[[1, 1, 5.0], [2, 2, 3.0], [2, 3, 0.0], [1, 2, 0.5]]"
    lines = spacar.run(mode, model(tmp_path, RETURN.format(rows=rows))).report
    lost = [line for line in lines if "has no effect" in line]
    assert len(lost) == 2, lines  # once each, however often the function is called; a zero stress loses nothing
    assert all(line.startswith("warning: law at t = 0") for line in lost)
    assert "element 1 (PLBEAM) e1 elongation" in lost[0]
    assert "fixed" in lost[0]
    assert "element 2 (PLBEAM) e2 bending at p" in lost[1]
    assert "prescribed" in lost[1]


@pytest.mark.parametrize(
    ("vector", "place"),
    [("e", "le[0, 5]"), ("ep", "le[1, 3]"), ("x", "lnp[1, 1]"), ("xp", "lnp[0]"), ("x", "[lnp[1, 1]]")],
)
def test_what_does_not_exist_is_not_read(tmp_path: Path, vector: str, place: str) -> None:
    """Before, -1 read the last deformation or coordinate: a wrong number without a word."""
    rows = f"[[1, 2, float(__import__('numpy').sum({vector}[{place}]))]]"
    with pytest.raises(AnalysisError) as caught:
        spacar.run(1, model(tmp_path, RETURN.format(rows=rows)))
    assert f"a place in {vector} is negative" in str(caught.value)
    assert "-1" in str(caught.value)


def test_guarded_vectors_are_vectors_otherwise() -> None:
    v = placed(np.arange(4.0), "e")
    assert type(v[1:]) is np.ndarray
    assert type(2.0 * v) is np.ndarray
    assert (v + v)[-1] == 6.0
    assert v[1:][-1] == 3.0
    assert v[[0, 2]].tolist() == [0.0, 2.0]
    assert v[v > 1.0].tolist() == [2.0, 3.0]
    assert np.linalg.norm(v) == pytest.approx(14.0**0.5, rel=1e-15)
    assert v @ v == 14.0
    assert np.sum(v) == 6.0
    assert len(v) == 4
