"""A deck with a direction: numbers that are moved along it by a complex step.

For derivatives with respect to numbers of the deck: a number p becomes p + i h, all that is computed from it without
branches carries i h d/dp along, exact to rounding for a tiny h (W. Squire, G. Trapp, SIAM Review 40 (1998) 110-112).
What the blocks of sections and materials stand for is expanded again with the complex numbers; the checks of the input
are those of the real deck. NumPy warns where a complex number is made real: who computes with such a deck makes these
warnings errors (`nothing_lost`), so that no part of a derivative gets lost in silence.
"""

import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace

import numpy as np

from spacar.deck.deck import Deck
from spacar.deck.deck_reader import read_text
from spacar.deck.findings import Findings
from spacar.deck.length_unit import length_power
from spacar.deck.rewrite.divide import divided
from spacar.deck.rewrite.refine import with_parts
from spacar.deck.section_block import expand
from spacar.deck.statement import Statement
from spacar.deck.table_types import Parameter
from spacar.errors import UsageError

STEP = 1e-50  # of complex steps: its square is far below rounding, products of a few stay above the smallest float


class DirectedDeck:
    """A checked deck, ready to be given directions one after the other."""

    def __init__(self, deck: Deck, pieces: Mapping[int, int] | None = None) -> None:
        """pieces: how many beams stand in the place of one (`divide.divided`) in what `along` gives."""
        self.deck, self.pieces = deck, pieces or {}
        contents = read_text(deck.text, deck.source, deck.mode)
        self._given, self._outline = contents.given.statements(), contents.outline

    def factor(self, statement: Statement, position: int, parameters: Sequence[Parameter]) -> float:
        """What one unit of the number in the file (UNITS) is in SI; `parameters`: those of the statement."""
        if self._outline.metre == 1.0:
            return 1.0
        named = list(zip(statement.values, parameters, strict=False))
        kinds = [self._outline.types[int(v)] for v, p in named if p.of == "element" and v in self._outline.types]
        role = next((self._outline.roles[int(v)] for v, p in named if "node" in p.of and v in self._outline.roles), "")
        place = position - 1
        power = length_power(statement.keyword, place, parameters[place], statement.values, kinds, role)
        return float(self._outline.metre**power)

    def along(self, places: Sequence[tuple[Statement, int, float]]) -> Deck:
        """The deck with i STEP times a factor added to arguments (from 1) of statements that stand in its text.

        Raises UsageError for a statement that follows from another one.
        """
        changes: dict[tuple[int, tuple[int, ...]], dict[int, float]] = {}
        for statement, position, factor in places:
            self.deck.require_written(statement)
            changes.setdefault(_place(statement), {})[position - 1] = factor
        given = [_moved(s, changes[_place(s)]) if _place(s) in changes else s for s in self._given]
        expansion = expand(given, self._outline, Findings(self.deck.source))
        statements, parts = divided(expansion.statements, self.pieces)
        return with_parts(replace(self.deck, statements=tuple(statements), sections=expansion.sections), parts)


def _place(s: Statement) -> tuple[int, tuple[int, ...]]:
    return s.line, s.columns


def _moved(s: Statement, factors: dict[int, float]) -> Statement:
    values = list(s.values)
    for k, factor in factors.items():
        # compares by its real part, unlike a complex number of Python
        values[k] = np.complex128(complex(float(values[k]), STEP * factor))  # type: ignore[call-overload]
    return s._replace(values=tuple(values))


@contextmanager
def nothing_lost() -> Iterator[None]:
    """In this context a complex number that would be made real is an error: UsageError 'sensitivity.model'."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", np.exceptions.ComplexWarning)
        try:
            yield
        except (np.exceptions.ComplexWarning, TypeError) as error:
            if "complex" not in str(error).lower():
                raise
            text = f"derivatives of this model are not followed: an element does not take complex steps ({error})"
            raise UsageError(text, "sensitivity.model") from error
