"""The perturbation method against full integration, and where it does not apply."""

import numpy as np
import pytest

import spacar
from spacar.dynamics import array_evaluator
from spacar.errors import UsageError
from spacar.studies.assignments import change, setting
from spacar.studies.perturbation import perturbation

GRID = {"duration": 0.02, "n_steps": 10}


def test_the_error_is_of_second_order_in_the_deformation(deck):
    """Half the speed, a quarter of the inertia forces: deformations fall by about 4, what the linear equations leave
    out by about 16. Bounds of 3 and 8: the nominal motion meets the vibration at other phases.
    """
    base = deck("crankfl", 1)
    short = {"duration": 0.004, "n_steps": 4}
    errors, sizes = [], []
    for rate in (40.0, 20.0):
        slow = change(base, [setting("INPUTX.2.1[start rate]")], [rate])
        full = spacar.run(1, slow, rtol=1e-6, atol=1e-9, **short)
        linear = perturbation(slow, 16, **short)
        flexible = slice(
            full.mechanism.numbering.e_class["dynamic"].start, full.mechanism.numbering.e_class["dynamic"].stop
        )
        sizes.append(np.abs(full["e"][:, flexible]).max())
        errors.append(np.abs(full["e"] - linear["e"]).max())
    assert errors[0] < 0.05 * sizes[0]
    assert sizes[0] / sizes[1] > 3.0
    assert errors[0] / errors[1] > 8.0


def test_the_grid_converges(deck):
    """The forcing is interpolated linearly: second order in the grid, or better."""
    base = deck("crankfl", 1)
    x = [perturbation(base, k, duration=0.01, n_steps=5)["e"] for k in (4, 8, 32)]
    coarse, fine = (np.abs(v - x[2]).max() for v in x[:2])
    assert coarse > 3.0 * fine > 0.0


def test_free_vibration_is_exact_on_any_grid(deck):
    """No prescribed motion but at rest (rate 0): constant matrices, so one step an output is as good as many."""
    base = change(
        deck("crankfl", 1), [setting("INPUTX.2.1[start rate]"), setting("STARTDE.2.2[start value]")], [0.0, 1e-4]
    )
    x = [perturbation(base, k, **GRID)["e"] for k in (1, 8)]
    assert np.abs(x[0]).max() > 5e-5
    assert np.abs(x[0] - x[1]).max() < 1e-12


def test_inertia_that_may_be_rounding_is_said(deck, monkeypatch):
    monkeypatch.setattr(array_evaluator, "is_doubtful", lambda *found: True)
    monkeypatch.setattr(array_evaluator, "require_regular_mass", lambda *found: "little inertia")
    assert "warning: little inertia" in perturbation(deck("crankfl", 1), duration=0.001, n_steps=1).report


@pytest.mark.parametrize(
    ("name", "options", "why"),
    [
        ("crank", {}, "may be dynamic, here nothing"),
        ("robotsim", GRID, "here element 1"),
        ("column2", GRID, r"here coordinates \(DYNX\)"),
        ("trike2", GRID, "wheels"),
    ],
)
def test_where_it_does_not_apply(deck, name, options, why):
    with pytest.raises(UsageError, match=why):
        perturbation(deck(name, 1), **options)


def test_trade_with_the_perturbation_method(call):
    import json

    done = call("trade", "crankfl", "--time", "0.002", "--steps", "2", "-i", "853", "-t", "1e-3", "--target", "1e-2",
                "--repeats", "1", "--variable", "x[6,2]", "--perturbation", "--substeps", "4", "--json")  # fmt: skip
    assert done.status == 0, done.err
    full, linear = json.loads(done.out)["settings"]
    assert (full["method"], linear["method"]) == ("full", "perturbation")
    assert full["error"] < linear["error"] < 0.05
    assert "for mode 1" in call.refused("trade", "plbeam5", "--perturbation")
