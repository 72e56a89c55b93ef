"""Targets with a name (SECTION, MATERIAL) and natural frequencies in the languages of studies."""

from pathlib import Path

import numpy as np
import pytest

import spacar
from spacar.deck import read_deck
from spacar.errors import UsageError
from spacar.studies.assignments import change, setting
from spacar.studies.runs.quantities import quantity
from tests.examples import DATA

GUIDE = DATA / "leafguide.dat"


@pytest.mark.parametrize("target", ["SECTION.leaf[t]", "section.LEAF[t along]", "SECTION.leaf[4]"])
def test_a_dimension_of_a_section(target: str) -> None:
    deck = change(read_deck(GUIDE, 10), [setting(target)], [0.6])
    [use] = [s for s in deck.sections if s.element == 1]
    assert use.dims == (0.05, 0.0006)


def test_a_number_of_a_material() -> None:
    deck = change(read_deck(GUIDE, 10), [setting("MATERIAL.spring[Young]")], [1e5])
    assert pytest.approx(1e11) == deck.sections[0].material.E


def test_a_name_that_there_is_not() -> None:
    with pytest.raises(UsageError, match="there is no statement SECTION blade to change"):
        setting("SECTION.blade[t]").targets[0].places(read_deck(GUIDE, 10))
    with pytest.raises(UsageError, match="its arguments are 1 name, 2 shape, 3 w along y', 4 t along z'"):
        setting("SECTION.leaf[d]").targets[0].places(read_deck(GUIDE, 10))


def test_frequencies_as_quantities() -> None:
    """frequency[i] is |eigval|/2 pi, from low to high."""
    result = spacar.run(7, Path(GUIDE).with_name("plbeam5free.dat"))
    values = np.sort(np.unique(np.abs(result["eigval"][-1] @ [1, 1j]).round(9))) / (2 * np.pi)
    assert quantity("frequency[1]@end").number(result) == pytest.approx(values[0], rel=1e-6)
    assert quantity("frequency[2]@end").number(result) == pytest.approx(result.frequencies[-1, 1], rel=1e-14)
    with pytest.raises(UsageError, match="frequency has"):
        quantity("frequency[99]@end").number(result)
