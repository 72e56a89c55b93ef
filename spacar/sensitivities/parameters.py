"""Numbers of the deck by the names that parameter studies use (spacar.studies.assignments), and directions along them.

    ESTIFF.3[EI]   X.2[x]   SECTION.leaf[dimension 2]   INPUTX.4.1 & INPUTX.5.1   XF.*[2]
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from spacar.deck import Deck, Statement
from spacar.deck.directed import DirectedDeck, nothing_lost
from spacar.deck.length_unit import shown_in
from spacar.errors import UsageError
from spacar.mechanism import Mechanism
from spacar.mechanism.build import along
from spacar.studies.assignments import Setting, change, parameters_of, setting


@dataclass(frozen=True)
class DeckNumber:
    """A number of the deck: its setting, present value in the unit of the file, and that unit."""

    setting: Setting
    value: float
    unit: str


def deck_numbers(deck: Deck, names: Sequence[str]) -> tuple[Deck, list[DeckNumber]]:
    """The numbers with these names. Arguments that were left out stand in the deck that is returned.

    Raises UsageError for names that the deck does not have, and for several places with different numbers.
    """
    settings = [name if isinstance(name, Setting) else setting(name) for name in names]
    for given in settings:
        missing = [(s, p) for t in given.targets for s, p in t.places(deck) if p > len(s.values)]
        if missing:
            s, p = missing[0]
            default = parameters_of(deck, s)[p - 1].default
            if default not in (None, 0.0):
                text = f"{s.subject}: argument {p} is left out; write its value into the file"
                raise UsageError(text, "sensitivity.parameter")
            deck = change(deck, [given], [0.0])
    directed = DirectedDeck(deck)
    return deck, [_number(deck, directed, given) for given in settings]


def _number(deck: Deck, directed: DirectedDeck, given: Setting) -> DeckNumber:
    values, unit = [], ""
    for target in given.targets:
        for s, p in target.places(deck):
            deck.require_written(s)
            parameters = parameters_of(deck, s)
            if parameters[p - 1].kind != "real":
                text = f"{given.name} is no real number; derivatives are with respect to real numbers"
                raise UsageError(text, "sensitivity.parameter")
            values.append(float(s.values[p - 1]) / directed.factor(s, p, parameters))
            unit = shown_in(parameters[p - 1].unit, deck.metre)[1]
    if max(values) - min(values) > 1e-12 * max(map(abs, values)):
        listed = ", ".join(f"{v:.9g}" for v in values[:4])
        text = f"{given.name} stands for {len(values)} different numbers ({listed}); make them equal, or name one"
        raise UsageError(text, "sensitivity.parameter")
    return DeckNumber(given, values[0], unit)


def directions(mechanism: Mechanism, numbers: Sequence[DeckNumber]) -> list[Mechanism]:
    """The mechanism with each of the numbers of its deck moved by a complex step. Raises UsageError for a number whose
    derivative is not followed."""
    directed = DirectedDeck(mechanism.deck)
    found = []
    with nothing_lost():
        for number in numbers:
            try:
                found.append(along(mechanism, directed.along(_places(mechanism.deck, directed, number.setting))))
            except (TypeError, RuntimeWarning) as error:
                text = f"derivatives with respect to {number.setting.name} are not followed ({error})"
                raise UsageError(text, "sensitivity.parameter") from None
    return found


def _places(deck: Deck, directed: DirectedDeck, given: Setting) -> list[tuple[Statement, int, float]]:
    return [
        (s, p, directed.factor(s, p, parameters_of(deck, s)))
        for target in given.targets
        for s, p in target.places(deck)
    ]
