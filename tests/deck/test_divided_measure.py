"""Beams that are divided keep their measure."""

import pytest

import spacar
from spacar.deck import parse_deck
from spacar.deck.rewrite.refine import refine
from spacar.mechanism.element_batches import by_angles
from tests.examples import DATA


@pytest.mark.parametrize(("statement", "measured"), [("ADEFORM", range(1, 11)), ("ADEFORM 2", (2, 7))])
def test_adeform_of_all_and_of_one_beam(statement, measured):
    """plbeam5 in halves: beam 2 becomes 2 and 7. ADEFORM without a number failed with IndexError."""
    text = (DATA / "plbeam5.dat").read_text().replace("DYNE 1 2 3", f"{statement}\nDYNE 1 2 3", 1)
    deck = refine(parse_deck(text, mode=7), 2)
    assert by_angles(deck) == set(measured)
    result = spacar.run(7, deck)
    forms = {b.family.measure for b in result.mechanism.batches if b.family.keyword == "PLBEAM"}
    assert forms == ({"angle"} if statement == "ADEFORM" else {"", "angle"})
