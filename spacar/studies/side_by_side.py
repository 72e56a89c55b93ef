"""Cases of one mechanism side by side: their numbers come from one mechanism of disjoint copies.

Case k has the nodes and elements of the first one, their numbers raised by k times the largest number. Since
coordinates are numbered by class, then node, case k holds the same places of every class as the single mechanism.
"""

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from spacar.arrays import Array
from spacar.deck import Deck, Statement
from spacar.deck.rewrite.references import places, renumbered
from spacar.dynamics.array_evaluator import Dynamics
from spacar.mechanism import Mechanism, build
from spacar.mechanism.user_files import STATEMENTS

if TYPE_CHECKING:
    from spacar.compiled.numbers import Numbers


class Cases(NamedTuple):
    """Cases of one mechanism, which is that of the first of them.

    numbers  of all cases;  start  their states (cases, components): degrees of freedom, their rates
    deck     of a case, made when it is asked for
    chosen   places of the cases among those that were asked for; empty: all of these
    """

    single: Mechanism
    numbers: "Numbers"
    start: Array
    deck: Callable[[int], Deck]
    chosen: Sequence[int] = ()


def side_by_side(decks: Sequence[Deck], **options: Any) -> Cases:
    """The cases of decks that are alike."""
    from spacar.compiled.numbers import of_copies

    single, together = build(decks[0], 1, **options), build(copies(decks), 1, **options)
    x_of, e_of = _places(single, together, len(decks), _stride(decks[0]))
    numbers, start = of_copies(single, together, x_of, e_of), _start(single, together, x_of, e_of)
    return Cases(single, numbers, start, decks.__getitem__)


def alike(a: Deck, *others: Deck) -> bool:
    """Whether decks are cases of one mechanism: the same statements, references and settings."""
    statements = _with_references(a)
    return all(_like(statements, _statements(other)) for other in others)


@lru_cache(maxsize=8)
def _with_references(deck: Deck) -> list[tuple[Statement, list[int]]]:
    """Statements that matter, and the places of the values in them that are node or element numbers."""
    return [(s, [i for i, _ in places(s)]) for s in _statements(deck)]


def _like(statements: list[tuple[Statement, list[int]]], others: list[Statement]) -> bool:
    if len(statements) != len(others):
        return False
    for (s, references), o in zip(statements, others, strict=True):
        if s is o:
            continue
        if s.keyword != o.keyword or len(s.values) != len(o.values) or (not references and s.values != o.values):
            return False
        if any(s.values[i] != o.values[i] for i in references):
            return False
    return True


def _start(single: Mechanism, together: Mechanism, x_of: Array, e_of: Array) -> Array:
    """State of every case at the start, (cases, components), in the order of `Start.state`."""
    one, n = single.numbering, together.numbering
    y, at, parts = start_of(together), 0, []
    for name in ("dynamic", "kinematic", "dynamic"):  # values, then rates
        for where, own, rows in (
            (x_of, one.x_class[name], n.x_class[name]),
            (e_of, one.e_class[name], n.e_class[name]),
        ):
            parts.append(y[at + where[:, own] - rows.start])
            at += rows.stop - rows.start
    return np.hstack(parts)


def start_of(mechanism: Mechanism) -> Array:
    """The state at the start, (components,)."""
    given = mechanism.start
    return given.state(given.e_kinematic) if given.is_complete else Dynamics(mechanism).start_values()


def copies(decks: Sequence[Deck]) -> Deck:
    """One deck with the mechanisms of all decks side by side. The decks are alike and have been checked."""
    first = decks[0]
    stride = _stride(first)
    statements: list[Statement] = []
    for k, deck in enumerate(decks):
        own = [s for s in _statements(deck) if places(s) or (k == 0 and s.keyword not in STATEMENTS)]
        shift = (k * stride).__add__
        statements += renumbered(own, shift, shift)
    return Deck(tuple(statements), first.source, first.path, first.text, first.data, mode=1)


def _statements(deck: Deck) -> list[Statement]:
    return [s for s in deck.statements if s.block < 3 and s.keyword != "OUTLEVEL"]


def _stride(deck: Deck) -> int:
    return max(s.integer(i) for s, which in _with_references(deck) for i in which)


def _places(single: Mechanism, together: Mechanism, n: int, stride: int) -> tuple[np.ndarray, np.ndarray]:
    """Where the coordinates and deformations of every case are, (n, nx) and (n, ne)."""
    one, all_ = single.numbering, together.numbering
    node, coordinate = np.array([one.x_owner(i) for i in range(one.nx)]).T
    shift = stride * np.arange(n)[:, None]
    x = all_.lnp[node + shift - 1, coordinate - 1] - 1
    owners = np.array([one.e_owner(i) for i in range(one.ne)]).reshape(-1, 2)
    number, mode = owners.T
    e = all_.le[np.maximum(number, 1) + shift - 1, mode - 1] - 1
    if len(one.normalization):
        row = dict(all_.normalization.tolist())
        for i in np.flatnonzero(number < 0):
            e[:, i] = [row[int(m)] for m in -number[i] + shift[:, 0]]
    return x, e
