"""Modes 2, 3, 4 and 7 to 10 with elements in C and in NumPy give the same for every example."""

from pathlib import Path

import numpy as np
import pytest

import spacar
from spacar.compiled.library import why_off
from spacar.errors import SpacarError
from tests.examples import DATA

pytestmark = pytest.mark.skipif(why_off() is not None, reason=str(why_off()))
LIKE = {"c0": "cd", "d0": "cd", "k0": "kng", "n0": "kng", "g0": "kng", "m0": "m"}


def examples(*modes: int) -> list[tuple[int, str]]:
    found = []
    for path in sorted(DATA.glob("*.dat")):
        for mode in modes:
            try:
                spacar.frames(mode, path)
            except SpacarError:
                continue
            found.append((mode, path.stem))
    return found


def first(mode: int, name: str, compiled: bool) -> tuple[spacar.Frame | str, dict]:
    """The first frame, or the kind of the error, and the header."""
    run = spacar.frames(mode, DATA / f"{name}.dat", compiled=compiled)
    try:
        return next(iter(run)), run.header
    except SpacarError as error:
        return error.code, run.header


@pytest.mark.parametrize(("mode", "name"), examples(2, 4, 7, 8, 9, 10))
def test_first_frames(mode: int, name: str) -> None:
    """To the tolerance of the iterations: 1e-6 of the largest entry of each kind, of 1 at least for the state."""
    (a, of_numpy), (b, of_c) = (first(mode, name, compiled) for compiled in (False, True))
    assert of_numpy["engine"][0] == "general"
    assert of_c["engine"][0] == "compiled"
    if isinstance(a, str) or isinstance(b, str):
        assert a == b
        return
    for word in ("x", "e", "sig"):
        want = getattr(a, word)
        size = np.abs(want).max(initial=1.0)
        np.testing.assert_allclose(getattr(b, word), want, atol=1e-6 * size, rtol=0, err_msg=word)
    assert a.matrices.keys() == b.matrices.keys()
    for word in LIKE.keys() & a.matrices.keys():
        like = [a.matrices[n].ravel() for n, kind in LIKE.items() if kind == LIKE[word] and n in a.matrices]
        size = np.abs(np.concatenate(like)).max(initial=0.0) + (LIKE[word] == "cd")
        np.testing.assert_allclose(b.matrices[word], a.matrices[word], atol=1e-6 * size, rtol=0, err_msg=word)


def test_mode_3_along_the_result_of_mode_2(tmp_path: Path) -> None:
    nominal = spacar.run(2, DATA / "robotinv.dat")
    frames = []
    for compiled in (False, True):
        run = spacar.frames(3, DATA / "robotinvlin.dat", nominal=nominal, compiled=compiled)
        frames.append(next(iter(run)))
        assert run.header["engine"][0] == ("compiled" if compiled else "general")
    a, b = frames
    for word in a.state_space:
        want = np.asarray(a.state_space[word])
        np.testing.assert_allclose(b.state_space[word], want, atol=1e-9 * np.abs(want).max(initial=1.0), rtol=0)


@pytest.mark.parametrize("compiled", [False, True])
def test_a_mass_of_rounding_is_no_mass(compiled: bool) -> None:
    """robotsim: one degree of freedom turns a rod without rotary inertia about itself; W^T M W is +-1e-19 there."""
    found, _ = first(7, "robotsim", compiled)
    assert found == "dynamics.singular-mass"
