"""Finite differences of whole analyses with Richardson extrapolation: the truth for derivatives along a direction."""

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

import spacar
from spacar.sensitivities.sensitivity import deck_numbers
from spacar.studies.assignments import change


def values_of(
    deck: spacar.Deck, names: Sequence[str], quantities: Sequence[str], **options: Any
) -> Callable[[np.ndarray], np.ndarray]:
    """The quantities (quantities,) as a function of the parameters, without any derivative."""
    deck, numbers = deck_numbers(deck, names)

    def at(parameters: np.ndarray) -> np.ndarray:
        moved = change(deck, [n.setting for n in numbers], parameters.tolist())
        return spacar.sensitivity(moved, [], quantities, **options).values

    return at


def extrapolated(deck: spacar.Deck, names: Sequence[str], quantities: Sequence[str], direction: np.ndarray, step: float,
                 orders: int = 2, **options: Any) -> np.ndarray:  # fmt: skip
    """d quantities / d s (quantities,) where the parameters are p + s direction: central differences with the steps
    step/2^k, extrapolated to an error of step^(2 orders)."""
    start = np.array([n.value for n in deck_numbers(deck, names)[1]])
    values = values_of(deck, names, quantities, **options)

    def at(s: float) -> np.ndarray:
        return values(start + s * direction)

    rows = [(at(h) - at(-h)) / (2.0 * h) for h in (step / 2.0**k for k in range(orders))]
    for k in range(1, orders):
        rows = [(4.0**k * b - a) / (4.0**k - 1.0) for a, b in pairwise(rows)]
    return rows[0]


def agree(deck: spacar.Deck, names: Sequence[str], quantities: Sequence[str], *, seed: int = 1,
          rel: float | Sequence[float] = 1e-6, step: float = 4e-4, **options: Any) -> spacar.Sensitivity:  # fmt: skip
    """Derivatives along a random direction (each parameter by its size) agree with the differences; `rel` of the
    largest term of the sum, or of the quantity by the step: what the differences are known to. One number, or one for
    each quantity."""
    found = spacar.sensitivity(deck, names, quantities, **options)
    size = np.where(found.parameter_values != 0.0, np.abs(found.parameter_values), 1.0)
    direction = np.random.default_rng(seed).uniform(0.3, 1.0, len(names)) * size
    want = extrapolated(deck, names, quantities, direction, step, **options)
    terms = found.derivatives * direction
    scale = np.abs(terms).max(axis=1) + 1e-4 * np.abs(found.values)
    error = np.abs(terms.sum(axis=1) - want) / np.where(scale > 0.0, scale, 1.0)
    worst = int(np.argmax(error / rel))
    assert np.all(error <= rel), (found.quantities[worst], terms[worst].sum(), want[worst], error)
    return found
