"""Cases in which only masses, stiffnesses, dampings, loads, prescribed motions or start values differ.

The equations of motion are linear in these numbers (theory-system.md (1), (5)), so that the numbers of a case are

    N(p) = N(a) + sum_i (p_i - a_i)/(b_i - a_i) (N(a + (b_i - a_i) e_i) - N(a))        a, b: least and largest values

to rounding, and no deck of its own has to be made. What is not linear, such as the shear of a beam or a fluid in a
tube, is found by comparison: the case with all largest values and one between have to come out. Whether a deck may have
the values is asked of all decks with the least and the largest ones: what a check allows of such a number is an
interval.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from spacar.arrays import Array
from spacar.deck import Deck
from spacar.dynamics.loaded_mechanism import LoadedMechanism
from spacar.errors import SpacarError
from spacar.mechanism import Mechanism, build
from spacar.studies.assignments import Setting, change, changed_statements
from spacar.studies.ensemble import why_not
from spacar.studies.side_by_side import Cases, alike, start_of

if TYPE_CHECKING:
    from spacar.compiled.numbers import Numbers

LINEAR = {"XM", "EM", "MEE", "ESTIFF", "EDAMP", "XF", "ESIG", "STARTDX", "STARTDE", "INPUTX", "INPUTE"}
FEWEST = 16  # cases; building the others together is as fast for fewer
MOST = 3  # numbers that differ: 2^n decks are checked


def affine_cases(
    deck: Deck, settings: tuple[Setting, ...], values: Sequence[Sequence[float]], **options: Any
) -> Cases | None:
    """The cases, or None where they have to be made from decks of their own."""
    if len(values) < FEWEST or not settings or deck.of("USERINP", block=2):
        return None
    table = np.array(values, float)
    low, high = table.min(axis=0), table.max(axis=0)
    varied = np.flatnonzero(high > low)
    if not 0 < len(varied) <= MOST or not changed_statements(deck, settings) <= LINEAR:
        return None
    between = table[len(table) // 2]
    places = [np.where(np.isin(np.arange(len(low)), chosen), high, low) for chosen in _subsets(varied)]
    try:
        decks = [change(deck, settings, place.tolist()) for place in (*places, between)]
        if why_not(decks[0], **options) or not alike(*decks):
            return None
        corners = {0, *(1 << k for k in range(len(varied))), len(places) - 1, len(places)}
        exact = {k: _numbers(decks[k], **options) for k in sorted(corners)}
    except SpacarError:
        return None  # the run of a case says why
    first, *others = (exact[k] for k in (0, *(1 << k for k in range(len(varied)))))

    def cases_at(where: Array) -> tuple[Numbers, Array] | None:
        from spacar.compiled.combined_numbers import combined

        weights = ((where - low)[:, varied] / (high - low)[varied]).T
        numbers = combined([numbers for _, numbers, _ in (first, *others)], weights)
        if numbers is None:
            return None
        start = first[2] + sum(w[:, None] * (other[2] - first[2]) for w, other in zip(weights, others, strict=True))
        return numbers, np.asarray(start)

    from spacar.compiled.combined_numbers import same

    for k, where in ((len(places) - 1, high), (len(places), between)):
        found = cases_at(where[None])
        if found is None or not same(exact[k][1], found[0]) or not np.allclose(exact[k][2], found[1], 1e-13, 1e-14):
            return None
    found = cases_at(table)
    assert found is not None
    return Cases(first[0], *found, lambda k: change(deck, settings, list(values[k])))


def _subsets(varied: Array) -> list[list[int]]:
    """All choices of them; place k holds those whose bit is set in k."""
    return [
        [int(v) for v, bit in zip(varied, reversed(bits), strict=True) if bit]
        for bits in product((0, 1), repeat=len(varied))
    ]


def _numbers(deck: Deck, **options: Any) -> tuple[Mechanism, Numbers, Array]:
    from spacar.compiled.numbers import of_one

    mechanism = build(deck, 1, **options)
    return mechanism, of_one(LoadedMechanism.of(mechanism)), start_of(mechanism)
