"""The walk over the load steps alone, without eigenvalue problems."""

from collections.abc import Iterator

from spacar.deck import Deck, parse_deck
from spacar.errors import Report
from spacar.mechanism import build
from spacar.stationary import LoadLevel, LoadProgram, StationarySolver


def levels(model: str | Deck, mode: int = 7) -> Iterator[tuple[StationarySolver, LoadLevel]]:
    """The solver after every level."""
    m = build(parse_deck(model, mode=mode) if isinstance(model, str) else model, mode)
    solver = StationarySolver(m, Report())
    for level in LoadProgram(m.settings):
        solver.solve(level)
        yield solver, level


def walked(model: str | Deck, mode: int = 7) -> StationarySolver:
    """The solver at the end."""
    *_, (solver, _) = levels(model, mode)
    return solver
