"""States outside the theory of an element, missing mass, broken user functions: what the user gets to read."""

import warnings
from pathlib import Path

import numpy as np
import pytest

import spacar
from spacar import Deck
from spacar.errors import AnalysisError
from spacar.forward.accepted_steps import fail_at


def failure(deck: Deck, mode: int = 1) -> AnalysisError:
    """The error of a run, in one line and without a warning of NumPy."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(AnalysisError) as caught:
            spacar.run(mode, deck)
    assert "\n" not in str(caught.value)
    return caught.value


PLANAR = [("PLBEAM", 1, 1, 2, 3, 4), ("X", 3, 1.0), ("FIX", 1), ("FIX", 2), ("DYNE", 1, 2, 3)]
SPRING = [("PLTRUSS", 1, 1, 2), ("X", 2, 1.0), ("FIX", 1), ("FIX", 2, 2), ("DYNE", 1)]
TWO_SPRINGS = [*SPRING, ("PLTRUSS", 2, 2, 3), ("X", 3, 2.0), ("FIX", 3, 2), ("DYNE", 2)]
SPATIAL = [("BEAM", 1, 1, 2, 3, 4, 0.0, 1.0, 0.0), ("X", 3, 1.0), ("FIX", 1), ("FIX", 2), ("DYNE", 1, 2, 3, 4, 5, 6)]


@pytest.mark.parametrize(
    ("rows", "em", "stiffness", "force"),
    [
        (PLANAR, (1.0, 0.1), (0.0, 1.0), (2.0,)),  # twice the stiffness: the end turns beyond 85 degrees to the chord
        *((SPATIAL, (1.0, 0.1, 0.1, 0.1), (0.0, 1.0, 1.0, 1.0), moment)
          for moment in ((0.0, 0.0, 2.0), (0.0, 2.0, 0.0), (2.0, 0.0, 0.0))),
    ],
    ids=["planar", "bent about z", "bent about y", "twisted"],
)  # fmt: skip
def test_a_beam_bent_or_twisted_beyond_one_element(rows, em, stiffness, force) -> None:
    dynamics = [("EM", 1, *em), ("ESTIFF", 1, *stiffness), ("XF", 4, *force), ("TIMESTEP", 5.0, 200)]
    error = failure(Deck.build(rows, dynamics))
    for words in (f"element 1 ({rows[0][0]})", "t = ", "degrees", "use more elements"):
        assert words in str(error)


def test_a_warning_comes_first() -> None:
    """Between 60 and 85 degrees the run goes on and the report says so once."""
    dynamics = [("XM", 3, 1.0), ("XM", 4, 0.1), ("EM", 1, 0.1), ("ESTIFF", 1, 0.0, 1.0), ("STARTDE", 1, 2, 0.9, 0.0)]
    report = spacar.run(1, Deck.build(PLANAR, dynamics)).report
    assert len([x for x in report if "warning: element 1 (PLBEAM)" in x and "use more elements" in x]) == 1


def test_roll_up_with_too_few_elements_has_no_equilibrium() -> None:
    """Full circle with 4 elements: 90 degrees each, no equilibrium exists; the message asks for more elements."""
    rows: list[tuple] = [("FIX", 1), ("FIX", 2)]
    dynamics: list[tuple] = [("XF", 10, 2 * np.pi), ("ITERSTEP", 20, 10)]
    for k in range(1, 5):
        p = 2 * k - 1
        rows += [("PLBEAM", k, p, p + 1, p + 2, p + 3), ("X", p + 2, k / 4, 0.0), ("DYNE", k, 2, 3)]
        dynamics.append(("ESTIFF", k, 0.0, 1.0))
    error = failure(Deck.build(rows, dynamics), 8)
    assert "element" in str(error)


@pytest.mark.parametrize(
    ("rows", "mass", "mode", "words"),
    [
        (TWO_SPRINGS, ("XM", 2, 1.0), 1, ("element 2 (PLTRUSS) e1 elongation", "XM", "EM", "RLSE")),
        # One mass for two degrees of freedom: both have inertia, their difference has none.
        (TWO_SPRINGS, ("XM", 3, 1.0), 1, ("elongation",)),
        (TWO_SPRINGS, ("XM", 3, 1.0), 7, ("elongation",)),
        (SPRING, ("XM", 2, -1.0), 1, ()),
    ],
    ids=["no mass", "dependent masses", "dependent masses, frequencies", "negative"],
)
def test_singular_mass_names_the_motion(rows, mass, mode, words) -> None:
    error = failure(Deck.build(rows, [mass, ("TIMESTEP", 1.0, 10)]), mode)
    assert error.code == "dynamics.singular-mass"
    assert all(word in str(error) for word in words)
    assert mass[1] != 2 or mass[2] < 0 or "element 1 (PLTRUSS)" not in str(error)


@pytest.mark.parametrize("kind", ["exception", "nan"])
def test_user_function_that_breaks_on_the_way(tmp_path: Path, kind: str) -> None:
    body = "raise ValueError('bad\\nluck')" if kind == "exception" else "return t, None, [[2, 1, float('nan')]]"
    (tmp_path / "load.py").write_text(
        f"def load(t, ne, le, e, ep, nx, lnp, x, xp):\n    if t > 0.42:\n        {body}\n    return t, None, None\n"
    )
    path = tmp_path / "m.dat"
    path.write_text(
        "PLTRUSS 1 1 2\nX 2 1\nFIX 1\nFIX 2 2\nDYNE 1\nEND HALT\nXM 2 1\nUSERSIG load\nTIMESTEP 1 10\nEND END\n"
    )
    error = failure(spacar.read_deck(path, 1))
    assert "load" in str(error)
    assert "t = 0.4" in str(error)


def test_the_time_stands_once_whatever_the_words_of_the_cause() -> None:
    with pytest.raises(AnalysisError, match=r"^at t = 0.5: a plate of t = 3 mm$") as first:
        fail_at(0.5, AnalysisError("a plate of t = 3 mm", "element.range", element=1))
    with pytest.raises(AnalysisError, match=r"^at t = 0.5: a plate of t = 3 mm$") as second:
        fail_at(0.75, first.value)
    assert second.value.data == {"element": 1, "t": 0.5}


def test_a_spring_that_explodes() -> None:
    """Negative stiffness and damping: exponential growth until a limit of the element, never inf or nan in a frame."""
    dynamics = [("XM", 2, 1.0), ("ESTIFF", 1, -1e4), ("STARTDE", 1, 1, -0.01, 0.0), ("TIMESTEP", 50.0, 50)]
    error = failure(Deck.build(SPRING, dynamics))
    assert "element 1 (PLTRUSS)" in str(error)
    assert "collapsed" in str(error)
