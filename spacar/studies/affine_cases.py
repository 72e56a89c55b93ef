"""Cases whose numbers are made for all of them at once, without a deck for each.

The equations of motion are linear in masses, stiffnesses, dampings, loads, prescribed motions and start values
(theory-system.md (1), (5)), so that the numbers of a case are

    N(p) = N(a) + sum_i (p_i - a_i)/(b_i - a_i) (N(a + (b_i - a_i) e_i) - N(a))        a, b: two values of each

to rounding, and no deck of its own has to be made. Where positions of nodes change (X), or where that is not linear,
such as the shear of a beam or a fluid in a tube, this holds of what the elements are made from, and all elements of all
cases are made together (`spacar.compiled.numbers_of_cases`). What is not even so is found by comparison with two cases.

Whether a deck may have the values is asked of all decks with the least and the largest ones: what a check allows of
such a number is an interval. The checks that depend on lengths (`spacar.deck.checks_geometry`) are made for all cases
at once, with bounds a little narrower, MARGIN for rounding. A case that does not pass is left out: the checks of a deck
of its own decide and say what is wrong.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import Array
from spacar.deck import ELEMENT_TYPES, Deck
from spacar.deck.checks_geometry import PARALLEL, ZERO_LENGTH, least_length
from spacar.deck.lexer import is_in_range
from spacar.dynamics.loaded_mechanism import LoadedMechanism
from spacar.errors import SpacarError
from spacar.mechanism import Mechanism, build
from spacar.studies.assignments import Setting, change, changed_arguments, changed_statements
from spacar.studies.ensemble import why_not_of
from spacar.studies.side_by_side import Cases, alike, start_of

if TYPE_CHECKING:
    from spacar.compiled.numbers import Numbers

LINEAR = {"XM", "EM", "MEE", "ESTIFF", "EDAMP", "XF", "ESIG", "STARTDX", "STARTDE", "INPUTX", "INPUTE"}
FEWEST = 16  # cases; building the others together is as fast for fewer
MOST = 3  # numbers that differ besides positions: 2^n decks are checked
MARGIN = 1e-9
MOST_PLACES = 64  # positions that differ: one deck each


def affine_cases(
    deck: Deck, settings: tuple[Setting, ...], values: Sequence[Sequence[float]], built: Mechanism | None = None,
    **options: Any,
) -> Cases | None:  # fmt: skip
    """The cases that pass their checks, or None where they have to be made from decks of their own. `built`: a
    mechanism that may be that of one of them."""
    if len(values) < FEWEST or not settings or deck.of("USERINP", block=2):
        return None
    keywords = [changed_statements(deck, (s,)) for s in settings]
    if not set().union(*keywords) <= LINEAR | {"X"}:
        return None
    table = np.array(values, float)
    varied = np.ptp(table, axis=0) > 0.0
    moved = np.array(["X" in k for k in keywords]) & varied
    if not varied.any() or (varied & ~moved).sum() > MOST or moved.sum() > MOST_PLACES:
        return None
    try:
        given, places = np.flatnonzero(varied & ~moved), np.flatnonzero(moved)
        return _Table(deck, settings, table, given, places, options, built).cases()
    except SpacarError:
        return None  # the run of a case says why


@dataclass
class _Table:
    """The values of all cases, (cases, settings); `given` and `moved`: settings of numbers and of positions that
    differ."""

    deck: Deck
    settings: tuple[Setting, ...]
    table: Array
    given: Array
    moved: Array
    options: Any
    built: Mechanism | None

    def __post_init__(self) -> None:
        self.varied = np.concatenate((self.given, self.moved))

    def cases(self) -> Cases | None:
        from spacar.compiled.numbers import of_one
        from spacar.compiled.numbers_of_cases import combined, corner_of, numbers_of_cases

        kept = self._kept() if len(self.moved) else np.arange(len(self.table))
        if not len(kept):
            return None
        passed = self.table[kept]
        self.base, self.far = passed.min(axis=0), passed.max(axis=0)
        self.base[self.moved] = passed[0, self.moved]
        # deck k has the far values of those whose bit is set in k
        choices = ([v for k, v in enumerate(self.given) if bits >> k & 1] for bits in range(1 << len(self.given)))
        decks = [self._changed(self._towards(chosen)) for chosen in choices]
        known = self.built is not None and self.built.deck.text == decks[0].text
        mechanisms = [self.built if known and self.built else build(decks[0], 1, **self.options)]
        if why_not_of(mechanisms[0]) or not alike(*decks):
            return None
        mechanisms += [build(decks[1 << k], 1, **self.options) for k in range(len(self.given))]
        for k in self.moved:
            mechanisms.append(build(self._moved(k, passed[:, k], mechanisms[0].length), 1, **self.options))
        starts = [start_of(m) for m in mechanisms]
        # combinations of the numbers of the corners, or of what their elements are made from
        ways: list[Any] = [(lambda m: of_one(LoadedMechanism.of(m)), combined), (corner_of, numbers_of_cases)]
        for corner, combine in ways[1:] if len(self.moved) else ways:
            found = self._combined(partial(combine, [corner(m) for m in mechanisms]), starts, kept)
            if found is not None:
                numbers, start, own = found
                return Cases(mechanisms[0], numbers, start, partial(self._deck, own), own.tolist())
        return None

    def _kept(self) -> Array:
        """Cases whose positions pass the checks."""
        mechanism = self.built or build(self.deck, 1, **self.options)
        n, x0 = mechanism.numbering, np.repeat(mechanism.x0[:, None], len(self.table), axis=1)
        for k, given in enumerate(self.settings):
            for keyword, node, argument in changed_arguments(self.deck, given):
                if keyword == "X" and node in n.kind and n.lnp[node - 1, argument - 2] > 0:
                    x0[n.lnp[node - 1, argument - 2] - 1] = self.table[:, k]
        passed = placed_well(mechanism, self.deck, x0)
        for k, row in enumerate(self.table[:, self.moved].tolist()):
            passed[k] &= all(is_in_range(v, "0") for v in row)
        return np.flatnonzero(passed)

    def _moved(self, k: int, values: Array, length: float) -> Deck:
        """A deck that differs from the first one in a position only: that of a case, or one that is not far."""
        tried = values[np.argmax(np.abs(values - self.base[k]))], self.base[k] + length / 8, self.base[k] - length / 8
        for n, value in enumerate(tried):
            self.far[k] = value
            try:
                return self._changed(self._towards([k]))
            except SpacarError:
                if n == len(tried) - 1:
                    raise
        raise AssertionError

    def _towards(self, chosen: Sequence[int]) -> Array:
        return np.where(np.isin(np.arange(len(self.base)), chosen), self.far, self.base)

    def _weights(self, where: Array) -> Array:
        return ((where - self.base)[:, self.varied] / (self.far - self.base)[self.varied]).T

    def _deck(self, chosen: Array, k: int) -> Deck:
        return self._changed(self.table[chosen[k]])

    def _changed(self, where: Array) -> Deck:
        return change(self.deck, self.settings, where.tolist())

    def _combined(
        self, make: Callable[[Array], "Numbers | None"], starts: Sequence[Array], kept: Array
    ) -> "tuple[Numbers, Array, Array] | None":
        """Numbers, starts and places of the cases, without those that cannot be; None where a case would be wrong."""
        from spacar.compiled.numbers import of_one
        from spacar.compiled.numbers_of_cases import ImpossibleCase, affine, same

        while len(kept):
            try:
                weights = self._weights(self.table[kept])
                numbers = make(weights)
                break
            except ImpossibleCase as impossible:
                kept = np.delete(kept, impossible.case)
        else:
            return None
        if numbers is None:
            return None
        start = affine([y[:, None] for y in starts], weights).T
        asked = [self.table[kept[len(kept) // 2]]]
        if len(self.moved):
            asked.append(self.table[kept[-1]])
        elif len(self.varied) > 1:
            asked.append(self.far)
        for where in asked:
            exact = build(self._changed(where), 1, **self.options)
            one = make(self._weights(where[None]))
            begun = affine([y[:, None] for y in starts], self._weights(where[None])).T
            if one is None or not same(of_one(LoadedMechanism.of(exact)), one):
                return None
            if not np.allclose(start_of(exact), begun, 1e-13, 1e-14):
                return None
        return numbers, start, kept


def placed_well(mechanism: Mechanism, deck: Deck, x0: Array) -> NDArray[np.bool_]:
    """Cases whose elements have lengths and directions that a deck may have; x0: (nx, cases)."""
    n = mechanism.numbering
    well: NDArray[np.bool_] = np.array(np.isfinite(x0).all(axis=0))
    places = x0[n.positions]  # (nodes, components, cases)
    if not len(places):
        return well
    least = ZERO_LENGTH * (1.0 + MARGIN) * (places.max(axis=0) - places.min(axis=0)).max(axis=0)
    for s in deck.of(*ELEMENT_TYPES, block=1):
        kind = ELEMENT_TYPES[s.keyword]
        ends = [s.integer(i) for i, role in enumerate(kind.nodes, 1) if role == "position"]
        if len(ends) < 2 or ends[0] == ends[1]:
            continue
        p, q = (x0[n.lnp[end - 1][n.lnp[end - 1] > 0] - 1] for end in ends[:2])
        chord = q - p
        length = np.sqrt((chord * chord).sum(axis=0))
        direction = None
        if kind.direction is not None:
            first, count, role = kind.direction
            direction = np.array(s.reals(first - 1, count)) if len(s.values) >= first - 1 + count else None
        if kind.length == "always" or (kind.length == "with direction" and direction is not None):
            well &= length > least
        if least_chord := (1.0 + MARGIN) * least_length(s):
            well &= length > least_chord
        if direction is not None and role != "axis":
            well &= ~(length > least) | ~(_sine(chord, length, direction) < (1.0 + MARGIN) * PARALLEL)
    return well


def _sine(chord: Array, length: Array, direction: Array) -> Array:
    """Of the angles between chords (components, cases) and a direction (components,)."""
    unit = direction / np.abs(direction).max()
    with np.errstate(all="ignore"):
        a = np.pad(chord / length, ((0, 3 - len(chord)), (0, 0))).T
    b = np.pad(unit / np.linalg.norm(unit), (0, 3 - len(unit)))
    return np.linalg.norm(np.cross(a, b), axis=-1)
