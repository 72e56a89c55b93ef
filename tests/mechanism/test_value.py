"""A mechanism is a value: a used one can be copied, pickled and run in another process, with the same result.

The copies hold the same numbers and the evaluation is deterministic, so that results are equal to the last bit.
"""

import copy
import multiprocessing
import pickle
from pathlib import Path

import numpy as np
import pytest

import spacar
from spacar.calls import frames
from spacar.mechanism import Mechanism
from spacar.modes import find_mode
from spacar.stream import Run
from tests.examples import DATA

CASES = (
    (1, "crank", {"n_steps": 5, "duration": 0.02}), (2, "robotinv", {}),
    (4, "crankfl", {"n_steps": 2, "duration": 0.001}), (7, "column2", {}), (8, "plbeam5buck", {}),
    (1, "trike3i", {"n_steps": 3, "duration": 0.01}),
)  # fmt: skip
COPIES = {"pickled": lambda m: pickle.loads(pickle.dumps(m)), "deep copy": copy.deepcopy, "copy": copy.copy}


def results(mode: int, mechanism: Mechanism) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    result = spacar.Result.collect(Run(find_mode(mode), mechanism))
    return result["x"], result["e"], result["sig"]


def used(mode: int, source: Path, **options: float) -> tuple[Mechanism, tuple[np.ndarray, ...]]:
    mechanism = frames(mode, source, **options).mechanism
    return mechanism, results(mode, mechanism)


@pytest.mark.parametrize(("mode", "name", "options", "how"), [
    pytest.param(*case, how, marks=[pytest.mark.slow] * (case[1] == "robotinv" and how != "pickled"))
    for case in CASES for how in COPIES
])  # fmt: skip
def test_a_copy_of_a_used_mechanism_runs(mode: int, name: str, options: dict[str, float], how: str) -> None:
    mechanism, expected = used(mode, DATA / f"{name}.dat", **options)
    for got, right in zip(results(mode, COPIES[how](mechanism)), expected, strict=True):
        np.testing.assert_array_equal(got, right)


def test_copies_do_not_share_arrays() -> None:
    mechanism, expected = used(1, DATA / "crank.dat", n_steps=5, duration=0.02)
    other = copy.deepcopy(mechanism)
    other.x0[:] = 0.0
    np.testing.assert_array_equal(results(1, mechanism)[0], expected[0])


def test_batches_are_numbered_by_their_place() -> None:
    """Also when the batches of a mechanism are exchanged; two places never share their arrays."""
    from dataclasses import replace

    mechanism = frames(1, DATA / "crankfl.dat").mechanism
    turned = replace(mechanism, batches=mechanism.batches[::-1])
    assert [b.index for b in turned.batches] == list(range(len(turned.batches)))
    assert len({key for key, *_ in turned.layout.x}) == len(turned.batches)


def test_a_used_mechanism_runs_in_another_process() -> None:
    """Through spawn, which shares nothing with this process."""
    mechanism, expected = used(1, DATA / "crank.dat", n_steps=5, duration=0.02)
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        result = pool.apply(spacar.Result.collect, (Run(find_mode(1), mechanism),))
    for name, right in zip(("x", "e", "sig"), expected, strict=True):
        np.testing.assert_array_equal(result[name], right)


FUNCTION = {
    "USERSIG": ("pull", "def pull(t, ne, le, e, ep, nx, lnp, x, xp):\n    return t, [], [[2, 1, 3.0 + t]]\n"),
    "USERINP": ("lift", "def lift(t, step):\n    return t, [], [[1, 2, 0.1 * t * t, 0.2 * t, 0.2]]\n"),
}


@pytest.mark.parametrize("how", COPIES)
@pytest.mark.parametrize("keyword", FUNCTION)
def test_user_functions_are_loaded_again(keyword: str, how: str, tmp_path: Path) -> None:
    name, text = FUNCTION[keyword]
    (tmp_path / f"{name}.py").write_text(text)
    path = tmp_path / "m.dat"
    path.write_text(
        "PLTRUSS 1 1 2\nX 1 0 0\nX 2 1 0\nFIX 1 1\nINPUTX 1 2\nFIX 2 2\nDYNE 1 1\nEND\nHALT\nXM 2 1.5\n"
        f"ESTIFF 1 40\n{keyword} {name}\nTIMESTEP 0.5 5\nEND\nEND\n"
    )
    mechanism, expected = used(1, path)
    assert np.ptp(expected[0][:, mechanism.numbering.x_index(2, 1)]) > 0.0 or keyword == "USERINP"
    for got, right in zip(results(1, COPIES[how](mechanism)), expected, strict=True):
        np.testing.assert_array_equal(got, right)
